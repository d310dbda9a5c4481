"""Runs of many rigs at once, eight side by side in the lanes of the processor.

All follow the same demand under laws of the same kind; the numbers of rig and law differ. A lane in
which something happens within a step is advanced over that step by the code for one run.
"""

import math

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.plant.copying import put, put_table
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.events import margin, settle
from pneuservo.plant.exponential import (
    CHAIN_LIKE,
    COEFFICIENTS,
    POWERS,
    ROWS,
    exponential_step,
    step_coefficients,
    step_series,
)
from pneuservo.plant.integrator import initial_modes
from pneuservo.plant.lane_arrays import load_lane, load_lanes, store_rows
from pneuservo.plant.lanes import WIDTH, lanes_that
from pneuservo.plant.located_step import store, through_events
from pneuservo.plant.outputs import (
    OUTPUTS,
    PRESSURE_A_OUT,
    PRESSURE_B_OUT,
    output_values,
)
from pneuservo.plant.single_axis import MODES_LIKE, PLANT_STATES, STATE_LIKE, STATES_WITH_CARD
from pneuservo.plant.single_run import SAME_STEP


@compiled
def run_batch(
    time, inputs, initial_states, numbers, law, plant, grid, largest_step, columns, outputs
):
    """Write chosen outputs of many runs.

    Parameters
    ----------
    time, inputs, largest_step
        As in `pneuservo.plant.single_run.run`; the same for all.
    initial_states : (blocks, 10, 8) array
        In SI, one run in each lane.
    numbers : (blocks, n, 8) array
        The floats of law and plant, in the order of their fields.
    law, plant : ControlLaw, SingleAxis
        Those of one of the runs: what kind of law it is, and how the numbers are arranged.
    grid : (4, 51, 101) array
        Discharge coefficients, the same for all.
    columns : (m,) array of int
        Places in `OUTPUTS` of what is wanted.
    outputs : (8 blocks, m, n) array
        Written, each row just after its time.
    """
    state, modes = np.empty((STATES_WITH_CARD, WIDTH)), np.empty((len(MODES_LIKE), WIDTH))
    row, chain = np.empty((len(OUTPUTS), WIDTH)), np.zeros((COEFFICIENTS, WIDTH))
    series = np.zeros((WIDTH, POWERS * ROWS, WIDTH))
    of_one_lane = (
        np.empty(STATES_WITH_CARD),
        np.empty(len(MODES_LIKE)),
        np.zeros(ROWS * WIDTH),
        np.empty((STATES_WITH_CARD, WIDTH)),
    )
    for block in range(numbers.shape[0]):
        own_numbers = numbers[block]
        put_table(initial_states[block], state)
        _start(state, modes, inputs, own_numbers, law, plant, series, largest_step)
        laws, plants = load_lanes(own_numbers, (law, plant))
        step_before = 0.0
        for k in range(time.shape[0]):
            held = (inputs[k, 0], inputs[k, 1])
            now, doing = load_lanes(state, STATE_LIKE), load_lanes(modes, MODES_LIKE)
            changed = lanes_that(margin(now, doing, held, laws, plants) < 0.0)
            if changed:
                _settle_lanes(changed, state, modes, held, own_numbers, law, plant, of_one_lane)
                now, doing = load_lanes(state, STATE_LIKE), load_lanes(modes, MODES_LIKE)
            store_rows(row, output_values(now, doing, held, laws, plants))
            _write(row, columns, outputs[block * WIDTH : (block + 1) * WIDTH, :, k])
            if k + 1 == time.shape[0]:
                break
            steps, step = steps_between(time[k], time[k + 1], largest_step)
            if law.source == CARD_TAPS and not abs(step - step_before) <= SAME_STEP * step:
                _chain_of_lanes(series, step / largest_step, of_one_lane[2], chain)
                step_before = step
            chains = load_lanes(chain, CHAIN_LIKE)
            for _ in range(steps):
                end = exponential_step(now, step, chains, doing, held, laws, plants, grid)
                crossed = lanes_that(margin(end, doing, held, laws, plants) < 0.0)
                if crossed:
                    store_rows(state, now)
                    now = _through_events_in_lanes(
                        crossed,
                        end,
                        state,
                        modes,
                        step,
                        held,
                        own_numbers,
                        law,
                        plant,
                        grid,
                        series,
                        largest_step,
                        of_one_lane,
                    )
                    doing = load_lanes(modes, MODES_LIKE)
                else:
                    now = end
            store_rows(state, now)


@compiled
def _write(row, columns, outputs):
    """Write the chosen outputs of all lanes at one time."""
    for lane in range(WIDTH):
        # Zero, or NaN when the state is none: then nothing of the run can be used.
        broken = 0.0
        for i in range(PLANT_STATES):
            broken += 0.0 * row[i, lane]
        if not min(row[PRESSURE_A_OUT, lane], row[PRESSURE_B_OUT, lane]) > 0.0:
            broken = math.nan
        for i in range(columns.shape[0]):
            outputs[lane, i] = row[columns[i], lane] + broken


@compiled
def _start(state, modes, inputs, numbers, law, plant, series, largest_step):
    """Write the first modes of all lanes and the series of their cards."""
    for lane in range(WIDTH):
        own_law, own_plant = load_lane(numbers, lane, (law, plant))
        put(initial_modes(state[:, lane], inputs[0], own_plant), modes[:, lane])
        if law.source == CARD_TAPS:
            put_table(step_series(own_law, largest_step), series[lane])


@compiled
def _chain_of_lanes(series, share, coefficients, chain):
    for lane in range(WIDTH):
        step_coefficients(series[lane], share, coefficients)
        put(coefficients[:COEFFICIENTS], chain[:, lane])


@compiled
def _settle_lanes(lanes, state, modes, inputs, numbers, law, plant, of_one_lane):
    own_state, own_modes, _, _ = of_one_lane
    for lane in range(WIDTH):
        if lanes >> lane & 1:
            own_law, own_plant = load_lane(numbers, lane, (law, plant))
            put(state[:, lane], own_state)
            put(modes[:, lane], own_modes)
            settle(own_state, own_modes, inputs, own_law, own_plant)
            put(own_state, state[:, lane])
            put(own_modes, modes[:, lane])


@compiled
def _through_events_in_lanes(
    lanes,
    end,
    state,
    modes,
    step,
    inputs,
    numbers,
    law,
    plant,
    grid,
    series,
    largest_step,
    of_one_lane,
):
    """Return the state one step later, the lanes in which something happens by the code for one.

    `state` is that before the step, `end` the one after it if nothing happened.
    """
    own_state, own_modes, coefficients, after = of_one_lane
    store_rows(after, end)
    for lane in range(WIDTH):
        if lanes >> lane & 1:
            own_law, own_plant = load_lane(numbers, lane, (law, plant))
            store(load_lane(state, lane, STATE_LIKE), own_state)
            store(load_lane(modes, lane, MODES_LIKE), own_modes)
            through_events(
                own_state,
                own_modes,
                load_lane(after, lane, STATE_LIKE),
                step,
                inputs,
                own_law,
                own_plant,
                grid,
                series[lane],
                largest_step,
                coefficients,
            )
            for i in range(STATES_WITH_CARD):
                after[i, lane] = own_state[i]
            for i in range(len(MODES_LIKE)):
                modes[i, lane] = own_modes[i]
    return load_lanes(after, STATE_LIKE)
