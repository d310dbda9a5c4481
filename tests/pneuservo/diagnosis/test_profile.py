"""Profile likelihood: the ends of an interval against what can be worked out by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.diagnosis.profile import RISE, _Profile

HALF = np.sqrt(RISE)


def profile(cost_vector, vector, jacobian, low=-np.inf, high=np.inf):
    bounds = np.full(len(vector), low), np.full(len(vector), high)
    problem = SimpleNamespace(cost_vector=cost_vector, bounds=bounds)
    return _Profile(problem, np.array(vector), np.array(jacobian), RISE)


def test_of_a_linear_problem_it_is_the_interval_from_the_curvature():
    columns = np.array([[1.0, 0.8], [0.0, 0.6], [0.0, 0.5]])
    found = profile(lambda v: columns @ (v - [1.0, 2.0]), [1.0, 2.0], columns)
    sigma = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    for place, centre in enumerate([1.0, 2.0]):
        for sign in (-1.0, 1.0):
            expected = centre + sign * HALF * sigma[place]
            assert found.end(place, sign) == pytest.approx(expected, rel=1e-6)


def test_of_a_bent_problem_it_is_lopsided_as_it_should():
    # Only the square of the value shows, to within 1: its ends are roots.
    found = profile(lambda v: v**2 - 4.0, [2.0], [[4.0]])
    # An end is accepted when the cost has risen to within 5 % of what it should.
    assert found.end(0, 1.0) == pytest.approx(np.sqrt(4.0 + HALF), rel=0.01)
    assert found.end(0, -1.0) == pytest.approx(np.sqrt(4.0 - HALF), rel=0.01)


def test_an_end_beyond_a_limit_is_the_limit():
    found = profile(lambda v: 0.1 * (v - 1.0), [1.0], [[0.1]], low=0.0, high=5.0)
    assert found.end(0, -1.0) == 0.0
    assert found.end(0, 1.0) == 5.0


def test_of_what_nothing_shows_all_that_is_possible_is_left():
    found = profile(lambda v: v[:1] - 1.0, [1.0, 0.3], [[1.0, 0.0]], low=-5.0, high=5.0)
    assert (found.end(1, -1.0), found.end(1, 1.0)) == (-5.0, 5.0)
    assert found.end(0, 1.0) == pytest.approx(1.0 + HALF, rel=1e-6)
