"""What every controller checks of its settings, and the transducer it works on."""

import math

from analog_card.design import Design
from analog_card.surface_weights import weights_from_settings
from pneuservo.errors import InputError
from pneuservo.rigs import Rig

# Share by which two transducers may differ that are meant to be one.
_SAME_TRANSDUCER = 0.01


def sensitivity(rig: Rig) -> float:
    """Return the gain of the displacement transducer [V/m]."""
    return rig["sensor.displacement.range"] / rig["piston.stroke"]


def other_transducer(design: Design, rig: Rig) -> str | None:
    """Return what a card on another transducer than it was designed for comes to, in words.

    Parameters
    ----------
    design : Design
        The card.
    rig : Rig
        What it closes the loop round.

    Returns
    -------
    str or None
        For a warning; None when both transducers have the same gain to 1 %.
    """
    designed, there = design.transducer.gain, sensitivity(rig)
    if abs(there / designed - 1.0) <= _SAME_TRANSDUCER:
        return None
    layer = weights_from_settings(design).boundary_layer
    return (
        f"the design of the card has a transducer of {designed:.4g} V/m, rig {rig.name} one of "
        f"{there:.4g} V/m (sensor.displacement.range over piston.stroke), which the loop runs on: "
        f"the boundary layer is {layer * designed / there:.3g} m/s2 there, not {layer:.3g} m/s2. "
        "Write the rig's transducer into [transducer] of the design and tune the card to it, or "
        "the design's into the rig file"
    )


def require(
    kind: str,
    name: str,
    value: float,
    above: float = -math.inf,
    at_least: float = -math.inf,
) -> None:
    """Refuse a setting that makes no controller.

    Parameters
    ----------
    kind, name : str
        Of the controller and of its setting.
    value : float
        Its value; a finite number.
    above, at_least : float, optional
        Bounds, in the unit of the setting.

    Raises
    ------
    InputError
        When the value is out of bounds.
    """
    if math.isfinite(value) and value > above and value >= at_least:
        return
    allowed = f"greater than {above:g}" if math.isfinite(above) else "a finite number"
    if math.isfinite(at_least):
        allowed = f"{at_least:g} or more"
    raise InputError(f"{kind}: {name} is {value:g}; it has to be {allowed}")
