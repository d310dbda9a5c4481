"""The exponential step: its coefficients, its order, and events located inside it."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard, SlidingMode
from pneuservo.plant import integrator, single_run
from pneuservo.plant.exponential import (
    LONGEST_STEP,
    ROWS,
    step_coefficients,
    step_limit,
    step_series,
)
from pneuservo.plant.lanes import WIDTH
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate
from pneuservo.simulation.run import with_card_at_rest

RIG = load_rig("single-axis")
PLANT, GRID = plant_numbers.single_axis(RIG), plant_numbers.valve_grid("ddv-27a1")
CARD = AnalogueCard(card_figures(load_design()))
RELAY_CARD = AnalogueCard(replace(CARD.figures, output_gain=math.inf))
TIME = np.arange(0.0, 0.1505, 1e-3)
DEMAND = np.where(TIME < 0.005, 0.015, 0.020)
INPUTS = np.column_stack((DEMAND, np.zeros_like(DEMAND)))
X = OUTPUTS.index("displacement")


def start(law):
    return with_card_at_rest(InitialState(0.0147).state(PLANT, 0.0, 0.0), law)


def chain(law):
    """The linear chain: velocity, input less first lagged signal, the other states of the card."""
    t1, t2 = law.velocity_lag_1, law.velocity_lag_2
    t3, t4 = law.acceleration_lag_1, law.acceleration_lag_2
    rc = law.velocity_time_constant
    return np.array(
        [
            [0, 0, 0, 0, 0],
            [law.sensitivity, -1 / t1, 0, 0, 0],
            [0, 1 / (t1 * t2), -1 / t2, 0, 0],
            [0, 0, -rc / t3, -1 / t3, 0],
            [0, 0, -rc / (t3 * t4), -1 / (t3 * t4), -1 / t4],
        ]
    )


@pytest.mark.parametrize("share", [1.0, 0.37, 1e-3])
def test_coefficients_are_those_of_the_matrix_exponential(share):
    law = CARD.law(RIG)
    longest = LONGEST_STEP * min(law.velocity_lag_1, law.acceleration_lag_1)
    coefficients = np.zeros(ROWS * WIDTH)
    step_coefficients(step_series(law, longest), share, coefficients)
    step, matrix = share * longest, chain(law)
    # Courses of the acceleration 1, t/h, (t/h)^2/2 as further states of a chain in front.
    longer = np.zeros((8, 8))
    longer[:5, :5], longer[0, 5] = matrix, 1.0
    longer[5, 6] = longer[6, 7] = 1.0 / step
    exact = expm(longer * step)
    whole = exact[:5, :5]
    expected = [whole[row, column] for row in range(1, 5) for column in range(row + 1)]
    for row in range(1, 5):
        first, second, third = exact[row, 5:]
        expected += [
            first - 3.0 * second + 4.0 * third,
            2.0 * second - 4.0 * third,
            4.0 * third - second,
        ]
    half = expm(longer * step / 2)
    expected += [half[2, 0], half[2, 1], half[2, 2], *half[4, :5], half[2, 5], half[4, 5]]
    # Both sum series of about 20 terms.
    scale = np.maximum(np.abs(expected), 1e-9 * np.abs(expected).max())
    assert np.max(np.abs(coefficients[: len(expected)] - expected) / scale) < 1e-9


def test_fourth_order_with_a_card_on_a_smooth_stretch():
    grid = np.full((4, 51, 101), 0.7)
    # A small surface in a wide layer: no limit, one direction, one side of the critical ratio.
    law = replace(CARD, figures=replace(CARD.figures, output_gain=1.0)).law(RIG)
    state = with_card_at_rest(np.array([0.012, 0.05, 4.6e5, 5.5e5, 0.3, 0.0]), law)
    # The filters have followed the motion for a while: otherwise the command starts at its limit.
    state[6] -= law.sensitivity * law.velocity_lag_1 * 0.05
    state[7] = law.sensitivity * 0.05
    state[8] = -law.velocity_time_constant * state[7]
    time, inputs = np.array([0.0, 0.002]), np.tile([0.02, 0.0], (2, 1))

    def end(step):
        return single_run.run(time, inputs, state, law, PLANT, grid, step)[-1, :6]

    exact = end(1e-6)
    errors = [abs(end(step)[3] - exact[3]) for step in (100e-6, 50e-6, 25e-6, 12.5e-6)]
    orders = [math.log2(a / b) for a, b in pairwise(errors)]
    # Measured 4.4 to 4.6: the error of the filters' part, of order 5, shows beside the rest.
    assert orders == pytest.approx([4.5] * 3, abs=0.5), errors


@pytest.mark.parametrize("controller", [SlidingMode(), CARD], ids=["true states", "card"])
def test_long_steps_under_a_boundary_layer(controller):
    law = controller.law(RIG)
    exact = integrator.run(TIME, INPUTS, start(law), law, PLANT, GRID, 2.5e-6)
    found = single_run.run(TIME, INPUTS, start(law), law, PLANT, GRID, 100e-6)
    # A hundredth to a fiftieth of a micrometre on other courses; asked for is 0.1.
    assert np.max(np.abs(found - exact)[:, X]) < 0.1e-6


@pytest.mark.parametrize("controller", [SlidingMode(boundary_layer=0.0), RELAY_CARD])
def test_relay_events_are_located(controller):
    law = controller.law(RIG)
    exact = integrator.run(TIME, INPUTS, start(law), law, PLANT, GRID, 1e-6)
    found = single_run.run(TIME, INPUTS, start(law), law, PLANT, GRID, 25e-6)
    switched = np.count_nonzero(np.diff(np.sign(exact[:, OUTPUTS.index("valve_voltage")])))
    assert switched > 10
    # Not located, a relay run in such steps is off by some 100 um.
    assert np.max(np.abs(found - exact)[:, X]) < 0.1e-6


def test_stops_and_rests_are_the_same_as_by_the_other_method():
    time = np.arange(0.0, 0.8, 1e-3)
    voltage = np.select([time < 0.15, time < 0.5], [5.0, -5.0], 0.0)
    inputs = np.column_stack((voltage, np.zeros_like(voltage)))
    law, state = SlidingMode().law(RIG), start(SlidingMode().law(RIG))
    law = law._replace(source=0, gain=1.0, level=math.inf)
    exact, found = (
        kernel(time, inputs, state, law, PLANT, GRID, 20e-6)
        for kernel in (integrator.run, single_run.run)
    )
    assert (exact[:, X].min(), exact[:, X].max()) == (0.0, 0.03)
    assert np.abs(exact[:, OUTPUTS.index("spool")]).max() == 1.0
    # Both locate events to far below 1e-9 s; velocities reach 1 m/s.
    assert np.max(np.abs(found - exact)[:, X]) < 1e-9
    np.testing.assert_array_equal(found[:, X] == 0.0, exact[:, X] == 0.0)


def test_a_step_longer_than_the_card_allows_is_shortened():
    law = CARD.law(RIG)
    limit = step_limit(PLANT, law)
    assert limit == pytest.approx(LONGEST_STEP * 56e-6, rel=1e-2)
    runs = [
        simulate(time=TIME, controller=CARD, demand=DEMAND, largest_step=step)["displacement"]
        for step in (1.0, limit)
    ]
    np.testing.assert_array_equal(*runs)
