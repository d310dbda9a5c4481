"""How recordings of the servo are read: hum, stops, the supply, and what the command does."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import NOISE, noisy, recorded

from pneuservo.controllers import DT2812A, DigitalSlidingMode, Proportional, SlidingMode
from pneuservo.diagnosis.fit import explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.followed import likeliest_followed, likeliest_held_back
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.servo.likelihood import compared
from pneuservo.diagnosis.models.servo.run_observer import COMMAND_DELAY
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.readings import (
    Reading,
    least_strained_first,
    likelier_with,
    ranked_readings,
)
from pneuservo.effects.supply import RIPPLE
from pneuservo.noise import wander
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 6.0, 1e-3)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def by_channel(model, cases, values):
    """Return what is left of each channel, in units of its noise."""
    return {c.channel: c.measured - model.predict(c, values) for c in cases}


def test_mains_hum_is_taken_out_of_every_channel(rig):
    clean = recorded(rig, Proportional(), 4)
    angle = 2.0 * np.pi * 49.97 * clean.time
    hum = 0.4 * np.sin(angle) + 0.2 * np.sin(3.0 * angle + 1.0)
    loud = {name: clean[name] + NOISE[name] * hum for name in NOISE}
    cases = ServoModel().cases(replace(clean, channels={**clean.channels, **loud}), rig)
    channels = [case for case in cases if case.recorded]
    assert [case.channel for case in channels] == ["displacement", "pressure_a", "pressure_b"]
    for case in channels[1:]:
        left = case.measured * case.scale - clean[case.channel]
        assert np.std(left) < 0.4 * np.std(NOISE[case.channel] * hum)


def test_a_chatter_that_is_read_wrongly_does_not_pass_for_hum(rig):
    # A relay at the second harmonic of 60 Hz: a command that runs on does not fit its edges, and
    # leaves a line there.
    command = 4.0 * np.sign(np.sin(2.0 * np.pi * 120.0 * TIME + 0.1))
    recording = noisy(simulate(rig, time=TIME, command=command), np.random.default_rng(7))
    model = ServoModel()
    running, held, *_ = model.readings(model.cases(recording, rig))
    taken = [
        np.std(c.recording["pressure_a"] - recording["pressure_a"]) for c in (running[1], held[1])
    ]
    assert max(taken) < 0.2 * NOISE["pressure_a"]
    assert np.std(by_channel(model, held, {})["pressure_a"]) == pytest.approx(1.0, abs=0.1)


def pressed(rig, offset):
    """Return a run into both stops, the displacement's zero off by some."""
    command = np.where(TIME % 2.0 < 1.0, 3.0, -3.0)
    recording = noisy(simulate(rig, time=TIME, command=command), np.random.default_rng(5))
    recording.channels["displacement"] += offset
    return recording


def test_a_piston_pressed_on_a_stop_tells_the_zero_of_its_transducer(rig):
    model = ServoModel()
    cases = model.cases(pressed(rig, 1e-4), rig)
    fed = cases[0].inputs["feed"]
    left, beside = (
        by_channel(model, cases, values)["displacement"]
        for values in ({}, {"sensor.position-offset:offset": 1e-4})
    )
    for side in (-1, 1):
        there = fed.resting == side
        assert np.mean(there) > 0.2
        # It shows when the piston arrives, and is then taken for a zero that wanders.
        arrived = np.flatnonzero(there & ~np.roll(there, 1))[1]
        assert np.mean(left[arrived : arrived + 10]) > 3.0
        assert np.sum(left[there] ** 2) > np.sum(beside[there] ** 2) + 200.0
        assert np.std(beside[there]) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("seed", range(8))
def test_a_zero_that_wanders_at_a_stop_is_no_offset(seed, rig):
    # Half a noise for a second at the one stop, and the other way at the other.
    model, rng = ServoModel(), np.random.default_rng(seed)
    recording = pressed(rig, NOISE["displacement"] * wander(TIME, rng))
    cases = model.cases(recording, rig)
    baseline = fit(model, cases, Hypothesis())
    offset = fit(model, cases, Hypothesis().adding("sensor.position-offset"), near=baseline)
    assert explained(baseline, offset) < 25.0


def test_pressures_count_while_the_piston_rests_at_a_stop(rig):
    model = ServoModel()
    cases = read_as(model, model.cases(pressed(rig, 0.0), rig))
    fed = cases[0].inputs["feed"]
    rests = fed.resting != 0
    assert np.mean(fed.shares[rests, 0]) > 0.8
    assert np.std(by_channel(model, cases, {})["pressure_a"][rests]) == pytest.approx(1.0, abs=0.1)


def test_a_measured_supply_is_held_against_source_and_line(rig):
    sag = {"supply.sag:volume": 5e-5, "supply.sag:area": 8e-7}
    command = np.where(TIME % 0.4 < 0.2, 3.0, -3.0)
    run = simulate(rig.with_values(sag), time=TIME, command=command)
    recording = noisy(run, np.random.default_rng(6), {**NOISE, "supply_pressure": 500.0})
    model = ServoModel()
    cases = model.cases(recording, rig)
    source = {"supply_level": rig["supply.pressure"]}
    noise = cases[0].inputs["feed"].noise["supply_pressure"]
    dip = float(np.std(run["supply_pressure"])) / noise
    assert dip > 5.0
    plain, sagging = (by_channel(model, cases, {**v, **source}) for v in ({}, sag))
    # What of the dip is slow may be the zero of the transducer.
    assert np.std(plain["supply_pressure"]) > 0.75 * dip
    assert np.std(sagging["supply_pressure"]) == pytest.approx(1.0, abs=0.1)
    # The chambers are driven by what was measured, whatever the supply is said to do.
    assert np.array_equal(plain["pressure_a"], sagging["pressure_a"])


def test_a_ripple_of_a_supply_that_was_not_recorded_shows_in_the_chambers(rig):
    swing = {"amplitude": 5e3, "frequency": 14.0, "phase": 1.0}
    true = {f"supply.ripple:{name}": value for name, value in swing.items()}
    model = ServoModel()
    cases = model.cases(recorded(rig.with_values(true), Proportional(), 4), rig)
    assert model.starts(RIPPLE, cases)["frequency"][-1] == pytest.approx(14.0, abs=0.1)


def read_as(model, cases):
    """Return the cases in the likelier reading of their command."""
    return ranked_readings(model, model.readings(cases), lambda step: None)[0].cases


def test_a_held_command_is_told_from_one_that_runs_on(rig):
    model = ServoModel()
    rng = np.random.default_rng(9)
    running = read_as(model, model.cases(recorded(rig, SlidingMode(), 8), rig))
    assert running[0].inputs["feed"].ramped
    steps = np.repeat(rng.uniform(0.3, 2.0, 150) * np.resize([1.0, -1.0], 150), 40)
    run = simulate(rig, time=TIME, command=steps)
    held = read_as(model, model.cases(noisy(run, rng), rig))
    assert not held[0].inputs["feed"].ramped


@pytest.mark.parametrize(
    ("kind", "runs_on"),
    [("analogue-card", True), ("digital", False), ("hybrid", False), ("proportional", True)],
)
def test_where_samples_hardly_tell_it_the_stated_controller_decides(rig, kind, runs_on):
    # Without pressures the ways to read a slow loop are as likely as each other.
    analogue = recorded(rig, Proportional(), 4)
    seen = {name: analogue[name] for name in ("valve_voltage", "displacement")}
    model = ServoModel()
    cases = model.cases(replace(analogue, channels=seen, controller={"kind": kind}), rig)
    assert read_as(model, cases)[0].inputs["feed"].ramped == runs_on


def test_what_samples_tell_is_not_overruled_by_the_stated_controller(rig):
    run = simulate(rig, time=TIME, command=4.0 * np.sign(np.sin(250.0 * TIME + 0.1)))
    relay = noisy(run, np.random.default_rng(7))
    model = ServoModel()
    stated = replace(relay, controller={"kind": "analogue-card"})
    assert not read_as(model, model.cases(stated, rig))[0].inputs["feed"].ramped


def test_what_a_reading_does_not_judge_is_no_argument_for_it(rig):
    # Read as if it ran on, the pressures are so unsure that the piston seems to stick.
    rng = np.random.default_rng(1)
    edges = np.repeat(np.resize([5.0, -5.0], 3000), rng.choice([2, 2, 2, 2, 3], 3000))
    recording = noisy(simulate(rig, time=TIME, command=edges[: len(TIME)]), rng)
    seen = {name: recording[name] for name in ("valve_voltage", "displacement")}
    model = ServoModel()
    running, held, *_ = model.readings(model.cases(replace(recording, channels=seen), rig))
    judged = [np.count_nonzero(way[0].inputs["feed"].shares[:, 2]) for way in (running, held)]
    assert judged[0] < 0.5 * judged[1]
    best = ranked_readings(model, [running, held], lambda step: None)[0]
    assert not best.cases[0].inputs["feed"].ramped


def test_each_recording_is_read_in_its_own_way(rig):
    model, quiet = ServoModel(), lambda step: None
    command = 4.0 * np.sign(np.sin(2.0 * np.pi * 40.0 * TIME + 0.1))
    relay = noisy(simulate(rig, time=TIME, command=command), np.random.default_rng(7))
    loop = recorded(rig, SlidingMode(), 8)
    cases = [case for each in (relay, loop) for case in model.cases(each, rig)]
    best = ranked_readings(model, model.readings(cases), quiet)[0]
    assert {(c.origin is loop, c.inputs["feed"].ramped) for c in best.cases} == {
        (False, False),
        (True, True),
    }
    # What is held back is read by what has been learnt, whatever was read beside it.
    again = model.cases(relay, rig)
    held_back = likeliest_held_back(model, again, best.baseline, best.cases[0])
    assert not any(case.inputs["feed"].ramped for case in held_back)


def test_what_an_effect_leaves_does_not_decide_how_a_command_is_read(rig):
    leak = "leakage.chamber-a"
    leaking = replace(rig, effects={leak: {"area": 3e-8}})
    model, quiet = ServoModel(), lambda step: None
    cases = model.cases(recorded(leaking, SlidingMode(), 5), rig)
    ranked = ranked_readings(model, model.readings(cases), quiet)
    # With the leak unexplained, 80 times the noise are left however the command is read: were one
    # that is held the likelier.
    held_first = sorted(ranked, key=lambda reading: reading.cases[0].inputs["feed"].ramped)
    first = held_first[0]
    named = fit(model, first.cases, Hypothesis().adding(leak), first.baseline)
    other = likelier_with(model, held_first, first.baseline, named, quiet)
    assert other.cases[0].inputs["feed"].ramped
    # What is held back is read as it is likelier with the leak.
    better = fit(model, other.cases, named.hypothesis, other.baseline)
    held_back = likeliest_held_back(model, cases, better, other.cases[0])
    assert all(case.inputs["feed"].ramped for case in held_back)
    # What explains less than lies between two readings cannot turn their order.
    baseline = ranked[0].baseline
    assert likelier_with(model, ranked, baseline, baseline, quiet) is None


def shaken_by(rig, share):
    """Return a recording with another force every 10 ms that nobody recorded.

    Its size is a share of the Coulomb friction.
    """
    rng = np.random.default_rng(3)
    size = share * rig["piston.coulomb_friction"]
    force = np.repeat(rng.normal(0.0, size, len(TIME) // 10 + 1), 10)[: len(TIME)]
    demand = np.where(TIME % 1.0 < 0.5, 0.010, 0.020)
    run = simulate(rig, time=TIME, controller=Proportional(), demand=demand, external_force=force)
    return noisy(run, rng, {**NOISE, "displacement": 2e-6})


def test_the_observer_allows_for_a_force_in_the_recording_where_there_is_one(rig):
    model = ServoModel()
    still, shaken = (model.cases(shaken_by(rig, share), rig) for share in (0.0, 0.3))
    used, baseline = likeliest_followed(model, [*still, *shaken], None, lambda step: None)
    allowed = [case.inputs["feed"].unsteadiness for case in used]
    assert max(allowed[: len(still)]) < 0.1
    assert allowed[len(still) :] == [1.0] * len(shaken)
    held_back = likeliest_held_back(model, shaken, baseline, used[0])
    assert all(case.inputs["feed"].unsteadiness == 1.0 for case in held_back)


def test_what_a_recording_does_not_tell_is_no_other_way_to_read_it(rig):
    heard = recorded(rig, Proportional(), 3, duration=2.0)
    quiet = replace(heard, name="quiet", channels=dict(heard.channels))
    model = ServoModel()
    cases = [case for each in (heard, quiet) for case in model.cases(each, rig)]
    # As if the first alone told the set point in steps.
    other = [case for case in model.readings(cases)[1] if case.origin is heard]
    ways = compared([cases, other + [case for case in cases if case.origin is quiet]])
    same = [[case for case in way if case.origin is quiet] for way in ways]
    assert all(one is two for one, two in zip(*same, strict=True))


def likeliest_baseline(recording, rig):
    model = ServoModel()
    ways = model.readings(model.cases(recording, rig))
    best = ranked_readings(model, ways, lambda step: None)[0]
    return best.cases[0].inputs["feed"], best.baseline


def test_a_command_whose_set_point_was_not_recorded_jumps_at_samples_where_it_does(rig):
    recording = recorded(rig, Proportional(gain=2.0), seed=3, interval=2e-3)
    fed, found = likeliest_baseline(replace(recording, noise_rms=NOISE), rig)
    assert np.flatnonzero(fed.jumps).tolist() == list(range(199, 1800, 200))
    assert found.shared["valve.spool.frequency"] == pytest.approx(200.0, rel=0.05)


def test_what_converters_take_is_no_delay_of_the_valve(rig):
    loop = DigitalSlidingMode(board=DT2812A)
    time = np.arange(0.0, 3.0, 5e-4)
    demand = np.repeat([0.012, 0.018, 0.015], len(time) // 3)
    run = simulate(rig, time=time, controller=loop, demand=demand)
    fine = NOISE | {"pressure_a": 200.0, "pressure_b": 200.0}
    recording = replace(noisy(run, np.random.default_rng(1), fine), noise_rms=fine)
    fed, found = likeliest_baseline(recording, rig)
    assert not fed.ramped
    assert found.own[0][COMMAND_DELAY] == pytest.approx(DT2812A.delay(1), abs=4e-6)
    assert max(np.std(left) for left in found.residuals) < 1.05


@pytest.mark.parametrize(
    ("deviance", "penalty", "first"),
    [
        pytest.param((100.0, 130.0), (20.0, 5.0), 1, id="hardly less likely, and nothing strained"),
        pytest.param((100.0, 130.0), (12.0, 5.0), 0, id="nothing to speak of is strained"),
        pytest.param((100.0, 160.0), (20.0, 5.0), 0, id="less likely"),
        pytest.param((100.0, 110.0, 140.0), (20.0, 21.0, 4.0), 2, id="one behind another"),
    ],
)
def test_of_ways_that_are_hardly_told_apart_the_one_that_strains_nothing_is_taken(
    deviance, penalty, first
):
    ranked = [
        Reading([], SimpleNamespace(penalty=strain), size)
        for strain, size in zip(penalty, deviance, strict=True)
    ]
    found = least_strained_first(ranked)
    assert found[0] is ranked[first]
    assert len(found) == len(ranked)
