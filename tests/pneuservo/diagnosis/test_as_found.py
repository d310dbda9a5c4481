"""What an observer hides that trusts its model too little is found by one that trusts it."""

import dataclasses

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.as_found import as_found
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.readings import ranked_readings
from pneuservo.diagnosis.search import Search
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

QUIET = lambda step: None  # noqa: E731


def interrupted(step):
    """Interrupt what says that it begins."""
    raise KeyboardInterrupt


def swinging(rig, seed):
    """Return a recording of a piston that swings to and fro, its displacement well measured."""
    time = np.arange(0.0, 4.0, 1e-3)
    demand = 0.015 + 0.006 * np.sin(4.0 * np.pi * time + seed)
    run = simulate(rig, time=time, controller=Proportional(), demand=demand)
    return noisy(run, np.random.default_rng(seed), {**NOISE, "displacement": 3e-6})


@pytest.mark.parametrize("force", [0.0, 0.34])
def test_a_side_load_that_is_hidden_is_found_and_nothing_where_there_is_none(force):
    rig, model = load_rig("single-axis"), ServoModel()
    loaded = dataclasses.replace(rig, effects={"friction.side-load": {"force": force}})
    cases = model.cases(swinging(loaded, 1), rig)
    cases = ranked_readings(model, model.readings(cases), QUIET)[0].cases
    begun = Search(model, cases, QUIET)
    begun.begin()
    assert not begun.accepted
    found = as_found(begun)
    if not force:
        assert found is begun
        # An interruption while more is asked for ends the search.
        begun.progress = interrupted
        assert as_found(begun).interrupted
        return
    assert found.accepted == ["friction.side-load"]
    assert found.chosen.shared["friction.side-load:force"] == pytest.approx(force, rel=0.2)
    assert all(case.inputs["feed"].unsteadiness < 0.1 for case in found.cases)
