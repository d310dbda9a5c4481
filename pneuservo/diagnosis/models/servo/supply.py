"""The supply pressure as source and line would have it, held against a measured one."""

import numpy as np

from pneuservo.arrays import Array, bridged
from pneuservo.effects.supply import RIPPLE
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.supply_effects import (
    SupplyEffects,
    has_reservoir,
    reservoir_rate,
    source_pressure,
)
from pneuservo.plant.single_axis import SingleAxis

SMOOTHING = (3e-3, 1e-2, 3e-2, 0.1, 0.3)
"""Times over which a measured supply pressure may be averaged [s]."""
_FINER = 4
_FEWEST_SWINGS = 3.0
_BESIDE = 40
"""So many lines are beside one."""
_HALVINGS = 40
"""Of the bracket of the pressure after a step: to a billionth of a bar."""


def smoothed_supply(time: Array, reading: Array) -> Array:
    """Return a measured supply pressure without most of its noise.

    Parameters
    ----------
    time, reading : (n,) array
        [s], [Pa]; NaN where there is no reading.

    Notes
    -----
    Averaged over that of the times `SMOOTHING` whose means tell the sample in their middle best by
    the others (leave-one-out cross-validation, Stone 1974), or not at all where the reading itself
    is better. A chamber that is open to the supply follows it: with means over 3 ms, what they left
    of the noise made a laminar tail of the valve, which gained 84 and 96 in recordings without any.

    Examples
    --------
    A steady pressure is averaged for long, a dip is not smeared:

    >>> t = np.arange(2000) * 1e-3
    >>> noise = 300.0 * np.random.default_rng(1).standard_normal(2000)
    >>> round(float(np.std(smoothed_supply(t, 6e5 + noise))) / 300.0, 1)
    0.1
    >>> dip = -2e4 * np.exp(-(((t - 1.0) / 0.02) ** 2))
    >>> round(float(np.min(smoothed_supply(t, 6e5 + dip + noise))), -3)
    580000.0
    """
    from scipy.ndimage import uniform_filter1d

    closed, interval = bridged(time, reading), float(np.median(np.diff(time)))
    # What a reading tells of the pressure, and of another reading, whose noise is its own.
    best, least = closed, float(np.mean(np.diff(closed) ** 2))
    for over in SMOOTHING:
        width = 2 * max(1, round(0.5 * over / interval)) + 1
        mean = uniform_filter1d(closed, width, mode="nearest")
        missed = float(np.mean((closed - mean) ** 2)) / (1.0 - 1.0 / width) ** 2
        if missed < least:
            best, least = np.asarray(mean), missed
    return best


def expected_supply(
    time: Array, level: float, drawn: Array, plant: SingleAxis, effects: SupplyEffects
) -> Array:
    """Return what a transducer at the valve's supply port should read [Pa].

    Parameters
    ----------
    time : (n,) array
        [s].
    level : float
        Pressure of the source [Pa].
    drawn : (n,) array
        Mass flow that the valve takes [kg/s].
    plant, effects
        The numbers of rig and supply.

    Examples
    --------
    >>> from pneuservo.rigs.plant_numbers import single_axis
    >>> from pneuservo.rigs import load_rig
    >>> plant = single_axis(load_rig("single-axis"))
    >>> t = np.array([0.0, 0.1])
    >>> expected_supply(t, 6e5, 0.0 * t, plant, SupplyEffects(drift=1e3)).tolist()
    [600000.0, 600100.0]
    """
    expected: Array = _expected(
        time, level, drawn, plant.polytropic_index, plant.gas, effects, _HALVINGS
    )
    return expected


def strongest_frequency(time: Array, reading: Array) -> float:
    """Return the frequency at which a supply pressure swings most [Hz].

    Parameters
    ----------
    time, reading : (n,) array
        [s], [Pa].

    Notes
    -----
    Of the spectrum without mean and trend, four times as fine as the length of the recording
    allows: a fit of a frequency has to begin within a period of it.

    Examples
    --------
    >>> t = np.arange(4000) * 1e-3
    >>> round(strongest_frequency(t, 6e5 + np.sin(2 * np.pi * 3.1 * t)), 1)
    3.1
    """
    frequency, power = _spectrum(time, reading)
    return float(frequency[int(np.argmax(power))])


def sharpest_frequency(time: Array, left: Array) -> float:
    """Return the frequency at which something swings far more than at those beside it [Hz].

    Parameters
    ----------
    time, left : (n,) array
        [s]; what is left of a channel, in which much else may be stronger.

    Notes
    -----
    The highest of the spectrum over its running median.

    Examples
    --------
    >>> t = np.arange(4000) * 1e-3
    >>> slow = np.cumsum(np.random.default_rng(1).standard_normal(4000))
    >>> round(sharpest_frequency(t, slow + 10.0 * np.sin(2 * np.pi * 14.0 * t)), 1)
    14.0
    """
    from scipy.ndimage import median_filter

    frequency, power = _spectrum(time, left)
    beside = median_filter(power, _BESIDE * _FINER + 1)
    return float(frequency[int(np.argmax(power / np.maximum(beside, 1e-9 * np.max(power))))])


def phase_of(time: Array, reading: Array, frequency: float) -> float:
    """Return the phase of the swing of a frequency, as that of a sine at the first sample [rad].

    Parameters
    ----------
    time, reading : (n,) array
        [s]; what swings, among other things.
    frequency : float
        Of the swing [Hz].

    Examples
    --------
    >>> t = np.arange(4000) * 1e-3
    >>> round(phase_of(t, 6e5 + np.sin(2 * np.pi * 3.1 * t + 2.0), 3.1), 1)
    2.0
    """
    from scipy.signal import detrend

    turned = np.exp(-2j * np.pi * frequency * (time - time[0]))
    return float(np.angle(1j * np.sum(detrend(bridged(time, reading)) * turned)))


def _spectrum(time: Array, reading: Array) -> tuple[Array, Array]:
    """Return the frequencies that a ripple may have [Hz], and the power there."""
    from scipy.signal import detrend

    swing = detrend(bridged(time, reading))
    step, size = float(np.median(np.diff(time))), _FINER * len(swing)
    power = np.asarray(np.abs(np.fft.rfft(swing, size)) ** 2, dtype=np.float64)
    frequency = np.asarray(np.fft.rfftfreq(size, step), dtype=np.float64)
    # What swings less than three times is as well a drift.
    possible = RIPPLE.parameters[1]
    lowest = max(possible.low, _FEWEST_SWINGS / float(time[-1] - time[0]))
    within = (frequency >= lowest) & (frequency <= possible.high)
    # Too short for any of them: the highest there is.
    within[-1] |= not within.any()
    return frequency[within], power[within]


@compiled
def _expected(time, level, drawn, polytropic_index, gas, effects, halvings):
    found = np.empty_like(time)
    pressure = source_pressure(level, time[0], effects)
    found[0] = pressure
    for k in range(1, time.shape[0]):
        source = source_pressure(level, time[k], effects)
        if not has_reservoir(effects):
            found[k] = source
            continue
        interval = time[k] - time[k - 1]
        # The refill gets steep where the drop is small: a step that ends where its rate is taken.
        low, high = 0.0, max(pressure, source)
        for _ in range(halvings):
            middle = 0.5 * (low + high)
            rate = reservoir_rate(middle, source, drawn[k], polytropic_index, gas, effects)
            if middle - pressure > interval * rate:
                high = middle
            else:
                low = middle
        pressure = 0.5 * (low + high)
        found[k] = pressure
    return found
