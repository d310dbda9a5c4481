"""What the method's own models make of a recording's path pretends no more than noise does."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy, recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.wander import beyond_wander
from pneuservo.diagnosis.noise import wander
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def held(rig):
    """Return a recording of fast motions whose command is held from sample to sample."""
    time = np.arange(0.0, 4.0, 1e-3)
    run = simulate(rig, time=time, command=np.where(time % 0.08 < 0.04, 2.0, -2.0))
    # What is estimated of such fast pressures is a quarter too much, and the copies have it.
    return replace(noisy(run, np.random.default_rng(3)), noise_rms=NOISE)


def running_on(rig):
    return recorded(rig, SlidingMode(), 5)


def settling(rig):
    return recorded(rig, Proportional(), 5)


@pytest.mark.parametrize("make", [held, running_on, settling], ids=lambda make: make.__name__)
def test_an_imitation_leaves_what_the_recording_of_a_perfect_model_does(make, rig):
    model = ServoModel()
    running, holding = model.readings(model.cases(make(rig), rig))
    cases = holding if make is held else running
    copies = model.imitate(cases, [{} for _ in cases], np.random.default_rng(1))
    for case, copy in zip(cases, copies, strict=True):
        left, there = (
            np.sqrt(np.mean((c.measured - model.predict(c, {}))[c.usable] ** 2))
            for c in (copy, case)
        )
        if case.recorded:
            # Its zeros wander, those of the recording do not.
            assert 0.8 * there < left < 1.2 * there, copy.channel
        else:
            assert max(left, there) < 1.0


def test_a_wandering_zero_of_the_supply_leaves_white_noise():
    time = np.arange(0.0, 20.0, 1e-3)
    rng = np.random.default_rng(2)
    reading = 300.0 * (rng.standard_normal(len(time)) + wander(time, rng))
    reading[4000:4100] = np.nan
    seen = beyond_wander(time, reading)
    assert np.all(seen[4000:4100] == 0.0)
    assert np.std(seen) == pytest.approx(300.0, rel=0.03)
    slow = seen.reshape(-1, 500).mean(axis=1)
    # Means of half a second of white noise; those of the reading itself spread five times as much.
    assert np.std(slow) < 2.0 * 300.0 / np.sqrt(500.0)
