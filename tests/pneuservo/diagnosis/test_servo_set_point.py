"""What a set point changes of the command of its loop at once."""

import numpy as np
import pytest
from servo_recordings import noisy

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.models.servo.command import running_command
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.set_point import at_once, gain_of_set_point, jumping
from pneuservo.diagnosis.readings import ranked_readings
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

FINE, EVERY = 1e-4, 10
TIME = np.arange(0.0, 6.0, FINE)
FULL = 5.0
SWING = 0.015 + 0.007 * np.sin(6.0 * TIME) + 0.001 * np.sin(19.0 * TIME)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def sampled(rig, controller, demand):
    """Return every tenth sample of an analogue loop as it is recorded, and the loop itself."""
    run = simulate(rig, time=TIME, controller=controller, demand=demand)
    every = noisy(run, np.random.default_rng(3)).channels | {"demand": demand}
    coarse = {name: samples[::EVERY] for name, samples in every.items()}
    return Recording("run", TIME[::EVERY], coarse), run


def test_a_set_point_that_moves_all_the_time_or_by_the_steps_of_a_converter_jumps_nowhere():
    swings = 0.015 + 0.005 * np.sin(20.0 * TIME[::EVERY])
    slow = 0.015 + 0.005 * np.sin(2.0 * TIME[::EVERY])
    assert not jumping(swings).any()
    assert not jumping(np.round(slow / 7.3e-6) * 7.3e-6).any()


@pytest.mark.parametrize("controller", [Proportional(), SlidingMode()])
def test_a_linear_loop_tells_its_gain(rig, controller):
    recording, _ = sampled(rig, controller, SWING)
    channels = (recording[name] for name in ("valve_voltage", "demand", "displacement"))
    law = controller.law(rig)
    slope = law.gain * law.weight_displacement
    assert gain_of_set_point(recording.time, *channels) == pytest.approx(slope, rel=0.05)


def test_a_relay_and_a_command_of_nobody_knows_what_tell_none(rig):
    relay, _ = sampled(rig, SlidingMode(boundary_layer=0.0), SWING)
    channels = [relay[name] for name in ("valve_voltage", "demand", "displacement")]
    assert gain_of_set_point(relay.time, *channels) == 0.0
    channels[0] = np.random.default_rng(1).normal(size=len(relay.time))
    assert gain_of_set_point(relay.time, *channels) == 0.0


def test_what_a_jump_adds_is_known_but_for_a_command_at_its_limit(rig):
    demand = np.where(TIME % 1.0 < 0.5, 0.010, 0.018)
    recording, run = sampled(rig, Proportional(), demand)
    fed = feed(recording, rig)
    jumps = jumping(recording["demand"])
    told = at_once(fed.voltage, fed.set_point, fed.gain_of_set_point)
    assert not told.unknown.any()
    # Until just before a jump the loop goes on as it did.
    command = running_command(fed.time, fed.voltage, FULL, told)
    before = run["valve_voltage"][EVERY - 1 :: EVERY][: len(jumps)][jumps]
    assert command[:-1][jumps][:, -1] == pytest.approx(before, abs=0.02)
    limited = np.clip(3.0 * fed.voltage, -3.0, 3.0)
    assert at_once(limited, fed.set_point, fed.gain_of_set_point).unknown.any()


@pytest.mark.parametrize("controller", [Proportional(), SlidingMode()])
def test_an_analogue_loop_that_is_told_steps_is_read_as_such(rig, controller):
    recording, _ = sampled(rig, controller, np.repeat(SWING[::EVERY], EVERY))
    model = ServoModel()
    ways = model.readings(model.cases(recording, rig))
    best = ranked_readings(model, ways, lambda step: None)[0]
    assert best.cases[0].inputs["feed"].in_steps
    assert best.baseline.rms_of("displacement") == pytest.approx(1.0, abs=0.05)


def test_one_whose_set_point_runs_on_is_not(rig):
    recording, _ = sampled(rig, Proportional(), SWING)
    model = ServoModel()
    ways = model.readings(model.cases(recording, rig))
    best = ranked_readings(model, ways, lambda step: None)[0]
    assert best.cases[0].inputs["feed"].ramped
    assert not best.cases[0].inputs["feed"].in_steps
