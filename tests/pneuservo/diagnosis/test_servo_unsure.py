"""Where readings do not tell how a piston moves, or a command runs, the observer is unsure."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import SlidingMode
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.followed import likeliest_followed
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.models.servo.command import as_it_may_have_been, is_relay
from pneuservo.diagnosis.models.servo.rests import chatters
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.trust import may_only_seem_to_rest, unsure_of_rest
from pneuservo.diagnosis.readings import ranked_readings
from pneuservo.diagnosis.readings_by_effect import likelier_if_late, likelier_with_another
from pneuservo.diagnosis.search import UNKNOWN_BETWEEN_SAMPLES
from pneuservo.diagnosis.ways import by_recording, deviance_in
from pneuservo.recordings import Recording
from pneuservo.report.page import diagnosis_page
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 4.0, 1e-3)
QUIET = lambda step: None  # noqa: E731


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.mark.parametrize("frequency", [60.0, 120.0, 180.0, 200.0])
def test_a_force_that_swings_beyond_friction_is_seen_at_any_frequency(frequency):
    rng, friction = np.random.default_rng(1), 2.4
    driving = 6.5 * np.sin(2.0 * np.pi * frequency * TIME) + rng.normal(0.0, 0.4, len(TIME))
    assert np.mean(chatters(driving, 0.4, friction, 2e-5, 1e-3)) > 0.95
    # By less than friction holds to either side it moves nothing.
    assert not np.any(chatters(0.3 * driving, 0.4, friction, 2e-5, 1e-3))


def test_a_command_that_keeps_moving_makes_rest_unsure(rig):
    rng, model = np.random.default_rng(2), ServoModel()
    still = simulate(rig, time=TIME, command=np.zeros_like(TIME))
    quiet = noisy(still, rng)
    moved = 0.1 * rng.standard_normal(len(TIME))
    restless = replace(quiet, channels={**quiet.channels, "valve_voltage": moved})
    held = [model.readings(model.cases(recording, rig))[1] for recording in (quiet, restless)]
    feeds = [cases[0].inputs["feed"] for cases in held]
    assert [may_only_seem_to_rest(fed, rig) for fed in feeds] == [False, True]
    unsure = unsure_of_rest(feeds[1], rig)
    assert np.all(unsure.spread >= feeds[1].spread)
    assert np.median(unsure.spread) > 2.0 * np.median(feeds[1].spread)
    # Where it is said to be quiet there is nothing to choose.
    assert [len(model.followed(cases)) for cases in held] == [2, 3]


@pytest.mark.parametrize("seed", [2, 3])
def test_what_a_piston_at_rest_does_unseen_does_not_tell_how_a_command_is_read(rig, seed):
    # It rings on the asperities of its seals by less than its transducer tells.
    given = rig.with_values({"load.mass": 7.2, "piston.coulomb_friction": 3.0})
    elastic = given.with_values({"friction.presliding:travel": 4e-5})
    rng = np.random.default_rng(seed)
    kicks = np.where(TIME % 0.5 < 0.02, 3.0, 0.0) * np.where(TIME % 1.0 < 0.5, 1.0, -1.0)
    command = kicks + 0.02 * rng.standard_normal(len(TIME))
    quiet = {"displacement": 1.6e-5, "pressure_a": 260.0, "pressure_b": 260.0}
    recording = noisy(simulate(elastic, time=TIME, command=command), rng, quiet)
    model = ServoModel()
    ways = model.readings(model.cases(replace(recording, noise_rms=quiet), given))[:2]
    nothing = [[{}] * len(way) for way in ways]
    surely = [by_recording(model, *each) for each in zip(ways, nothing, strict=True)]
    excused = deviance_in(model, ways, nothing)
    running, held = (sum(way.values()) for way in surely)
    assert running < held
    running, held = (sum(way.values()) for way in excused)
    assert held < running - LEAST_GAIN


def analogue_relay(rig, mass: float, seed: int) -> Recording:
    """Return a relay that switches between the samples of its recording, which are 1 ms apart."""
    rng = np.random.default_rng(seed)
    fine = np.arange(0.0, TIME[-1] + 1e-9, 1e-4)
    edges = np.cumsum(rng.uniform(2e-3, 4e-3, 2 * len(TIME)))
    command = np.where(np.searchsorted(edges, fine) % 2 == 0, 5.0, -5.0)
    run = simulate(rig.with_values({"load.mass": mass}), time=fine, command=command)
    every = {name: run[name][::10] for name in (*NOISE, "valve_voltage")}
    channels = {n: v + rng.normal(0.0, NOISE[n], len(v)) for n, v in every.items() if n in NOISE}
    return Recording("run", TIME, {**channels, "valve_voltage": every["valve_voltage"]})


def test_a_relay_that_switches_between_samples_is_not_read_as_held_for_a_wrong_mass(rig):
    model = ServoModel()
    cases = model.cases(analogue_relay(rig, 1.2 * rig["load.mass"], 3), rig)
    best = ranked_readings(model, model.readings(cases), QUIET)[0]
    assert best.cases[0].inputs["feed"].ramped


def test_a_relay_may_have_switched_at_any_moment_between_its_samples():
    rng = np.random.default_rng(4)
    voltage = np.where(np.arange(4000) % 8 < 4, 5.0, -5.0)
    assert is_relay(voltage)
    command = np.repeat(voltage[:, np.newaxis], 5, axis=1)
    drawn = np.array([as_it_may_have_been(command, voltage, rng) for _ in range(20)])
    switching = np.flatnonzero(np.diff(voltage))
    means = drawn[:, switching].mean(axis=2)
    # Anywhere in the interval: its mean is as likely to be anything from one level to the other.
    assert np.mean(means) == pytest.approx(0.0, abs=0.1)
    assert np.std(means) == pytest.approx(10.0 / np.sqrt(12.0), rel=0.05)
    elsewhere = np.setdiff1d(np.arange(3999), switching)
    assert 0.01 < np.mean(np.ptp(drawn[:, elsewhere], axis=2) > 0.0) < 0.2


def test_what_is_late_has_a_say_in_how_a_command_is_read(rig):
    weak = rig.with_values({"spool.amplitude-bandwidth:acceleration": 2e5})
    rng = np.random.default_rng(5)
    command = np.repeat(rng.uniform(-5.0, 5.0, 50) * (-1.0) ** np.arange(50), 40)
    recording = noisy(simulate(weak, time=TIME[:2000], command=command), rng)
    model = ServoModel()
    ranked = ranked_readings(model, model.readings(model.cases(recording, rig)), QUIET)
    late = likelier_if_late(model, ranked, QUIET)
    found = late or ranked[0]
    assert not found.cases[0].inputs["feed"].ramped


def test_what_else_may_be_missing_has_a_say_where_more_than_noise_is_left(rig):
    shifted = rig.with_values({"sensor.ground-shift:shift_a": 1200.0})
    rng = np.random.default_rng(5)
    slow = np.convolve(rng.normal(0.0, 1.0, 667), np.ones(5) / 5, "same")
    command = np.repeat(rng.normal(0.0, 1.5, 667) + 3.0 * slow, 3)[:2000]
    command -= np.mean(command)
    recording = noisy(simulate(shifted, time=TIME[:2000], command=command), rng)
    model = ServoModel()
    ranked = ranked_readings(model, model.readings(model.cases(recording, rig)), QUIET)
    baseline = ranked[0].baseline
    assert ranked[0].cases[0].inputs["feed"].ramped
    other = likelier_with_another(model, ranked, baseline, baseline, QUIET)
    assert not other.cases[0].inputs["feed"].ramped
    # What explains all there is leaves nothing to another.
    named = fit(model, other.cases, Hypothesis().adding("sensor.ground-shift"), other.baseline)
    rest = [other, *(reading for reading in ranked if reading is not other)]
    assert likelier_with_another(model, rest, other.baseline, named, QUIET) is None


def test_a_piston_that_chatters_unseen_is_followed_unsurely(rig):
    # At 180 Hz it moves by less than the noise, and its friction is a third of the force.
    heavy = rig.with_values({"piston.coulomb_friction": 4.0})
    given = rig.with_values({"piston.coulomb_friction": 4.0})
    rng = np.random.default_rng(6)
    command = np.where(np.arange(len(TIME)) % 6 < 3, 5.0, -5.0)
    loud = {"displacement": 3e-5, "pressure_a": 800.0, "pressure_b": 800.0}
    recording = noisy(simulate(heavy, time=TIME, command=command), rng, loud)
    recording = replace(recording, noise_rms=loud)
    model = ServoModel()
    held = model.readings(model.cases(recording, given))[1]
    assert held[0].inputs["feed"].chatter > 0.5
    cases, _ = likeliest_followed(model, held, None, QUIET)
    sizes = {
        case.channel: np.sqrt(np.mean((case.measured - model.predict(case, {}))[case.usable] ** 2))
        for case in cases
        if case.recorded
    }
    assert max(sizes.values()) < 1.1


def test_nothing_is_named_that_shows_only_where_nobody_knows_the_command(rig):
    """A sliding mode with next to no boundary layer switches some times between two samples."""
    time = np.arange(0.0, 0.75, 1e-3)
    demand = 0.015 + 3e-3 * np.sin(4.4 * time) + 2e-3 * np.sin(14.5 * time)
    run = simulate(rig, time=time, controller=SlidingMode(boundary_layer=1.0), demand=demand)
    fine = {"displacement": 3e-6, "pressure_a": 500.0, "pressure_b": 500.0}
    recording = noisy(run, np.random.default_rng(1), fine)
    found = diagnose([replace(recording, noise_rms=fine)])
    answer = document(found)
    assert answer["verdict"] == "consistent", found.search.accepted
    # Something was named at first, and had to go for that.
    assert UNKNOWN_BETWEEN_SAMPLES in [step.why for step in found.search.ledger]
    assert answer["not_judged"] == ["run"]
    sentence = "What the command of run did between its samples is not known"
    assert sentence in diagnosis_page(found, answer)
