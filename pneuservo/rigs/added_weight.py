"""What hangs on the rod, in a run for which weights were added to the load or taken off it."""

import math
from collections.abc import Callable, Mapping

MOVED_MASS = "load.mass"
_Values = dict[str, float]


def _behind_the_joint(values: _Values, ratio: float) -> _Values:
    """Return what hangs behind a joint: weights do, and what is between it and the rod stays."""
    return {"share": max(1.0 - (1.0 - values["share"]) / ratio, 0.0)}


def _that_swings(values: _Values, ratio: float) -> _Values:
    """Return the share of what swings by itself: it is as heavy as before."""
    return {"share": values["share"] / ratio}


def _of_the_frame(values: _Values, ratio: float) -> _Values:
    """Return how a frame swings that is as heavy and as stiffly held as before."""
    frame = 1.0 / values["share"] - 1.0
    slower = math.sqrt((frame + 1.0) / (frame + ratio))
    found = {name: values[name] * slower for name in ("frequency", "damping") if name in values}
    return found | {"share": ratio / (frame + ratio)}


_LAWS: Mapping[str, Callable[[_Values, float], _Values]] = {
    "load.compliance": _behind_the_joint,
    "load.backlash": _behind_the_joint,
    "load.transverse-mode": _that_swings,
    "load.base-motion": _of_the_frame,
}


def with_added_weight(values: Mapping[str, float], ratio: float) -> dict[str, float]:
    """Return values of effects that are stated for one moved mass, for another.

    Parameters
    ----------
    values : mapping of str to float
        ``effect:parameter`` to value in SI, among others.
    ratio : float
        The other moved mass over that which they are stated for [-].

    Returns
    -------
    dict of str to float
        What is absent, a share of nothing, stays so.

    Notes
    -----
    Shares of the moved mass, as `pneuservo.effects.load` states them, belong to one mass. Weights
    that are added hang behind an elastic joint; a mode of the structure keeps its mass; a frame of
    mass M on springs k, which recoils under a moved mass m, has the share m/(M + m) and swings at
    sqrt(k/(M + m)).

    Examples
    --------
    >>> with_added_weight({"load.compliance:share": 0.5}, 2.0)
    {'load.compliance:share': 0.75}
    >>> with_added_weight({"load.transverse-mode:share": 0.1, "load.mass": 2.0}, 2.0)
    {'load.transverse-mode:share': 0.05, 'load.mass': 2.0}
    """
    found = dict(values)
    if ratio == 1.0:
        return found
    for effect, law in _LAWS.items():
        head = f"{effect}:"
        own = {key.removeprefix(head): v for key, v in values.items() if key.startswith(head)}
        if own.get("share", 0.0) > 0.0:
            found |= {f"{head}{name}": value for name, value in law(own, ratio).items()}
    return found
