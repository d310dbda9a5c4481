"""Loops that hear the noise of their transducer: how is their command read?"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lsim

from pneuservo.controllers import DigitalSlidingMode, Proportional, SlidingMode
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.readings import ranked_readings
from pneuservo.diagnosis.strained import only_followed
from pneuservo.recordings import Recording
from pneuservo.rigs import Transducer, load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 2.0, 1e-3)
DEMAND = np.repeat([0.015, 0.024, 0.006, 0.015], len(TIME) // 4)
RECORDED = ("demand", "displacement", "pressure_a", "pressure_b", "valve_voltage")
NOISE = {"displacement": 2e-5, "pressure_a": 500.0, "pressure_b": 500.0}
FREQUENCY = "valve.spool.frequency"


@pytest.fixture(scope="module")
def rig():
    noise = {
        "displacement": Transducer(noise=NOISE["displacement"]),
        "pressure": Transducer(noise=NOISE["pressure_a"]),
    }
    return replace(load_rig("single-axis"), transducers=noise)


def likeliest(run, rig, time=TIME, noise=NOISE):
    channels = {name: run[name] for name in RECORDED if name in run}
    cases = ServoModel().cases(Recording("run", time, channels, noise_rms=noise), rig)
    model = ServoModel()
    best = ranked_readings(model, model.readings(cases), lambda step: None)[0]
    spool = best.baseline.shared[FREQUENCY]
    assert spool == pytest.approx(rig[FREQUENCY], rel=0.05)
    return best.cases[0].inputs["feed"]


def test_noise_that_runs_on_between_samples(rig):
    run = simulate(rig, time=TIME, controller=SlidingMode(), demand=DEMAND, seed=1)
    fed = likeliest(run.channels, rig)
    assert fed.ramped
    assert not len(fed.heard)
    # Of 65 mV that the loop hears nearly nothing is unknown between samples.
    assert np.median(fed.unseen) < 0.02


def test_noise_that_stays_from_sample_to_sample(rig):
    noise = NOISE["displacement"] * np.random.default_rng(1).standard_normal(len(TIME))
    quiet = replace(rig, transducers={"pressure": rig.transducers["pressure"]})
    # A loop that hears a displacement too large wants it smaller.
    run = simulate(quiet, time=TIME, controller=SlidingMode(), demand=DEMAND - noise, seed=1)
    heard = run.channels | {"displacement": run["displacement"] + noise, "demand": DEMAND}
    fed = likeliest(heard, rig)
    assert fed.ramped
    assert len(fed.heard)


def test_noise_that_runs_on_beside_a_set_point_that_comes_in_steps(rig):
    time = np.arange(0.0, 4.0, 1e-3)
    demand = 0.015 + 3e-3 * np.sin(4.4 * time) + 1e-3 * np.sin(38.0 * time)
    loop = SlidingMode(boundary_layer=20.0)
    run = simulate(rig, time=time, controller=loop, demand=demand, seed=1)
    fed = likeliest(run.channels, rig, time)
    assert fed.in_steps
    # Read with the steps alone, all that it hears is unknown between samples.
    assert np.median(fed.unseen) < 0.02


def test_noise_that_has_passed_the_filters_of_a_state_feedback(rig):
    known = {"displacement": 5e-6, "pressure_a": 150.0, "pressure_b": 150.0}
    fine, sampled = 5e-5, np.arange(0.0, 3.0, 1e-3)
    time = np.arange(0.0, 3.0, fine)
    noise = known["displacement"] * np.random.default_rng(3).standard_normal(len(sampled))
    # Velocity and acceleration of a reading, each behind the same three filters of 150 Hz.
    corner = 2.0 * np.pi * 150.0
    filters = np.polymul([1.0, corner], np.polymul([1.0, corner], [1.0, corner]))
    feedback = corner**3 * np.array([0.25, 22.0, 900.0]), filters
    heard = lsim(feedback, np.interp(time, sampled, noise), time)[1]
    controller, law = Proportional(), Proportional().law(rig)
    slope = law.gain * law.weight_displacement
    demand = 0.015 + 6e-3 * np.sin(4.4 * time) - heard / slope
    quiet = replace(rig, transducers={"pressure": Transducer(noise=known["pressure_a"])})
    run = simulate(quiet, time=time, controller=controller, demand=demand, seed=1)
    read = {name: run[name][:: len(time) // len(sampled)] for name in RECORDED[1:]}
    read["displacement"] = read["displacement"] + noise
    fed = likeliest(read, rig, sampled, known)
    assert fed.ramped
    assert fed.of_noise


def test_a_command_that_a_computer_changes_just_after_it_was_recorded(rig):
    run = simulate(rig, time=TIME, controller=DigitalSlidingMode(), demand=DEMAND, seed=1)
    fed = likeliest(run.channels, rig)
    assert not fed.ramped
    np.testing.assert_array_equal(fed.voltage[:-1], run["valve_voltage"][1:])


def test_beside_noise_that_is_heard_a_wrong_parameter_is_one(rig):
    index = "chamber.polytropic_index"
    other = rig.with_values({index: 1.15})
    run = simulate(other, time=TIME, controller=SlidingMode(), demand=DEMAND, seed=7)
    # The spool is recorded without any noise: what is left of it is no measure.
    channels = {name: run[name] for name in (*RECORDED, "spool")}
    answer = document(diagnose([Recording("run", TIME, channels)]))
    assert answer["verdict"] == "parameter"
    assert answer["corrected_parameters"][index]["value"] == pytest.approx(1.15, abs=0.02)


@pytest.mark.parametrize(
    ("command", "ramped", "level", "followed"),
    [
        ("chatter", True, 1.0, False),
        ("chatter", True, 0.5, True),
        ("steps", True, 0.5, False),
        # Held from sample to sample, nothing of it is unknown.
        ("chatter", False, 0.5, False),
    ],
)
def test_a_pressure_far_below_its_noise_was_only_followed(command, ramped, level, followed):
    times = np.arange(40)
    voltage = (
        np.sin(2.0 * times)
        if command == "chatter"
        else np.array([0.0, 1.0, -2.0, 3.0])[times // 10]
    )
    inputs = {"feed": SimpleNamespace(voltage=voltage, ramped=ramped)}
    cases = [
        SimpleNamespace(channel=name, origin=None, inputs=inputs)
        for name in ("pressure_a", "spool")
    ]
    found = SimpleNamespace(residuals=(np.full(9, level), np.full(9, 0.1)))
    assert bool(only_followed(ServoModel(), cases, found, [1.0, 1.0])) is followed
