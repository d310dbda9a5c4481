"""The chambers' steps: coarse where that changes nothing, fine where something asks for it."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, recorded

from pneuservo.controllers import DigitalSlidingMode, Proportional
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feed import feed, with_held_command
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.diagnosis.models.servo.steps import dividing, steps_along, steps_beside
from pneuservo.effects import effect_by_id
from pneuservo.rigs import load_rig

EXACT = 25e-6
SIZES = np.array([NOISE[name] for name in ("pressure_a", "pressure_b", "displacement")])


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.fixture(
    scope="module",
    params=[(Proportional(), 1.5), (DigitalSlidingMode(), 4.0)],
    ids=["calm", "relay"],
)
def fed(request, rig):
    controller, most = request.param
    found = with_observer(with_held_command(feed(recorded(rig, controller, 3), rig), rig), rig)
    assert found.steps.mean() <= most
    return found


@pytest.mark.parametrize(
    "values", [{}, {"chamber.heat-transfer:conductance": 0.4}, {"spool.delay:time": 5e-3}], ids=str
)
def test_innovations_are_those_of_much_finer_steps(fed, rig, values):
    found = run_observer(fed, values, rig)[:3]
    exact = run_observer(replace(fed, steps=dividing(fed.time, EXACT)), values, rig)[:3]
    apart = np.sum(((found - exact) / SIZES[:, None]) ** 2, axis=1)
    # Together far less than what decides on anything.
    assert np.all(apart < 3.0)


def test_steps_are_fine_where_pressures_decay_fast():
    time = np.arange(5) * 1e-3
    decays = np.array([0.1, 0.5, 0.9, 5.0, 0.0])
    assert steps_along(time, np.zeros(5), 5.0, decays).tolist() == [1, 2, 3, 4, 1]


def test_a_recording_that_is_slow_is_carried_on_finely_after_a_jump():
    time = np.arange(5) * 1e-2
    voltage = np.where(time < 1.5e-2, 0.0, 5.0)
    assert steps_along(time, voltage, 5.0, np.zeros(5)).tolist() == [10, 40, 40, 10, 10]


@pytest.mark.parametrize(
    ("effect", "each"),
    [
        ("chamber.heat-transfer", 1),
        ("spool.hysteresis", 1),
        ("line.delay", 4),
        ("load.compliance", 10),
    ],
)
def test_what_is_stiff_or_remembers_is_carried_on_in_finer_steps(effect, each):
    entry = effect_by_id(effect, "single-axis")
    fields = {parameter.field for parameter in entry.parameters}
    time = np.arange(5) * 1e-3
    assert steps_beside(np.ones(5, np.int64), time, fields).tolist() == [each] * 5


def test_steps_do_not_depend_on_how_large_an_effect_is(fed, rig):
    # A fit that comes to none of it would else meet a jump, and take that for a slope.
    none, little = (
        run_observer(fed, {"spool.flow-force:shift": shift}, rig)[:3] / SIZES[:, None]
        for shift in (0.0, 1e-9)
    )
    assert np.max(np.abs(none - little)) < 1e-3
