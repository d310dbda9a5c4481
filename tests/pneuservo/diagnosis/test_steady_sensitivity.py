"""Kept sensitivities: a fit that strays far from where it began still ends at its optimum."""

from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.fit import explained
from pneuservo.diagnosis.fitting import fit, polished
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
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
