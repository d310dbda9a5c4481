"""Campaigns: what a sample is, and what the samples together say."""

import json
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import spearmanr

from analog_card.behaviour import Imperfections
from analog_card.design_file import load_design
from analog_card.errors import InputError as QuantityError
from pneuservo.campaign.metrics import METRICS, metrics_of
from pneuservo.campaign.picture import campaign_figure
from pneuservo.campaign.plan_file import campaign_of
from pneuservo.campaign.run import SAMPLES, identity, run_campaign
from pneuservo.campaign.sample import run_samples, simulate_sample
from pneuservo.campaign.summary import grid_means, shown, spreads, summary
from pneuservo.controllers import Proportional, SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.recordings import Recording, write_recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import Simulation, simulate, step_demand

CARD = {"controller": "analogue-card", "demand": "15,24 mm", "hold": 0.1}
CAPACITANCE = "soldered.velocity_differentiator.capacitance"


def test_a_sample_is_the_run_that_simulate_gives(campaign, outcome):
    time, demand = step_demand([0.015, 0.024], 0.3, 1000.0)
    values = campaign.values(5)
    rig = load_rig("single-axis").with_values(values)
    (step,) = simulate(rig, time=time, demand=demand, controller=SlidingMode()).step_responses()
    sample = outcome.samples[5]
    assert sample["values"] == values
    for name in ("rise_time", "settling_time", "overshoot", "steady_state_error"):
        assert sample["metrics"][name] == getattr(step, name)


def test_trials_of_a_noisy_rig_differ_by_their_noise(tmp_path):
    (tmp_path / "noisy.toml").write_text(
        '[rig]\nkind = "single-axis"\n[transducers.displacement]\nnoise = "20 um"\n'
    )
    loop = {"controller": "proportional", "demand": "15,24 mm", "hold": 0.1}
    loop["vary"] = {"load.mass": "1.825 kg"}
    noisy = campaign_of({**loop, "rig": str(tmp_path / "noisy.toml"), "trials": 3})
    samples = run_campaign(noisy).samples
    assert len({sample["metrics"]["steady_state_error"] for sample in samples}) == 3
    # Each has its own seed, whatever was run before it.
    assert list(run_samples(noisy, [2])) == samples[2:]
    assert identity(noisy) != identity(replace(noisy, rig=load_rig("single-axis"), trials=1))


def test_metrics_are_those_of_the_worst_step():
    time, demand = step_demand([0.015, 0.024, 0.006], 0.3, 1000.0)
    run = simulate(time=time, demand=demand, controller=SlidingMode(boundary_layer=0.0))
    steps = run.step_responses()
    found = metrics_of(run, tuple(METRICS))
    assert found["settling_time"] == max(step.settling_time for step in steps)
    errors = [step.steady_state_error for step in steps]
    assert abs(found["steady_state_error"]) == max(map(abs, errors))
    last = run.limit_cycle()
    late = (time >= last.start) & (time <= last.end)
    assert found["limit_cycle_stroke"] >= np.ptp(run["displacement"][late]) > 0.0
    # The largest error is the larger step, just after it, before the piston has moved far.
    assert found["largest_error"] == pytest.approx(0.018, rel=0.01)
    error = np.linalg.norm(demand - run["displacement"]) / np.sqrt(len(run))
    assert found["rms_error"] == pytest.approx(error, rel=1e-9)


def test_the_limit_cycle_is_that_of_the_hold_that_swings_most():
    time = np.arange(1000) * 1e-3
    demand = np.where(time < 0.5, 0.015, 0.02)
    swing = np.where(time < 0.5, 2e-4, 1e-4) * np.sin(
        2 * np.pi * np.where(time < 0.5, 40, 60) * time
    )
    channels = {"demand": demand, "displacement": demand + swing, "valve_voltage": swing}
    run = Simulation(load_rig("single-axis"), time, channels)
    found = metrics_of(run, ["limit_cycle_frequency", "limit_cycle_stroke"])
    # Times of crossings are interpolated: off by far less than a sample over ten periods.
    assert found["limit_cycle_frequency"] == pytest.approx(40.0, rel=1e-3)
    # 25 samples a period: the highest misses the top by no more than 1 - cos(pi/25), 0.8 %.
    assert found["limit_cycle_stroke"] == pytest.approx(4e-4, rel=0.008)


def test_a_metric_that_one_step_lacks_is_lacking():
    time, demand = step_demand([0.015, 0.024, 0.015], 0.3, 1000.0)
    run = simulate(time=time, demand=demand, controller=Proportional(gain=3.4))
    settled = [np.isfinite(step.settling_time) for step in run.step_responses()]
    assert not all(settled)  # the thesis: 3.4 oscillates
    assert metrics_of(run, ["settling_time"]) == {"settling_time": None}


@pytest.mark.ngspice
def test_the_circuit_takes_the_same_values():
    vary = {CAPACITANCE: "110 nF", "element.xdifference.rdemand": "9.9 kohm"}
    loop = {**CARD, "hold": "20 ms", "rate": "10 kHz", "vary": vary}
    runs = []
    for card in ("circuit", "behaviour"):
        campaign = campaign_of({**loop, "card": card})
        runs.append(simulate_sample(campaign, campaign.values(0))["displacement"])
    nominal = simulate_sample(campaign, {})["displacement"]
    # As for the card as designed: 0.5 % of the step. That card does something else.
    limit = 0.005 * 9e-3
    assert np.abs(runs[0] - runs[1]).max() < limit < np.abs(runs[0] - nominal).max()


def test_the_transducer_is_the_rigs(tmp_path):
    # No law reads that of the design: an axis of it would change nothing.
    with pytest.raises(InputError, match=r"transducer\.full_scale_voltage"):
        campaign_of({**CARD, "vary": {"transducer.full_scale_voltage": "5, 10 V"}})
    (tmp_path / "card.toml").write_text('[transducer]\nfull_scale_voltage = "5 V"\n')
    warnings = []
    settings = {**CARD, "design": str(tmp_path / "card.toml"), "vary": {"load.mass": "2 kg"}}
    campaign_of(settings, warn=warnings.append)
    assert "166.7 V/m" in warnings[0]


def test_component_values_change_the_card_and_not_its_settings():
    campaign = campaign_of({**CARD, "vary": {CAPACITANCE: "110 nF"}})
    found = simulate_sample(campaign, campaign.values(0))
    design = load_design()
    parts = replace(design.soldered.velocity_differentiator, capacitance=110e-9)
    changed = replace(design, soldered=replace(design.soldered, velocity_differentiator=parts))
    time, demand = campaign.time, campaign.demand
    card = card_of(changed, Imperfections.none())
    expected = simulate(time=time, demand=demand, controller=card)
    np.testing.assert_array_equal(found["displacement"], expected["displacement"])
    nominal = simulate(time=time, demand=demand, controller=card_of(design, Imperfections.none()))
    # Velocity weighs 10 % more, the piston is slower by about that.
    assert found["velocity"].max() < 0.97 * nominal["velocity"].max()


def test_single_elements_change_the_behaviour():
    vary = {"element.xdifference.rdemand": "9.9 kohm"}
    campaign = campaign_of({**CARD, "card": "behaviour", "vary": vary})
    found = simulate_sample(campaign, campaign.values(0))
    elements = {"xdifference.rdemand": 9900.0}
    expected = simulate(
        time=campaign.time,
        demand=campaign.demand,
        controller=card_of(load_design(), elements=elements),
    )
    np.testing.assert_array_equal(found["displacement"], expected["displacement"])


def test_effects_and_controller_options_vary():
    vary = {"spool.null-bias:bias": "0, 0.02", "controller.gain": "1, 3.4"}
    loop = {"controller": "proportional", "demand": "15,24 mm"}
    outcome = run_campaign(campaign_of({**loop, "vary": vary}))
    table = outcome.table()
    # A proportional loop needs a voltage to make up for the bias: 5 V * 0.02 / gain on a transducer
    # of 10 V over 30 mm.
    error = table["steady_state_error"].to_numpy()
    moved = error[2:] - error[:2]
    assert moved[0] == pytest.approx(-5.0 * 0.02 / 1.0 * 3e-3, rel=0.05)
    assert table["overshoot"][1] > table["overshoot"][0]


def test_an_impossible_sample_does_not_end_a_campaign():
    loop = {"controller": "sliding-mode", "demand": "15,24 mm", "hold": 0.1}
    outcome = run_campaign(campaign_of({**loop, "vary": {"load.mass": "1.8, -1 kg"}}))
    assert outcome.samples[0]["error"] is None
    assert "load.mass is -1" in outcome.samples[1]["error"]
    assert set(outcome.samples[1]["metrics"].values()) == {None}
    assert (summary(outcome)["failed"], spreads(outcome)[0].without) == (1, 1)
    with pytest.raises(InputError, match=r"not one of 1 samples.*load\.mass is -1"):
        run_campaign(campaign_of({**loop, "vary": {"load.mass": "-1 kg"}}))


def test_a_recorded_demand_is_followed(tmp_path):
    time = np.arange(400) * 1e-3
    demand = 0.015 + 0.004 * np.sin(2 * np.pi * 5.0 * time)
    path = tmp_path / "sine.csv"
    write_recording(Recording("sine", time, {"demand": demand, "displacement": demand}), path)
    settings = {"controller": "sliding-mode", "demand": str(path), "vary": {"load.mass": "1.8 kg"}}
    (sample,) = run_campaign(campaign_of(settings)).samples
    # Lags behind by the surface's time constant of 4/70 ms: below 4 mm times 5 Hz times that.
    assert 1e-4 < sample["metrics"]["rms_error"] < 4e-3
    assert "settling_time" not in sample["metrics"]


def test_numbers_of_the_summary(campaign, outcome):
    table = outcome.table()
    spread = spreads(outcome)[0]
    times = np.array([sample["metrics"]["rise_time"] for sample in outcome.samples])
    assert spread.mean == pytest.approx(times.mean(), rel=1e-12)
    assert spread.deviation == pytest.approx(times.std(ddof=1), rel=1e-9)
    assert times[spread.highest_sample] == spread.highest == times.max()
    masses = table["load.mass"].to_numpy()
    expected = spearmanr(masses, times).statistic ** 2
    assert spread.important["load.mass"] == pytest.approx(expected, rel=1e-9)
    means = grid_means(outcome)
    assert list(means.index) == [6.5e5, 7.7e5]
    assert means.loc[7.7e5, "rise_time"] == pytest.approx(times[1::2].mean(), rel=1e-12)
    assert shown(means.index[0], "bar", "Pa") == pytest.approx(6.5)
    report = json.loads(json.dumps(summary(outcome)))
    assert (report["samples"], report["failed"]) == (40, 0)
    assert [axis["kind"] for axis in report["axes"]] == ["grid", "random"]


def test_every_metric_is_drawn_against_every_axis(outcome):
    figure = campaign_figure(outcome)
    had = [spread for spread in spreads(outcome) if spread.mean is not None]
    assert len(figure.axes) == 2 * len(had)
    bottom = figure.axes[-2:]
    labels = [ax.get_xlabel() for ax in bottom]
    assert labels == ["supply.pressure [bar]", "load.mass [kg]"]
    assert figure.axes[0].get_ylabel() == "rise time\n[ms]"
    drawn = sum(len(line.get_xdata()) for line in figure.axes[1].get_lines())
    assert drawn == 40


def test_a_campaign_without_any_metric_is_drawn_empty():
    # One set point, at which the piston starts: there is no step to measure.
    loop = {"controller": "sliding-mode", "demand": "15 mm", "hold": 0.1}
    settings = {**loop, "metrics": ["rise_time"], "vary": {"load.mass": "1.8, 7 kg"}}
    outcome = run_campaign(campaign_of(settings))
    assert outcome.table()["rise_time"].isna().all()
    (panel,) = campaign_figure(outcome).axes
    assert panel.get_ylabel() == "rise time\n[ms]"


def test_samples_without_a_metric_are_counted_at_their_point_and_seen(outcome):
    samples = deepcopy(outcome.samples)
    # Samples go through the grid: even ones are at 6.5 bar.
    for index in (0, 2, 4):
        samples[index]["metrics"]["rise_time"] = None
    some = replace(outcome, samples=samples)
    points = summary(some)["grid"]
    assert [point["without"]["rise_time"] for point in points] == [3, 0]
    left = [sample["metrics"]["rise_time"] for sample in outcome.samples[6::2]]
    assert points[0]["rise_time"] == pytest.approx(np.mean(left), rel=1e-12)
    opened = [
        line.get_xdata().tolist()
        for line in campaign_figure(some).axes[0].get_lines()
        if line.get_markerfacecolor() == "white"
    ]
    assert opened == [pytest.approx([6.5])]


def test_more_trials_go_on_from_those_kept(tmp_path, campaign, outcome):
    run_campaign(replace(campaign, trials=2), tmp_path)
    kept = (tmp_path / SAMPLES).read_text()
    ran = []
    assert run_campaign(campaign, tmp_path, step=ran.append).samples == outcome.samples
    assert (tmp_path / SAMPLES).read_text().startswith(kept)
    assert len(ran) == 36


@pytest.mark.parametrize(
    "figures",
    [
        {},
        {"values": {}, "metrics": {}, "error": None},
        {"values": {"load.mass": 2.0}, "metrics": {"rise_time": "x"}, "error": None},
        {"values": {"load.mass": True}, "metrics": {"rise_time": None}, "error": None},
        {"values": {"load.mass": 2.0}, "metrics": {"rise_time": 0.1}, "error": 3},
        3,
    ],
)
def test_a_sample_that_is_not_whole_is_refused_by_its_line(tmp_path, figures):
    loop = {"controller": "proportional", "demand": "15,16 mm", "hold": "20 ms"}
    small = campaign_of({**loop, "metrics": ["rise_time"], "vary": {"load.mass": "2, 3 kg"}})
    run_campaign(small, tmp_path)
    head, sample, _ = (tmp_path / SAMPLES).read_text().splitlines()
    damaged = json.dumps({"trial": 1, "figures": figures})
    (tmp_path / SAMPLES).write_text("\n".join((head, sample, damaged, "")))
    ran = []
    with pytest.raises(InputError, match=r"samples\.jsonl: line 3 is no whole sample.*again"):
        run_campaign(small, tmp_path, step=ran.append)
    assert not ran
    (tmp_path / SAMPLES).write_text("\n".join((head, sample, "")))
    assert len(run_campaign(small, tmp_path, step=ran.append).samples) == 2
    assert ran == ["trial 1"]
    with pytest.raises(QuantityError, match="another study"):
        run_campaign(replace(small, seed=1), tmp_path)


def test_another_campaign_is_another(campaign):
    other_rig = campaign.rig.with_values({"load.gravity": 0.0})
    others = [
        replace(campaign, seed=1),
        replace(campaign, rig=other_rig),
        replace(campaign, demand=campaign.demand + 1e-9),
        replace(campaign, axes=campaign.axes[:1], trials=1),
        replace(campaign, metrics=("rise_time",)),
    ]
    assert len({identity(each) for each in (campaign, *others)}) == 6
    assert identity(replace(campaign, trials=3, title="x")) == identity(campaign)
