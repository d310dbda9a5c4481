"""The command between its samples: held, or running on from one to the next."""

import math

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.model import Array

FINEST_PART = 250e-6
"""A command that runs on is followed in straight parts of about this length [s]."""
_FEWEST = 3
"""Samples that a curve can be drawn through."""


def held_command(voltage: Array) -> Array:
    """Return a command that stays as it is until the next sample.

    Parameters
    ----------
    voltage : (n,) array
        As sampled [V].

    Returns
    -------
    (n, 2) array
        At the beginning and the end of each sampling interval [V].

    Examples
    --------
    >>> held_command(np.array([1.0, 3.0])).tolist()
    [[1.0, 1.0], [3.0, 3.0]]
    """
    return np.column_stack([voltage, voltage])


def running_command(time: Array, voltage: Array, limit: float, demand: Array | None) -> Array:
    """Return a command that runs on smoothly between its samples.

    Parameters
    ----------
    time, voltage : (n,) array
        As sampled [s], [V].
    limit : float
        Beyond this the valve's driver does not go [V].
    demand : (n,) array or None
        Set point of the loop, where it was recorded: when it jumps, so does the command, and until
        then it stays as it was [m].

    Returns
    -------
    (n, m + 1) array
        At the ends of the m equal parts of each sampling interval, straight in between [V].

    Notes
    -----
    A cubic with the mean slope of both neighbours at each sample (Catmull and Rom 1974), and no
    farther than the driver goes. Straight lines between samples lack 15 % of a swing at a fifth of
    the sampling rate, as loops of an analogue relay have it; this lacks 2 %.

    Examples
    --------
    >>> t = np.arange(5) * 1e-3
    >>> running_command(t, 1e3 * t, 5.0, None)[1].tolist()
    [1.0, 1.25, 1.5, 1.75, 2.0]
    >>> step = np.where(t < 1.5e-3, 0.0, 1.0)
    >>> running_command(t, 4.0 * step, 5.0, step)[:3].tolist()
    [[0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0], [4.0, 4.0, 4.0, 4.0, 4.0]]
    """
    parts = max(1, math.ceil(float(np.median(np.diff(time))) / FINEST_PART - 1e-9))
    found = np.repeat(voltage[:, np.newaxis], parts + 1, axis=1)
    jumps = np.zeros(0, dtype=np.int64)
    if demand is not None:
        jumps = np.flatnonzero(_jumping(demand)) + 1
    for first, end in zip([0, *jumps], [*jumps, len(time)], strict=True):
        if end - first >= _FEWEST:
            within = slice(first, end)
            found[first : end - 1] = _curve(time[within], voltage[within], parts)
    return np.clip(found, -limit, limit)


def _jumping(demand: Array) -> NDArray[np.bool_]:
    """Return in which intervals a set point jumps: it moves there and in neither neighbour."""
    moves = np.abs(np.diff(demand))
    beside = np.maximum(np.append(0.0, moves[:-1]), np.append(moves[1:], 0.0))
    return np.asarray(moves > 10.0 * beside)


def _curve(time: Array, voltage: Array, parts: int) -> Array:
    """Return the cubic at the ends of all parts of all intervals [V]."""
    from scipy.interpolate import CubicHermiteSpline

    curve = CubicHermiteSpline(time, voltage, np.gradient(voltage, time))
    moments = time[:-1, np.newaxis] + np.diff(time)[:, np.newaxis] * np.linspace(
        0.0, 1.0, parts + 1
    )
    moments[:, -1] = time[1:]
    return np.asarray(curve(moments))
