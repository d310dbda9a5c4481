"""Friction of a seal beyond a constant Coulomb force."""

import math

import numpy as np

from pneuservo.effects.effect import Effect, EffectParameter
from pneuservo.plant.compilation import compiled

_RIGS = ("seal-tester",)


@compiled
def presliding_state(displacement, travel, exponent, initial):
    """Return the share of the sliding friction that has built up, -1 to 1.

    Parameters
    ----------
    displacement : (n,) array
        Piston displacement [m].
    travel : float
        Distance over which friction builds up after a reversal; 0 for at once [m].
    exponent : float
        Shape of the build-up: 1 exponential, larger values with a longer tail [-].
    initial : float
        State at the first sample, -1 to 1 [-].

    Returns
    -------
    (n,) array
        The state; while the piston rests it stays.

    Notes
    -----
    Dahl 1968: dz/dx = (1/travel) (1 - z sgn(dx))^exponent sgn(dx), solved exactly over each
    step. With travel = 0 this is sgn(v), the Coulomb law.

    Examples
    --------
    >>> presliding_state(np.array([0.0, 1e-3, 0.5e-3]), 0.0, 1.0, 0.0).tolist()
    [0.0, 1.0, -1.0]
    """
    state = np.empty(displacement.size)
    z = initial
    state[0] = z
    for k in range(1, displacement.size):
        step = displacement[k] - displacement[k - 1]
        if step != 0.0:
            direction = 1.0 if step > 0.0 else -1.0
            rest = 1.0 - z * direction
            if travel <= 0.0:
                rest = 0.0
            elif rest > 0.0:
                distance = abs(step) / travel
                if exponent - 1.0 < 1e-9:
                    rest *= math.exp(-distance)
                else:
                    rest *= (1.0 + (exponent - 1.0) * distance * rest ** (exponent - 1.0)) ** (
                        -1.0 / (exponent - 1.0)
                    )
            z = direction * (1.0 - rest)
        state[k] = z
    return state


PRESSURE = Effect(
    id="friction.pressure",
    block="piston",
    rigs=_RIGS,
    statement="Seal friction grows with chamber pressure; the model holds it constant.",
    equation="F = (Fc + slope (p_a - p_atm)) sgn(v)",
    parameters=(
        EffectParameter(
            "slope", "m**2", 0.0, -1e-5, 1e-4, (1e-6,), "friction per gauge pressure [N/Pa]"
        ),
    ),
    source="Andrighetto and others 2006; Belforte and others 2003",
    experiment="repeat at 1, 4 and 8 bar with the same drive speed",
)
PRESLIDING = Effect(
    id="friction.presliding",
    block="piston",
    rigs=_RIGS,
    statement=(
        "After a reversal friction builds up over a distance; the model lets it jump at once."
    ),
    equation="F = Fc z, dz/dx = (1/travel) (1 - z sgn(v))^exponent sgn(v)",
    parameters=(
        EffectParameter(
            "travel", "m", 0.0, 0.0, 5e-3, (1e-4,), "distance over which friction builds up"
        ),
        EffectParameter("exponent", "", 1.0, 1.0, 5.0, (1.5,), "shape: 1 exponential, above: tail"),
    ),
    source="Dahl 1968; Canudas de Wit and others 1995; Tran and others 2012",
    experiment="drive strokes of 0.05 to 1 mm about one place with a position resolution of 5 um",
)
ASYMMETRIC = Effect(
    id="friction.asymmetric",
    block="piston",
    rigs=_RIGS,
    statement="Friction differs between the two directions; the model holds it equal.",
    equation="F = Fc sgn(v) + difference |sgn(v)|",
    parameters=(
        EffectParameter("difference", "N", 0.0, -10.0, 10.0, (0.3,), "half the difference"),
    ),
    source="thesis tables 4.6 and 4.7",
    experiment="turn the cylinder round, or vent it and drive it by hand: an offset stays",
)
POSITION = Effect(
    id="friction.position",
    block="piston",
    rigs=_RIGS,
    statement="Friction changes along the stroke; the model holds it the same everywhere.",
    equation="F = Fc (1 + slope s + curvature s^2) sgn(v), s = -1..1 along the recorded stroke",
    parameters=(
        EffectParameter("slope", "", 0.0, -1.0, 1.0, (0.05,), "change from mid to the far end"),
        EffectParameter("curvature", "", 0.0, -1.0, 1.0, (0.0,), "change at both ends"),
    ),
    source="thesis equation (4.54)",
    experiment="drive slowly over the full stroke both ways, twice",
)
STRIBECK = Effect(
    id="friction.stribeck",
    block="piston",
    rigs=_RIGS,
    statement="Friction is higher at low speed; the model holds it the same at every speed.",
    equation="F = (Fc + excess exp(-|v|/speed)) sgn(v)",
    parameters=(
        EffectParameter("excess", "N", 0.0, 0.0, 15.0, (0.5,), "static minus sliding friction"),
        EffectParameter("speed", "m/s", 0.005, 0.001, 0.05, (0.003,), "speed at which it fades"),
    ),
    source="Armstrong-Helouvry and others 1994; Tran and Yanada 2013",
    experiment="drive at constant speeds from 1 to 300 mm/s",
)
RUN_IN = Effect(
    id="friction.run-in",
    block="piston",
    rigs=_RIGS,
    statement="Friction drifts during the recording; the model holds it constant.",
    equation="F = Fc (1 + rate t) sgn(v)",
    parameters=(EffectParameter("rate", "1/s", 0.0, -0.01, 0.01, (1e-4,), "relative change"),),
    source="thesis section 4.3.2: friction does not repeat",
    experiment="repeat the same cycle hourly",
)
EFFECTS = (PRESSURE, PRESLIDING, ASYMMETRIC, POSITION, STRIBECK, RUN_IN)
