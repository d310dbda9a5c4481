"""The servo followed from what was measured: no effect, no structure."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.models.servo.motion import smooth_motion
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.noise import effective_samples
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
        case.channel: (case.measured - model.predict(case, values))[case.usable]
        for case in cases
        if case.recorded
    }


def without(recording, missing):
    channels = {n: v for n, v in recording.channels.items() if n not in missing}
    return replace(recording, channels=channels)


def test_the_velocity_is_recovered_far_better_than_by_differences(rig):
    demand = np.where(TIME % 2.0 < 1.0, 0.01, 0.02)
    run = simulate(rig, time=TIME, controller=Proportional(), demand=demand)
    rng = np.random.default_rng(2)
    noisy = run["displacement"] + rng.normal(0.0, 1e-5, len(TIME))
    mass, ambient = rig["load.mass"], rig["ambient.pressure"]
    force = rig["piston.area_a"] * (run["pressure_a"] - ambient)
    force = force - rig["piston.area_b"] * (run["pressure_b"] - ambient)
    driving = force / mass + rig["load.gravity"] + rng.normal(0.0, 0.17, len(TIME))
    friction = rig["piston.coulomb_friction"] / mass
    *motion, velocity_rms, at_rest = smooth_motion(TIME, noisy, 1e-5, driving, 0.17, friction)
    error, stated = motion[1] - run["velocity"], float(np.median(velocity_rms[~at_rest]))
    # Differences of this noise are wrong by 14 mm/s.
    assert np.std(error) < 1e-3
    # Friction that turns round is no random walk: the stated uncertainty is a little large.
    moving = np.abs(run["velocity"]) > 1e-3
    assert 300 < np.count_nonzero(moving) < 3000
    assert 0.5 * stated < np.std(error[moving]) < 2.0 * stated
    # A piston that sticks is not moved by the noise of the pressures.
    rest = (TIME % 1.0 > 0.6) & (TIME % 1.0 < 0.9)
    assert not np.any(moving & rest)
    assert np.std(error[rest]) < 0.3 * stated
    assert not at_rest[np.abs(run["velocity"]) > 0.02].any()


@pytest.mark.parametrize("controller", [SlidingMode(), Proportional()], ids=lambda c: c.kind)
@pytest.mark.parametrize(
    "missing", [(), ("pressure_a",), ("pressure_b",), ("pressure_a", "pressure_b")], ids=str
)
def test_without_effects_the_innovations_are_white_and_of_the_size_of_the_noise(
    rig, controller, missing
):
    left = innovations(without(recorded(rig, controller, 3), missing), rig, {})
    assert set(left) == {"displacement", "pressure_a", "pressure_b"} - set(missing)
    for channel, samples in left.items():
        # Samples at which little is expected count for less than noise. Where friction turns
        # round between two samples the displacement tells a little more.
        assert 0.85 < np.std(samples) < (1.25 if channel == "displacement" else 1.1), channel
        if not missing and channel != "displacement":
            assert effective_samples(samples) > 0.5 * len(samples), channel


def test_pressures_that_were_not_measured_are_estimated(rig):
    recording = recorded(rig, Proportional(), 3)
    truth = np.array([recording["pressure_a"], recording["pressure_b"]])
    for missing in (("pressure_b",), ("pressure_a", "pressure_b")):
        cases = ServoModel().cases(without(recording, missing), rig)
        estimated = cases[0].inputs["feed"].pressures
        # A motion that is known to 1 mm/s tells a force to 2 %, after the start.
        error = (estimated - truth)[:, 500:]
        assert np.sqrt(np.mean(error**2)) < 0.1e5, missing


@pytest.mark.parametrize(
    ("parameter", "factor", "channel"),
    [
        ("load.mass", 1.2, "displacement"),
        ("piston.viscous_friction", 1.3, "displacement"),
        ("valve.flow.area_s_a", 1.1, "pressure_a"),
        ("chamber.b.dead_volume", 1.5, "pressure_b"),
    ],
)
def test_a_wrong_parameter_shows_in_its_own_block_first(rig, parameter, factor, channel):
    recording = recorded(rig, Proportional(), 4)
    right = innovations(recording, rig, {})
    wrong = innovations(recording, rig, {parameter: rig[parameter] * factor})
    growth = {name: np.std(wrong[name]) / np.std(right[name]) for name in right}
    assert growth[channel] > 1.05
    # A wrong flow moves the piston too: which chamber it is shows in the pressures.
    rivals = set(growth) if channel == "displacement" else {"pressure_a", "pressure_b"}
    assert all(growth[name] < growth[channel] for name in rivals - {channel})


def test_an_effect_shows_in_its_own_block_first(rig):
    recording = recorded(rig, Proportional(), 5)
    right = innovations(recording, rig, {})
    spring = innovations(recording, rig, {"load.spring:stiffness": 200.0})
    leak = innovations(recording, rig, {"leakage.chamber-a:area": 3e-9})
    change = {
        name: [float(np.std(changed[name] - right[name])) for changed in (spring, leak)]
        for name in right
    }
    assert change["displacement"][0] > change["pressure_a"][0]
    assert change["pressure_a"][1] > change["displacement"][1]
