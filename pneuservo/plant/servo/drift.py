"""A parameter of the rig that changes in the course of a recording, by a table over time."""

import numpy as np

from pneuservo.arrays import Array
from pneuservo.plant.piston import Piston
from pneuservo.plant.servo.compilation import compiled, compiled_apart, compiled_whole
from pneuservo.plant.servo.layout import Servo
from pneuservo.plant.servo.sensor_effects import SensorEffects
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.unexplained_effects import Table, between_knots
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.plant.valve import Valve

DRIFTING = (
    "moved mass",
    "Coulomb friction",
    "area of the exhaust edges",
    "area of the supply edges",
    "gain of the displacement transducer",
    "gain of all transducers",
    "pressure of the supply",
)
"""What may drift; `Table.over` of a drift is the place in this list."""
MASS, COULOMB_FRICTION, EXHAUST_EDGES, SUPPLY_EDGES, DISPLACEMENT_GAIN, REFERENCE, SUPPLY = range(
    len(DRIFTING)
)
_READING = (float(DISPLACEMENT_GAIN), float(REFERENCE))
"""What changes how a displacement is read."""


def drift_of(effects: ServoEffects) -> Table | None:
    """Return the table of what drifts, if anything does.

    Parameters
    ----------
    effects : ServoEffects
        All effects of the servo.
    """
    table = effects.unexplained_drift
    return None if table.high == table.low else table


@compiled
def drifted(servo, time):
    """Return the servo as it is at a moment.

    Parameters
    ----------
    servo : Servo
        The numbers of rig, effects and law.
    time : float
        Since the start of the run [s].
    """
    return drifted_by(servo, servo.effects.unexplained_drift, time)


@compiled
def drifted_by(servo, table, time):
    """Return the servo as a drift has left it at a moment.

    Parameters
    ----------
    servo : Servo
        The numbers of rig, effects and law.
    table : Table or None
        The drift, from `drift_of`: without one a kernel is compiled to keep its servo.
    time : float
        Since the start of the run [s].
    """
    if table is None or table.high == table.low:
        return servo
    return with_factor(servo, table.over, 1.0 + between_knots(time, table))


@compiled_apart
def with_factor(servo, which, factor):
    """Return the servo with one of its parameters multiplied."""
    return Servo(
        _plant_with_factor(servo.plant, which, factor),
        _effects_with_factor(
            servo.effects, factor if DISPLACEMENT_GAIN <= which <= REFERENCE else 1.0
        ),
        servo.law,
        servo.displacement_range,
    )


@compiled
def _plant_with_factor(plant, which, factor):
    piston, valve = plant.piston, plant.valve
    moved = factor if which == MASS else 1.0
    rubbing = factor if which == COULOMB_FRICTION else 1.0
    out = factor if which == EXHAUST_EDGES else 1.0
    into = factor if which == SUPPLY_EDGES else 1.0
    return SingleAxis(
        plant.supply_pressure,
        plant.ambient_pressure,
        plant.dead_volume_a,
        plant.dead_volume_b,
        plant.polytropic_index,
        plant.gas,
        Valve(
            valve.full_voltage,
            into * valve.area_s_a,
            out * valve.area_b_e,
            into * valve.area_s_b,
            out * valve.area_a_e,
            valve.spool_frequency,
            valve.spool_damping,
        ),
        Piston(
            piston.area_a,
            piston.area_b,
            piston.stroke,
            moved * piston.mass,
            piston.gravity,
            piston.viscous_friction,
            rubbing * piston.coulomb_friction,
        ),
    )


@compiled
def _effects_with_factor(effects, read):
    sensor = effects.sensor
    return ServoEffects(
        effects.spool,
        effects.valve,
        effects.supply,
        effects.line,
        effects.chamber,
        effects.leakage,
        effects.friction,
        effects.load,
        effects.stop,
        SensorEffects(
            read * (1.0 + sensor.displacement_gain) - 1.0,
            sensor.displacement_offset,
            sensor.bow,
            sensor.first_harmonic,
            sensor.second_harmonic,
            sensor.displacement_lag,
            sensor.wiper_play,
            sensor.displacement_step,
            sensor.pressure_a_offset,
            sensor.pressure_b_offset,
            sensor.pressure_a_gain,
            sensor.pressure_b_gain,
            sensor.static_share,
            sensor.pressure_lag,
            sensor.pressure_step,
            sensor.pressure_skew,
            sensor.hum,
            sensor.hum_frequency,
            sensor.hum_phase,
            sensor.ground_shift_a,
            sensor.ground_shift_b,
        ),
        effects.unexplained_force,
        effects.unexplained_flow_a,
        effects.unexplained_flow_b,
        effects.unexplained_drift,
    )


def behind_drift(time: Array, motion: Array, table: Table) -> Array:
    """Return the motion that a transducer whose gain drifts has read.

    Parameters
    ----------
    time : (n,) array
        Since the start of the run [s].
    motion : (3, n) array
        Displacement, velocity and acceleration of the reading, SI.
    table : Table
        The drift.

    Returns
    -------
    (3, n) array
        What another drift leaves as it is. The gain's second derivative is left out.
    """
    if table.high == table.low or table.over not in _READING:
        return motion
    gain = _gain(time, table)
    rising = np.gradient(gain, time)
    place = motion[0] / gain
    speed = (motion[1] - rising * place) / gain
    return np.array([place, speed, (motion[2] - 2.0 * rising * speed) / gain])


def read_by_reference(time: Array, pressure: Array, ambient: float, table: Table) -> Array:
    """Return what a transducer reads of a pressure while the reference of all of them drifts [Pa].

    Parameters
    ----------
    time, pressure : (n,) array
        Since the start of the run [s], absolute [Pa].
    ambient : float
        Which it reads right: its zero does not drift [Pa].
    table : Table
        The drift; another one leaves the pressure as it is.
    """
    if not _is_of(REFERENCE, table):
        return pressure
    return ambient + _gain(time, table) * (pressure - ambient)


def behind_reference(time: Array, readings: Array, ambient: float, table: Table) -> Array:
    """Return the pressures behind what transducers read while the reference of all drifts [Pa].

    Parameters
    ----------
    time : (n,) array
        Since the start of the run [s].
    readings : (..., n) array
        [Pa].
    ambient, table
        As in `read_by_reference`.
    """
    if not _is_of(REFERENCE, table):
        return readings
    return ambient + (readings - ambient) / _gain(time, table)


def gain_of_reference(time: Array, table: Table) -> Array | float:
    """Return the gain that all transducers have in common by a drift of their reference [-].

    Parameters
    ----------
    time : (n,) array
        Since the start of the run [s].
    table : Table
        The drift; with another one it is 1.
    """
    return _gain(time, table) if _is_of(REFERENCE, table) else 1.0


def drifting_supply(time: Array, pressure: Array, table: Table) -> Array:
    """Return the pressure of a source that drifts [Pa].

    Parameters
    ----------
    time, pressure : (n,) array
        Since the start of the run [s], what it would be without a drift [Pa].
    table : Table
        The drift; another one leaves the pressure as it is.
    """
    return pressure * _gain(time, table) if _is_of(SUPPLY, table) else pressure


def _is_of(which: int, table: Table) -> bool:
    return table.high != table.low and table.over == which


@compiled_whole
def _gain(time, table):
    gain = np.empty(time.size)
    for k in range(time.size):
        gain[k] = 1.0 + between_knots(time[k], table)
    return gain
