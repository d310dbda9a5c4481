"""Fixed steps of the classical Runge-Kutta method, with events located inside a step.

For controllers that act in steps of their own, and as a reference: steps and location of events are
not those of `pneuservo.plant.single_run`, the equations are.
"""

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.copying import put
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.events import margin, settle
from pneuservo.plant.outputs import OUTPUTS, output_values
from pneuservo.plant.piston import is_moving, motion_from
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    MOTION,
    RELAY_SIGN,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    VELOCITY,
    derivative,
    piston_force,
)

# How closely an event is located: far below any step, far above the rounding of the time.
TIME_TOLERANCE = 1e-12
MOST_TRIALS = 100
# A step with more events than this is taken to its end as it is, so that no input can hang a run.
MOST_EVENTS_PER_STEP = 100
# Below this the spool is at rest at null; smaller numbers would only become subnormal and slow.
SMALLEST_OPENING = 1e-30


@compiled
def runge_kutta_step(state, step, modes, inputs, law, plant, grid, work, result):
    """Write the state one step later, the modes staying as they are.

    Parameters
    ----------
    state : (n,) array
        Before the step.
    step : float
        Length of the step [s].
    modes, inputs, law, plant, grid
        As in `derivative`.
    work : (3, n) array
        Overwritten.
    result : (n,) array
        Written: the state after the step; must not be `state` itself.
    """
    stage, rate, total = work[0], work[1], work[2]
    derivative(state, modes, inputs, law, plant, grid, rate)
    for i in range(state.shape[0]):
        total[i] = rate[i]
        stage[i] = state[i] + 0.5 * step * rate[i]
    derivative(stage, modes, inputs, law, plant, grid, rate)
    for i in range(state.shape[0]):
        total[i] += 2.0 * rate[i]
        stage[i] = state[i] + 0.5 * step * rate[i]
    derivative(stage, modes, inputs, law, plant, grid, rate)
    for i in range(state.shape[0]):
        total[i] += 2.0 * rate[i]
        stage[i] = state[i] + step * rate[i]
    derivative(stage, modes, inputs, law, plant, grid, rate)
    for i in range(state.shape[0]):
        result[i] = state[i] + step / 6.0 * (total[i] + rate[i])


@compiled
def locate_event(state, step, modes, inputs, law, plant, grid, work, result):
    """Return how far into a step the first event lies, and write the state just after it.

    Parameters
    ----------
    state, step, modes, inputs, law, plant, grid, work
        As in `runge_kutta_step`; the step is known to end beyond an event.
    result : (n,) array
        On entry the state at the end of the step, on return the state at the event.

    Returns
    -------
    float
        Time from the start of the step to the event [s].

    Notes
    -----
    Regula falsi with Illinois weights (Dowell and Jarratt 1971) on steps repeated from the same
    start, so that the state at the event has the error of a step and not of an interpolation.
    """
    before, after = 0.0, step
    margin_before = margin(state, modes, inputs, law, plant)
    margin_after = margin(result, modes, inputs, law, plant)
    kept = 0
    for trials in range(MOST_TRIALS + 1):
        width = after - before
        located = width <= TIME_TOLERANCE or trials == MOST_TRIALS
        trial = after
        if not located:
            # A margin of exactly zero may be one that does not change: halve the bracket then.
            share = 0.5 if margin_before == 0.0 else margin_after / (margin_after - margin_before)
            trial -= width * min(max(share, 0.01), 0.99)
        runge_kutta_step(state, trial, modes, inputs, law, plant, grid, work, result)
        if located:
            break
        margin_trial = margin(result, modes, inputs, law, plant)
        if margin_trial < 0.0:
            after, margin_after = trial, margin_trial
            if kept == -1:
                margin_before *= 0.5
            kept = -1
        else:
            before, margin_before = trial, margin_trial
            if kept == 1:
                margin_after *= 0.5
            kept = 1
    return after


@compiled
def advance(state, duration, modes, inputs, law, plant, grid, work, result):
    """Advance the state over one step, through every event inside it.

    Parameters
    ----------
    state : (n,) array
        Changed.
    duration : float
        Length of the step [s].
    modes : (3,) array of int
        Changed at events.
    inputs, law, plant, grid, work, result
        As in `runge_kutta_step`; `result` is overwritten.
    """
    remaining = duration
    events = 0
    while True:
        runge_kutta_step(state, remaining, modes, inputs, law, plant, grid, work, result)
        beyond = margin(result, modes, inputs, law, plant) < 0.0
        if not beyond or events == MOST_EVENTS_PER_STEP:
            put(result, state)
            break
        reached = locate_event(state, remaining, modes, inputs, law, plant, grid, work, result)
        put(result, state)
        settle(state, modes, inputs, law, plant)
        remaining -= reached
        events += 1
        if remaining <= 0.0:
            break
    if abs(state[SPOOL]) < SMALLEST_OPENING and abs(state[SPOOL_RATE]) < SMALLEST_OPENING:
        state[SPOOL] = 0.0
        state[SPOOL_RATE] = 0.0


@compiled
def initial_modes(state, inputs, plant):
    """Return the modes at the start of a run, and bring the state onto what they hold.

    Parameters
    ----------
    state : array
        Changed where a mode holds it.
    inputs, plant
        As in `derivative`.

    Returns
    -------
    (3,) array of int
        Places as named in `pneuservo.plant.single_axis`.
    """
    modes = np.empty(3, np.int64)
    modes[MOTION] = motion_from(
        state[DISPLACEMENT],
        state[VELOCITY],
        piston_force(state, inputs, plant),
        plant.piston,
    )
    if not is_moving(modes[MOTION]):
        state[VELOCITY] = 0.0
    modes[RELAY_SIGN] = 1
    modes[SPOOL_LIMIT] = SPOOL_FREE
    if abs(state[SPOOL]) >= 1.0:
        modes[SPOOL_LIMIT] = 1 if state[SPOOL] > 0.0 else -1
    return modes


@compiled
def run(time, inputs, initial_state, law, plant, grid, largest_step):
    """Return the outputs at every time of a run.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    inputs : (n, 2) array
        Held voltage [V] or demand [m], and external force [N]; a row holds until the next time.
    initial_state : (6,) or (10,) array
        In SI; ten with a card.
    law, plant, grid
        As in `derivative`.
    largest_step : float
        The intervals are divided into equal steps no longer than this [s].

    Returns
    -------
    (n, 10) array
        One column per name of `OUTPUTS`, in SI, each row just after its time. Columns that the law
        does not have are NaN.
    """
    state = initial_state.copy()
    work = np.empty((3, state.shape[0]))
    result = np.empty_like(state)
    outputs = np.empty((time.shape[0], len(OUTPUTS)))
    modes = initial_modes(state, inputs[0], plant)
    for k in range(time.shape[0]):
        held = inputs[k]
        settle(state, modes, held, law, plant)
        row = output_values(state, modes, held, law, plant)
        for i in range(len(row)):
            outputs[k, i] = row[i]
        if k + 1 < time.shape[0]:
            steps, step = steps_between(time[k], time[k + 1], largest_step)
            for _ in range(steps):
                advance(state, step, modes, held, law, plant, grid, work, result)
    return outputs
