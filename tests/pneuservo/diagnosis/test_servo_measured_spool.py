"""A spool whose position is measured is judged by that."""

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.fit import explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import SECOND_SHARE
from pneuservo.diagnosis.models.servo.measured_spool import SPOOL_GAIN, SPOOL_ZERO
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.readings import ranked_readings
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 4.0, 1e-3)
ZERO, GAIN, SPOOL_NOISE = 0.004, 1.015, 1e-3


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def test_a_recording_may_begin_while_the_spool_moves(rig):
    """As one does that was cut: where the spool was before is in no sample."""
    command = np.where(TIME % 0.1 < 0.05, 3.0, -3.0)
    run = simulate(rig, time=TIME, command=command)
    recording = noisy(run, np.random.default_rng(2))
    recording.channels.update(spool=run["spool"])
    cut = recording.slice(0.052, 1.0)
    assert abs(cut["spool"][0] - cut["valve_voltage"][0] / 5.0) > 0.1
    model = ServoModel()
    cases = model.cases(model.completed(cut, rig), rig)
    held = next(way for way in model.readings(cases) if not way[0].inputs["feed"].ramped)
    for case in held:
        left = (case.measured - model.predict(case, {}))[case.usable]
        assert np.std(left) < 1.3, case.channel


def recorded(rig, effects, with_spool, with_demand, seed=6):
    """Return a run whose spool is read by a transducer that is off in zero and gain."""
    rng = np.random.default_rng(seed)
    demand = np.repeat(rng.uniform(0.006, 0.024, 20), 200)
    faulty = rig.with_values(effects)
    run = simulate(faulty, time=TIME, controller=Proportional(), demand=demand)
    recording = noisy(run, rng)
    read = ZERO + GAIN * run["spool"] + rng.normal(0.0, SPOOL_NOISE, len(TIME))
    if with_demand:
        recording.channels.update(demand=demand)
    recording.noise_rms.update(NOISE)
    if with_spool:
        recording.channels.update(spool=read)
        recording.noise_rms.update(spool=SPOOL_NOISE)
    return recording


def fitted(rig, effects, *names, with_spool=True):
    """Return the baseline of a command that runs on, and the fits with each of some names alone."""
    model = ServoModel()
    cases = model.cases(recorded(rig, effects, with_spool, with_demand=True), rig)
    assert ("spool" in {case.channel for case in cases}) == with_spool
    baseline = fit(model, cases, Hypothesis())
    return baseline, [fit(model, cases, Hypothesis().adding(name), baseline) for name in names]


@pytest.mark.parametrize("with_demand", [True, False])
def test_where_nothing_is_missing_zero_and_gain_of_its_transducer_are_all(rig, with_demand):
    model = ServoModel()
    cases = model.cases(recorded(rig, {}, True, with_demand), rig)
    likeliest = ranked_readings(model, model.readings(cases), lambda step: None)[0]
    assert likeliest.cases[0].inputs["feed"].ramped
    baseline = likeliest.baseline
    assert baseline.rms_of("spool") == pytest.approx(1.0, abs=0.05)
    assert baseline.own[0][SPOOL_ZERO] == pytest.approx(ZERO, abs=1e-3)
    assert baseline.own[0][SPOOL_GAIN] == pytest.approx(GAIN, abs=2e-3)


def test_it_tells_play_from_stiction(rig):
    truth, names = {"spool.hysteresis:half_width": 0.004}, ("spool.hysteresis", "spool.stiction")
    baseline, (play, stiction) = fitted(rig, truth, *names)
    assert baseline.rms_of("spool") > 1.2
    assert play.rms_of("spool") == pytest.approx(1.0, abs=0.05)
    assert play.shared["spool.hysteresis:half_width"] == pytest.approx(0.004, rel=0.05)
    alike = 1.0 - SECOND_SHARE
    assert explained(baseline, stiction, play) < alike * explained(baseline, play)
    baseline, (play, stiction) = fitted(rig, truth, *names, with_spool=False)
    assert explained(baseline, stiction, play) > alike * explained(baseline, play)
