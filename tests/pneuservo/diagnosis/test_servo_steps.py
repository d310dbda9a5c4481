"""The chambers' steps: coarse where that changes nothing, fine where something asks for it."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, recorded

from pneuservo.controllers import DigitalSlidingMode, Proportional
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feed import feed, held_command
from pneuservo.diagnosis.models.servo.run_observer import numbers, run_observer
from pneuservo.diagnosis.models.servo.steps import dividing, steps_along, steps_beside
from pneuservo.rigs import load_rig

EXACT = 25e-6
SIZES = np.array([NOISE[name] for name in ("pressure_a", "pressure_b", "displacement")])


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.fixture(
    scope="module", params=[Proportional(), DigitalSlidingMode()], ids=["calm", "relay"]
)
def fed(request, rig):
    recording = recorded(rig, request.param, 3)
    return with_observer(held_command(feed(recording, rig), rig), rig)


@pytest.mark.parametrize(
    "values", [{}, {"chamber.heat-transfer:conductance": 0.4}, {"spool.delay:time": 2e-3}], ids=str
)
def test_innovations_are_those_of_much_finer_steps(fed, rig, values):
    assert fed.steps.mean() < 4.1
    found = run_observer(fed, values, rig)[:3]
    exact = run_observer(replace(fed, steps=dividing(fed.time, EXACT)), values, rig)[:3]
    apart = np.sum(((found - exact) / SIZES[:, None]) ** 2, axis=1)
    # Together far less than what decides on anything.
    assert np.all(apart < 3.0)


def test_steps_are_fine_where_pressures_decay_fast():
    time = np.arange(5) * 1e-3
    decays = np.array([0.1, 0.5, 0.9, 5.0, 0.0])
    assert steps_along(time, np.zeros(5), 5.0, decays).tolist() == [1, 2, 3, 4, 1]


@pytest.mark.parametrize(
    ("effect", "each"),
    [
        ("chamber.heat-transfer:conductance", 1),
        ("line.delay:time", 4),
        ("load.compliance:share", 10),
    ],
)
def test_what_is_stiff_or_remembers_is_carried_on_in_finer_steps(rig, effect, each):
    from pneuservo.effects import effect_by_id

    entry = effect_by_id(effect.partition(":")[0], "single-axis")
    values = {entry.key(p.name): p.starts[0] for p in entry.parameters}
    assert effect in values
    time = np.arange(5) * 1e-3
    _, effects = numbers(values, rig)
    assert steps_beside(np.ones(5, np.int64), time, effects).tolist() == [each] * 5
