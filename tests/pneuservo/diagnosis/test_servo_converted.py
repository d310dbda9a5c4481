"""Steps of a converter are noise, whatever is stated of the transducers before it."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis import diagnose
from pneuservo.diagnosis.models.servo.converted import with_noise_of_steps
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.recordings.converter import converter_step, noise_of_steps
from pneuservo.rigs import load_rig

STEPS = {"displacement": 7.3e-6, "pressure_a": 500.0, "pressure_b": 500.0}
STATED = {"displacement": 1e-6, "pressure_a": 100.0, "pressure_b": 100.0}


def converted(recording, noise_rms, times=1.0):
    """Return a recording read in steps, and what is stated of its noise."""
    channels = dict(recording.channels)
    for name, step in STEPS.items():
        channels[name] = np.round(channels[name] / (times * step)) * (times * step)
    return replace(recording, channels=channels, noise_rms=noise_rms)


@pytest.fixture(scope="module")
def run():
    return recorded(load_rig("single-axis"), Proportional(), 1, noise=STATED)


def test_steps_are_found_through_samples_that_were_interpolated(run):
    place = converted(run, {})["displacement"].copy()
    place[[100, 2000, 3001]] += np.array([1.1e-6, 2.3e-6, 0.7e-6])
    assert converter_step(place) == pytest.approx(STEPS["displacement"])
    assert converter_step(run["displacement"]) == 0.0


def test_stated_noise_is_no_less_than_that_of_the_steps(run):
    found = with_noise_of_steps(converted(run, STATED))
    for name, step in STEPS.items():
        most = np.hypot(STATED[name], noise_of_steps(step))
        assert 0.999 * noise_of_steps(step) <= found.noise_rms[name] <= 1.001 * most
    assert sum("read in steps of" in text for text in found.warnings) == len(STEPS)


def test_noise_that_is_stated_with_the_steps_in_it_stays(run):
    whole = {name: 1.1 * noise_of_steps(step) for name, step in STEPS.items()}
    coarse = converted(run, {name: 3.0 * size for name, size in whole.items()})
    assert with_noise_of_steps(coarse) is coarse
    assert with_noise_of_steps(run) is run


def test_noise_of_which_nothing_is_stated_is_no_less_than_that_of_the_steps(run):
    # A piston that rests within one step shows no noise at all.
    found = feed(converted(run, {}, times=4.0), load_rig("single-axis")).noise
    for name, step in STEPS.items():
        assert found[name] >= 0.999 * noise_of_steps(4.0 * step)


@pytest.mark.parametrize("stated", [STATED, {}], ids=["of the transducers", "nothing"])
@pytest.mark.parametrize("seed", [3, 4])
def test_steps_alone_are_no_physics(stated, seed):
    rig = load_rig("single-axis")
    used = [
        converted(recorded(rig, controller, seed + number, noise=STATED), stated, times=2.0)
        for number, controller in enumerate((Proportional(), SlidingMode()))
    ]
    assert diagnose(used).verdict == "consistent"
