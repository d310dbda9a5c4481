"""What the transducers make of displacement and pressure."""

import math
from typing import NamedTuple

from pneuservo.plant.servo.compilation import compiled, compiled_whole

# Bore of the pipe in which the pressure transducers sit: 2 mm (thesis section 3.2.1).
PIPE_AREA = 0.25 * math.pi * 2e-3**2


class SensorEffects(NamedTuple):
    """Parameters of the errors of the transducers."""

    displacement_gain: float = 0.0
    """Relative error [-]."""
    displacement_offset: float = 0.0
    """[m]."""
    bow: float = 0.0
    """Amplitude of an error with half a period along the stroke [m]."""
    first_harmonic: float = 0.0
    """The same with one period [m]."""
    second_harmonic: float = 0.0
    """The same with two periods [m]."""
    displacement_lag: float = 0.0
    """First-order time constant [s]."""
    wiper_play: float = 0.0
    """Half width of the play of the wiper [m]."""
    displacement_step: float = 0.0
    """Resolution of the recorded displacement [m]; 0 for exact."""
    pressure_a_offset: float = 0.0
    pressure_b_offset: float = 0.0
    """[Pa]."""
    pressure_a_gain: float = 0.0
    pressure_b_gain: float = 0.0
    """Relative error of the absolute pressure [-]."""
    static_share: float = 0.0
    """Dynamic pressure in the pipe that the reading lacks, as a share [-]."""
    pressure_lag: float = 0.0
    """First-order time constant [s]."""
    pressure_step: float = 0.0
    """Resolution of the recorded pressures [Pa]; 0 for exact."""
    pressure_skew: float = 0.0
    """Time by which the pressures are sampled after the displacement [s]."""
    hum: float = 0.0
    """Amplitude of mains hum on the pressures [Pa]."""
    hum_frequency: float = 50.0
    """[Hz]."""
    hum_phase: float = 0.0
    """[rad]."""
    ground_shift_a: float = 0.0
    ground_shift_b: float = 0.0
    """By how much a pressure reads more for each volt of the command [Pa/V]."""


@compiled
def displacement_error(displacement, stroke, effects):
    """Return the static error of the displacement transducer [m].

    Parameters
    ----------
    displacement, stroke : float
        [m].
    effects : SensorEffects
        The effects.

    Examples
    --------
    >>> displacement_error(0.01, 0.03, SensorEffects(displacement_gain=0.01))
    0.0001
    """
    error = effects.displacement_gain * displacement + effects.displacement_offset
    if effects.bow != 0.0 or effects.first_harmonic != 0.0 or effects.second_harmonic != 0.0:
        angle = math.pi * displacement / stroke
        error += effects.bow * math.sin(angle)
        error += effects.first_harmonic * math.sin(2.0 * angle)
        error += effects.second_harmonic * math.sin(4.0 * angle)
    return error


@compiled
def displacement_gain(displacement, stroke, effects):
    """Return the slope of the reading over the true displacement [-].

    Parameters
    ----------
    displacement, stroke, effects
        As in `displacement_error`.
    """
    slope = 1.0 + effects.displacement_gain
    if effects.bow != 0.0 or effects.first_harmonic != 0.0 or effects.second_harmonic != 0.0:
        w = math.pi / stroke
        angle = w * displacement
        slope += w * effects.bow * math.cos(angle)
        slope += 2.0 * w * effects.first_harmonic * math.cos(2.0 * angle)
        slope += 4.0 * w * effects.second_harmonic * math.cos(4.0 * angle)
    return slope


@compiled
def displacement_bend(displacement, stroke, effects):
    """Return by how much the slope of the reading grows along the way [1/m].

    Parameters
    ----------
    displacement, stroke, effects
        As in `displacement_error`.
    """
    if effects.bow == 0.0 and effects.first_harmonic == 0.0 and effects.second_harmonic == 0.0:
        return 0.0
    w = math.pi / stroke
    angle = w * displacement
    bend = effects.bow * math.sin(angle) + 4.0 * effects.first_harmonic * math.sin(2.0 * angle)
    return -w * w * (bend + 16.0 * effects.second_harmonic * math.sin(4.0 * angle))


@compiled
def heard_motion(displacement, velocity, acceleration, lagged, stroke, effects):
    """Return displacement [m], velocity [m/s] and acceleration [m/s^2] as the transducer has them.

    Parameters
    ----------
    displacement, velocity, acceleration : float
        Of the piston.
    lagged : float
        Output of the transducer's lag [m]; ignored without one.
    stroke : float
        [m].
    effects : SensorEffects
        The effects.

    Notes
    -----
    d^2 r/dt^2 = (dr/dx) d^2x/dt^2 + (d^2r/dx^2) (dx/dt)^2 for a reading r(x).
    """
    slope = displacement_gain(displacement, stroke, effects)
    read = displacement + displacement_error(displacement, stroke, effects)
    bend = displacement_bend(displacement, stroke, effects)
    rate, second = slope * velocity, slope * acceleration + bend * velocity * velocity
    if effects.displacement_lag > 0.0:
        lagged_rate = (read - lagged) / effects.displacement_lag
        return lagged, lagged_rate, (rate - lagged_rate) / effects.displacement_lag
    return read, rate, second


@compiled
def lag_rate(displacement, lagged, stroke, effects):
    """Return the rate of the transducer's lag [m/s].

    Parameters
    ----------
    displacement, lagged, stroke, effects
        As in `heard_motion`.
    """
    if effects.displacement_lag == 0.0:
        return 0.0
    read = displacement + displacement_error(displacement, stroke, effects)
    return (read - lagged) / effects.displacement_lag


@compiled_whole
def dynamic_pressure(mass_flow, pressure, gas):
    """Return the dynamic pressure of the flow in the transducer's pipe [Pa].

    Parameters
    ----------
    mass_flow : float or array
        Through the pipe [kg/s].
    pressure : float or array
        Absolute [Pa].
    gas : Gas
        The gas.

    Notes
    -----
    rho w^2/2 with w = m/(rho A) (thesis section 3.2.1).

    Examples
    --------
    A thousandth of a kg/s at 5 bar gives 8.5 kPa in a 2 mm pipe:

    >>> from pneuservo.plant.gas import ideal_gas
    >>> round(dynamic_pressure(1e-3, 5e5, ideal_gas(293.0, 287.0, 1.4)), -2)
    8500.0
    """
    flux = mass_flow / PIPE_AREA
    return 0.5 * flux * flux * gas.gas_constant * gas.temperature / pressure
