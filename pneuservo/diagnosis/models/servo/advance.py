"""Spool and chambers carried on by one sampling interval, the piston moved as it is told."""

import math

from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.chain import write_spool_rates
from pneuservo.plant.servo.layout import COMMAND, SUPPLY, TIME
from pneuservo.plant.servo.memory import remember
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.servo.spool_effects import travel_end
from pneuservo.plant.single_axis import (
    CARD_LAGGED_1,
    DISPLACEMENT,
    PRESSURE_A,
    SPOOL,
    SPOOL_RATE,
    STATES_WITH_CARD,
    VELOCITY,
)

ON_ITS_WAY = 0.02
"""A spool that is farther from where it is told to be, as a share of full opening ..."""
FINE_STEP = 125e-6
"""... is followed with steps no longer than this: a tenth of its time constant [s]."""


@compiled
def write_drive(drive, k, time, voltage, supply, ramped):
    """Write what drives the chain from sample k on.

    Parameters
    ----------
    drive : (2, m) array
        Written: the inputs and their rates; columns as in `pneuservo.plant.servo.layout`.
    k : int
        The sample.
    time, voltage, supply : (n,) array
        [s], [V], [Pa].
    ramped : bool
        Whether the command runs straight between samples instead of being held.
    """
    interval = time[k + 1] - time[k]
    drive[0, COMMAND], drive[0, SUPPLY], drive[0, TIME] = voltage[k], supply[k], time[k]
    drive[1, COMMAND] = (voltage[k + 1] - voltage[k]) / interval if ramped else 0.0
    drive[1, SUPPLY] = (supply[k + 1] - supply[k]) / interval
    drive[1, TIME] = 1.0


@compiled
def advance(
    state, before, after, interval, longest_step, modes, memory, rows, drive, servo, grid, work
):
    """Advance spool, chambers and what belongs to them by one sampling interval.

    Parameters
    ----------
    state, modes, memory, rows, drive, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`; the first four are written.
    before, after : (2,) array
        Displacement and velocity of the piston at both ends, SI.
    interval, longest_step : float
        The interval, divided into equal steps no longer than that [s].
    work : (3, m) array
        Room to work in.
    """
    valve = servo.plant.valve
    asked = min(max(drive[0, COMMAND] / valve.full_voltage, -1.0), 1.0)
    way = abs(asked - state[SPOOL]) + abs(state[SPOOL_RATE]) / valve.spool_frequency
    longest = min(longest_step, FINE_STEP) if way > ON_ITS_WAY else longest_step
    steps = max(1, math.ceil(interval / longest - 1e-9))
    step = interval / steps
    for j in range(steps):
        _step(
            state,
            before,
            after,
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
