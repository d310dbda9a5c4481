"""How noisy a channel is, and how many independent samples a residual holds."""

import numpy as np

from pneuservo.arrays import Array, bridged

WANDER = 0.35
"""The zero of a transducer wanders by up to this share of its white noise ..."""
LIKELY_WANDER = 0.25
"""... by this share as a rule ..."""
WANDER_TIME = 0.5
"""... within this time [s]: a third of the power of recorded noise is below some hertz."""
_TOO_LOW = 7.0
"""The lowest of eight bands of white noise is too low by so much over the root of the number of
samples, as a share of its power: 6.4 to 7.5 from 256 to 100,000 samples ..."""
_LEAST_SHARE = 0.6
"""... and by no more than this leaves where there are fewer."""


def noise_floor(samples: Array, time: Array) -> float:
    """Return the root-mean-square noise of a channel, from the quietest part of its spectrum.

    Parameters
    ----------
    samples : (n,) array
        The channel, n at least 16 [any unit].
    time : (n,) array
        Time of each sample [s].

    Returns
    -------
    float
        Noise, as if it were white up to half the sampling rate [unit of samples].

    Notes
    -----
    The band from a tenth of to half the sampling rate is cut into eight; the lowest mean power
    density, taken over the whole band, is the noise. Content of the signal that fills every
    part of the band makes the figure too high; noise below the quietest band is missed.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(4000) * 1e-3
    >>> bool(abs(noise_floor(np.sin(5 * t) + 0.1 * rng.standard_normal(4000), t) - 0.1) < 0.01)
    True
    """
    from scipy.signal import welch

    # A straight line across what is missing has none.
    present = float(np.mean(np.isfinite(samples)))
    samples = bridged(time, samples)
    rate = 1.0 / float(np.median(np.diff(time)))
    length = min(256, len(samples) // 2)
    # The linear trend of each window would leak into every band.
    frequency, density = welch(samples, rate, nperseg=length, detrend="linear", window="blackman")
    bands = np.array_split(density[(frequency > 0.1 * rate) & (frequency < 0.49 * rate)], 8)
    quietest = min(float(np.mean(band)) for band in bands if len(band))
    return max(float(np.sqrt(quietest * rate / 2.0 / present)), resolution(samples))


def noise_level(samples: Array, time: Array) -> float:
    """Return the noise of a channel without what the quietest of several bands is too low by.

    Parameters
    ----------
    samples : (n,) array
        The channel, n at least 16 [any unit].
    time : (n,) array
        Time of each sample [s].

    Returns
    -------
    float
        Noise, as if it were white up to half the sampling rate [unit of samples].

    Notes
    -----
    Of white noise `noise_floor` is too low by 3.5 % in 10,000 samples and by 8 % in 2,000, for
    chance makes one of the bands the lowest. Where the signal fills some of them it is by less.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> t = np.arange(2000) * 2e-3
    >>> found = [noise_level(rng.standard_normal(2000), t) for _ in range(50)]
    >>> bool(abs(np.mean(found) - 1.0) < 0.02)
    True
    """
    share = max(1.0 - _TOO_LOW / len(samples) ** 0.5, _LEAST_SHARE)
    return noise_floor(samples, time) / share**0.5


def resolution(samples: Array) -> float:
    """Return the difference below which two readings of a channel count as equal.

    Parameters
    ----------
    samples : (n,) array
        The channel; NaN are passed over [any unit].

    Returns
    -------
    float
        A billionth of the largest reading: no transducer resolves that [unit of samples].
    """
    return 1e-9 * float(np.nanmax(np.abs(samples), initial=0.0)) + 1e-15


def effective_samples(residual: Array) -> float:
    """Return how many independent samples a residual is worth.

    Parameters
    ----------
    residual : (n,) array
        Evenly sampled residual; NaN are passed over [any unit].

    Returns
    -------
    float
        n / (1 + 2 sum of autocorrelations), the sum taken up to the first one below 0.05.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> bool(effective_samples(rng.standard_normal(1000)) > 800)
    True
    """
    residual = residual[np.isfinite(residual)]
    n = len(residual)
    spread = residual - residual.mean()
    power = np.abs(np.fft.rfft(spread, 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0.0:
        return float(n)
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0.05)
    end = int(below[0]) if len(below) else n
    return float(min(n, max(4.0, n / (1.0 + 2.0 * float(np.sum(correlation[1:end]))))))


def surrogate(residual: Array, rng: np.random.Generator) -> Array:
    """Return random noise with the spectrum of a residual.

    Parameters
    ----------
    residual : (n,) array
        Evenly sampled, finite.
    rng : Generator
        Source of the random phases.

    Returns
    -------
    (n,) array
        Noise of the same power at every frequency.
    """
    spectrum = np.fft.rfft(residual)
    phases = np.exp(2j * np.pi * rng.random(len(spectrum)))
    phases[0] = 1.0 if rng.random() < 0.5 else -1.0
    return np.fft.irfft(spectrum * phases, len(residual))


def wander(time: Array, rng: np.random.Generator) -> Array:
    """Return how the zero of a transducer wanders, in units of its white noise.

    Parameters
    ----------
    time : (n,) array
        Evenly spaced [s].
    rng : Generator
        Draws it.

    Returns
    -------
    (n,) array
        Steady from the start [-].

    Examples
    --------
    >>> made = wander(np.arange(40000) * 1e-3, np.random.default_rng(1))
    >>> bool(abs(np.std(made) - WANDER) < 0.1)
    True
    """
    from scipy.signal import lfilter

    interval = float(np.median(np.diff(time)))
    pole = float(np.exp(-interval / WANDER_TIME))
    step = WANDER * float(np.sqrt(1.0 - pole**2))
    start = pole * WANDER * rng.standard_normal()
    made, _ = lfilter([step], [1.0, -pole], rng.standard_normal(len(time)), zi=[start])
    return np.asarray(made)
