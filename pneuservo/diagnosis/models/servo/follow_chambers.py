"""Both chamber pressures, followed from the command and the piston's measured motion."""

import math

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.chain import write_spool_rates
from pneuservo.plant.servo.layout import (
    COMMAND,
    INPUTS,
    MEMORY,
    PAST_COLUMNS,
    PAST_ROWS,
    SUPPLY,
    TIME,
)
from pneuservo.plant.servo.memory import begin, remember
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.servo.spool_effects import travel_end
from pneuservo.plant.single_axis import (
    CARD_LAGGED_1,
    DISPLACEMENT,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    STATES_WITH_CARD,
    VELOCITY,
)


@compiled
def follow_chambers(
    time,
    voltage,
    ramped,
    motion,
    pressures,
    supply,
    variance,
    spread,
    servo,
    grid,
    initial_state,
    longest_step,
):
    """Return what both pressures read beyond what flow and their own past make expected.

    Parameters
    ----------
    time : (n,) array
        [s].
    voltage : (n,) array
        Into the valve driver [V].
    ramped : bool
        Whether it runs straight between samples instead of being held.
    motion : (2, n) array
        Displacement and velocity of the piston, SI.
    pressures : (2, n) array
        As measured, the errors of the transducers undone [Pa].
    supply : (n,) array
        At the valve's supply port, or of the source behind a reservoir [Pa].
    variance : (2,) array
        Of the noise of each pressure [Pa^2].
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
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
    (2, n) array
        Innovations, each counted in the spread that it was expected to have [Pa].

    Notes
    -----
    A scalar Kalman filter per chamber. After an interval in which the command jumped at an
    unknown moment the reading counts for more and the innovation for less.
    """
    n = time.shape[0]
    left = np.zeros((2, n))
    state = initial_state.copy()
    modes = np.zeros(3, np.int64)
    modes[SPOOL_LIMIT] = SPOOL_FREE
    memory, rows = np.zeros(MEMORY), np.zeros((PAST_ROWS, PAST_COLUMNS))
    drive, work = np.zeros((2, INPUTS)), np.zeros((3, len(state)))
    drive[0, COMMAND], drive[0, SUPPLY], drive[0, TIME] = voltage[0], supply[0], time[0]
    begin(state, modes, memory, rows, drive, servo, grid)
    known = variance.copy()
    places = (PRESSURE_A, PRESSURE_B)
    for k in range(n - 1):
        interval = time[k + 1] - time[k]
        drive[0, COMMAND], drive[0, SUPPLY], drive[0, TIME] = voltage[k], supply[k], time[k]
        drive[1, COMMAND] = (voltage[k + 1] - voltage[k]) / interval if ramped else 0.0
        drive[1, SUPPLY] = (supply[k + 1] - supply[k]) / interval
        drive[1, TIME] = 1.0
        steps = max(1, math.ceil(interval / longest_step - 1e-9))
        for j in range(steps):
            step = interval / steps
            _step(
                state,
                motion[:, k],
                motion[:, k + 1],
                j * step,
                step,
                interval,
                modes,
                memory,
                rows,
                drive,
                servo,
                grid,
                work,
            )
            remember(state, modes, memory, rows, drive, (j + 1) * step, step, servo, grid)
        for side in range(2):
            known[side] += spread[side, k]
            expected = known[side] + variance[side]
            error = pressures[side, k + 1] - state[places[side]]
            left[side, k + 1] = error * math.sqrt(variance[side] / expected)
            state[places[side]] += known[side] / expected * error
            known[side] *= variance[side] / expected
    return left


@compiled
def _step(
    state, before, after, elapsed, step, interval, modes, memory, rows, drive, servo, grid, work
):
    """Advance the state by one classical Runge-Kutta step, the motion straight between samples."""
    rate, total, start = work[0], work[1], work[2]
    start[:] = state
    total[:] = 0.0
    for stage in range(4):
        at = elapsed + (0.0 if stage == 0 else step if stage == 3 else 0.5 * step)
        share = at / interval
        state[DISPLACEMENT] = before[0] + share * (after[0] - before[0])
        state[VELOCITY] = before[1] + share * (after[1] - before[1])
        pneumatic_rates(state, state[VELOCITY], memory, rows, drive, at, servo, grid, rate)
        write_spool_rates(state, modes, memory, rows, drive, at, servo, rate)
        weight = 1.0 if stage == 0 or stage == 3 else 2.0
        for i in range(PRESSURE_A, state.shape[0]):
            if i < CARD_LAGGED_1 or i >= STATES_WITH_CARD:
                total[i] += weight / 6.0 * rate[i]
                if stage < 3:
                    state[i] = start[i] + (0.5 if stage < 2 else 1.0) * step * rate[i]
    for i in range(PRESSURE_A, state.shape[0]):
        if i < CARD_LAGGED_1 or i >= STATES_WITH_CARD:
            state[i] = start[i] + step * total[i]
    end = travel_end(state[SPOOL], servo.effects.spool)
    if abs(state[SPOOL]) > end:
        state[SPOOL] = math.copysign(end, state[SPOOL])
        state[SPOOL_RATE] = 0.0
