"""When the piston strikes a stop, when it rests at one, and when friction holds it."""

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.rests import averaged

NEAR_STOP = 5e-4
"""Distance from a stop within which the piston may touch it [m]."""
IMPACT = 0.01
"""Time round a touch during which the motion is not known well [s]."""
FARTHEST = 0.1
"""A displacement that reads more than this share of the stroke from a stop is not that of a piston
at the stop."""
PRESSED = 2.0
"""A piston that rests though it is pushed by so many times its friction is held by a stop ..."""
OF_FULL_FORCE = 0.1
"""... and by this share of what the supply pushes it with: an axis that leans, a spring, a pressure
that reads wrongly or more friction than the rig has hold or push by tens of newtons anywhere."""
PRESSED_FOR = 0.05
"""Time for which it has to be [s]."""
UNSURE = 0.015
"""When a rest begins and ends is known to within this [s]."""
AVERAGED_AT_REST = 0.02
"""Time over which the pressures are averaged whose force a piston at rest is judged by [s]."""
APART = 0.1
"""The force on a piston at rest is judged this often [s]. Its error is that of the zeros, and does
not fade within a rest: all moments of one count as much as one."""


def around(moments: Mask, interval: float) -> Mask:
    """Return the time round some moments during which the motion is not known well.

    Parameters
    ----------
    moments : (n,) array of bool
        When something touches.
    interval : float
        Of the samples [s].
    """
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(moments, np.ones(2 * max(1, round(IMPACT / interval)) + 1)))


def touching(displacement: Array, rests: NDArray[np.int64], interval: float, stroke: float) -> Mask:
    """Return when the piston may touch a stop, where a force acts that nothing tells.

    Parameters
    ----------
    displacement : (n,) array
        [m].
    rests : (n,) array of int
        From `resting`: a stop is where the piston rests pressed on it, whatever its transducer
        reads there. Where it rests a cushion may have held it up before: the farthest counts.
    interval, stroke : float
        Of the samples [s]; of the piston [m].
    """
    low = float(np.min(displacement[rests < 0], initial=np.inf))
    high = float(np.max(displacement[rests > 0], initial=-np.inf))
    low, high = low if np.isfinite(low) else 0.0, high if np.isfinite(high) else stroke
    near = (displacement < low + NEAR_STOP) | (displacement > high - NEAR_STOP)
    return around(near, interval)


def resting(
    displacement: Array,
    still: Mask,
    force: Array,
    least: float,
    interval: float,
    stroke: float,
) -> NDArray[np.int64]:
    """Return at which stop the piston rests: -1 the retracted, 1 the extended, 0 none.

    Parameters
    ----------
    displacement : (n,) array
        [m].
    still : (n,) array of bool
        While the piston does not move.
    force : (n,) array
        On the piston but for its friction [N].
    least : float
        Force by which it is pressed on a stop at the least [N].
    interval, stroke : float
        Of the samples [s]; of the piston [m].
    """
    from scipy.ndimage import binary_opening

    push = averaged(force, interval)
    window = np.ones(max(2, round(PRESSED_FOR / interval)))
    retracted = still & (push < -least) & (displacement < FARTHEST * stroke)
    extended = still & (push > least) & (displacement > (1.0 - FARTHEST) * stroke)
    found = binary_opening(extended, window).astype(np.int64)
    return np.asarray(found - binary_opening(retracted, window))


def judged_at_rest(stuck: Mask, interval: float) -> Mask:
    """Return the moments at which the force on a piston at rest is judged.

    Parameters
    ----------
    stuck : (n,) array of bool
        While nothing but friction holds it.
    interval : float
        Of the samples [s].

    Returns
    -------
    (n,) array of bool
        Of each rest the moment before it ends, when the force is largest, and some before that.

    Examples
    --------
    >>> stuck = (np.arange(500) > 99) & (np.arange(500) < 400)
    >>> np.flatnonzero(judged_at_rest(stuck, 1e-3)).tolist()
    [184, 284, 384]
    """
    found = np.zeros(len(stuck), dtype=bool)
    for _, _, moments in _judged_in_each_rest(stuck, interval):
        found[moments] = True
    return found


def moments_of_rest(stuck: Mask, interval: float) -> Array:
    """Return at how many moments the rest is judged that each sample is part of, at least 1.

    Parameters
    ----------
    stuck, interval
        As for `judged_at_rest`.

    Returns
    -------
    (n,) array
        1 where the piston does not rest.
    """
    found = np.ones(len(stuck))
    for begin, end, moments in _judged_in_each_rest(stuck, interval):
        found[begin:end] = max(1, len(moments))
    return found


def each_rest(stuck: Mask) -> list[tuple[int, int]]:
    """Return the first sample of each rest, and the first after it.

    Examples
    --------
    >>> each_rest(np.array([True, False, True, True]))
    [(0, 1), (2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stuck, [False]]).astype(np.int8)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _judged_in_each_rest(stuck: Mask, interval: float) -> list[tuple[int, int, NDArray[np.int_]]]:
    """Return where each rest begins and ends, and the moments at which it is judged."""
    unsure, apart = round(UNSURE / interval), max(1, round(APART / interval))
    return [
        (begin, end, np.arange(end - 1 - unsure, begin + unsure - 1, -apart))
        for begin, end in each_rest(stuck)
    ]
