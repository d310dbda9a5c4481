"""Noise as transducers and converters have it: white, hum, drift and steps."""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from pneuservo.challenge.truth.parameters import Array

MAINS = 50.0
_DRIFT_CORNER = 0.3  # [Hz]


@dataclass(frozen=True)
class ChannelNoise:
    """How large the noise of one channel is.

    Parameters
    ----------
    white : float
        Root-mean-square of white noise [unit of the channel].
    hum : float, optional
        ... of mains hum and its third harmonic.
    drift : float, optional
        ... of drift.
    step : float, optional
        Step of the converter; 0 for none.
    """

    white: float
    hum: float = 0.0
    drift: float = 0.0
    step: float = 0.0

    @property
    def total(self) -> float:
        """Return the root-mean-square of everything together."""
        return math.hypot(self.white, self.hum, self.drift, self.step / math.sqrt(12.0))

    def times(self, factor: float) -> "ChannelNoise":
        """Return louder noise in front of the same converter."""
        return replace(
            self, white=factor * self.white, hum=factor * self.hum, drift=factor * self.drift
        )


def draw_noise(rms: float, step: float, rng: np.random.Generator) -> ChannelNoise:
    """Return noise of a size, hum and drift in random shares.

    Parameters
    ----------
    rms : float
        Of everything but the converter's steps [unit of the channel].
    step : float
        Step of the converter [unit of the channel].
    rng : Generator
        Draws the shares.

    Returns
    -------
    ChannelNoise
        Hum of up to a third and drift of up to half the white part.
    """
    shares = np.array([1.0, rng.uniform(0.0, 0.35), rng.uniform(0.0, 0.45)])
    white, hum, drift = (rms / np.linalg.norm(shares) * shares).tolist()
    return ChannelNoise(white, hum, drift, step)


def noise(level: ChannelNoise, samples: int, rate: float, rng: np.random.Generator) -> Array:
    """Return noise before conversion.

    Parameters
    ----------
    level : ChannelNoise
        How large.
    samples : int
        How many.
    rate : float
        Samples per second [Hz].
    rng : Generator
        Draws it.

    Returns
    -------
    (samples,) array
        White noise, hum and drift [unit of the channel].
    """
    time = np.arange(samples) / rate
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    hum = np.sin(2.0 * np.pi * MAINS * time + phase[0])
    hum += 0.4 * np.sin(2.0 * np.pi * 3.0 * MAINS * time + phase[1])
    pole = _drift_pole(rate)
    # Run in, so that the drift begins anywhere.
    drift = lfilter([math.sqrt(1.0 - pole**2)], [1.0, -pole], rng.standard_normal(samples + 4000))
    made = level.white * rng.standard_normal(samples) + level.drift * drift[4000:]
    return np.asarray(made + level.hum * hum / math.sqrt(0.5 * (1.0 + 0.4**2)))


def converted(values: Array, level: ChannelNoise) -> Array:
    """Return what a converter with steps makes of the values."""
    return np.round(values / level.step) * level.step if level.step > 0.0 else values


def whitened(values: Array, level: ChannelNoise, rate: float) -> Array:
    """Return values filtered so that the noise in them becomes white with unit variance.

    Parameters
    ----------
    values : (..., n) array
        Noise-free values [unit of the channel].
    level : ChannelNoise
        The noise; its hum is left out, for it stands in two narrow lines.
    rate : float
        Samples per second [Hz].

    Returns
    -------
    (..., n) array
        Filtered along the last axis [-].

    Notes
    -----
    White noise and a first-order drift add up to an ARMA(1, 1) process; this is its inverse.

    Examples
    --------
    >>> import numpy as np
    >>> whitened(np.array([3.0, 3.0]), ChannelNoise(white=1.5), 1000.0)
    array([2., 2.])
    """
    white = level.white**2 + level.step**2 / 12.0
    if level.drift == 0.0:
        return values / math.sqrt(white)
    pole = _drift_pole(rate)
    own = level.drift**2 * (1.0 - pole**2) + white * (1.0 + pole**2)
    half = 0.5 * own / (pole * white)
    zero = half - math.sqrt(half * half - 1.0)
    scale = math.sqrt(pole * white / zero)
    return np.asarray(lfilter([1.0 / scale, -pole / scale], [1.0, -zero], values))


def _drift_pole(rate: float) -> float:
    return math.exp(-2.0 * math.pi * _DRIFT_CORNER / rate)
