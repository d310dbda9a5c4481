"""Mains hum in what a model leaves of a recording: a line that no physics has."""

from collections.abc import Callable, Sequence

import numpy as np

from pneuservo.arrays import Array

MAINS = (50.0, 60.0)
"""Nominal frequencies of the mains [Hz] ..."""
OFF_NOMINAL = 0.2
"""... from which they deviate by less than this [Hz]."""
HARMONICS = (1, 2, 3)
LINE = 15.0
"""A line of so many times the power beside it is no noise: one in three million bins is."""
ALONE = 3.0
"""A line that is not so many times as strong as any beside it is one of many, as a misfit leaves
them that comes back with each step of a command: a leak under a set point that stepped every 0.4 s
was taken for hum of 0.3 to 0.7 times the noise in each way of reading the recordings."""
SLOW = 3.0
"""What is left of a command that repeats more slowly has lines beside those of the mains [Hz]."""
REPEATED = 0.5
"""Share of a command's energy that one frequency has where the command repeats itself."""
_BESIDE = (0.5, 6.0)
"""Distance from a line within which the power beside it is taken [Hz]."""
_LEAST_SEEN = 0.1
"""Share of the samples that a channel has to show a line in."""
_STEP = 0.01
_HIGHEST = 0.45
"""Share of the sampling rate up to which lines are looked for."""


def repeats(command: Array, interval: float) -> bool:
    """Return whether a command repeats itself so fast that what is left of it may pass for hum.

    Parameters
    ----------
    command : (n,) array
        At equal intervals [any unit].
    interval : float
        Between its samples [s].

    Examples
    --------
    >>> t = np.arange(4000) * 1e-3
    >>> repeats(np.sign(np.sin(20 * np.pi * t + 0.1)), 1e-3), repeats(np.sin(t), 1e-3)
    (True, False)
    """
    power = np.abs(np.fft.rfft(command - np.mean(command))) ** 2
    most = int(np.argmax(power))
    line = float(np.sum(power[max(most - 1, 0) : most + 2]))
    fast = most / (len(command) * interval) > SLOW
    return bool(fast and line > REPEATED * float(np.sum(power)))


def hum_in(residuals: Sequence[Array], shares: Sequence[Array], time: Array) -> list[Array]:
    """Return the mains hum that several channels of one recording have in common.

    Parameters
    ----------
    residuals : sequence of (n,) array
        What a model leaves of each channel, in units of its noise; zero where there is nothing.
    shares : sequence of (n,) array
        By how much of itself an error of the reading shows in each residual [-].
    time : (n,) array
        Time of each sample [s].

    Returns
    -------
    list of (n,) array
        Hum of each channel, in units of its noise; zeros where no line stands out.

    Notes
    -----
    Lines at a mains frequency and its harmonics, one frequency for all channels, each fitted by
    least squares and kept where it stands out of the spectrum beside it. A relay that chatters
    near the mains has a broad line, which does not.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(4000) * 1e-3
    >>> noise, line = rng.standard_normal(4000), 0.5 * np.sin(2 * np.pi * 50.04 * t + 1.0)
    >>> found, nothing = hum_in([noise + line, noise], [np.ones(4000)] * 2, t)
    >>> bool(np.std(found - line) < 0.1), bool(np.any(nothing))
    (True, False)
    """
    found = [np.zeros(len(time)) for _ in residuals]
    heard = [
        place
        for place, (left, share) in enumerate(zip(residuals, shares, strict=True))
        if np.any(left) and np.mean(share > 0.0) >= _LEAST_SEEN
    ]
    highest = _HIGHEST / float(np.median(np.diff(time)))
    nominal = [mains for mains in MAINS if mains + OFF_NOMINAL < highest]
    if not heard or not nominal:
        return found
    left, share = (np.array([each[place] for place in heard]).T for each in (residuals, shares))
    off = np.arange(-OFF_NOMINAL, OFF_NOMINAL + 0.5 * _STEP, _STEP)
    tried = [[k * (mains + o) for k in HARMONICS] for mains in nominal for o in off]
    harmonics = [np.array([f for f in multiples if f < highest]) for multiples in tried]
    floors = [_floors(each, time) for each in left.T]
    # What no frequency changes is worked out once: a hundred are tried.
    seen, weights, there = share * left, share**2, np.mean(share > 0.0, axis=0)

    def standing_out(frequencies: Array) -> Array:
        """Return by how much each line exceeds the power beside it in each channel, (m, c)."""
        _, energy = _sizes(seen, weights, _waves(time, frequencies))
        floor = np.array([[of_channel(f) for of_channel in floors] for f in frequencies])
        return np.divide(0.5 * energy * there, floor, out=np.zeros_like(energy), where=floor > 0.0)

    standing = [standing_out(frequencies) for frequencies in harmonics]
    best = max(range(len(tried)), key=lambda n: float(np.sum(standing[n])))
    waves = _waves(time, harmonics[best])
    sizes, _ = _sizes(seen, weights, waves)
    lines = np.moveaxis(waves, 0, -1) @ np.moveaxis(sizes, 1, 2)
    for channel, place in enumerate(heard):
        for ratio, line in zip(standing[best][:, channel], lines, strict=True):
            if ratio > LINE:
                found[place] += line[:, channel]
    return found


def _waves(time: Array, frequencies: Array) -> Array:
    """Return cosine and sine of some frequencies, (2, m, n)."""
    angle = 2.0 * np.pi * frequencies[:, np.newaxis] * time
    return np.stack([np.cos(angle), np.sin(angle)])


def _floors(residual: Array, time: Array) -> Callable[[float], float]:
    """Return a function that gives what a line of some frequency has to stand out of.

    As what a line of one degree of freedom takes; 0 where nothing is beside it.
    """
    bins = np.fft.rfftfreq(len(residual), float(np.median(np.diff(time))))
    power = np.abs(np.fft.rfft(residual)) ** 2 / len(residual)
    near, far = _BESIDE

    def floor(frequency: float) -> float:
        below = np.searchsorted(bins, frequency - far, "right")
        above = np.searchsorted(bins, frequency + far, "left")
        line = np.searchsorted(bins, (frequency - near, np.nextafter(frequency + near, np.inf)))
        around = np.concatenate([power[below : line[0]], power[line[1] : above]])
        # A short recording has nothing beside a line.
        if not len(around):
            return 0.0
        return max(float(np.mean(around)), float(np.max(around)) * ALONE / LINE)

    return floor


def _sizes(seen: Array, weights: Array, waves: Array) -> tuple[Array, Array]:
    """Return sizes of cosine and sine in each channel by least squares, and what they explain.

    (m, c, 2) and (m, c) of m frequencies and c channels.
    """
    along = np.moveaxis(waves @ seen, 0, -1)
    cosine, sine = waves
    even, odd = (cosine * cosine) @ weights, (cosine * sine) @ weights
    squares = np.array([[even, odd], [odd, np.sum(weights, axis=0) - even]])
    # On samples that are missing in a pattern sine and cosine may be the same wave.
    inverse = np.linalg.pinv(np.moveaxis(squares, (0, 1), (-2, -1)), rcond=1e-9, hermitian=True)
    sizes = (inverse @ along[..., np.newaxis])[..., 0]
    return sizes, np.sum(sizes * along, axis=-1)
