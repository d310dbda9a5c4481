"""One run in fixed steps of the exponential method, with events located inside a step."""

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.plant.copying import put
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.events import margin, settle
from pneuservo.plant.exponential import (
    CHAIN_LIKE,
    ROWS,
    exponential_step,
    step_coefficients,
    step_series,
)
from pneuservo.plant.integrator import initial_modes
from pneuservo.plant.lane_arrays import load_tuple
from pneuservo.plant.lanes import WIDTH
from pneuservo.plant.located_step import store, through_events
from pneuservo.plant.outputs import OUTPUTS, output_values
from pneuservo.plant.single_axis import MODES_LIKE, STATE_LIKE, STATES_WITH_CARD

# Steps whose lengths differ by less are the same: times are themselves rounded.
SAME_STEP = 1e-11


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
        As in `pneuservo.plant.single_axis.derivative`.
    largest_step : float
        The intervals are divided into equal steps no longer than this [s].

    Returns
    -------
    (n, 10) array
        One column per name of `OUTPUTS`, in SI, each row just after its time. Columns that the law
        does not have are NaN.
    """
    state = np.zeros(STATES_WITH_CARD)
    put(initial_state, state)
    modes = initial_modes(state, inputs[0], plant).astype(np.float64)
    outputs = np.empty((time.shape[0], len(OUTPUTS)))
    coefficients, other_coefficients = np.zeros(ROWS * WIDTH), np.zeros(ROWS * WIDTH)
    series = np.zeros((1, WIDTH))
    if law.source == CARD_TAPS:
        series = step_series(law, largest_step)
    step_before = 0.0
    for k in range(time.shape[0]):
        held = (inputs[k, 0], inputs[k, 1])
        settle(state, modes, held, law, plant)
        store(output_values(state, modes, held, law, plant), outputs[k])
        if k + 1 == time.shape[0]:
            break
        steps, step = steps_between(time[k], time[k + 1], largest_step)
        if law.source == CARD_TAPS and not abs(step - step_before) <= SAME_STEP * step:
            step_coefficients(series, step / largest_step, coefficients)
            step_before = step
        chain = load_tuple(coefficients, CHAIN_LIKE)
        for _ in range(steps):
            start, modes_now = load_tuple(state, STATE_LIKE), load_tuple(modes, MODES_LIKE)
            end = exponential_step(start, step, chain, modes_now, held, law, plant, grid)
            if margin(end, modes_now, held, law, plant) < 0.0:
                through_events(
                    state,
                    modes,
                    end,
                    step,
                    held,
                    law,
                    plant,
                    grid,
                    series,
                    largest_step,
                    other_coefficients,
                )
            else:
                store(end, state)
    return outputs
