"""The supply pressure as source and line would have it, held against a measured one."""

import numpy as np

from pneuservo.diagnosis.models.model import Array
from pneuservo.effects.supply import RIPPLE
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.supply_effects import (
    SupplyEffects,
    has_reservoir,
    reservoir_rate,
    source_pressure,
)
from pneuservo.plant.single_axis import SingleAxis

_FINER = 4
_FEWEST_SWINGS = 3.0
_HALVINGS = 40
"""Of the bracket of the pressure after a step: to a billionth of a bar."""


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
    >>> from pneuservo.plant.from_rig import single_axis
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
    from scipy.signal import detrend

    swing = detrend(np.interp(time, time[np.isfinite(reading)], reading[np.isfinite(reading)]))
    step, size = float(np.median(np.diff(time))), _FINER * len(swing)
    power = np.abs(np.fft.rfft(swing, size)) ** 2
    # What swings less than three times is as well a drift.
    lowest = max(RIPPLE.parameters[1].low, _FEWEST_SWINGS / float(time[-1] - time[0]))
    power[np.fft.rfftfreq(size, step) < lowest] = 0.0
    return max(float(np.fft.rfftfreq(size, step)[int(np.argmax(power))]), lowest)


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
