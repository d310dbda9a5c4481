"""A parameter that was measured anew for a recording has an error of its own there."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import SlidingMode
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.problem import problems_of
from pneuservo.diagnosis.unknowns import values_in_each
from pneuservo.rigs import load_rig

ADDED = 5.0
STATED = 1.825


@pytest.fixture(scope="module")
def cases():
    """Two recordings: 4 % less mass than stated, then with 5 kg more, weighed exactly."""
    rig, model, found = load_rig("single-axis"), ServoModel(), []
    for seed, added in enumerate((0.0, ADDED)):
        true = rig.with_values({"load.mass": 0.96 * STATED + added})
        conditions = {"load_mass": STATED + added} if added else {}
        recording = replace(recorded(true, SlidingMode(), seed), conditions=conditions)
        found += model.cases(recording, rig.with_conditions(conditions))
    return found


def test_only_what_was_measured_anew_has_an_error_of_its_own(cases):
    problem = problems_of(ServoModel(), cases, Hypothesis())[0]
    own = [{unknown.key: unknown for unknown in mine} for mine in problem.own]
    errors = {place: key for place, mine in enumerate(own) for key in mine if "mass" in key}
    second = next(i for i, case in enumerate(cases) if case.recording is not cases[0].recording)
    assert list(errors) == [second]
    error = own[second][errors[second]]
    assert error.start == 0.0
    assert error.sigma == pytest.approx(0.03)


def test_what_is_added_is_weighed_better_than_what_it_is_added_to(cases):
    model = ServoModel()
    found = fit(model, cases, Hypothesis())
    first, *_, last = values_in_each(cases, cases[0], found.shared, found.own)
    assert first["load.mass"] == pytest.approx(0.96 * STATED, rel=0.01)
    # By the same factor it would be 0.2 kg less.
    assert last["load.mass"] == pytest.approx(0.96 * STATED + ADDED, rel=0.01)
    for case, left in zip(cases, found.residuals, strict=True):
        if case.channel == "displacement":
            assert np.sqrt(np.mean(left**2)) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("stated", [0.0, 0.8])
def test_a_zero_is_off_by_as_much_everywhere(stated):
    rig = load_rig("seal-tester").with_values({"sensor.force.offset": stated})
    zero = replace(rig.parameters["sensor.force.offset"], tolerance=1.0)
    rig = replace(rig, parameters={**rig.parameters, "sensor.force.offset": zero})
    there = rig.with_values({"sensor.force.offset": 3.0})
    first, second = SimpleNamespace(rig=rig), SimpleNamespace(rig=there)
    shared = {"sensor.force.offset": stated + 0.5}
    found = values_in_each([first, second], first, shared, [{}, {}])
    assert [each["sensor.force.offset"] for each in found] == pytest.approx([stated + 0.5, 3.5])
