"""A force that was measured at the rod is part of what is known, as well as it was measured."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feed import FOLLOWED
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 3.0, 1e-3)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.fixture(scope="module")
def pushed(rig):
    """Return the noise-free run of a servo that is pushed, and the force."""
    force = np.where((TIME > 1.0) & (TIME < 2.2), 15.0, 0.0) + 5.0 * np.sin(4.4 * TIME)
    demand = 0.015 + 0.006 * np.sign(np.sin(np.pi * TIME))
    run = simulate(rig, time=TIME, controller=Proportional(), demand=demand, external_force=force)
    return run, force


def left(recording, rig) -> np.ndarray:
    """Return the root mean square of what each channel leaves, in its noise."""
    fed = with_observer(feed(recording, rig), rig)
    innovations = run_observer(fed, {}, rig)[: len(FOLLOWED)] / fed.noise_of(FOLLOWED)[:, None]
    return np.sqrt(np.mean(innovations**2, axis=1))


@pytest.mark.parametrize("force_rms", [0.0, 0.5, 3.0])
def test_a_measured_force_is_no_misfit_however_noisy(rig, pushed, force_rms):
    run, force = pushed
    rng = np.random.default_rng(1)
    recording = noisy(run, rng)
    measured = {"force": force + rng.normal(0.0, force_rms, len(TIME))}
    stated = {"force": force_rms} if force_rms else {}
    recording = replace(
        recording, channels={**recording.channels, **measured}, noise_rms=NOISE | stated
    )
    assert (left(recording, rig) < 1.1).all()


def test_one_that_was_not_measured_is_a_misfit(rig, pushed):
    recording = replace(noisy(pushed[0], np.random.default_rng(1)), noise_rms=NOISE)
    assert left(recording, rig).max() > 1.3
