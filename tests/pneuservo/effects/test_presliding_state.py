"""The build-up of friction after a reversal against exact solutions."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pneuservo.plant.presliding import presliding_state

TRAVEL = 1e-4
# Steps are solved exactly: what is left is rounding, a few times per step over 100 steps.
ROUNDING = 1e-12


def test_exponent_one_is_an_exponential():
    distance = np.linspace(0.0, 5.0 * TRAVEL, 101)
    state = presliding_state(distance, TRAVEL, 1.0, 0.0)
    assert state == pytest.approx(1.0 - np.exp(-distance / TRAVEL), abs=ROUNDING)


def test_exponent_two_is_a_hyperbola():
    distance = np.linspace(0.0, 5.0 * TRAVEL, 101)
    state = presliding_state(-distance, TRAVEL, 2.0, 1.0)
    # From 1 downwards: what is missing to -1 begins at 2.
    assert state == pytest.approx(-1.0 + 1.0 / (0.5 + distance / TRAVEL), abs=ROUNDING)


def test_other_exponents_solve_the_differential_equation():
    exponent, start = 3.3, -0.4
    distance = np.linspace(0.0, 3.0 * TRAVEL, 40)
    truth = solve_ivp(
        lambda _, z: (1.0 - z) ** exponent / TRAVEL,
        (0.0, distance[-1]),
        [start],
        t_eval=distance,
        method="DOP853",
        rtol=1e-10,
        atol=1e-12,
    )
    # The tolerance of the solver, carried over about 30 steps.
    assert presliding_state(distance, TRAVEL, exponent, start) == pytest.approx(
        truth.y[0], abs=1e-8
    )


def test_an_exponent_next_to_one_joins_the_exponential():
    distance = np.linspace(0.0, 3.0 * TRAVEL, 50)
    one = presliding_state(distance, TRAVEL, 1.0, -1.0)
    near = presliding_state(distance, TRAVEL, 1.0 + 1e-6, -1.0)
    # The rate r^n changes with n by r^n ln r, at most 2 ln 2 for r up to 2, over 3 travels.
    assert 0.0 < np.max(np.abs(near - one)) < 3.0 * 2.0 * np.log(2.0) * 1e-6


def test_without_travel_it_is_the_sign_of_the_motion():
    displacement = np.array([0.0, 1e-3, 2e-3, 2e-3, 1e-3, 1e-3, 3e-3])
    state = presliding_state(displacement, 0.0, 2.0, 0.25)
    assert state.tolist() == [0.25, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0]


@pytest.mark.parametrize("exponent", [1.0, 1.7, 4.0])
def test_splitting_the_steps_changes_nothing(exponent):
    rng = np.random.default_rng(0)
    nodes = np.cumsum(rng.normal(0.0, TRAVEL, 60))
    index = np.arange(len(nodes))
    parts = 7
    fine = np.interp(np.linspace(0, index[-1], index[-1] * parts + 1), index, nodes)
    coarse_state = presliding_state(nodes, TRAVEL, exponent, 0.1)
    fine_state = presliding_state(fine, TRAVEL, exponent, 0.1)[::parts]
    # Rounding of the seven steps; a reversal forgets what was before it.
    assert fine_state == pytest.approx(coarse_state, abs=1e-11)


@pytest.mark.parametrize("exponent", [1.0, 2.5, 5.0])
def test_it_stays_between_full_friction_either_way_and_keeps_still_at_rest(exponent):
    rng = np.random.default_rng(1)
    displacement = np.repeat(np.cumsum(rng.normal(0.0, 3.0 * TRAVEL, 200)), 2)
    state = presliding_state(displacement, TRAVEL, exponent, 0.0)
    assert np.all(np.abs(state) <= 1.0)
    assert np.array_equal(state[1::2], state[::2])
    # It does swing: steps of three travels cover most of the way, less so with a long tail.
    assert np.max(state) > 0.4
    assert np.min(state) < -0.4
