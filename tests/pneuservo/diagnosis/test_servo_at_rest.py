"""A piston at rest tells how much force friction holds, and no more than that moves it."""

import re
from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import diagnose
from pneuservo.diagnosis.models.servo.feed import AT_REST
from pneuservo.diagnosis.models.servo.motion import smooth_motion
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.stops import judged_at_rest, moments_of_rest
from pneuservo.noise import wander
from pneuservo.recordings import Recording
from pneuservo.report.diagnosis_figures import diagnosis_figures
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 6.0, 1e-3)
STICKING = {"friction.stribeck:excess": 6.0, "friction.stribeck:speed": 0.013}
DWELL = {"friction.breakaway-dwell:excess": 3.0, "friction.breakaway-dwell:time": 0.3}


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def to_and_fro(rig, seed: int) -> Recording:
    """Return moves to and fro; in between the piston rests under a force that differs."""
    rng = np.random.default_rng(seed)
    command = np.where(TIME % 0.4 < 0.2, np.where(TIME % 1.6 < 0.8, 0.02, -0.02), 0.0)
    run = simulate(rig, time=TIME, command=command)
    channels = {
        name: run[name] + size * (rng.standard_normal(len(TIME)) + wander(TIME, rng))
        for name, size in NOISE.items()
    }
    channels["valve_voltage"] = run["valve_voltage"]
    return Recording("to and fro", TIME, channels, "single-axis", noise_rms=NOISE)


def left_at_rest(recording: Recording, rig, values) -> np.ndarray:
    model = ServoModel()
    case = next(c for c in model.cases(recording, rig) if c.channel == AT_REST)
    return -model.predict(case, values)[case.usable]


def test_a_piston_at_rest_does_not_follow_the_wandering_zero():
    rng = np.random.default_rng(1)
    noise = 2e-5
    reading = 0.015 + noise * (rng.standard_normal(len(TIME)) + wander(TIME, rng))
    driving = 0.3 + 0.2 * rng.standard_normal(len(TIME))
    _, velocity, _, velocity_rms, rest = smooth_motion(TIME, reading, noise, driving, 0.2, 1.0)
    assert rest.mean() > 0.95
    # The wander alone moves at 0.02 mm/s; following it with the noise gave 0.15 mm/s.
    inside = slice(200, -200)
    assert np.std(velocity[inside]) < 2e-5
    assert np.median(velocity_rms) < 5e-5


def test_a_piston_that_was_moved_slowly_by_a_little_rests_before_and_after():
    # Gliding all the time was likelier than moving all the time: its velocity followed the noise,
    # which moved a pressure, and a loop that samples was read as one that does not.
    time, rng, noise = np.arange(0.0, 10.0, 1e-3), np.random.default_rng(1), 2e-5
    reading = noise * rng.standard_normal(len(time))
    for start, way in ((2.5, 3e-4), (5.0, -3e-4), (7.5, 3e-4)):
        reading += way * (1.0 - np.exp(-np.clip(time - start, 0.0, None) / 0.12))
    driving = 0.4 * rng.standard_normal(len(time))
    _, velocity, _, velocity_rms, rest = smooth_motion(time, reading, noise, driving, 0.4, 1.3)
    before = slice(0, 2400)
    assert rest[before].all()
    assert 0.8 < rest.mean() < 0.98
    assert np.std(velocity[before]) < 1e-5
    assert np.max(velocity_rms[before]) < 1e-4


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("creep", [7e-5, 1.4e-4])
def test_a_piston_creeps_to_each_rest_in_its_own_way(creep, seed):
    # Still at two stops, and let go by a leak between them: in the stops' way it crept too slowly,
    # and its transducer's zero was taken to wander with it.
    time, rng, noise = np.arange(0.0, 6.0, 1e-3), np.random.default_rng(seed), 8e-6
    creeping = slice(2200, 3800)
    knots = [0.0, 1.5, 2.0, 4.0, 4.3, 6.0]
    reading = np.interp(time, knots, [0.03, 0.03, 0.0145, 0.0145 + 2.0 * creep, 0.03, 0.03])
    reading += noise * (rng.standard_normal(len(time)) + wander(time, rng))
    driving = np.where(time < 2.0, 0.0, 0.5) + 0.2 * rng.standard_normal(len(time))
    _, velocity, _, velocity_rms, rest = smooth_motion(time, reading, noise, driving, 0.2, 1.3)
    assert rest[creeping].all()
    assert np.mean(velocity[creeping]) == pytest.approx(creep, rel=0.05)
    assert np.std(velocity[200:1400]) < 1e-5
    assert np.median(velocity_rms[200:1400]) < 2e-5


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("demand", "stuck", "left"),
    [
        # It sticks and slips, with far more friction than the baseline has.
        (np.interp(TIME, [0.0, 3.0, 6.0], [0.008, 0.022, 0.008]), 0.5, 1.05),
        # Released 10 ms too early, it left 1.8 times the noise.
        (np.where(TIME % 1.0 < 0.5, 0.012, 0.019), 0.5, 1.4),
    ],
    ids=["slowly", "in steps"],
)
def test_a_piston_that_sticks_is_held_until_it_breaks_away(rig, demand, stuck, left, seed):
    run = simulate(rig.with_values(STICKING), time=TIME, controller=Proportional(), demand=demand)
    recording = replace(noisy(run, np.random.default_rng(seed)), noise_rms=NOISE)
    model, speed = ServoModel(), np.abs(run["velocity"])
    cases = model.cases(recording, rig)
    fed = cases[0].inputs["feed"]
    assert np.mean(fed.held[speed < 1e-5]) > 0.97
    assert np.mean(speed[fed.held] > 5e-3) < 3e-3
    assert fed.stuck.mean() > stuck
    displacement = next(case for case in cases if case.channel == "displacement")
    missed = (displacement.measured - model.predict(displacement, STICKING))[displacement.usable]
    assert np.sqrt(np.mean(missed**2)) < left


@pytest.mark.parametrize("seed", range(3))
def test_without_an_effect_friction_holds_the_piston(rig, seed):
    left = left_at_rest(to_and_fro(rig, seed), rig, {})
    assert len(left) >= 10
    assert np.sqrt(np.mean(left**2)) < 1.2


@pytest.mark.parametrize("seed", range(3))
def test_a_breakaway_force_that_grows_with_rest_shows_and_is_explained(rig, seed):
    recording = to_and_fro(rig.with_values(DWELL), seed)
    without = left_at_rest(recording, rig, {})
    with_it = left_at_rest(recording, rig, DWELL)
    assert np.sqrt(np.mean(without**2)) > 3.0
    assert np.sqrt(np.mean(with_it**2)) < 1.2


def test_what_is_judged_at_rest_is_no_channel_of_the_answer(rig):
    from pneuservo.diagnosis.document import document

    recording = to_and_fro(rig.with_values(DWELL), 1).slice(0.0, 3.2)
    found = diagnose([recording], rig=rig)
    answer = document(found)
    assert set(answer["fit"]["channels"]) == set(NOISE)
    # Rests that all last as long do not tell what grows with rest from what is always there.
    (named,) = (entry["effect"] for entry in answer["missing"])
    assert named in ("friction.breakaway-dwell", "friction.stribeck")
    assert answer["located"][0]["block"] == "piston"
    # No recorded channel shows it: the report draws what does.
    (title, picture), *_ = diagnosis_figures(found, answer)["curves"]
    slipping, moments, mended = (int(word) for word in re.findall(r"\b\d+\b", title))
    assert moments > slipping >= 5
    assert mended <= 1
    assert "held at most" in picture


def test_all_moments_of_one_rest_count_as_much_as_one():
    stuck = np.zeros(1200, dtype=bool)
    stuck[100:400] = stuck[600:700] = stuck[900:905] = True
    moments = moments_of_rest(stuck, 1e-3)
    judged = judged_at_rest(stuck, 1e-3)
    assert set(moments[100:400]) == {3.0}
    assert set(moments[~stuck]) == {1.0}
    # Too short to be judged, the last rest does not count.
    assert np.sum(1.0 / moments[judged]) == pytest.approx(2.0)
