"""The whole servo followed at once, whether or not every pressure was measured."""

import math
from typing import NamedTuple

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.models.servo.advance import (
    BEHIND_A,
    BEHIND_B,
    WITHIN,
    advance,
    followed,
    write_drive,
)
from pneuservo.diagnosis.models.servo.covariance import (
    FOLLOWED_A,
    FOLLOWED_B,
    GAIN_ROWS,
    POSITION,
    SPEED,
    ZEROS,
    carry_on,
    force_spread,
    start_covariance,
    take_over,
    weigh,
)
from pneuservo.diagnosis.models.servo.innovations import (
    add_dynamic_pressure,
    corrections,
    place_at_stop,
    pressure_errors,
)
from pneuservo.diagnosis.models.servo.push import dry_friction, push
from pneuservo.diagnosis.models.servo.turning import friction_direction
from pneuservo.noise import WANDER_TIME
from pneuservo.plant.compilation import compiled
from pneuservo.plant.presliding import presliding_step
from pneuservo.plant.servo.drift import drifted_by
from pneuservo.plant.servo.layout import (
    COMMAND,
    INPUTS,
    JOINT_RATE,
    MEMORY,
    PAST_COLUMNS,
    PAST_ROWS,
    SUPPLY,
    TIME,
    Servo,
)
from pneuservo.plant.servo.load_effects import rigid_mass
from pneuservo.plant.servo.mechanics import carried_force
from pneuservo.plant.servo.memory import begin
from pneuservo.plant.servo.sensor_effects import displacement_bend, displacement_gain
from pneuservo.plant.servo.valve_side import supply_at_valve, valve_flows
from pneuservo.plant.single_axis import (
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
)


class Observed(NamedTuple):
    """What `observe` found in a recording, and of what.

    Parameters
    ----------
    left, path, known, drawn, decays
        What it returns, pressures as the transducers read them.
    motion : (3, n) array
        Displacement, velocity and acceleration of the piston, SI.
    pressures : (2, n) array
        As measured, the errors of the transducers undone [Pa].
    force : (n,) array
        At the rod, positive when it resists extension [N].
    servo : Servo
        The numbers of rig and effects.
    state : array
        Where it began.
    """

    left: Array
    path: Array
    known: Array
    drawn: Array
    decays: Array
    motion: Array
    pressures: Array
    force: Array
    servo: Servo
    state: Array


@compiled
def observe(
    time,
    command,
    readings,
    age,
    motion,
    true,
    supply,
    external_force,
    force_rms,
    held,
    resting,
    velocity_rms,
    reversal,
    unsteadiness,
    turning_unsteadiness,
    variance,
    spread,
    gains,
    shares,
    learning,
    drawing,
    servo,
    drift,
    grid,
    initial_state,
    steps,
    moves,
):
    """Return what every channel reads beyond what the model and the past make expected.

    Parameters
    ----------
    time : (n,) array
        [s].
    command : (n, m + 1) array
        Into the valve driver, as in `pneuservo.diagnosis.models.servo.spool.arriving` [V].
    readings : (3, n) array
        Both pressures, the errors of the transducers undone but for their lag, and the displacement
        as measured; NaN where there is none, SI.
    age : float
        By how much sooner than at its sample each pressure was read, at most an interval [s].
    motion, true : (3, n) array
        Smoothed displacement, velocity and acceleration of the reading and of the piston, SI.
    supply : (n,) array
        At the valve's supply port, or of the source behind a reservoir [Pa].
    external_force : (n,) array
        At the rod, positive when it resists extension [N].
    force_rms : float
        Noise of that, as it was measured [N].
    held : (n,) array of bool
        While the piston sticks or lies at a stop: its motion is taken over, and its displacement
        tells nothing ...
    resting : (n,) array of int
        ... unless it is pressed on the retracted (-1) or extended (1) stop, whose place is known.
    velocity_rms : (n,) array
        How well the velocity is known that is taken over [m/s].
    reversal : float
        Speed over which friction turns round [m/s].
    unsteadiness, turning_unsteadiness : float
        Unmodelled force, see `pneuservo.diagnosis.models.servo.covariance.carry_on` [-].
    variance : (3,) array
        Of the noise of each reading, SI.
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
    gains : (n, GAIN_ROWS, 3) array
        What each error of expectation corrects, and what of a later reading it makes expected;
        written while learning.
    shares : (n, 3) array
        Noise of each reading over the spread its innovation is expected to have; written while
        learning.
    learning : bool
        Whether gains and shares are worked out, on the way of this servo.
    drawing : bool
        Whether what is drawn from the supply is worked out: a tenth of the time goes into it.
    servo : Servo
        The numbers of rig and effects.
    drift : Table or None
        From `pneuservo.plant.servo.drift.drift_of`. To change the servo from sample to sample takes
        nearly as long as all the rest.
    grid : (4, 51, 101) array
        Discharge coefficients.
    initial_state : array
        From `pneuservo.plant.servo.starting.servo_state`.
    steps : (n,) array of int
        Of the chambers in each interval.
    moves : (m, MOVED) array
        How the spool moves in each of them, see `pneuservo.diagnosis.models.servo.advance.advance`.

    Returns
    -------
    left : (3, n) array
        Innovations, each counted in the spread that it was expected to have, SI; infinite from
        where the servo runs away.
    path : (4, n) array
        Both pressures as followed [Pa], the spool's opening [-], and the force on the piston of
        what hangs on it and of cushions [N].
    known : (n,) array
        Standard deviation of the force that they give; zeros unless learning [N].
    drawn : (n,) array
        Mass flow out of the supply; zeros unless it was asked for [kg/s].
    decays : (n,) array
        From `pneuservo.diagnosis.models.servo.covariance.carry_on`; zeros unless learning [-].

    Notes
    -----
    An extended Kalman filter whose gains are worked out once, for the baseline, so that the
    innovations are nearly linear in what an effect changes. Volumes and which way friction acts
    follow the smoothed motion. The speed that fills and empties the chambers, and that friction
    feels, is the observer's own: with the noise of a smoothed one damping would look too small.
    While the motion is taken over it is the smoothed speed, and how well that is known counts. The
    zeros of the three transducers wander and are followed too, but that of the displacement at a
    stop, which is followed in what is left there (`run_observer`): left out, they pretend more of
    slow effects than real ones show.
    """
    n = time.shape[0]
    left, path, known, drawn = np.zeros((3, n)), np.zeros((4, n)), np.zeros(n), np.zeros(n)
    decays = np.zeros(n)
    state = initial_state.copy()
    modes = np.zeros(3, np.int64)
    modes[SPOOL_LIMIT] = SPOOL_FREE
    memory, rows = np.zeros(MEMORY), np.zeros((PAST_ROWS, PAST_COLUMNS))
    drive = np.zeros((2, INPUTS))
    rate, total, start = np.zeros_like(state), np.zeros_like(state), np.zeros_like(state)
    drive[0, COMMAND], drive[0, SUPPLY], drive[0, TIME] = command[0, 0], supply[0], time[0]
    begin(state, modes, memory, rows, drive, servo, grid)
    nominal, servo = servo, drifted_by(servo, drift, time[0])
    plant, effects = servo.plant, servo.effects
    piston, lag = plant.piston, effects.sensor.displacement_lag
    direction, turned = friction_direction(time, true[0], true[1], reversal, effects.friction)
    behind = behind_the_rod(motion[0], held, effects.sensor.wiper_play)
    felt = true[1, 0]
    position, velocity, lagged = motion[0, 0] + behind[0], motion[1, 0], motion[2, 0]
    slope = displacement_gain(true[0, 0], piston.stroke, effects.sensor)
    # As a literal it would have what it is handed to compiled twice.
    last, place = 0.0, np.int64(0)
    pressed, yielding = math.nan, 0.0
    zeros = np.zeros(3)
    covariance = start_covariance(readings[:, 0], variance, reversal)
    before, after = np.zeros(3), np.zeros(3)
    path[0, 0], path[1, 0], path[2, 0] = state[PRESSURE_A], state[PRESSURE_B], state[SPOOL]
    error, moved, within = np.zeros(3), np.zeros(GAIN_ROWS), np.zeros(WITHIN)
    behind_a, behind_b = state[PRESSURE_A] - readings[0, 0], state[PRESSURE_B] - readings[1, 0]
    # A reading that is missing is behind nothing.
    within[BEHIND_A] = behind_a if math.isfinite(behind_a) else 0.0
    within[BEHIND_B] = behind_b if math.isfinite(behind_b) else 0.0
    for k in range(n - 1):
        interval = time[k + 1] - time[k]
        write_drive(drive, k, time, supply)
        if learning:
            decays[k] = carry_on(
                covariance,
                state,
                true[1, k],
                reversal,
                unsteadiness,
                turning_unsteadiness,
                force_rms,
                interval,
                spread[:, k],
                held[k],
                variance,
                memory,
                rows,
                drive,
                servo,
                grid,
                rate,
                total,
                start,
            )
        for i in range(3):
            before[i], after[i] = true[i, k], true[i, k + 1]
        earlier, servo = effects.sensor.displacement_gain, drifted_by(nominal, drift, time[k + 1])
        plant, effects = servo.plant, servo.effects
        piston, mass = plant.piston, rigid_mass(plant.piston.mass, effects.load)
        rising = (effects.sensor.displacement_gain - earlier) / interval
        if not held[k]:
            before[1] = (velocity + lag * lagged - rising * true[0, k]) / slope
        elif resting[k] != 0 and resting[k + 1] != 0 and effects.stop.stiffness > 0.0:
            before[1] = after[1] = yielding
        if held[k]:
            # What swings on the piston is thrown on by all of the speed that a stop takes.
            before[2] = after[2] = (after[1] - before[1]) / interval
        free = effects.load.joint_share > 0.0 and not held[k]
        if free:
            before[2] = after[2] = last
        kept = math.exp(-interval / WANDER_TIME)
        for slot in range(3):
            zeros[slot] *= kept
        bent, ahead, swung, shift = advance(
            state,
            before,
            after,
            held[k],
            free,
            last,
            time,
            command,
            k,
            steps[k],
            moves,
            place,
            modes,
            memory,
            rows,
            drive,
            servo,
            grid,
            rate,
            total,
            start,
            within,
        )
        place += steps[k]
        missed, flow_a, flow_b = effects.sensor.static_share, 0.0, 0.0
        if drawing or missed != 0.0:
            port = supply_at_valve(state, drive, interval, servo)
            flow_a, flow_b, drawn[k + 1] = valve_flows(
                state[SPOOL], state, memory, port, servo, grid
            )
        felt += (after[1] - felt) * followed(interval, effects.friction.lag)
        now = push(
            time[k + 1],
            state,
            after[1],
            felt,
            external_force[k + 1],
            direction[k + 1],
            servo,
        )
        slope = displacement_gain(true[0, k + 1], piston.stroke, effects.sensor)
        mean = slope * (0.5 * (now + last) + bent + swung if k else now)
        halfway = 0.5 * (before[0] + after[0])
        bend = displacement_bend(halfway, piston.stroke, effects.sensor)
        mean += bend * (0.5 * (before[1] + after[1])) ** 2
        if turned[k] != 0.0:
            extending, retracting = dry_friction(time[k + 1], state, after[1], servo)
            mean -= slope * 0.5 * (extending + retracting) * turned[k] / mass
        if free:
            # While it swung, the other forces were taken to stay as they had been.
            state[JOINT_RATE] -= interval * (0.5 * (now - last - shift) + bent)
        # A transducer's lag lets go of what it held back: exact for a force that stays as it is.
        let_go = followed(interval, lag)
        held_back = lag * (lagged - mean)
        position += interval * velocity + 0.5 * interval * interval * mean + slope * ahead
        position += held_back * (interval - lag * let_go)
        velocity += interval * mean + held_back * let_go
        lagged += (mean - lagged) * let_go
        if held[k + 1]:
            position = motion[0, k + 1] - zeros[2] + behind[k + 1]
            velocity, lagged = motion[1, k + 1], motion[2, k + 1]
        if not math.isfinite(position + state[PRESSURE_A] + state[PRESSURE_B]):
            # Nothing is expected of a servo that ran away, and no reading is as expected.
            left[:, k + 1 :] = math.inf
            break
        pressure_errors(error, readings[:, k + 1], state, path[:, k], age / interval, within, zeros)
        if missed != 0.0:
            add_dynamic_pressure(error, missed, flow_a, flow_b, state, plant.gas)
        error[2] = math.nan if held[k + 1] else readings[2, k + 1] - position - zeros[2]
        error[2] += behind[k + 1]
        if learning:
            if held[k + 1]:
                take_over(covariance, variance[2], velocity_rms[k + 1])
            weigh(covariance, error, variance, gains[k + 1], shares[k + 1])
            if resting[k + 1] != 0:
                shares[k + 1, 2] = 1.0
            known[k + 1] = force_spread(covariance, piston)
        if resting[k + 1] != 0:
            stop, read = place_at_stop(resting[k + 1], state, external_force[k + 1], servo)
            error[2] = readings[2, k + 1] - read + behind[k + 1]
            # What gives way does so as slowly as the pressures change; nan when it has just begun.
            yielding, pressed = (stop - pressed) / interval, stop
            if not math.isfinite(yielding):
                yielding = 0.0
        else:
            yielding, pressed = 0.0, math.nan
        corrections(moved, left[:, k + 1], error, gains[k + 1], shares[k + 1])
        state[PRESSURE_A] += moved[FOLLOWED_A]
        state[PRESSURE_B] += moved[FOLLOWED_B]
        for slot in range(3):
            zeros[slot] += moved[ZEROS[slot]]
        position += moved[POSITION]
        velocity += moved[SPEED]
        given = piston.area_a * moved[FOLLOWED_A] - piston.area_b * moved[FOLLOWED_B]
        given -= piston.viscous_friction * moved[SPEED] / slope
        last = now + given / mass
        path[0, k + 1], path[1, k + 1] = state[PRESSURE_A], state[PRESSURE_B]
        path[2, k + 1] = state[SPOOL]
        if state.shape[0] > PLANT_STATES:
            path[3, k + 1] = carried_force(state, servo)
    return left, path, known, drawn, decays


@compiled
def behind_the_rod(reading, held, play):
    """Return by how much a wiper with play reads less than where the rod is [m].

    Parameters
    ----------
    reading : (n,) array
        Smoothed displacement [m].
    held : (n,) array of bool
        While the piston sticks or lies at a stop: what moves there is noise.
    play : float
        Half width of the play [m].

    Notes
    -----
    The half width, with the sign of the last motion. The rod turns round before the reading does:
    the reading has not gone back far when the whole play has been taken up.

    Examples
    --------
    >>> there_and_back = np.array([0.0, 1e-3, 0.0])
    >>> behind_the_rod(there_and_back, np.zeros(3, dtype=np.bool_), 1e-5).tolist()
    [0.0, 1e-05, -1e-05]
    """
    behind, share = np.zeros(reading.size), 0.0
    for k in range(1, reading.size):
        if play > 0.0 and not held[k]:
            share = presliding_step(share, reading[k] - reading[k - 1], play, 1.0)
        behind[k] = play * share
    return behind
