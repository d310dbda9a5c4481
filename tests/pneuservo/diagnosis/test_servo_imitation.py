"""What the method's own models make of a recording's path pretends no more than noise does."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy, recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis.fit import explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.wander import beyond_wander
from pneuservo.diagnosis.pretence import Pretence, _no_worse
from pneuservo.noise import wander
from pneuservo.rigs import Transducer, load_rig
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
    running, holding, *_ = model.readings(model.cases(make(rig), rig))
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


def test_an_imitation_sticks_at_times_of_its_own(rig):
    sticking = {"friction.stribeck:excess": 6.0, "friction.stribeck:speed": 0.013}
    time = np.arange(0.0, 4.0, 1e-3)
    demand = np.where(time % 1.0 < 0.5, 0.012, 0.019)
    run = simulate(rig.with_values(sticking), time=time, controller=SlidingMode(), demand=demand)
    model = ServoModel()
    cases = model.cases(noisy(run, np.random.default_rng(3)), rig)
    values = [sticking for _ in cases]
    for copy in model.imitate(cases, values, np.random.default_rng(1)):
        left = (copy.measured - model.predict(copy, sticking))[copy.usable]
        # Held and let go with the recording it was left at 3.6 times its noise.
        assert np.sqrt(np.mean(left**2)) < 1.2, copy.channel
        if copy.channel == "displacement":
            # It is not judged where either of them sticks.
            assert np.mean(left != 0.0) > 0.7


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


class Knowing(ServoModel):
    """A model of which one value makes use of the very readings that it is to predict."""

    def predict(self, case, values):
        share = values.get("knowing:share", 0.0)
        expected = super().predict(case, {k: v for k, v in values.items() if k != "knowing:share"})
        return expected + share * (case.measured - expected)


def test_what_lives_on_the_noise_of_the_recording_does_so_in_copies_too(rig):
    # What it changes in the recording is that recording's noise: a copy's is another. An asymmetric
    # friction was named with 0.95 beside a relay, where there was nothing.
    model = Knowing()
    cases = model.cases(recorded(rig, Proportional(), 5, duration=2.0), rig)
    baseline = fit(model, cases, Hypothesis())
    share = 0.05
    closer = replace(
        baseline,
        shared=baseline.shared | {"knowing:share": share},
        residuals=tuple((1.0 - share) * left for left in baseline.residuals),
    )
    pretence = Pretence(model, cases, baseline, lambda text: None, 0)
    gained = explained(baseline, closer)
    assert gained > 200.0
    assert pretence.of("knowing", baseline, closer) > gained


def test_a_copy_of_a_rig_with_noisy_transducers_has_their_noise_once(rig):
    noise = {"displacement": Transducer(noise=2e-5), "pressure": Transducer(noise=500.0)}
    noisy_rig = replace(rig, transducers=noise)
    model, rng = ServoModel(), np.random.default_rng(1)
    cases = model.cases(recorded(rig, Proportional(), 5, duration=2.0), noisy_rig)
    values = [{} for _ in cases]
    copies = model.imitate(cases, values, rng)
    left = {case.channel: case.measured - model.predict(case, {}) for case in copies}
    for channel in ("displacement", "pressure_a", "pressure_b"):
        assert np.nanstd(left[channel]) < 1.2, channel


def test_a_rig_that_runs_away_does_not_end_the_diagnosis(rig):
    model = ServoModel()
    cases = model.cases(recorded(rig, Proportional(), 5, duration=1.0), rig)
    # Exhausts as wide as a hose empty the chambers within a step.
    runaway = {"valve.flow.area_b_e": 1.0, "valve.flow.area_a_e": 1.0}
    copies = model.imitate(cases, [runaway for _ in cases], np.random.default_rng(1))
    for copy in copies:
        left = copy.measured - model.predict(copy, {})
        assert np.nanstd(left) < 1.2, copy.channel


def test_no_moment_of_a_copy_counts_for_more_than_the_worst_of_the_recording():
    recorded = [np.array([1.0, -3.0, 2.0]), np.zeros(3)]
    copy = [np.array([27.0, -2.0, -27.0]), np.ones(3)]
    found = _no_worse(copy, recorded)
    assert [each.tolist() for each in found] == [[3.0, -2.0, -3.0], [0.0, 0.0, 0.0]]
