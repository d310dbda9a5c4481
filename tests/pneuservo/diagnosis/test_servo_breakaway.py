"""The force at which a piston breaks away is what friction holds, no more and no less."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy, recorded

from pneuservo.controllers import DigitalSlidingMode, SlidingMode
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.followed import likeliest_followed
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.servo.breakaway import NOWHERE, as_in, departures
from pneuservo.diagnosis.models.servo.feed import AT_REST
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 8.0, 1e-3)
SEEDS = range(3)
STICKING = {"friction.stribeck:excess": 2.5, "friction.stribeck:speed": 2e-3}
LATE = {"sensor.position-lag:time": 4e-3}


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def pushed(rig, seed: int) -> Recording:
    """Return ramps of the command after rests: forces that grow slowly, to either side."""
    phase = TIME % 1.0
    side = np.where(TIME % 2.0 < 1.0, 1.0, -1.0)
    command = side * np.interp(phase, [0.0, 0.5, 0.8, 0.85, 1.0], [0.0, 0.0, 0.08, 0.0, 0.0])
    run = simulate(rig, time=TIME, command=command)
    return replace(noisy(run, np.random.default_rng(seed)), noise_rms=NOISE)


def breaking_away(recording: Recording, rig, values) -> tuple[np.ndarray, np.ndarray]:
    """Return force and friction at which the piston breaks away [N], and what is left of each."""
    model = ServoModel()
    case = next(case for case in model.cases(recording, rig) if case.channel == AT_REST)
    gone, side = model.breaks_away(case), case.inputs["feed"].departures.side
    force, holding = model.forces_at_rest(case, values)[:, gone]
    left = -model.predict(case, values)[gone]
    return np.array([side * force, holding]), side * left


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("planted", [{}, STICKING, LATE], ids=["nothing", "stiction", "late"])
def test_a_piston_breaks_away_at_what_friction_holds(rig, planted, seed):
    recording = pushed(rig.with_values(planted) if planted else rig, seed)
    (force, holding), left = breaking_away(recording, rig, planted)
    assert len(left) >= 6
    assert np.median(force) == pytest.approx(np.median(holding), abs=0.5)
    assert np.sqrt(np.mean(left**2)) < 1.3


@pytest.mark.parametrize("seed", SEEDS)
def test_friction_that_holds_less_is_told_as_one_that_holds_more(rig, seed):
    # A friction that is never overcome at rest cost nothing: only one that is too small did.
    sticks, slides = pushed(rig.with_values(STICKING), seed), pushed(rig, seed)
    _, too_little = breaking_away(sticks, rig, {})
    _, too_much = breaking_away(slides, rig, STICKING)
    assert np.mean(too_little) > 3.0
    assert np.mean(too_much) < -3.0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_piston_that_is_pushed_hard_is_not_taken_to_go_later(rig, seed):
    # Nearly without noise, from step to step: what brakes it grows within an interval.
    quiet = {name: 1e-3 * size for name, size in NOISE.items()}
    recording = replace(recorded(rig, SlidingMode(), seed, noise=quiet), noise_rms=NOISE)
    (force, holding), _ = breaking_away(recording, rig, {})
    assert len(force) >= 6
    assert abs(np.median(force - holding)) < 2.5


def test_a_piston_leaves_when_it_has_gone_farther_than_its_noise():
    gone = np.clip(np.arange(900) - 400, 0, None) * 1e-5
    motion = np.array([gone, np.gradient(gone, 1e-3), np.zeros(900)])
    stuck = np.arange(900) < 410
    found = departures(motion, stuck, stuck, 1e-5, 1e-3)
    assert [part.tolist() for part in found[:5]] == [[0.0], [409.0], [350.0], [408.0], [1.0]]
    # Back again, it goes the other way; what does not go far enough, or rested too shortly, stays.
    assert departures(-motion, stuck, stuck, 1e-5, 1e-3).side.tolist() == [-1.0]
    assert departures(1e-2 * motion, stuck, stuck, 1e-5, 1e-3).at.size == 0
    shortly = stuck & (np.arange(900) > 380)
    assert departures(motion, shortly, shortly, 1e-5, 1e-3).at.size == 0


def test_a_copy_is_judged_at_the_departures_of_its_original():
    original = NOWHERE._replace(
        **{name: np.array([400.0, 800.0]) for name in ("rested", "at", "first", "gone")},
        side=np.array([1.0, -1.0]),
        unsure=np.full(2, 1e-5),
    )
    copy = original._replace(at=np.array([420.0, 820.0]), side=np.array([1.0, 1.0]))
    found = as_in(original, copy, 1e-3)
    assert found.at.tolist() == [400.0]
    assert found.side.tolist() == [1.0]
    assert as_in(original, NOWHERE, 1e-3).at.size == 0
    assert as_in(NOWHERE, copy, 1e-3).at.size == 0


@pytest.mark.parametrize("seed", SEEDS)
def test_a_motion_is_smoothed_by_the_friction_that_was_found(rig, seed):
    # A loop on a computer whose piston is held by 12 N for 1: smoothed as by 1 N it moved to and
    # fro by less than its noise where it stuck, and the right parameters left 3.2 times that.
    found = {"piston.coulomb_friction": 12.0}
    time = TIME[:4000]
    demand = np.interp(time, np.arange(5.0), [0.012, 0.018, 0.016, 0.01, 0.014])
    run = simulate(
        rig.with_values(found), time=time, controller=DigitalSlidingMode(), demand=demand
    )
    recording = replace(noisy(run, np.random.default_rng(seed)), noise_rms=NOISE)
    model = ServoModel()
    # What the computer has made of a sample is seen in the next one.
    _, _, as_held, *_ = model.readings(model.cases(recording, rig))
    hypothesis = Hypothesis().adding("param.piston.coulomb_friction")
    named = fit(model, as_held, hypothesis)
    cases, again = likeliest_followed(model, as_held, named, lambda words: None)
    assert rms(model, as_held, found) > 2.5
    assert rms(model, cases, found) < 1.15
    before, after = (12.0 - each.shared["piston.coulomb_friction"] for each in (named, again))
    assert before > 2.5
    assert abs(after) < 0.5 * before


def rms(model, cases, values) -> float:
    case = next(case for case in cases if case.channel == "displacement")
    left = (case.measured - model.predict(case, values))[case.usable]
    return float(np.sqrt(np.mean(left**2)))
