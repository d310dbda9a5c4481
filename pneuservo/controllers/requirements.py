"""What every controller checks of its settings, and the transducer it works on."""

import math

from pneuservo.errors import InputError
from pneuservo.rigs import Rig


def sensitivity(rig: Rig) -> float:
    """Return the gain of the displacement transducer [V/m]."""
    return rig["sensor.displacement.range"] / rig["piston.stroke"]


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
