"""When a piston rests: where it looks like it, and the samples at which that begins and ends."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array, Mask

Likely = Callable[[Mask], Array]
"""Takes where a piston rests and returns how likely that makes each reading, as a logarithm."""

REST_TIME = 0.1
"""Time over which it has to look at rest [s] ..."""
SHORT_REST = 0.02
"""... or over which it has to keep its place, while it sticks and slips ..."""
FORCE_SMOOTHING = 5e-3
"""Time over which pressures are averaged where the force that they give is asked for [s]."""
_REST_FORCES = ((FORCE_SMOOTHING, 5.0), (2e-3, 6.0))
"""... and over which that force, averaged over the first, may swing by more than all of the Coulomb
friction by the second, in its own noise (a relay at 180 Hz swings once in 5 ms), where it would
swing by less than so many times ..."""
CHATTER = 5.0
"""... the displacement's noise: in chatter too a piston moves by less."""
_AT_FIRST = np.arange(-0.024, 0.0481, 0.004)
_THEN = np.arange(-0.003, 0.0031, 0.001)
"""By how much later a rest may end, or begin, than at first sight [s]; what moves within the time
it is looked at over ends it too early. It never begins earlier: the way to it would pass for it."""


def rests_at_first_sight(likelier: Array, chatter: Mask, interval: float) -> Mask:
    """Return where a piston rests, from how much likelier that makes each reading.

    Parameters
    ----------
    likelier : (n,) array
        Logarithm of how much likelier each reading is while it rests throughout.
    chatter : (n,) array of bool
        Where the displacement does not tell, from `chatters`.
    interval : float
        Of the samples [s].
    """
    from scipy.ndimage import uniform_filter1d

    width = max(1, round(REST_TIME / interval))
    return np.asarray(uniform_filter1d(likelier, width, mode="nearest") > 0.0) & ~chatter


def keeps_its_place(
    reading: Array, variance: float, moving: Array, chatter: Mask, interval: float, over: float
) -> Mask:
    """Return where a piston keeps its place for some time.

    Parameters
    ----------
    reading : (n,) array
        Displacement [m].
    variance : float
        Of its noise [m^2].
    moving : (n,) array
        Logarithm of how likely each reading is while it moves throughout.
    chatter, interval
        As in `rests_at_first_sight`.
    over : float
        So long, `SHORT_REST` or `REST_TIME` [s].
    """
    from scipy.ndimage import binary_dilation, uniform_filter1d

    width = max(2, round(over / interval))
    if width >= len(reading):
        return np.zeros(len(reading), dtype=np.bool_)
    beside = reading - np.mean(reading)
    spread = uniform_filter1d(beside**2, width) - uniform_filter1d(beside, width) ** 2
    # The place itself is taken from the same readings.
    still = -0.5 * (spread / variance + math.log(variance) + math.log(width) / width)
    keeps = still > uniform_filter1d(moving, width)
    return np.asarray(binary_dilation(keeps, np.ones(width)) & ~chatter)


def settled(rest: Mask, likely: Callable[[Mask], Likely], interval: float) -> Mask:
    """Return where a piston rests, from when it is likeliest to rest to when it breaks away.

    Parameters
    ----------
    rest : (n,) array of bool
        Where it does at first sight.
    likely : callable
        Takes where it rests and returns a `Likely` for what is close to that.
    interval : float
        Of the samples [s].
    """
    for offsets in (_AT_FIRST, _THEN):
        shifts = np.unique(np.round(offsets / interval).astype(int))
        rest = _shifted(rest, likely(rest), shifts, interval, False)
        rest = _shifted(rest, likely(rest), shifts[shifts >= 0], interval, True)
    return rest


def _shifted(
    rest: Mask, likely: Likely, shifts: NDArray[np.int_], interval: float, begins: bool
) -> Mask:
    """Return rests each of which begins, or ends, at the likeliest of some samples."""
    changes = np.diff(rest.astype(int))
    edges = np.flatnonzero(changes == (1 if begins else -1)) + 1
    if not len(edges):
        return rest
    every = np.concatenate([[0], np.flatnonzero(changes) + 1, [len(rest)]])
    place = np.searchsorted(every, edges)
    before, after = every[place - 1] - edges, every[place + 1] - edges
    reach = round(REST_TIME / interval)
    first, last = edges + np.maximum(before, -reach), edges + np.minimum(after, reach)
    # A rest may reach the next one, but not vanish.
    tried = np.clip(shifts[:, np.newaxis], before // 2, after // 2 if begins else after)
    scores = np.empty(tried.shape)
    for score, moved in zip(scores, tried, strict=True):
        summed = np.append(0.0, np.cumsum(likely(_with_edges(rest, edges, moved, begins))))
        score[:] = summed[last] - summed[first]
    likeliest = np.take_along_axis(tried, np.argmax(scores, axis=0)[np.newaxis], axis=0)[0]
    return _with_edges(rest, edges, likeliest, begins)


def _with_edges(rest: Mask, edges: NDArray[np.int_], moved: NDArray[np.int_], begins: bool) -> Mask:
    found = rest.copy()
    for edge, by in zip(edges, moved, strict=True):
        found[min(edge, edge + by) : max(edge, edge + by)] = (by > 0) != begins
    return found


def chatters(
    driving: Array, driving_rms: float, friction: float, noise: float, interval: float
) -> Mask:
    """Return where a force would move a piston to and fro by less than its displacement tells.

    Parameters
    ----------
    driving : (n,) array
        Acceleration that the pressures would give without friction [m/s^2].
    driving_rms : float
        Its noise [m/s^2].
    friction : float
        Acceleration that the Coulomb friction takes: a force that swings by less than twice that
        does not move the piston [m/s^2].
    noise : float
        Of the displacement [m].
    interval : float
        Of the samples [s].
    """
    swings = np.zeros(len(driving), dtype=np.bool_)
    for over, by in _REST_FORCES:
        known = driving_rms / math.sqrt(averaged_samples(interval, over))
        swings |= _swing(driving, interval, over) > 2.0 * friction + by * known
    return swings & (_would_swing(driving, interval) < CHATTER * noise)


def _swing(driving: Array, interval: float, over: float) -> Array:
    """Return from where to where the averaged force goes around each sample."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = max(1, round(REST_TIME / interval))
    smooth = averaged(driving, interval, over)
    return np.asarray(maximum_filter1d(smooth, width) - minimum_filter1d(smooth, width))


def _would_swing(driving: Array, interval: float) -> Array:
    """Return by how much it would move a free piston to and fro around each sample [m]."""
    from scipy.ndimage import uniform_filter1d
    from scipy.signal import savgol_filter

    width = 2 * round(0.5 * REST_TIME / interval) + 1
    if not 3 < width <= len(driving):
        return np.zeros_like(driving)
    # Beside values with which the observer runs away it swings without end, and that is no error.
    with np.errstate(over="ignore"):
        way = np.cumsum(np.cumsum(driving - np.mean(driving))) * interval**2
        beside = way - savgol_filter(way, width, 2)
        return np.asarray(np.sqrt(np.abs(uniform_filter1d(beside**2, width, mode="nearest"))))


def averaged(readings: Array, interval: float, over: float = FORCE_SMOOTHING) -> Array:
    """Return pressures, or the force that they give, without most of their noise.

    Parameters
    ----------
    readings : (..., n) array
        [any unit].
    interval : float
        Of the samples [s].
    over : float, optional
        Time round each sample that is averaged over [s].
    """
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(readings, averaged_samples(interval, over), mode="nearest"))


def averaged_samples(interval: float, over: float = FORCE_SMOOTHING) -> int:
    """Return how many samples `averaged` takes the mean of.

    Parameters
    ----------
    interval, over : float
        Of the samples; that is averaged over [s].
    """
    return max(1, round(over / interval))
