"""Friction of a piston that turns round between two samples."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.turning import friction_direction, mean_direction
from pneuservo.plant.presliding import presliding_state
from pneuservo.plant.servo.friction_effects import FrictionEffects
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

REVERSAL = 1e-3
FINELY = 2000


def means(values):
    """Return the mean of every `FINELY` intervals, by the trapezoidal rule."""
    both = 0.5 * (values[1:] + values[:-1])
    return both.reshape(-1, FINELY).mean(axis=1)


@pytest.mark.parametrize("seed", range(5))
def test_the_mean_direction_is_that_of_a_velocity_that_runs_straight(seed):
    velocity = np.random.default_rng(seed).normal(0.0, 5.0 * REVERSAL, 50)
    velocity[10] = velocity[11]
    finely = np.interp(np.arange(49 * FINELY + 1) / FINELY, np.arange(50), velocity)
    expected = means(np.tanh(finely / REVERSAL))
    assert mean_direction(velocity, REVERSAL)[:-1] == pytest.approx(expected, abs=1e-3)


def test_a_piston_that_keeps_its_velocity_turns_nothing():
    velocity = np.full(20, 0.03)
    _, beyond = friction_direction(
        np.arange(20) * 1e-3, 3e-5 * np.arange(20), velocity, REVERSAL, FrictionEffects()
    )
    assert beyond == pytest.approx(np.zeros(20), abs=1e-12)


def test_friction_that_builds_up_does_so_within_an_interval_too():
    swing = lambda time: 2e-4 * np.sin(40.0 * time)  # noqa: E731
    speed = lambda time: 8e-3 * np.cos(40.0 * time)  # noqa: E731
    friction = FrictionEffects(presliding_travel=2e-5, presliding_exponent=1.0)
    time = np.arange(0.0, 0.4, 1e-3)
    share, beyond = friction_direction(time, swing(time), speed(time), REVERSAL, friction)
    finely = np.linspace(0.0, time[-1], (len(time) - 1) * FINELY + 1)
    expected = presliding_state(swing(finely), 2e-5, 1.0, share[0])
    assert share == pytest.approx(expected[::FINELY], abs=5e-3)
    found = beyond[:-1] + 0.5 * (share[1:] + share[:-1])
    assert found == pytest.approx(means(expected), abs=5e-3)


def test_an_observer_that_trusts_its_model_leaves_next_to_nothing_of_a_clean_recording():
    """Taken at samples alone, friction that turns leaves a fifth of the noise."""
    rig, model, random = load_rig("single-axis"), ServoModel(), np.random.default_rng(1)
    time = np.arange(0.0, 0.9, 1e-3)
    command = np.repeat(np.resize([2.0, -2.0], 90) * random.uniform(0.8, 1.2, 90), 10)
    run = simulate(rig, time=time, command=command, initial=InitialState(0.015))
    noise = {"displacement": 5e-6, "pressure_a": 300.0, "pressure_b": 300.0}
    channels = {name: run[name] for name in noise} | {"valve_voltage": command}
    clean = Recording("clean", time, channels, noise_rms=noise)
    held = model.readings(model.cases(clean, rig))[1]
    fed = model.followed(held)[1][0].inputs["feed"]
    assert np.sum(np.diff(np.sign(fed.motion[1])) != 0.0) > 60
    left = run_observer(fed, {}, rig)[2] / noise["displacement"]
    assert np.sqrt(np.nanmean(left[~fed.held] ** 2)) < 0.15
