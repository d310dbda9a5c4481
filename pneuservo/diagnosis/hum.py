"""Mains hum in what a model leaves of a recording: a line that no physics has."""

from collections.abc import Sequence

import numpy as np

from pneuservo.diagnosis.noise import Array

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
    highest = _HIGHEST / float(np.median(np.diff(time)))
    tried = [
        mains + off
        for mains in MAINS
        if mains + OFF_NOMINAL < highest
        for off in np.arange(-OFF_NOMINAL, OFF_NOMINAL + 0.5 * _STEP, _STEP)
    ]
    if not tried:
        return found
    beside = [_powers_beside(r, time) for r in residuals]

    def lines(mains: float) -> list[list[tuple[float, Array]]]:
        """Return how each harmonic stands out of each channel, and its line there."""
        harmonics = [k * mains for k in HARMONICS if k * mains < highest]
        waves = [_waves(time, frequency) for frequency in harmonics]
        return [
            [
                _standing_out(residual, share, wave, frequency, floor)
                for wave, frequency in zip(waves, harmonics, strict=True)
            ]
            for residual, share, floor in zip(residuals, shares, beside, strict=True)
        ]

    best = max((lines(mains) for mains in tried), key=_strength)
    for place, channel in enumerate(best):
        for ratio, line in channel:
            if ratio > LINE:
                found[place] += line
    return found


def _strength(lines: Sequence[Sequence[tuple[float, Array]]]) -> float:
    return sum(ratio for channel in lines for ratio, _ in channel)


def _waves(time: Array, frequency: float) -> Array:
    angle = 2.0 * np.pi * frequency * time
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _powers_beside(residual: Array, time: Array) -> tuple[Array, Array]:
    """Return frequencies, and the power at each as what a line of one degree of freedom takes."""
    step = float(np.median(np.diff(time)))
    power = np.abs(np.fft.rfft(residual)) ** 2 / len(residual)
    return np.asarray(np.fft.rfftfreq(len(residual), step)), np.asarray(power)


def _standing_out(
    residual: Array, share: Array, waves: Array, frequency: float, beside: tuple[Array, Array]
) -> tuple[float, Array]:
    """Return by how much a line exceeds the power beside it, and the line itself."""
    # Of frequencies that rise only those nearby are looked at: this is done a thousand times.
    ends = np.searchsorted(beside[0], (frequency - 2.0 * _BESIDE[1], frequency + 2.0 * _BESIDE[1]))
    near = slice(*ends)
    away = np.abs(beside[0][near] - frequency)
    around = beside[1][near][(away > _BESIDE[0]) & (away < _BESIDE[1])]
    # A short recording has nothing beside a line.
    floor = (
        max(float(np.mean(around)), float(np.max(around)) * ALONE / LINE) if len(around) else 0.0
    )
    there = float(np.mean(share > 0.0))
    if not floor > 0.0 or there < _LEAST_SEEN:
        return 0.0, np.zeros(len(waves))
    seen = waves * share[:, np.newaxis]
    # On samples that are missing in a pattern sine and cosine may be the same wave.
    along = seen.T @ residual
    size = np.linalg.lstsq(seen.T @ seen, along, rcond=1e-9)[0]
    return 0.5 * float(size @ along) * there / floor, waves @ size
