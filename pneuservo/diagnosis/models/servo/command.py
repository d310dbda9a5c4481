"""The command between its samples: held, or running on from one to the next."""

import math

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.gaps import GAP
from pneuservo.diagnosis.models.servo.noisy_command import without_jumps
from pneuservo.diagnosis.models.servo.set_point import AtOnce, beside

FINEST_PART = 250e-6
"""A command that runs on is followed in straight parts of about this length [s]."""
_EDGE = 0.6
"""Error of the moment of a jump of the command, as a share of the sampling interval: at most
half of it to either side, and a little for what a curve swings over beside it."""
_CURVE = 0.05
"""Error of a curve through samples, as a share of how sharply they bend."""
_BENT = 0.2
"""Share of that which is left where its bends are fitted."""
_OF_A_JUMP = 2.0
"""A command that moves by more than so many times what it does in both neighbours jumps."""
_SETTLED = 6.0
"""Time constants after which a spool stands still."""
_FINER = 10
"""Parts of an interval in which a spool's reply is worked out."""
_CALM_SAMPLES = 51
"""Samples over which the noise of a command is looked for."""
_CHATTER = 0.1
"""What is found of more than this (rms) is chatter and no noise of a command [V]."""
_FEWEST = 3
"""Samples that a curve can be drawn through."""
_AT_A_LEVEL = 0.02
"""Share of what lies between its two levels by which a relay may be off them ..."""
_OF_A_RELAY = 0.9
"""... in this share of the samples ..."""
_AT_LEAST = 0.1
"""... of which each level has this one."""
_NEARBY = 11
"""Samples over which it shows how often a relay switches."""
_LEAST_EVEN = 0.01
"""Where it switches in every other interval, nothing is known of how often it does within one."""


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


def running_command(time: Array, voltage: Array, limit: float, told: AtOnce | None = None) -> Array:
    """Return a command that runs on smoothly between its samples.

    Parameters
    ----------
    time, voltage : (n,) array
        As sampled [s], [V].
    limit : float
        Beyond this the valve's driver does not go [V].
    told : AtOnce, optional
        What the set point of the loop changes of it at once, where that was recorded, at the end of
        each interval; where nobody knows how much, it stays as it was until then.

    Returns
    -------
    (n, m + 1) array
        At the ends of the m equal parts of each sampling interval, straight in between [V].

    Notes
    -----
    A cubic whose slopes come from five samples each, and no farther than the driver goes. Of a
    swing at a fifth of the sampling rate, as loops of an analogue relay have it, straight lines
    between samples lack 13 %, and this 2 %. A spline through all of them would ring where it jumps.

    Examples
    --------
    >>> t = np.arange(5) * 1e-3
    >>> running_command(t, 1e3 * t, 5.0)[1].tolist()
    [1.0, 1.25, 1.5, 1.75, 2.0]
    >>> jumps = AtOnce(np.where(t < 1.5e-3, 0.0, 4.0), np.zeros(4, dtype=bool))
    >>> running_command(t, 1e2 * t + jumps.added, 5.0, jumps)[1:3].round(3).tolist()
    [[0.1, 0.125, 0.15, 0.175, 0.2], [4.2, 4.225, 4.25, 4.275, 4.3]]
    """
    steps = np.diff(time)
    interval = float(np.median(steps))
    parts = max(1, math.ceil(interval / FINEST_PART - 1e-9))
    found = np.repeat(voltage[:, np.newaxis], parts + 1, axis=1)
    gaps = steps > GAP * interval
    found[:-1][gaps] = np.linspace(voltage[:-1][gaps], voltage[1:][gaps], parts + 1, axis=1)
    sudden = np.zeros_like(voltage) if told is None else told.added
    ends = np.flatnonzero(gaps if told is None else gaps | told.unknown) + 1
    for first, end in zip([0, *ends], [*ends, len(time)], strict=True):
        if end - first >= _FEWEST:
            within = slice(first, end)
            smooth = _curve(time[within], (voltage - sudden)[within], parts)
            found[first : end - 1] = smooth + sudden[first : end - 1, np.newaxis]
    return np.clip(found, -limit, limit)


def unseen(voltage: Array, told: AtOnce | None = None, of_noise: bool = False) -> Array:
    """Return by how much a command that runs on may be off between two samples [V].

    Parameters
    ----------
    voltage, told
        As in `running_command`.
    of_noise : bool, optional
        Whether it is the noise that its loop hears, and its bends are fitted, see
        `pneuservo.diagnosis.models.servo.noisy_command`.

    Returns
    -------
    (n,) array
        Of each sampling interval, of its mean.

    Notes
    -----
    When a command jumped that moves in one interval alone is not known, unless the set point says
    so. At a fifth of the sampling rate jumps and swings look alike, but for what goes all of
    the way from one level to the other: that jumps. Noise comes to every interval.

    Examples
    --------
    >>> unseen(np.array([0.0, 0.0, 0.0, 4.0, 4.0, 4.0])).round(2).tolist()
    [0.0, 0.2, 2.6, 0.2, 0.0, 0.0]
    >>> unseen(np.arange(6.0) ** 2).round(2).tolist()
    [0.1, 0.1, 0.1, 0.1, 0.1, 0.1]
    >>> unseen(np.array([5.0, -5.0, 5.0, 5.0, -5.0, 5.0])).tolist()
    [7.0, 7.0, 0.5, 7.0, 7.0, 7.0]
    """
    smooth = voltage if told is None else voltage - told.added
    change = np.diff(smooth)
    if told is not None:
        change = np.where(told.unknown, 0.0, change)
    moves = np.abs(change)
    switches = _switches(smooth)
    jump = np.where(switches, moves, np.maximum(moves - _OF_A_JUMP * beside(moves), 0.0))
    curve = np.abs(np.diff(change, prepend=change[0], append=change[-1]))
    bend = np.maximum(curve[:-1], curve[1:])
    if of_noise:
        noisy = without_jumps(change) & ~switches
        off = np.where(noisy, _BENT * _CURVE * bend, _EDGE * jump + _CURVE * bend)
    else:
        off = np.hypot(_EDGE * jump + _CURVE * bend, noise_of_command(smooth))
    return np.append(off, off[-1:])


def _switches(voltage: Array) -> Mask:
    """Return in which intervals a command goes all of the way from one of its ends to the other."""
    low, high = float(np.min(voltage)), float(np.max(voltage))
    return np.asarray(np.abs(np.diff(voltage)) > (1.0 - 2.0 * _AT_A_LEVEL) * (high - low))


def is_relay(voltage: Array) -> bool:
    """Return whether a command is that of an ideal relay: nearly always at one of two levels.

    Parameters
    ----------
    voltage : (n,) array
        As sampled [V].

    Examples
    --------
    >>> is_relay(np.array([5.0, -5.0, -5.0, 5.0, 5.0, -5.0]))
    True
    >>> is_relay(np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])), is_relay(np.zeros(6))
    (False, False)
    """
    low, high = float(np.min(voltage)), float(np.max(voltage))
    near = _AT_A_LEVEL * (high - low)
    shares = np.mean(voltage <= low + near), np.mean(voltage >= high - near)
    return bool(low < high and sum(shares) > _OF_A_RELAY and min(shares) > _AT_LEAST)


def as_it_may_have_been(command: Array, voltage: Array, rng: np.random.Generator) -> Array:
    """Return the mean of a command that runs on in each part of each sampling interval [V].

    Parameters
    ----------
    command : (n, m + 1) array
        From `running_command`.
    voltage : (n,) array
        As sampled [V].
    rng : Generator
        Draws the moments at which an ideal relay switched between samples.

    Returns
    -------
    (n, m) array
        Of the m equal parts.

    Examples
    --------
    >>> straight, rng = np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 5.0]]), np.random.default_rng(1)
    >>> as_it_may_have_been(straight, np.array([1.0, 3.0, 5.0]), rng).tolist()
    [[1.5, 2.5], [3.5, 4.5]]
    """
    means = 0.5 * (command[:, :-1] + command[:, 1:])
    if not is_relay(voltage):
        return means
    parts = np.arange(means.shape[1])
    after = np.append(voltage[1:], voltage[-1:])
    middle = 0.5 * (float(np.min(voltage)) + float(np.max(voltage)))
    switched = (voltage > middle) != (after > middle)
    twice = ~switched & (rng.random(len(voltage)) < _switching_twice(switched))
    first, last = np.sort(len(parts) * rng.random((2, len(voltage))), axis=0)
    last = np.where(switched, len(parts), np.where(twice, last, first))
    other = np.where(switched, after, 2.0 * middle - voltage)
    # How much of each part lies between both switches.
    ends = (np.clip(moment[:, np.newaxis] - parts, 0.0, 1.0) for moment in (first, last))
    between = -np.subtract(*ends)
    return np.asarray(voltage[:, np.newaxis] + between * (other - voltage)[:, np.newaxis])


def _switching_twice(switched: Mask) -> Array:
    """Return how likely each interval without a switch hides two, from how often others have one.

    As if switches came at random: an odd number of them shows in the samples, an even one not.
    """
    from scipy.ndimage import uniform_filter1d

    odd = uniform_filter1d(switched.astype(float), _NEARBY, mode="nearest")
    none = np.sqrt(np.maximum(1.0 - 2.0 * odd, _LEAST_EVEN))
    return np.asarray(1.0 - none / (0.5 * (1.0 + none**2)))


def noise_of_command(voltage: Array) -> float:
    """Return how much of a command is noise, from the calmer half of it; chatter is none [V].

    Noise that reaches beyond half the sampling rate says nothing of the mean between two samples.
    Of a swing at a fifth of that rate 16 % of the amplitude pass for noise, at a tenth 1 %.

    Parameters
    ----------
    voltage : (n,) array
        As sampled [V].

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> slow = np.sin(0.03 * np.arange(4000))
    >>> bool(abs(noise_of_command(slow + 0.01 * rng.standard_normal(4000)) - 0.01) < 0.001)
    True
    >>> round(noise_of_command(np.repeat([0.0, 1.0, 3.0], 100)), 6)
    0.0
    """
    from scipy.ndimage import uniform_filter1d

    if len(voltage) < _CALM_SAMPLES:
        return 0.0
    # Fourth differences of a slow swing are next to nothing; those of noise are sqrt(70) of it.
    squares = uniform_filter1d(np.diff(voltage, 4) ** 2 / 70.0, _CALM_SAMPLES)
    noise = float(np.sqrt(max(np.median(squares), 0.0)))
    return noise if noise < _CHATTER else 0.0


def settling_time(frequency: float, damping: float) -> float:
    """Return after how long a spool stands still [s].

    Parameters
    ----------
    frequency, damping : float
        Of the spool [rad/s], [-].
    """
    return _SETTLED / (damping * frequency)


def followed_by_spool(
    off: Array, interval: float, frequency: float, damping: float
) -> tuple[Array, Array]:
    """Return what a spool makes of a command that is off for a while.

    Parameters
    ----------
    off : (n,) array
        By how much its mean may be off in each sampling interval [V].
    interval : float
        Between samples [s].
    frequency, damping : float
        Of the spool [rad/s], [-].

    Returns
    -------
    mean, at_samples : (n,) array
        The same of the mean opening in each interval, and of the opening at each sample [V].

    Examples
    --------
    >>> off = np.array([0.0, 1.0, 0.0, 0.0, 0.0])
    >>> mean, at_samples = followed_by_spool(off, 1e-3, 1256.0, 0.7)
    >>> mean.round(2).tolist(), at_samples.round(2).tolist()
    ([0.0, 0.17, 0.5, 0.3, 0.07], [0.0, 0.0, 0.42, 0.45, 0.16])
    """
    from scipy.signal import step

    intervals = math.ceil(settling_time(frequency, damping) / interval)
    moments = interval / _FINER * np.arange(_FINER * intervals + 1)
    _, reply = step(([frequency**2], [1.0, 2.0 * damping * frequency, frequency**2]), T=moments)
    # Of one interval: the reply to a step less the same one interval later.
    pulse = np.abs(reply - np.concatenate([np.zeros(_FINER), reply[:-_FINER]]))
    means = 0.5 * (pulse[1:] + pulse[:-1]).reshape(intervals, _FINER).mean(axis=1)
    ends = pulse[::_FINER]
    mean, at_samples = (np.convolve(off, part)[: len(off)] for part in (means, ends))
    return mean, at_samples


def _curve(time: Array, voltage: Array, parts: int) -> Array:
    """Return the cubic at the ends of all parts of all intervals [V]."""
    from scipy.interpolate import CubicHermiteSpline

    slope = np.gradient(voltage, time)
    # Of evenly spaced samples, exact to the fourth order (Fornberg 1988).
    slope[1:-1] += np.diff(slope, 2) / -6.0
    curve = CubicHermiteSpline(time, voltage, slope)
    return np.asarray(curve(np.linspace(time[:-1], time[1:], parts + 1, axis=1)))
