"""The observer of the servo: its gains against the textbook, and that it cannot run away."""

import numpy as np
import pytest
from servo_recordings import NOISE, recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.servo.covariance import (
    ESTIMATED,
    GAIN_ROWS,
    READ,
    ZEROS,
    take_over,
    weigh,
)
from pneuservo.diagnosis.models.servo.estimate import with_observer
from pneuservo.diagnosis.models.servo.feed import FOLLOWED
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.run_observer import ASTRAY, run_observer
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.noise import LIKELY_WANDER, WANDER, wander
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

VARIANCE = np.array([4.0, 9.0, 1.0])


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def some_covariance(seed: int) -> np.ndarray:
    half = np.random.default_rng(seed).standard_normal((ESTIMATED, ESTIMATED))
    return half @ half.T


def reads() -> np.ndarray:
    matrix = np.zeros((3, ESTIMATED))
    for slot in range(3):
        matrix[slot, READ[slot]] = matrix[slot, ZEROS[slot]] = 1.0
    return matrix


@pytest.mark.parametrize("seed", range(5))
def test_readings_one_by_one_correct_as_all_at_once(seed):
    before = some_covariance(seed)
    covariance, gain, share = before.copy(), np.zeros((GAIN_ROWS, 3)), np.zeros(3)
    weigh(covariance, np.ones(3), VARIANCE, gain, share)
    spread = reads() @ before @ reads().T + np.diag(VARIANCE)
    kalman = before @ reads().T @ np.linalg.inv(spread)
    assert gain[:ESTIMATED] == pytest.approx(kalman, abs=1e-9)
    assert covariance == pytest.approx(before - kalman @ reads() @ before, abs=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_innovations_of_one_sample_are_independent_and_counted_in_their_spread(seed):
    before = some_covariance(seed)
    gain, share = np.zeros((GAIN_ROWS, 3)), np.zeros(3)
    weigh(before.copy(), np.ones(3), VARIANCE, gain, share)
    own = np.eye(3) - gain[ESTIMATED:]
    spread = reads() @ before @ reads().T + np.diag(VARIANCE)
    assert own @ spread @ own.T == pytest.approx(np.diag(VARIANCE / share**2), abs=1e-8)


def test_a_reading_that_is_missing_corrects_nothing():
    before = some_covariance(1)
    covariance, gain, share = before.copy(), np.ones((GAIN_ROWS, 3)), np.ones(3)
    weigh(covariance, np.full(3, np.nan), VARIANCE, gain, share)
    assert not gain.any()
    assert not share.any()
    assert (covariance == before).all()


def test_a_motion_that_is_taken_over_leaves_a_covariance_that_can_be():
    covariance = some_covariance(2)
    take_over(covariance, 1.0, 0.0)
    assert covariance == pytest.approx(covariance.T)
    assert np.linalg.eigvalsh(covariance).min() > -1e-9


def slow_recording(rig, seed: int) -> Recording:
    """Return a slow to and fro, with noise on zeros that wander."""
    time = np.arange(0.0, 8.0, 1e-3)
    rng = np.random.default_rng(seed)
    demand = 0.015 + 0.008 * np.abs((time / 2.0 + 0.5) % 2.0 - 1.0) - 0.004
    run = simulate(rig, time=time, controller=Proportional(), demand=demand)
    channels = {
        name: run[name]
        + size * (rng.standard_normal(len(time)) + LIKELY_WANDER / WANDER * wander(time, rng))
        for name, size in NOISE.items()
    }
    channels["valve_voltage"] = run["valve_voltage"]
    return Recording("slow", time, channels, noise_rms=NOISE)


@pytest.fixture(scope="module")
def slow(rig):
    return with_observer(feed(slow_recording(rig, 1), rig), rig)


def of_noise(fed, rig, values) -> np.ndarray:
    return run_observer(fed, values, rig)[:3] / np.array(list(NOISE.values()))[[1, 2, 0], None]


@pytest.mark.parametrize(
    "effect",
    [
        {"leakage.chamber-a:area": 1e-8},
        {"leakage.rod-seal:area": 1e-8},
        {"chamber.heat-transfer:conductance": 0.1},
        {"spool.null-bias:bias": 0.005},
    ],
    ids=lambda effect: next(iter(effect)),
)
def test_an_effect_far_too_large_does_not_make_it_run_away(slow, rig, effect):
    left = of_noise(slow, rig, effect)
    assert np.isfinite(left).all()
    assert np.sqrt(np.mean(left**2, axis=1)).max() < 30.0


def test_one_that_lost_its_way_fits_nothing(slow, rig):
    # As soon as the piston moves the force counts that is no number.
    left = of_noise(slow, rig, {"load.spring:stiffness": np.nan})
    assert left[:, -1000:].min() > 0.9 * ASTRAY


def test_zeros_that_wander_leave_no_slow_innovations(slow, rig):
    # The displacement has some where friction turns round at this speed.
    left = of_noise(slow, rig, {})[:2]
    power = np.abs(np.fft.rfft(left, axis=1)) ** 2 / left.shape[1]
    frequency = np.fft.rfftfreq(left.shape[1], 1e-3)
    slowly = (frequency > 0.1) & (frequency < 3.0)
    assert power[:, slowly].mean(axis=1).max() < 1.5
    assert power[:, ~slowly].mean() == pytest.approx(1.0, abs=0.15)


def test_a_piston_about_to_break_away_is_not_moved_by_what_follows(rig):
    time = np.arange(0.0, 2.0, 1e-3)
    demand = np.where(time < 1.0, 0.01, 0.02)
    run = simulate(rig, time=time, controller=Proportional(), demand=demand)
    rng = np.random.default_rng(3)
    channels = {n: run[n] + rng.normal(0.0, NOISE[n], len(time)) for n in NOISE}
    fed = feed(Recording("step", time, channels | {"valve_voltage": run["valve_voltage"]}), rig)
    before = (time > 0.9) & (time < 0.995)
    assert np.ptp(run["displacement"][before]) < 1e-6
    error = fed.motion[0] - run["displacement"]
    # It reached three times the noise when one smoother had to fit rest and motion.
    assert np.abs(error[before]).max() < NOISE["displacement"]


@pytest.mark.parametrize(
    "effect",
    [
        {"sensor.position-lag:time": 0.005},
        {"sensor.position-nonlinearity:first": 3e-4},
    ],
    ids=lambda effect: next(iter(effect)),
)
def test_a_faulty_transducer_does_not_reach_the_chambers(rig, effect):
    time = np.arange(0.0, 4.0, 1e-3)
    demand = np.where(time % 1.0 < 0.5, 0.01, 0.02)
    faulty = rig.with_values(effect)
    run = simulate(faulty, time=time, controller=Proportional(), demand=demand)
    rng = np.random.default_rng(4)
    channels = {n: run[n] + rng.normal(0.0, NOISE[n], len(time)) for n in NOISE}
    channels["valve_voltage"] = run["valve_voltage"]
    recording = Recording("steps", time, channels, noise_rms=NOISE)
    fed = with_observer(feed(recording, rig), rig)
    known, ignored = of_noise(fed, rig, effect), of_noise(fed, rig, {})
    # The smoothed motion still is the reading's own.
    assert np.std(known, axis=1).max() < 1.25
    assert np.std(known) < 0.7 * np.std(ignored)


def test_what_makes_it_run_away_all_the_same_gives_numbers_a_fit_can_turn_back_from(slow, rig):
    left = run_observer(slow, {"leakage.rod-seal:area": 1e-5, "load.mass": 0.01}, rig)[:3]
    assert np.isfinite(left).all()
    assert np.all(np.abs(left).max(axis=1) <= ASTRAY * 1.001 * slow.noise_of(FOLLOWED))


def test_an_observer_that_trusts_its_model_shows_what_it_would_else_follow(rig):
    model, heavier = ServoModel(), {"load.mass": 1.02 * rig["load.mass"]}
    ways = model.followed(model.cases(recorded(rig, Proportional(), 1), rig))[:2]
    as_ever, steadily = (
        np.nansum((model.predict(case, heavier) - model.predict(case, {})) ** 2)
        for case, *_ in ways
    )
    assert steadily > 1.6 * as_ever > 400.0
