"""Parameters of the servo that are strained for want of an effect do not hide it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.diagnosis import _speaks_against
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.screen import LEAST_PROMISE, promising
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.strained import is_strained, promises_from_nominal
from pneuservo.rigs import load_rig

WEAK_MOTOR = {"spool.amplitude-bandwidth": {"acceleration": 2e5}}


def begun(effects):
    """Return a search in two recordings of a rig with some effects, and what cannot be negative."""
    rig = replace(load_rig("single-axis"), effects=effects)
    used = [recorded(rig, Proportional(), 1), recorded(rig, SlidingMode(), 2)]
    model = ServoModel()
    cases = [case for one in used for case in model.cases(one, load_rig("single-axis"))]
    one_sided = [e.id for e in model.effects if e.parameters[0].low >= 0.0]
    return Search(model, cases), one_sided


def test_a_weak_motor_strains_the_spool_and_shows_from_its_nominal_frequency():
    search, one_sided = begun(WEAK_MOTOR)
    base = search.baseline
    assert is_strained(base)
    names = [effect.id for effect in search.model.effects]
    near = promising(base, search.pretence.signatures, names, (), one_sided)
    found = promises_from_nominal(search.model, search.cases, base, names, one_sided)
    assert max(found, key=found.__getitem__) == "spool.amplitude-bandwidth"
    assert max(near, key=near.__getitem__) != "spool.amplitude-bandwidth"
    assert min(found.values()) > LEAST_PROMISE


def test_without_effect_nothing_is_strained():
    search, _ = begun({})
    assert not is_strained(search.baseline)


@pytest.mark.parametrize(
    ("distances", "is_said"),
    # The force at a zero is no parameter of the rig.
    [((3.5, -4.0, 11.0, 0.0), True), ((3.5, -4.0, 2.5, 9.0), False)],
)
def test_what_strains_many_parameters_is_no_answer(distances, is_said):
    parameters = ("supply.pressure", "load.mass", "piston.stroke")
    fit = SimpleNamespace(
        tolerated=(*parameters, "zero_force"),
        shared=dict.fromkeys(parameters, 1.0),
        distance=np.array(distances),
    )
    search = SimpleNamespace(baseline=None, chosen=None, are_judged=lambda fit: True)
    held_back = SimpleNamespace(are_predicted_worse=lambda *fits, table: False)
    found = SimpleNamespace(fit=fit, table=None, instead=False)
    why = _speaks_against(search, held_back, found)
    assert ("strains many parameters" in why) == is_said
