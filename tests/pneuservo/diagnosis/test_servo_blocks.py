"""The blocks of the servo, followed from what was measured round them: no effect, no structure."""

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.models.servo.motion import smooth_motion
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.noise import effective_samples
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 4.0, 1e-3)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def innovations(recording, rig, values):
    model = ServoModel()
    cases = model.cases(recording, rig)
    return {
        case.channel: (case.measured - model.predict(case, values))[case.usable] for case in cases
    }


def test_the_velocity_is_recovered_far_better_than_by_differences(rig):
    run = simulate(rig, time=TIME, controller=Proportional(), demand=0.02)
    rng = np.random.default_rng(2)
    noisy = run["displacement"] + rng.normal(0.0, 1e-5, len(TIME))
    force = 490.87e-6 * run["pressure_a"] - 412.33e-6 * run["pressure_b"]
    driving = force / 1.825 + rng.normal(0.0, 0.17, len(TIME))
    *motion, stated = smooth_motion(TIME, noisy, 1e-5, driving, 0.17)
    error = float(np.std(motion[1] - run["velocity"]))
    # Differences of this noise are wrong by 14 mm/s.
    assert error < 1e-3
    # Friction that turns round is no random walk: the stated uncertainty is a little large.
    assert 0.5 * stated < error < 2.0 * stated


@pytest.mark.parametrize("controller", [SlidingMode(), Proportional()], ids=lambda c: c.kind)
def test_without_effects_the_innovations_are_white_and_of_the_size_of_the_noise(rig, controller):
    left = innovations(recorded(rig, controller, 3), rig, {})
    for channel in ("pressure_a", "pressure_b"):
        # Intervals in which the command jumps count for less than noise, none for more.
        assert 0.9 < np.std(left[channel]) < 1.1, channel
        assert effective_samples(left[channel]) > 0.5 * len(left[channel]), channel
    # Friction turns round somewhere between two samples: a tenth more than noise.
    assert 0.9 < np.std(left["displacement"]) < 1.25


@pytest.mark.parametrize(
    ("parameter", "factor", "channel"),
    [
        ("load.mass", 1.2, "displacement"),
        ("piston.viscous_friction", 1.3, "displacement"),
        ("valve.flow.area_s_a", 1.1, "pressure_a"),
        ("chamber.b.dead_volume", 1.5, "pressure_b"),
    ],
)
def test_a_wrong_parameter_shows_in_its_own_block_alone(rig, parameter, factor, channel):
    recording = recorded(rig, Proportional(), 4)
    right = innovations(recording, rig, {})
    wrong = innovations(recording, rig, {parameter: rig[parameter] * factor})
    growth = {name: np.std(wrong[name]) / np.std(right[name]) for name in right}
    assert growth[channel] > 1.05
    assert all(growth[name] < 1.01 for name in growth if name != channel)


def test_an_effect_changes_the_channels_of_its_block_alone(rig):
    recording = recorded(rig, Proportional(), 5)
    right = innovations(recording, rig, {})
    spring = innovations(recording, rig, {"load.spring:stiffness": 200.0})
    np.testing.assert_array_equal(spring["pressure_a"], right["pressure_a"])
    assert np.std(spring["displacement"]) > 1.5 * np.std(right["displacement"])
    leak = innovations(recording, rig, {"leakage.chamber-a:area": 3e-9})
    np.testing.assert_array_equal(leak["displacement"], right["displacement"])
    assert np.std(leak["pressure_a"]) > 1.5 * np.std(right["pressure_a"])
