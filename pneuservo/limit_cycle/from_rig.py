"""The loop of a rig: its linear model at a position, with the valve stronger one way."""

from dataclasses import replace

from analog_card.surface_weights import state_weights
from pneuservo.limit_cycle.loop import Loop, Signals
from pneuservo.linear import advanced_servo, conventional_servo, servo_data, without_valve
from pneuservo.naming import require_known
from pneuservo.rigs import Rig

# Linear models by name.
ADVANCED, CONVENTIONAL = "advanced", "conventional"
MODELS = (ADVANCED, CONVENTIONAL)


def rig_loop(
    rig: Rig,
    displacement: float,
    *,
    settling_time: float = 0.07,
    damping: float = 1.0,
    level: float | None = None,
    boundary_layer: float = 0.0,
    signals: Signals | None = None,
    valve: bool = True,
    model: str = ADVANCED,
) -> Loop:
    """Return the sliding-mode loop round the linear model of a rig.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    displacement : float
        Piston position [m].
    settling_time, damping : float, optional
        Of the sliding surface, 4/(damping wn) [s], [-].
    level : float, optional
        Largest voltage; by default what opens the valve fully [V].
    boundary_layer : float, optional
        0 for a relay [m/s2].
    signals : Signals, optional
        By default every state is measured.
    valve : bool, optional
        Whether the valve has dynamics.
    model : str, optional
        ``advanced``, whose b0 depends on the direction, or ``conventional``, with equal areas.

    Returns
    -------
    Loop
        With the advanced model b0 is the mean of both directions, and the asymmetry half their
        difference over it.

    Raises
    ------
    InputError
        When the rig has no such model, or a value is impossible.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> rig_loop(load_rig("single-axis"), 0.015).asymmetry > 0.0  # extends more strongly
    True
    """
    require_known(model, MODELS, "model")
    data = servo_data(rig)
    if model == CONVENTIONAL:
        servo, asymmetry = conventional_servo(data, displacement), 0.0
    else:
        out, back = (advanced_servo(data, displacement, way) for way in (True, False))
        servo = replace(out, b0=0.5 * (out.b0 + back.b0))
        asymmetry = (out.b0 - back.b0) / (out.b0 + back.b0)
    return Loop(
        servo if valve else without_valve(servo),
        (*state_weights(settling_time, damping), 1.0),
        data.full_voltage if level is None else level,
        boundary_layer,
        asymmetry,
        signals or Signals(),
    )
