"""The observer of the servo run on a feed, with the errors of its transducers undone."""

import math

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.models.servo.covariance import GAIN_ROWS
from pneuservo.diagnosis.models.servo.feed import FOLLOWED, Feed
from pneuservo.diagnosis.models.servo.friction_at_rest import beyond_friction, forces_on_resting
from pneuservo.diagnosis.models.servo.measured_spool import (
    SPOOL_GAIN,
    SPOOL_ZERO,
    beyond_expected,
)
from pneuservo.diagnosis.models.servo.noisy_command import bends_in, bent
from pneuservo.diagnosis.models.servo.observer import Observed, observe
from pneuservo.diagnosis.models.servo.spool import MOVED, follow_spool
from pneuservo.diagnosis.models.servo.steps import FINEST, Steps, dividing, steps_beside
from pneuservo.diagnosis.models.servo.supply import expected_supply
from pneuservo.diagnosis.models.servo.wander import beyond_wander
from pneuservo.effects.servo import SERVO_FIELDS, servo_effects
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo.drift import (
    behind_drift,
    behind_reference,
    drift_of,
    drifting_supply,
    gain_of_reference,
)
from pneuservo.plant.servo.layout import Servo
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.starting import servo_state
from pneuservo.plant.servo.supply_effects import SupplyEffects
from pneuservo.plant.servo.transducers import true_motion, true_pressures
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    VELOCITY,
    SingleAxis,
)
from pneuservo.rigs import Rig
from pneuservo.rigs.plant_numbers import single_axis, valve_grid

ZERO_FORCE = "zero_force"
"""What the drift of the pressure transducers' zeros makes of the force in one recording [N]."""
SUPPLY_LEVEL = "supply_level"
"""Pressure of the source in one recording in which the supply was measured [Pa]."""
COMMAND_DELAY = "command_delay"
"""How long after it has sampled a computer puts out its command, in one recording [s]."""
REVERSAL = "reversal"
"""Speed over which friction turns round, as a multiple of the resolution of the velocity [-]."""

ASTRAY = 1e3
"""Innovations are never larger than so many times the noise: a fit turns back from values with
which the observer runs away, but can make nothing of numbers that are not finite."""
_ELSEWHERE = 4.0
"""So many times its noise a spool is read off where it was told to be, if it is elsewhere."""


def numbers(values: Values, rig: Rig) -> tuple[SingleAxis, ServoEffects]:
    """Return the numbers of rig and effects as the kernels take them.

    Parameters
    ----------
    values : mapping of str to float
        Rig parameters by id, effect parameters as ``effect:parameter``; others are left out.
    rig : Rig
        What is not among them, the effects that it has included.
    """
    parameters = {key: value for key, value in values.items() if key in rig.parameters}
    effects = {key: value for key, value in values.items() if ":" in key}
    effects = {**rig.effect_values, **effects}
    return single_axis(rig.with_values(parameters)), servo_effects(effects)


def truth(fed: Feed, plant: SingleAxis, effects: ServoEffects) -> tuple[Array, Array]:
    """Return motion and pressures behind what faulty transducers read.

    But for the dynamic pressure of flows, which the observer knows.

    Parameters
    ----------
    fed : Feed
        What they read.
    plant, effects
        From `numbers`.

    Returns
    -------
    motion : (3, n) array
        Displacement, velocity and acceleration, SI.
    pressures : (2, n) array
        [Pa].
    """
    sensor, stroke = effects.sensor, plant.piston.stroke
    motion = behind_drift(fed.time, fed.motion, effects.unexplained_drift)
    place, speed = true_motion(motion[0], motion[1], motion[2], stroke, sensor)
    slope = 1.0 + sensor.displacement_gain
    # A shift in time is undone with the smoothed rate: shifting the reading would smooth its noise.
    shift = sensor.pressure_lag - sensor.pressure_skew
    readings = behind_reference(
        fed.time,
        fed.pressures + shift * fed.pressure_rates,
        plant.ambient_pressure,
        effects.unexplained_drift,
    )
    still = sensor._replace(pressure_lag=0.0, pressure_skew=0.0, hum=0.0)
    # What is sampled together with a command that is held meets the command of before.
    arrived = np.append(fed.command[:1, 0], fed.command[:-1, -1])
    pressures = true_pressures(fed.time, readings[0], readings[1], arrived, still)
    return np.array([place, speed, motion[2] / slope]), np.array(pressures)


def run_observer(fed: Feed, values: Values, rig: Rig) -> Array:
    """Return what is read beyond what was expected, and what friction cannot hold.

    Parameters
    ----------
    fed : Feed
        What was measured, and the observer's gains.
    values : mapping of str to float
        Rig and effect parameters, and what belongs to one recording.
    rig : Rig
        What is not among them.

    Returns
    -------
    (6, n) array
        Both pressures, displacement, supply and spool as the transducers read them, SI; zeros
        where nothing was measured. The last row is the force beyond what friction can hold while it
        holds the piston, and where it lets it go how far the force is from that, in how well that
        is known. Nothing is more than `ASTRAY`.

    Notes
    -----
    A measured supply pressure drives the chambers as it is: what the supply does shows in its
    own channel alone.
    """
    known = numbers(values, rig)
    observed = _observe(fed, values, known, rig, fed.gains, fed.shares, learning=False)
    farthest = ASTRAY * fed.noise_of(FOLLOWED)[:, np.newaxis]
    left = _within(observed.left, farthest)
    place = left[FOLLOWED.index("displacement")]
    for side in (-1, 1):
        # One stop that is not where it should be says nothing of the other.
        there = fed.resting == side
        if there.any():
            place[there] = beyond_wander(fed.time, np.where(there, place, np.nan))[there]
    beyond = np.zeros_like(fed.time)
    if fed.supply is not None:
        expected = _expected_supply(fed, values, known, observed.drawn)
        beyond = beyond_wander(fed.time, fed.supply_reading - expected)
    spool = np.zeros_like(fed.time)
    if len(fed.spool_reading):
        zero, gain = values.get(SPOOL_ZERO, 0.0), values.get(SPOOL_GAIN, 1.0)
        most = ASTRAY * fed.noise["spool"]
        spool = np.clip(beyond_expected(fed, observed.path[2], zero, gain), -most, most)
    friction = _within(beyond_friction(fed, observed), ASTRAY)
    return np.vstack([left, beyond, spool, friction])


def _within(left: Array, farthest: Array | float) -> Array:
    """Return what is left, nowhere more than the farthest; so far where it is not a number."""
    return np.fmax(np.fmin(left, farthest), -farthest)


def forces_at_rest(fed: Feed, values: Values, rig: Rig) -> Array:
    """Return the force on a piston at rest, and how much of it friction can hold.

    Parameters
    ----------
    fed, values, rig
        As in `run_observer`.

    Returns
    -------
    (2, n) array
        The force positive towards extension; zeros where the piston is not known to rest [N]. At
        the last sample of a rest they are those at which it breaks away.
    """
    known = numbers(values, rig)
    observed = _observe(fed, values, known, rig, fed.gains, fed.shares, learning=False)
    return forces_on_resting(fed, observed)


def supply_to_be_read(fed: Feed, values: Values, rig: Rig) -> Array:
    """Return what a transducer at the valve's supply port should read [Pa].

    Parameters
    ----------
    fed, values, rig
        As in `run_observer`, of a recording in which the supply was measured.
    """
    known = numbers(values, rig)
    observed = _observe(fed, values, known, rig, fed.gains, fed.shares, learning=False)
    return _expected_supply(fed, values, known, observed.drawn)


def _expected_supply(
    fed: Feed, values: Values, known: tuple[SingleAxis, ServoEffects], drawn: Array
) -> Array:
    plant, effects = known
    level = values.get(SUPPLY_LEVEL, float(np.nanmean(fed.supply_reading)))
    expected = expected_supply(fed.time, level, drawn, plant, effects.supply)
    return drifting_supply(fed.time, expected, effects.unexplained_drift)


def learn_to_observe(fed: Feed, rig: Rig) -> tuple[Array, Array, Array, Array, Array]:
    """Return the observer's gains for the baseline, and what it finds on its way.

    Parameters
    ----------
    fed : Feed
        What the observer is fed with.
    rig : Rig
        The rig.

    Returns
    -------
    gains : (n, GAIN_ROWS, 3) array
        What each error of expectation corrects, see `observe`.
    shares : (n, 3) array
        Noise of each reading over the spread of its innovation.
    path : (4, n) array
        As in `observe`.
    force_rms : (n,) array
        How well they tell the force on the piston [N].
    decays : (n,) array
        From `pneuservo.diagnosis.models.servo.covariance.carry_on`.
    """
    samples = len(fed.time)
    gains, shares = np.zeros((samples, GAIN_ROWS, 3)), np.zeros((samples, 3))
    observed = _observe(fed, {}, numbers({}, rig), rig, gains, shares, learning=True)
    return gains, shares, observed.path, observed.known, observed.decays


def _observe(
    fed: Feed,
    values: Values,
    known: tuple[SingleAxis, ServoEffects],
    rig: Rig,
    gains: Array,
    shares: Array,
    learning: bool,
) -> Observed:
    plant, effects = known
    if fed.supply is not None:
        effects = effects._replace(supply=SupplyEffects())
    late = effects.spool.delay + values.get(COMMAND_DELAY, 0.0)
    effects = effects._replace(spool=effects.spool._replace(delay=late))
    motion, pressures = truth(fed, plant, effects)
    there = np.array(fed.measured)[:, np.newaxis]
    force = fed.force + values.get(ZERO_FORCE, 0.0)
    # How far a transducer is behind, the observer knows better than smoothed rates do.
    behind = effects.sensor.pressure_lag - effects.sensor.pressure_skew
    read = np.where(fed.read, pressures - behind * fed.pressure_rates / _as_read(effects), np.nan)
    late = math.ceil(effects.sensor.pressure_skew / fed.interval)
    command = bent(fed.command, fed.bends, values, plant.valve.full_voltage)
    opening = _opening_at_first(fed, values, plant.valve.full_voltage)
    servo, state, supply = _chain(
        fed, motion, np.where(there, pressures, fed.pressures), opening, plant, effects
    )
    if learning:
        steps = dividing(fed.time, FINEST)
    else:
        every = {**rig.effect_values, **values}
        fields = {SERVO_FIELDS[key] for key in every if key in SERVO_FIELDS}
        if fed.supply is not None:
            fields = {field for field in fields if not field.startswith("supply.")}
        steps = steps_beside(fed.steps, fed.time, fields)
    left, path, force_rms, drawn, decays = observe(
        fed.time,
        command,
        np.vstack([taken_by_then(read, late), fed.reading]),
        late * fed.interval - effects.sensor.pressure_skew,
        fed.motion,
        motion,
        supply,
        force,
        fed.force_rms,
        fed.held,
        fed.resting,
        fed.velocity_rms,
        fed.reversal * values.get(REVERSAL, 1.0),
        fed.unsteadiness,
        fed.turning_unsteadiness,
        fed.noise_of(FOLLOWED) ** 2,
        fed.spread,
        gains,
        shares,
        learning,
        fed.supply is not None,
        servo,
        drift_of(effects),
        valve_grid(rig.valve),
        state,
        steps,
        _moves_of_spool(fed, command, values, servo, float(state[SPOOL]), steps),
    )
    left[:2] *= _as_read(effects) * gain_of_reference(fed.time, effects.unexplained_drift)
    return Observed(left, path, force_rms, drawn, decays, motion, pressures, force, servo, state)


def taken_by_then(readings: Array, late: int) -> Array:
    """Return readings at the first sample by which they had been taken.

    Parameters
    ----------
    readings : (2, n) array
        Each taken at another moment than its sample.
    late : int
        So many samples later.

    Examples
    --------
    >>> readings = np.array([[1.0, 2.0, 3.0, 4.0]])
    >>> taken_by_then(readings, 1).tolist(), taken_by_then(readings, -2).tolist()
    ([[nan, 1.0, 2.0, 3.0]], [[3.0, 4.0, nan, nan]])
    """
    if not late:
        return readings
    found = np.full_like(readings, np.nan)
    if late > 0:
        found[:, late:] = readings[:, :-late]
    else:
        found[:, :late] = readings[:, -late:]
    return found


def _moves_of_spool(
    fed: Feed, command: Array, values: Values, servo: Servo, opening: float, steps: Steps
) -> Array:
    """Return how the spool moves; what does not touch it shares this.

    With a flow force it moves with the chambers, and only room is made.
    """
    spool, valve = servo.effects.spool, servo.plant.valve
    if spool.flow_force != 0.0:
        return np.empty((int(np.sum(steps[:-1])), MOVED))
    reply = (valve.full_voltage, valve.spool_frequency, valve.spool_damping)
    return fed.spools.get(
        (spool, reply, opening, steps.tobytes(), bends_in(values)),
        lambda: follow_spool(fed.time, command, steps, opening, servo),
    )


def _chain(
    fed: Feed,
    motion: Array,
    pressures: Array,
    opening: float,
    plant: SingleAxis,
    effects: ServoEffects,
) -> tuple[Servo, Array, Array]:
    """Return the numbers of the chain, the state it starts from, and the supply pressure."""
    servo = Servo(plant, effects, OPEN_LOOP)
    supply = fed.supply
    if supply is None:
        supply = np.full_like(fed.time, plant.supply_pressure)
        supply = drifting_supply(fed.time, supply, effects.unexplained_drift)
    start = np.zeros(PLANT_STATES)
    start[SPOOL] = np.clip(opening, -1.0, 1.0)
    start[[PRESSURE_A, PRESSURE_B]] = pressures[:, 0]
    start[[DISPLACEMENT, VELOCITY]] = motion[:2, 0]
    return servo, servo_state(start, servo, float(supply[0])), supply


def _opening_at_first(fed: Feed, values: Values, full_voltage: float) -> float:
    """Return where the spool is when a recording begins: where it was told to be, or was read.

    A recording may begin, or be cut, while it moves.
    """
    told = float(fed.voltage[0]) / full_voltage
    if not len(fed.spool_reading) or not np.isfinite(fed.spool_reading[0]):
        return told
    read = float(fed.spool_reading[0] - values.get(SPOOL_ZERO, 0.0)) / values.get(SPOOL_GAIN, 1.0)
    return read if abs(read - told) > _ELSEWHERE * fed.noise["spool"] else told


def _as_read(effects: ServoEffects) -> Array:
    """Return the slopes of both pressure transducers, so that what is left counts as they read."""
    sensor = effects.sensor
    return np.array([[1.0 + sensor.pressure_a_gain], [1.0 + sensor.pressure_b_gain]])
