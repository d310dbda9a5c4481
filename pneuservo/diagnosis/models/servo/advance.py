"""Spool, chambers and load carried on by one sampling interval, the piston moved as it is told."""

import math

from pneuservo.diagnosis.models.servo.spool import (
    CROSSED,
    ENDED,
    OPENED,
    OPENED_BEFORE,
    write_move_apart,
)
from pneuservo.plant.compilation import compiled_lean
from pneuservo.plant.servo.chain import pressure_share
from pneuservo.plant.servo.layout import JOINT, JOINT_RATE, SUPPLY, TIME
from pneuservo.plant.servo.load_effects import joint_force, rigid_mass
from pneuservo.plant.servo.mechanics import carried_rates
from pneuservo.plant.servo.memory import remember_beside_spool
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    STATES_WITH_CARD,
    VELOCITY,
)

MEAN_A, MEAN_B, BEGAN_A, BEGAN_B, MOVING, SWEPT, BEHIND_A, BEHIND_B = range(8)
"""What belongs to a sampling interval: both pressures integrated over it and at its beginning; of a
piston that is free to move the velocity, and that integrated. The last two go on from one to the
next: by how much the readings of transducers that lag are behind the pressures."""
WITHIN = 8
_AIR_LEFT = 0.5
"""Share of its dead volume that a chamber never lacks, wherever a transducer has the piston."""


@compiled_lean
def write_drive(drive, k, time, supply):
    """Write what drives the chain from sample k on, but for the command: the spool goes before.

    Parameters
    ----------
    drive : (2, m) array
        Written: the inputs and their rates; columns as in `pneuservo.plant.servo.layout`.
    k : int
        The sample.
    time, supply : (n,) array
        [s], [Pa].
    """
    interval = time[k + 1] - time[k]
    drive[0, SUPPLY], drive[0, TIME] = supply[k], time[k]
    drive[1, SUPPLY] = (supply[k + 1] - supply[k]) / interval
    drive[1, TIME] = 1.0


@compiled_lean
def advance(
    state,
    before,
    after,
    held,
    free,
    acceleration,
    time,
    command,
    k,
    steps,
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
):
    """Advance spool, chambers, load and what belongs to them by one sampling interval.

    Parameters
    ----------
    state, modes, memory, rows, drive, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`; the first four are written.
    before, after : (3,) array
        Displacement, velocity and acceleration of the piston at both ends, SI; the velocity at the
        end is written unless the piston is held.
    held : bool
        Whether the piston moves as it is told; otherwise its velocity follows from its acceleration
        at the beginning and from what pressures and viscous friction change by.
    free : bool
        Whether the piston gives way to the load behind a joint: the acceleration is then what it
        would be if the joint's force stayed as it is.
    time, command
        As in `pneuservo.diagnosis.models.servo.spool.arriving`.
    acceleration : float
        Acceleration of the piston at the beginning [m/s^2].
    k : int
        The sample at which the interval begins.
    steps : int
        The interval is divided into so many equal steps.
    moves : (m, MOVED) array
        How the spool moves in each step, see `pneuservo.diagnosis.models.servo.spool.follow_spool`;
        written where a flow force makes it feel the chambers.
    place : int
        The row of the first step.
    rate, total, start : (m,) array
        Room to work in, as long as the state.
    within : (WITHIN,) array
        The same; what the transducers are behind is kept from one interval to the next.

    Returns
    -------
    bent : float
        By how much the mean push of the pressures differs from that of both ends of the interval:
        after a jump of the command they are far from straight in it [m/s^2].
    ahead : float
        By how much the piston gets farther than at the mean of its velocities at both ends [m].
    beyond, change : float
        By how much the joint's mean push differs from that of both ends of the interval, and by
        how much its push has changed in it [m/s^2].
    """
    interval = time[k + 1] - time[k]
    step = interval / steps
    begun = _joint(state, servo) if free else math.nan
    within[BEGAN_A], within[BEGAN_B] = state[PRESSURE_A], state[PRESSURE_B]
    within[MEAN_A] = within[MEAN_B] = within[SWEPT] = 0.0
    within[MOVING] = math.nan if held else before[1]
    swung, before_step = 0.0, begun
    for j in range(steps):
        started_a, started_b = state[PRESSURE_A], state[PRESSURE_B]
        _step(
            state,
            before,
            after,
            begun,
            acceleration,
            j * step,
            step,
            time,
            command,
            k,
            moves,
            place + j,
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
        _fall_behind(
            within, state[PRESSURE_A] - started_a, state[PRESSURE_B] - started_b, step, servo
        )
        remember_beside_spool(state, modes, memory, rows, drive, (j + 1) * step, step, servo, grid)
        if free:
            here = _joint(state, servo)
            swung += 0.5 * (before_step + here) / steps
            before_step = here
    piston = servo.plant.piston
    mass = rigid_mass(piston.mass, servo.effects.load)
    bent_a = within[MEAN_A] / interval - 0.5 * (within[BEGAN_A] + state[PRESSURE_A])
    bent_b = within[MEAN_B] / interval - 0.5 * (within[BEGAN_B] + state[PRESSURE_B])
    bent = (piston.area_a * bent_a - piston.area_b * bent_b) / mass
    ahead = 0.0
    if not held:
        after[1] = within[MOVING]
        ahead = within[SWEPT] - 0.5 * interval * (before[1] + after[1])
    if not free:
        return bent, ahead, 0.0, 0.0
    swings = (swung - 0.5 * (begun + before_step)) / mass
    return bent, ahead, swings, (before_step - begun) / mass


@compiled_lean
def _fall_behind(within, risen_a, risen_b, step, servo):
    """Let transducers that lag follow pressures that have risen straight over a step."""
    lag = servo.effects.sensor.pressure_lag
    share = followed(step, lag)
    within[BEHIND_A] += share * (lag / step * risen_a - within[BEHIND_A])
    within[BEHIND_B] += share * (lag / step * risen_b - within[BEHIND_B])


@compiled_lean
def followed(interval, lag):
    """Return the share of a step that a first-order lag has followed after some time [-].

    Parameters
    ----------
    interval, lag : float
        [s]; without a lag it follows at once.

    Examples
    --------
    >>> round(followed(1e-3, 1e-3), 3), followed(1e-3, 0.0)
    (0.632, 1.0)
    """
    return -math.expm1(-interval / lag) if lag > 0.0 else 1.0


@compiled_lean
def _joint(state, servo):
    """Return the force of the load's joint on the rod [N]."""
    if servo.effects.load.joint_share > 0.0:
        return joint_force(state[JOINT], state[JOINT_RATE], servo.effects.load)
    return 0.0


@compiled_lean
def _step(
    state,
    before,
    after,
    begun,
    acceleration,
    elapsed,
    step,
    time,
    command,
    k,
    moves,
    place,
    memory,
    rows,
    drive,
    servo,
    grid,
    rate,
    total,
    start,
    within,
):
    """Advance spool and chambers by one step, divided where the spool crosses its null.

    There the flows have a kink: charging and venting edges differ.
    """
    began, interval = state[SPOOL], time[k + 1] - time[k]
    if servo.effects.spool.flow_force != 0.0:
        since, felt = time[k] + elapsed, pressure_share(state, drive, elapsed, servo)
        until = since + step
        write_move_apart(moves, place, state, memory, time, command, k, since, until, felt, servo)
    ended, opened = moves[place, ENDED], moves[place, OPENED]
    crossed, opened_before = moves[place, CROSSED], moves[place, OPENED_BEFORE]
    crosses = crossed < math.inf
    for part in range(2 if crosses else 1):
        passed, length, opens, first, last = elapsed, step, opened, began, ended
        if crosses and part == 0:
            length, opens, last = crossed, opened_before, 0.0
        elif crosses:
            passed, length = elapsed + crossed, step - crossed
            opens, first = opened - opened_before, 0.0
        _fill(
            state,
            (first, 1.5 * opens / length - 0.25 * (first + last), last),
            before,
            after,
            begun,
            acceleration,
            passed,
            length,
            interval,
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


@compiled_lean
def _fill(
    state,
    openings,
    before,
    after,
    begun,
    acceleration,
    elapsed,
    step,
    interval,
    memory,
    rows,
    drive,
    servo,
    grid,
    rate,
    total,
    start,
    within,
):
    """Advance the chambers by one classical Runge-Kutta step, and a piston that is free to move.

    One that is held moves straight in time. Of the three openings, at the beginning, halfway and
    at the end, the second is what gives the mean with the others: where the spool meets the end of
    its travel, its place would not.
    """
    started_a, started_b = state[PRESSURE_A], state[PRESSURE_B]
    total_a = total_b = 0.0
    for i in range(STATES_WITH_CARD, state.shape[0]):
        start[i], total[i] = state[i], 0.0
    plant, moving = servo.plant, within[MOVING] == within[MOVING]
    piston = plant.piston
    # However far beyond a stop a transducer has the piston, there is air in front of it.
    lowest = -_AIR_LEFT * plant.dead_volume_a / piston.area_a
    highest = piston.stroke + _AIR_LEFT * plant.dead_volume_b / piston.area_b
    mass = rigid_mass(piston.mass, servo.effects.load)
    speed, faster, gained = within[MOVING], 0.0, 0.0
    for stage in range(4):
        passed = 0.0 if stage == 0 else step if stage == 3 else 0.5 * step
        at = elapsed + passed
        state[SPOOL] = openings[(stage + 1) // 2]
        share = at / interval
        place = before[0] + share * (after[0] - before[0])
        state[DISPLACEMENT] = min(max(place, lowest), highest)
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        more = _joint(state, servo) - begun if begun == begun else 0.0
        state[VELOCITY] = before[1] + share * (after[1] - before[1])
        if moving:
            state[VELOCITY] = speed + passed * faster
            within[SWEPT] += weight / 6.0 * step * state[VELOCITY]
            push = piston.area_a * (state[PRESSURE_A] - within[BEGAN_A]) + more
            push -= piston.area_b * (state[PRESSURE_B] - within[BEGAN_B])
            push -= piston.viscous_friction * (state[VELOCITY] - before[1])
            faster = acceleration + push / mass
            gained += weight / 6.0 * step * faster
        if state.shape[0] > PLANT_STATES:
            second = before[2] + share * (after[2] - before[2]) + more / mass
            carried_rates(state, state[VELOCITY], second, servo, rate)
        pneumatic_rates(state, state[VELOCITY], memory, rows, drive, at, servo, grid, rate)
        within[MEAN_A] += weight / 6.0 * step * state[PRESSURE_A]
        within[MEAN_B] += weight / 6.0 * step * state[PRESSURE_B]
        total_a += weight / 6.0 * rate[PRESSURE_A]
        total_b += weight / 6.0 * rate[PRESSURE_B]
        onward = (0.5 if stage < 2 else 1.0) * step
        state[PRESSURE_A] = started_a + onward * rate[PRESSURE_A]
        state[PRESSURE_B] = started_b + onward * rate[PRESSURE_B]
        for i in range(STATES_WITH_CARD, state.shape[0]):
            total[i] += weight / 6.0 * rate[i]
            state[i] = start[i] + onward * rate[i]
    state[PRESSURE_A] = started_a + step * total_a
    state[PRESSURE_B] = started_b + step * total_b
    for i in range(STATES_WITH_CARD, state.shape[0]):
        state[i] = start[i] + step * total[i]
    within[MOVING] = speed + gained
