"""The chambers' steps: coarse where that changes nothing, fine where something asks for it."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, recorded

from pneuservo.controllers import DigitalSlidingMode, Proportional, SlidingMode
from pneuservo.diagnosis.models.servo.between_samples import with_held_command
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.steps import dividing, steps_along, steps_beside
from pneuservo.effects import effect_by_id
from pneuservo.plant.servo.transducers import first_order_lag
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

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
    "values",
    [
        {},
        {"chamber.heat-transfer:conductance": 0.4},
        {"spool.delay:time": 5e-3},
        {"spool.flow-force:shift": 0.02},
        {"friction.lag:time": 2e-4},
        {"sensor.position-lag:time": 1e-4},
        {"load.base-motion:share": 0.3, "load.base-motion:frequency": 40.0},
        {"line.resonance:frequency": 300.0},
        {"supply.sag:volume": 2e-4},
        {"load.compliance:share": 0.5, "load.compliance:stiffness": 3e6},
    ],
    ids=str,
)
def test_innovations_are_those_of_much_finer_steps(fed, rig, values):
    found = run_observer(fed, values, rig)[:3]
    exact = run_observer(replace(fed, steps=dividing(fed.time, EXACT)), values, rig)[:3]
    apart = np.sum(((found - exact) / SIZES[:, None]) ** 2, axis=1)
    # Together far less than what decides on anything.
    assert np.all(apart < 3.0)


@pytest.mark.parametrize("values", [{}, {"valve.overlap:lap": 0.01}], ids=str)
def test_a_command_that_runs_on_is_followed_in_long_steps(rig, values):
    running = with_observer(feed(recorded(rig, SlidingMode(), 3), rig), rig)
    assert running.steps.mean() < 1.1
    found = run_observer(running, values, rig)[:3]
    exact = run_observer(replace(running, steps=dividing(running.time, EXACT)), values, rig)[:3]
    assert np.all(np.sum(((found - exact) / SIZES[:, None]) ** 2, axis=1) < 1.0)


def test_steps_are_fine_where_pressures_decay_fast():
    time = np.arange(5) * 1e-3
    decays = np.array([0.1, 0.5, 0.9, 5.0, 0.0])
    assert steps_along(time, np.zeros((5, 2)), 5.0, decays).tolist() == [1, 2, 3, 4, 1]


def test_a_recording_that_is_slow_is_carried_on_finely_after_a_jump():
    time = np.arange(5) * 1e-2
    voltage = np.where(time < 1.5e-2, 0.0, 5.0)[:, np.newaxis] * np.ones(2)
    assert steps_along(time, voltage, 5.0, np.zeros(5)).tolist() == [10, 40, 40, 10, 10]


@pytest.mark.parametrize(
    ("effect", "each"),
    [
        ("chamber.heat-transfer", 1),
        ("spool.hysteresis", 1),
        ("friction.lag", 1),
        ("load.base-motion", 2),
        ("line.delay", 4),
        ("line.resonance", 10),
        ("load.compliance", 10),
    ],
)
def test_what_is_stiff_or_remembers_is_carried_on_in_finer_steps(effect, each):
    entry = effect_by_id(effect, "single-axis")
    fields = {parameter.field for parameter in entry.parameters}
    time = np.arange(5) * 1e-3
    assert steps_beside(np.ones(5, np.int64), time, fields).tolist() == [each] * 5
    # Never in coarser ones than the recording asks for.
    assert steps_beside(np.full(5, 20), time, fields).tolist() == [20] * 5


def test_steps_do_not_depend_on_how_large_an_effect_is(fed, rig):
    # A fit that comes to none of it would else meet a jump, and take that for a slope.
    none, little = (
        run_observer(fed, {"spool.flow-force:shift": shift}, rig)[:3] / SIZES[:, None]
        for shift in (0.0, 1e-9)
    )
    assert np.max(np.abs(none - little)) < 1e-3


@pytest.mark.parametrize("lag", [1e-4, 2e-3])
def test_transducers_that_lag_are_followed_through_every_jump_of_the_command(rig, lag):
    # Undone by smoothed rates, a lag of 0.1 ms was left at up to three times the noise of a relay.
    each, interval = 20, 1e-3
    fine = np.arange(0.0, 3.0, interval / each)
    time = fine[::each]
    command = 4.0 * np.sign(np.sin(2.0 * np.pi * 6.0 * time + 0.01))
    run = simulate(rig, time=fine, command=np.repeat(command, each))
    late = {
        name: first_order_lag(fine, run[name], lag)[::each] for name in ("pressure_a", "pressure_b")
    }
    channels = {"displacement": run["displacement"][::each], "valve_voltage": command, **late}
    model = ServoModel()
    held = model.readings(model.cases(Recording("run", time, channels, noise_rms=NOISE), rig))[1]
    for case in held:
        if case.recorded:
            judged = case.usable & ~case.inputs["feed"].touching & (time > 0.2)
            found = case.measured - model.predict(case, {"sensor.pressure-lag:time": lag})
            assert np.sqrt(np.mean(found[judged] ** 2)) < 0.2, case.channel


@pytest.mark.parametrize(("rate", "left"), [(2000.0, 0.05), (1000.0, 0.1), (500.0, 0.25)])
def test_a_clean_recording_leaves_next_to_nothing_however_coarsely_it_is_sampled(rate, left):
    # With the piston carried on by straight lines it was 0.1, 0.4 and 1.8 of the noise, and read as
    # friction that lags, or a joint that gives way.
    rig, noise = load_rig("single-axis"), {"displacement": 1e-5, "pressure_a": 300.0}
    time = np.arange(0.0, 3.0, 1.0 / rate)
    command = 4.0 * np.sign(np.sin(2.0 * np.pi * 6.0 * time + 0.01))
    run = simulate(rig, time=time, command=command)
    channels = {name: run[name] for name in (*noise, "pressure_b", "valve_voltage")}
    stated = {**noise, "pressure_b": 300.0}
    model = ServoModel()
    held = model.readings(model.cases(Recording("run", time, channels, noise_rms=stated), rig))[1]
    for case in held:
        if case.recorded:
            judged = case.usable & ~case.inputs["feed"].touching & (time > 0.2)
            found = (case.measured - model.predict(case, {}))[judged]
            assert np.sqrt(np.mean(found**2)) < left, case.channel
