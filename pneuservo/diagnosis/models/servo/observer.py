"""The whole servo followed at once, where not every pressure was measured."""

import math

import numpy as np

from pneuservo.diagnosis.models.servo.advance import advance, write_drive
from pneuservo.diagnosis.models.servo.push import FELT, friction_direction, push
from pneuservo.plant.compilation import compiled
from pneuservo.plant.piston import driving_force
from pneuservo.plant.servo.layout import (
    COMMAND,
    INPUTS,
    MEMORY,
    PAST_COLUMNS,
    PAST_ROWS,
    SUPPLY,
    TIME,
)
from pneuservo.plant.servo.memory import begin
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.servo.sensor_effects import displacement_error, displacement_gain
from pneuservo.plant.servo.stop_effects import resting_place
from pneuservo.plant.servo.valve_side import supply_at_valve, valve_flows
from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B, SPOOL, SPOOL_FREE, SPOOL_LIMIT

FOLLOWED_A, FOLLOWED_B, POSITION, SPEED = range(4)
"""What the observer corrects: both pressures, and the motion as the transducer has it."""
FORCE_STEP = 0.05
"""An unmodelled force, as a share of the Coulomb friction, that comes and goes ..."""
FORCE_TIME = 1e-2
"""... within this time [s]."""
UNKNOWN_PRESSURE = 1e5
"""How little is known of a pressure that is not measured, at the start [Pa]."""
_SLOPE_STEP = 100.0


@compiled
def observe(
    time,
    voltage,
    ramped,
    readings,
    motion,
    true,
    supply,
    external_force,
    held,
    resting,
    reversal,
    variance,
    spread,
    gains,
    shares,
    learning,
    servo,
    grid,
    initial_state,
    longest_step,
):
    """Return what every channel reads beyond what the model and the past make expected.

    Parameters
    ----------
    time : (n,) array
        [s].
    voltage : (n,) array
        Into the valve driver [V].
    ramped : bool
        Whether it runs straight between samples instead of being held.
    readings : (3, n) array
        Both pressures, the errors of the transducers undone, and the displacement as measured;
        NaN where there is none, SI.
    motion, true : (3, n) array
        Smoothed displacement, velocity and acceleration of the reading and of the piston, SI.
    supply : (n,) array
        At the valve's supply port, or of the source behind a reservoir [Pa].
    external_force : (n,) array
        At the rod, positive when it resists extension [N].
    held : (n,) array of bool
        While the piston sticks or lies at a stop: its motion is taken over, and its displacement
        tells nothing ...
    resting : (n,) array of int
        ... unless it is pressed on the retracted (-1) or extended (1) stop, whose place is known.
    reversal : float
        Speed over which friction turns round [m/s].
    variance : (3,) array
        Of the noise of each reading, SI.
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
    gains : (n, 4, 3) array
        What each innovation corrects; written while learning.
    shares : (n, 3) array
        Noise of each reading over the spread its innovation is expected to have; written while
        learning.
    learning : bool
        Whether gains and shares are worked out, on the way of this servo.
    servo : Servo
        The numbers of rig and effects.
    grid : (4, 51, 101) array
        Discharge coefficients.
    initial_state : array
        From `pneuservo.plant.servo.starting.servo_state`.
    longest_step : float
        The intervals are divided into equal steps no longer than this [s].

    Returns
    -------
    left : (3, n) array
        Innovations, each counted in the spread that it was expected to have, SI.
    path : (2, n) array
        Both pressures as followed [Pa].
    known : (n,) array
        Standard deviation of the force that they give; zeros unless learning [N].
    drawn : (n,) array
        Mass flow out of the supply [kg/s].

    Notes
    -----
    An extended Kalman filter whose gains are worked out once, for the baseline, so that the
    innovations are nearly linear in what an effect changes. Forces are worked out at the smoothed
    motion.
    """
    n = time.shape[0]
    left, path, known, drawn = np.zeros((3, n)), np.zeros((2, n)), np.zeros(n), np.zeros(n)
    state = initial_state.copy()
    modes = np.zeros(3, np.int64)
    modes[SPOOL_LIMIT] = SPOOL_FREE
    memory, rows = np.zeros(MEMORY), np.zeros((PAST_ROWS, PAST_COLUMNS))
    drive, work = np.zeros((2, INPUTS)), np.zeros((3, len(state)))
    drive[0, COMMAND], drive[0, SUPPLY], drive[0, TIME] = voltage[0], supply[0], time[0]
    begin(state, modes, memory, rows, drive, servo, grid)
    plant, effects = servo.plant, servo.effects
    piston, lag = plant.piston, effects.sensor.displacement_lag
    direction = friction_direction(true[0], true[1], reversal, effects.friction)
    remembered = np.zeros(3)
    remembered[FELT] = true[1, 0]
    position, velocity, lagged = motion[0, 0], motion[1, 0], 0.0
    last = 0.0
    covariance = np.diag(
        np.array([UNKNOWN_PRESSURE**2, UNKNOWN_PRESSURE**2, variance[2], reversal**2])
    )
    for side in range(2):
        if readings[side, 0] == readings[side, 0]:
            covariance[side, side] = variance[side]
    path[0, 0], path[1, 0] = state[PRESSURE_A], state[PRESSURE_B]
    error = np.zeros(3)
    for k in range(n - 1):
        interval = time[k + 1] - time[k]
        write_drive(drive, k, time, voltage, supply, ramped)
        if learning:
            _spread_out(
                covariance,
                state,
                true[1, k],
                interval,
                spread[:, k],
                memory,
                rows,
                drive,
                servo,
                grid,
                work,
            )
        advance(
            state,
            true[:2, k],
            true[:2, k + 1],
            interval,
            longest_step,
            modes,
            memory,
            rows,
            drive,
            servo,
            grid,
            work,
        )
        port = supply_at_valve(state, drive, interval, servo)
        _, _, drawn[k + 1] = valve_flows(state[SPOOL], state, memory, port, servo, grid)
        now = push(
            time[k + 1],
            interval,
            true[:, k + 1],
            state[PRESSURE_A],
            state[PRESSURE_B],
            state[SPOOL],
            external_force[k + 1],
            direction[k + 1],
            remembered,
            plant,
            effects,
        )
        slope = displacement_gain(true[0, k + 1], piston.stroke, effects.sensor)
        mean = slope * (0.5 * (now + last) if k else now)
        if lag > 0.0:
            lagged += (mean - lagged) * -math.expm1(-interval / lag)
            mean = lagged
        position += interval * velocity + 0.5 * interval * interval * mean
        velocity += interval * mean
        if held[k + 1]:
            position, velocity, lagged = motion[0, k + 1], motion[1, k + 1], motion[2, k + 1]
        error[0] = readings[0, k + 1] - state[PRESSURE_A]
        error[1] = readings[1, k + 1] - state[PRESSURE_B]
        error[2] = math.nan if held[k + 1] else readings[2, k + 1] - position
        if learning:
            if held[k + 1]:
                _take_over(covariance, variance[2], reversal)
            _weigh(covariance, error, variance, gains[k + 1], shares[k + 1])
            if resting[k + 1] != 0:
                shares[k + 1, 2] = 1.0
            known[k + 1] = _force_spread(covariance, piston)
        if resting[k + 1] != 0:
            force = driving_force(
                state[PRESSURE_A],
                state[PRESSURE_B],
                0.0,
                external_force[k + 1],
                plant.ambient_pressure,
                piston,
            )
            place = resting_place(resting[k + 1], force, piston.stroke, effects.stop)
            error[2] = readings[2, k + 1] - place
            error[2] -= displacement_error(place, piston.stroke, effects.sensor)
        moved = np.zeros(4)
        for slot in range(3):
            if error[slot] == error[slot]:
                left[slot, k + 1] = error[slot] * shares[k + 1, slot]
                for place in range(4):
                    moved[place] += gains[k + 1, place, slot] * error[slot]
        state[PRESSURE_A] += moved[FOLLOWED_A]
        state[PRESSURE_B] += moved[FOLLOWED_B]
        if not held[k + 1]:
            position += moved[POSITION]
            velocity += moved[SPEED]
        given = piston.area_a * moved[FOLLOWED_A] - piston.area_b * moved[FOLLOWED_B]
        last = now + given / piston.mass
        path[0, k + 1], path[1, k + 1] = state[PRESSURE_A], state[PRESSURE_B]
    return left, path, known, drawn


@compiled
def _spread_out(covariance, state, speed, interval, spread, memory, rows, drive, servo, grid, work):
    """Carry the covariance on by one interval."""
    plant = servo.plant
    piston, mass = plant.piston, plant.piston.mass
    moving = np.eye(4)
    rate, moved, start = work[0], work[1], work[2]
    start[:] = state
    pneumatic_rates(start, speed, memory, rows, drive, 0.0, servo, grid, rate)
    places, areas = (PRESSURE_A, PRESSURE_B), (piston.area_a, -piston.area_b)
    for side in range(2):
        here = places[side]
        start[here] += _SLOPE_STEP
        pneumatic_rates(start, speed, memory, rows, drive, 0.0, servo, grid, moved)
        start[here] -= _SLOPE_STEP
        fading = max(0.0, (rate[here] - moved[here]) / _SLOPE_STEP)
        moving[side, side] = math.exp(-interval * fading)
        moving[SPEED, side] = interval * areas[side] / mass
        moving[POSITION, side] = 0.5 * interval * interval * areas[side] / mass
    moving[POSITION, SPEED] = interval
    covariance[:, :] = moving @ covariance @ moving.T
    covariance[0, 0] += spread[0]
    covariance[1, 1] += spread[1]
    unknown = FORCE_STEP * piston.coulomb_friction / mass
    covariance[SPEED, SPEED] += unknown * unknown * FORCE_TIME * interval


@compiled
def _take_over(covariance, position_variance, reversal):
    """Forget what the motion tells of the pressures: friction is whatever it has to be."""
    for place in (POSITION, SPEED):
        for other in range(4):
            covariance[place, other] = 0.0
            covariance[other, place] = 0.0
    covariance[POSITION, POSITION] = position_variance
    covariance[SPEED, SPEED] = reversal * reversal


@compiled
def _weigh(covariance, error, variance, gain, share):
    """Write the gains of the readings that are there, and take up what they tell."""
    gain[:, :] = 0.0
    share[:] = 0.0
    places = (FOLLOWED_A, FOLLOWED_B, POSITION)
    for slot in range(3):
        if error[slot] == error[slot]:
            expected = covariance[places[slot], places[slot]] + variance[slot]
            share[slot] = math.sqrt(variance[slot] / expected)
    # One reading after the other; each meets what those before it have corrected.
    for slot in range(3):
        if error[slot] != error[slot]:
            continue
        here = places[slot]
        own = covariance[:, here] / (covariance[here, here] + variance[slot])
        before = gain[here].copy()
        for place in range(4):
            for other in range(3):
                gain[place, other] -= own[place] * before[other]
            gain[place, slot] += own[place]
        row = covariance[here].copy()
        for place in range(4):
            for other in range(4):
                covariance[place, other] -= own[place] * row[other]


@compiled
def _force_spread(covariance, piston):
    a, b = piston.area_a, piston.area_b
    square = a * a * covariance[0, 0] + b * b * covariance[1, 1] - 2.0 * a * b * covariance[0, 1]
    return math.sqrt(max(square, 0.0))
