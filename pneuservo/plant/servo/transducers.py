"""From what is to what the transducers read, and back."""

import numpy as np

from pneuservo.arrays import Array
from pneuservo.plant.gas import Gas
from pneuservo.plant.servo.compilation import compiled_whole
from pneuservo.plant.servo.sensor_effects import (
    SensorEffects,
    displacement_error,
    displacement_gain,
    dynamic_pressure,
)


@compiled_whole
def first_order_lag(time, values, time_constant):
    """Return a signal after a first-order lag, settled at the first sample.

    Parameters
    ----------
    time : (n,) array
        Increasing [s].
    values : (n,) array
        The signal, straight between samples.
    time_constant : float
        Greater than 0 [s].

    Examples
    --------
    >>> first_order_lag(np.array([0.0, 1.0]), np.array([0.0, 1.0]), 1.0).round(4).tolist()
    [0.0, 0.3679]
    """
    result = np.empty_like(values)
    result[0] = values[0]
    for k in range(1, len(values)):
        step = time[k] - time[k - 1]
        slope = (values[k] - values[k - 1]) / step
        before = values[k - 1] - slope * time_constant
        result[k] = values[k] - slope * time_constant
        result[k] += (result[k - 1] - before) * np.exp(-step / time_constant)
    return result


@compiled_whole
def play(values, half_width):
    """Return a signal after play, which starts without slack taken up.

    Parameters
    ----------
    values : (n,) array
        The signal.
    half_width : float
        Of the play, in the unit of the signal.
    """
    result = np.empty_like(values)
    position = values[0]
    for k in range(len(values)):
        position = min(max(position, values[k] - half_width), values[k] + half_width)
        result[k] = position
    return result


def in_steps(values: Array, step: float) -> Array:
    """Return a signal rounded to a resolution, or as it is for a resolution of 0."""
    if step <= 0.0:
        return values
    whole: Array = np.round(values / step) * step
    return whole


def read_pressures(
    time: Array,
    pressure_a: Array,
    pressure_b: Array,
    mass_flow_a: Array,
    mass_flow_b: Array,
    voltage: Array,
    gas: Gas,
    sensor: SensorEffects,
) -> tuple[Array, Array]:
    """Return what the pressure transducers have, before noise, range and resolution [Pa].

    Parameters
    ----------
    time : (n,) array
        [s].
    pressure_a, pressure_b : (n,) array
        In the chambers [Pa].
    mass_flow_a, mass_flow_b : (n,) array
        Through the pipes in which the transducers sit [kg/s].
    voltage : (n,) array
        That drives the valve at each sample [V].
    gas : Gas
        The gas.
    sensor : SensorEffects
        The effects.
    """
    readings = []
    offset_a, offset_b = _offsets(voltage, sensor)
    for pressure, flow, gain, offset in (
        (pressure_a, mass_flow_a, sensor.pressure_a_gain, offset_a),
        (pressure_b, mass_flow_b, sensor.pressure_b_gain, offset_b),
    ):
        reading = pressure
        if sensor.static_share != 0.0:
            reading = reading - sensor.static_share * dynamic_pressure(flow, pressure, gas)
        reading = reading * (1.0 + gain)
        if sensor.pressure_skew != 0.0:
            reading = np.interp(time + sensor.pressure_skew, time, reading)
        if sensor.pressure_lag > 0.0:
            reading = first_order_lag(time, reading, sensor.pressure_lag)
        if sensor.hum != 0.0:
            reading = reading + _hum(time, sensor)
        readings.append(reading + offset)
    return readings[0], readings[1]


def true_motion(
    displacement: Array,
    velocity: Array,
    acceleration: Array | None,
    stroke: float,
    sensor: SensorEffects,
) -> tuple[Array, Array]:
    """Return displacement [m] and velocity [m/s] behind what the transducer reads.

    Parameters
    ----------
    displacement, velocity : (n,) array
        As read [m], [m/s].
    acceleration : (n,) array or None
        As read; where the transducer lags, the velocity needs it [m/s^2].
    stroke : float
        [m].
    sensor : SensorEffects
        The effects.

    Notes
    -----
    A lag is undone by one derivative; the static error is small against the stroke, so that three
    rounds of x = reading - error(x) settle to 1e-6 of it.
    """
    if sensor.displacement_lag > 0.0:
        displacement = displacement + sensor.displacement_lag * velocity
        if acceleration is not None:
            velocity = velocity + sensor.displacement_lag * acceleration
    errors = (
        sensor.displacement_gain,
        sensor.displacement_offset,
        sensor.bow,
        sensor.first_harmonic,
        sensor.second_harmonic,
    )
    if not any(errors):
        return displacement, velocity
    true, slope = _behind(displacement, stroke, sensor)
    return true, velocity / slope


@compiled_whole
def _behind(reading, stroke, sensor):
    true, slope = np.empty_like(reading), np.empty_like(reading)
    for k in range(len(reading)):
        x = reading[k]
        for _ in range(3):
            x = reading[k] - displacement_error(x, stroke, sensor)
        true[k] = x
        slope[k] = displacement_gain(x, stroke, sensor)
    return true, slope


def true_pressures(
    time: Array,
    pressure_a: Array,
    pressure_b: Array,
    voltage: Array,
    sensor: SensorEffects,
) -> tuple[Array, Array]:
    """Return the pressures behind what the transducers read of still air [Pa].

    Parameters
    ----------
    time : (n,) array
        [s].
    pressure_a, pressure_b : (n,) array
        As read [Pa].
    voltage : (n,) array
        That drives the valve at each sample [V].
    sensor : SensorEffects
        The effects.

    Notes
    -----
    A lag is undone by one derivative of the reading, so that it amplifies noise.
    """
    found = []
    offset_a, offset_b = _offsets(voltage, sensor)
    for reading, gain, offset in (
        (pressure_a, sensor.pressure_a_gain, offset_a),
        (pressure_b, sensor.pressure_b_gain, offset_b),
    ):
        pressure = reading - offset
        if sensor.hum != 0.0:
            pressure = pressure - _hum(time, sensor)
        if sensor.pressure_lag > 0.0:
            pressure = pressure + sensor.pressure_lag * np.gradient(pressure, time)
        if sensor.pressure_skew != 0.0:
            pressure = np.interp(time - sensor.pressure_skew, time, pressure)
        found.append(pressure / (1.0 + gain))
    return found[0], found[1]


def _hum(time: Array, sensor: SensorEffects) -> Array:
    """Return what the mains add to the pressures [Pa]."""
    angle = 2.0 * np.pi * sensor.hum_frequency * time + sensor.hum_phase
    return sensor.hum * np.sin(angle)


def _offsets(voltage: Array, sensor: SensorEffects) -> tuple[Array, Array]:
    """Return what the electronics of the two pressures add, whatever the pressure [Pa]."""
    return (
        sensor.pressure_a_offset + sensor.ground_shift_a * voltage,
        sensor.pressure_b_offset + sensor.ground_shift_b * voltage,
    )
