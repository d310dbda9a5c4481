"""Kept sensitivities: a fit that strays far from where it began still ends at its optimum."""

from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.fit import explained
from pneuservo.diagnosis.fitting import fit, polished
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.diagnosis.steady import SteadySensitivity
from pneuservo.rigs import load_rig

SLOWER = 0.2
WRONG = "valve.spool.frequency"


def test_a_parameter_far_from_nominal_is_fitted_to_the_end():
    rig = load_rig("single-axis")
    slow = rig.with_values({WRONG: SLOWER * rig[WRONG]})
    model = model_of(rig.kind)
    cases = model.cases(recorded(slow, Proportional(), 11, duration=3.0), rig)
    found = fit(model, cases, Hypothesis())
    # With sensitivities of its own it finds no more than the size of noise.
    assert explained(found, polished(model, cases, found)) < 5.0
    assert found.shared[WRONG] < 0.3 * rig[WRONG]


class Parabola(SimpleNamespace):
    """A problem of one effect's parameter, whose sensitivity is twice its value."""

    def cost_vector(self, vector):
        self.asked += 1
        return vector**2


@pytest.mark.parametrize(
    ("begun", "moved", "anew"), [(1.0, 0.01, False), (1.0, 0.03, True), (0.05, 0.002, True)]
)
def test_sensitivities_to_an_effect_are_kept_while_its_parameters_hardly_move(begun, moved, anew):
    ones, none = np.ones(1), np.zeros(0, dtype=int)
    problem = Parabola(
        cases=[SimpleNamespace(usable=np.ones(1, dtype=bool))],
        unknowns=[None],
        keys=["effect:size"],
        tolerated=none,
        start=ones,
        bounds=(-10.0 * ones, 10.0 * ones),
        row_scale=lambda: ones,
        asked=0,
    )
    nothing = SimpleNamespace(keys=[], row_scale=lambda: ones)
    slope = SteadySensitivity(problem, nothing)
    assert slope(begun * ones) == pytest.approx(2.0 * begun, rel=1e-2)
    asked = problem.asked
    after = slope((begun + moved) * ones)
    assert (problem.asked > asked) is anew
    assert after == pytest.approx(2.0 * (begun + (moved if anew else 0.0)), rel=1e-2)
