"""The spool followed through the command that arrives at it, in steps of its own."""

import math

import numpy as np

from pneuservo.plant.control_law import limited
from pneuservo.plant.servo.chain import driving
from pneuservo.plant.servo.compilation import compiled, compiled_apart, compiled_whole
from pneuservo.plant.servo.layout import MEMORY, SPOOL_STUCK
from pneuservo.plant.servo.memory import begin_spool, remember_spool, remembers
from pneuservo.plant.servo.spool_effects import spool_rates, travel_end
from pneuservo.plant.single_axis import PLANT_STATES, SPOOL, SPOOL_RATE

STEP = 125e-6
"""Longest step of a spool that replies linearly: a tenth of its time constant [s] ..."""
STEP_ON_A_SLOPE = 250e-6
"""... and where its command runs on, and does not leave it behind as one that jumps does [s]."""
FINE_STEP = 25e-6
"""Longest step where limits and stiction switch on and off, and near the end of the travel [s]."""
_NEAR_END = 0.03
"""So far from it, and what it may move in a long step [-]."""
_SAME_MOMENT = 1e-11
"""Moments that are no farther apart are one [s]: a fit moves a delay by nanoseconds."""

ENDED, OPENED, CROSSED, OPENED_BEFORE = range(4)
"""Of one move of the spool: where it ends [-], and what `move_spool` returns of it."""
MOVED = 4


@compiled
def arriving(time, command, latest, moment):
    """Return the command at a moment, how fast it rises, and until when it goes on so.

    Parameters
    ----------
    time : (n,) array
        Of the samples [s].
    command : (n, m + 1) array
        Of each sampling interval at the ends of its m equal parts, see
        `pneuservo.diagnosis.models.servo.command` [V].
    latest : int
        A sample; the moment is before the next one.
    moment : float
        Before the first sample the command has stood as it is there [s].

    Returns
    -------
    command, rising, until : float
        [V], [V/s], [s].

    Examples
    --------
    >>> import numpy as np
    >>> time = np.array([0.0, 0.5, 1.0])
    >>> held, runs = np.array([[1.0, 1.0], [3.0, 3.0]]), np.array([[1.0, 3.0], [3.0, 2.0]])
    >>> arriving(time, held, 1, 0.25), arriving(time, runs, 1, 0.25)
    ((1.0, 0.0, 0.5), (2.0, 4.0, 0.5))
    """
    k = latest
    while k >= 0 and time[k] > moment + _SAME_MOMENT:
        k -= 1
    if k < 0:
        return command[0, 0], 0.0, time[0]
    parts = command.shape[1] - 1
    length = (time[k + 1] - time[k]) / parts
    part = min(int((moment - time[k] + _SAME_MOMENT) / length), parts - 1)
    began = time[k] + part * length
    until = time[k + 1] if part == parts - 1 else began + length
    rising = (command[k, part + 1] - command[k, part]) / length
    return command[k, part] + rising * (moment - began), rising, until


@compiled
def move_spool(state, memory, time, command, latest, since, until, share, servo):
    """Move the spool from one moment of a sampling interval to another.

    Parameters
    ----------
    state, memory, servo
        As in `pneuservo.plant.servo.chain.derivative`; of the first two, what is the spool's is
        written.
    time, command
        As in `arriving`.
    latest : int
        The sample at which the interval begins.
    since, until : float
        Both in that interval [s].
    share : float
        From `pneuservo.plant.servo.chain.pressure_share`; only a flow force feels it [-].

    Returns
    -------
    opened : float
        Its opening integrated over that time [s].
    crossed : float
        After how long it first crosses its null, where it ends on the other side; infinite where
        it does not, or next to either end of that time [s].
    opened_before : float
        Its opening integrated until then [s].

    Notes
    -----
    But for that it does not feel the chambers, and has its own classical Runge-Kutta steps. None
    goes over a jump of the command, which a delay lets arrive in the midst of an interval.
    """
    began, opened, opened_before, crossed = state[SPOOL], 0.0, 0.0, math.inf
    effects = servo.effects.spool
    switching = effects.acceleration_limit + effects.rate_limit + effects.stiction
    now = since
    while now < until - _SAME_MOMENT:
        voltage, rising, goes_on = arriving(time, command, latest, now - effects.delay)
        end = min(until, goes_on + effects.delay)
        longest = STEP if rising == 0.0 else STEP_ON_A_SLOPE
        reach = abs(state[SPOOL]) + longest * abs(state[SPOOL_RATE]) + _NEAR_END
        if switching > 0.0 or reach > travel_end(state[SPOOL], effects):
            longest = FINE_STEP
        steps = max(1, math.ceil((end - now) / longest - 1e-6))
        step = (end - now) / steps
        for _ in range(steps):
            place = state[SPOOL]
            more = _step(state, memory, voltage, rising, step, share, servo)
            if crossed == math.inf and place * state[SPOOL] < 0.0:
                part = place / (place - state[SPOOL])
                crossed = now + part * step - since
                opened_before = opened + 0.5 * part * step * place
            opened += more
            voltage += step * rising
            now += step
            if remembers(effects):
                remember_spool(voltage, now, state, memory, step, servo)
        now = end
    if (
        began * state[SPOOL] >= 0.0
        or crossed < _SAME_MOMENT
        or crossed > now - since - _SAME_MOMENT
    ):
        crossed = math.inf
    return opened, crossed, opened_before


@compiled_whole
def follow_spool(time, command, steps, opening, servo):
    """Return how a spool that does not feel the chambers moves in each step of a recording.

    Parameters
    ----------
    time, command, servo
        As in `move_spool`.
    steps : (n,) array of int
        Into how many equal steps each sampling interval is divided.
    opening : float
        Where it begins, at rest [-].

    Returns
    -------
    (m, MOVED) array
        Of every step in turn.
    """
    state, memory = np.zeros(PLANT_STATES), np.zeros(MEMORY)
    state[SPOOL] = opening
    begin_spool(memory, limited(command[0, 0], servo.law.level), time[0], servo)
    # As a literal it would have what it is handed to compiled twice.
    moves, place = np.empty((np.sum(steps[:-1]), MOVED)), np.int64(0)
    for k in range(time.shape[0] - 1):
        step = (time[k + 1] - time[k]) / steps[k]
        for j in range(steps[k]):
            since = time[k] + j * step
            until = since + step
            write_move(moves, place, state, memory, time, command, k, since, until, 0.0, servo)
            place += 1
    return moves


@compiled
def write_move(moves, place, state, memory, time, command, latest, since, until, share, servo):
    """Move the spool as `move_spool` does, and write how it moved.

    Parameters
    ----------
    moves : (m, MOVED) array
        Written ...
    place : int
        ... in this row.
    state, memory, time, command, latest, since, until, share, servo
        As in `move_spool`.
    """
    opened, crossed, opened_before = move_spool(
        state, memory, time, command, latest, since, until, share, servo
    )
    moves[place, ENDED], moves[place, OPENED] = state[SPOOL], opened
    moves[place, CROSSED], moves[place, OPENED_BEFORE] = crossed, opened_before


@compiled_apart
def write_move_apart(
    moves, place, state, memory, time, command, latest, since, until, share, servo
):
    """Write what `write_move` does, where it is seldom asked to.

    Parameters
    ----------
    moves, place, state, memory, time, command, latest, since, until, share, servo
        As in `write_move`.
    """
    write_move(moves, place, state, memory, time, command, latest, since, until, share, servo)


@compiled
def reached(place, speed, later_speed, step, end):
    """Return after what part of a step the end of the travel is reached [s]; the step if it is not.

    Parameters
    ----------
    place, speed, later_speed : float
        Where the spool begins the step, how fast, and how fast it would end it, outwards
        [-], [1/s].
    step : float
        Length of the step [s].
    end : float
        End of the travel [-].

    Notes
    -----
    On the parabola through these. A spool that all but reaches the end is found to do so, or not,
    with next to no consequence: residuals must not jump when a parameter moves a little.

    Examples
    --------
    >>> reached(0.99, 100.0, 100.0, 125e-6, 1.0) < 1.01e-4
    True
    >>> reached(0.99, 100.0, -100.0, 125e-6, 1.0)
    0.000125
    """
    gap = end - place
    if gap <= 0.0:
        return 0.0
    slowing = (speed - later_speed) / step
    root = speed * speed - 2.0 * slowing * gap
    if root < 0.0 or speed + math.sqrt(root) <= 0.0:
        return step
    return min(2.0 * gap / (speed + math.sqrt(root)), step)


@compiled
def _step(state, memory, command, rising, step, share, servo):
    """Move the spool by one step, inelastically onto the end of its travel if it gets there.

    Returns its opening integrated over the step.
    """
    place, speed = state[SPOOL], state[SPOOL_RATE]
    _free_step(state, memory, 0.0, command, rising, step, share, servo)
    side = 1.0 if state[SPOOL] > 0.0 else -1.0
    end = travel_end(side, servo.effects.spool)
    opened = 0.5 * step * (place + state[SPOOL])
    opened += step * step / 12.0 * (speed - state[SPOOL_RATE])
    if side * place < end and side * state[SPOOL] < end and speed * state[SPOOL_RATE] >= 0.0:
        return opened
    until = reached(side * place, side * speed, side * state[SPOOL_RATE], step, end)
    if until < step:
        state[SPOOL], state[SPOOL_RATE] = side * end, 0.0
        opened = 0.5 * until * (place + side * end)
        _free_step(state, memory, until, command, rising, step - until, share, servo)
        opened += 0.5 * (step - until) * (side * end + state[SPOOL])
    if side * state[SPOOL] > end:
        state[SPOOL], state[SPOOL_RATE] = side * end, 0.0
    return opened


@compiled
def _free_step(state, memory, passed, command, rising, step, share, servo):
    """Move the spool by one classical Runge-Kutta step, as if its travel had no end.

    What it remembers and the command are of some time ago.
    """
    valve, effects = servo.plant.valve, servo.effects.spool
    opening, speed = state[SPOOL], state[SPOOL_RATE]
    moved = sped = first = second = 0.0
    for stage in range(4):
        at = 0.0 if stage == 0 else step if stage == 3 else 0.5 * step
        since = passed + at
        driven = driving(command + rising * since, memory, since, servo)
        first, second = spool_rates(
            limited(driven, valve.full_voltage),
            opening + at * first,
            speed + at * second,
            share,
            memory[SPOOL_STUCK],
            valve,
            effects,
        )
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        moved += weight / 6.0 * step * first
        sped += weight / 6.0 * step * second
    state[SPOOL] = opening + moved
    state[SPOOL_RATE] = speed + sped
