"""Tuning for a set of rigs: what the worst is, what a front is, and what the check checks."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest
from small_tuning import PLAN, small_problem, small_tuning

from analog_card.errors import AnalogCardError
from analog_card.settings import (
    boundary_layer_setting,
    displacement_setting,
    level_setting,
    velocity_setting,
)
from analog_card.surface_weights import weights_from_settings
from pneuservo.controllers import AnalogueCard, card_of
from pneuservo.errors import FitError, InputError
from pneuservo.recordings import Recording, write_recording
from pneuservo.simulation import simulate
from pneuservo.simulation.metrics import control_effort, final_swings
from pneuservo.tuning.check import drawn_rigs, judged, run_check
from pneuservo.tuning.evaluation import RESOLUTION, Worst, worst_by_batch, worst_by_single_runs
from pneuservo.tuning.front import by_preference, confirmed, front_of
from pneuservo.tuning.picture import tuning_figure
from pneuservo.tuning.problem import (
    LIMITED,
    OBJECTIVES,
    POTENTIOMETERS,
    settable,
    standard_set,
    tuning_problem,
)
from pneuservo.tuning.run import run_tuning
from pneuservo.tuning.search import Search, search
from pneuservo.tuning.summary import binding, summary

CAPACITANCE = "soldered.velocity_differentiator.capacitance"


@pytest.fixture(scope="module")
def problem():
    return small_problem()


@pytest.fixture(scope="module")
def found():
    return small_tuning()


def made_up(settling_time, chatter=0.0, effort=1.0, overshoot=0.0, error=0.0, lacking=0):
    figures = dict(zip(OBJECTIVES, (settling_time, chatter, effort), strict=True))
    figures |= {"overshoot": overshoot, "steady_state_error": error}
    return Worst((0.5, 0.5, 0.5, 0.5), figures, dict.fromkeys(figures, 0), lacking)


def test_settings_are_kept_where_the_parts_of_the_card_vary():
    problem = tuning_problem({"vary": {CAPACITANCE: "90, 110 nF", "load.mass": "1.8, 7 kg"}})
    cards = problem.controllers((0.4, 0.5, 0.2, 0.6))
    figures = [card.figures for card in cards]
    # 120 kohm times the capacitance; the weights are those of the settings in all of them.
    expected = [120e3 * values[CAPACITANCE] for values in problem.members]
    assert [each.rc_velocity for each in figures] == pytest.approx(expected)
    assert len({each.weight_velocity for each in figures}) == 1
    assert [rig["load.mass"] for rig in problem.rigs] == [1.8, 7.0, 1.8, 7.0]
    assert AnalogueCard(figures[0]) == cards[0]


def test_unless_said_the_set_is_its_sixteen_corners():
    problem = tuning_problem({})
    assert len(problem.members) == 16
    ends = np.array(
        [
            [min(column), max(column)]
            for column in zip(*map(dict.values, problem.members), strict=True)
        ]
    )
    np.testing.assert_allclose(
        ends, [[6.5e5, 7.7e5], [1.825, 11.825], [95e-9, 105e-9], [95e-9, 105e-9]]
    )
    assert list(standard_set(problem.design)) == list(problem.members[0])


def test_the_worst_is_that_of_the_worst_rig(problem):
    settings = (0.4, 0.5, 0.2, 0.6)
    worst = worst_by_single_runs(problem, settings)
    time, demand = problem.campaign.time, problem.campaign.demand
    times, efforts, swings = [], [], []
    for rig, card in zip(problem.rigs, problem.controllers(settings), strict=True):
        run = simulate(rig, time=time, demand=demand, controller=card)
        times.append(max(step.settling_time for step in run.step_responses()))
        efforts.append(control_effort(time, run["valve_voltage"]))
        swings.append(max(each.size for each in final_swings(time, demand, run["valve_voltage"])))
    for name, values in zip(OBJECTIVES, (times, swings, efforts), strict=True):
        assert worst.figures[name] == max(values)
        assert values[worst.rigs[name]] == max(values)


def test_single_runs_confirm_both_ends_of_the_front(problem, found):
    for batch in (found.front[0], found.front[-1], found.chosen):
        single = worst_by_single_runs(problem, batch.settings)
        # A displacement within 0.03 um moves a crossing of the band by one sample at the most, and
        # the surface of a card of 5 m/s2 and 5 V by c1 = 3000/s2 times that: 0.1 mV.
        assert abs(batch.figures["settling_time"] - single.figures["settling_time"]) < 1.5e-3
        for name in ("chatter", "control_effort"):
            assert abs(batch.figures[name] - single.figures[name]) < 1e-3
        assert abs(batch.figures["overshoot"] - single.figures["overshoot"]) < 1e-4
        assert single.feasible(problem)


def test_what_single_runs_do_not_confirm_is_not_taken(problem, found):
    now = replace(found.tried[0], figures=dict.fromkeys((*OBJECTIVES, *LIMITED), 0.0))
    assert by_preference([found.chosen, now])[0] == 1
    place, located = confirmed(problem, [found.chosen, now])
    assert (place, located) == (0, found.located)
    with pytest.raises(FitError, match="not one of the 1 settings of the front"):
        confirmed(problem, [now])


def test_a_loop_that_does_not_move_keeps_no_limit(problem):
    still = worst_by_batch(problem, (0.5, 0.5, 0.2, 0.0))
    assert still.figures["control_effort"] == 0.0
    # 9 mm up and 18 mm down are left.
    assert abs(still.figures["steady_state_error"]) == pytest.approx(9e-3, rel=1e-3)
    assert not still.feasible(problem)


def test_the_card_of_the_thesis_chatters_in_one_rig_and_the_front_in_none(problem, found):
    now = found.tried[0]
    assert now.settings == settable(problem.now)
    assert not now.feasible(problem)
    # Between the levels of 5 V, in the lightest rig at the highest pressure.
    assert now.figures["chatter"] > 9.0
    assert problem.members[now.rigs["chatter"]] == {"supply.pressure": 7.7e5, "load.mass": 1.825}
    assert found.chosen.figures["chatter"] < 0.1


def test_nothing_tried_beats_the_front(problem, found):
    within = [each for each in found.tried if each.feasible(problem)]
    assert 1 < len(found.front) < len(within) < len(found.tried)
    for kept in found.front:
        assert kept.feasible(problem)
        mine = np.array(kept.objectives())
        for other in within:
            theirs = np.array(other.objectives())
            assert not (np.all(theirs <= mine) and np.any(theirs < mine))
    times = [each.figures["settling_time"] for each in found.front]
    assert times == sorted(times) or np.max(np.abs(np.diff(times))) > RESOLUTION["settling_time"]
    for other in within:
        beaten = [np.all(np.array(kept.objectives()) <= other.objectives()) for kept in found.front]
        assert any(beaten)


def test_settings_of_the_front_are_within_reach(found):
    ways_back = {
        "displacement": displacement_setting,
        "velocity": velocity_setting,
        "boundary_layer": boundary_layer_setting,
        "level": level_setting,
    }
    for each in found.front:
        design = found.problem.turned(each.settings)
        weights = weights_from_settings(design)
        # Each raises where the card cannot be turned to it.
        back = [way(getattr(weights, name), design) for name, way in ways_back.items()]
        assert back == pytest.approx(each.settings, abs=1e-9)
        assert each.settings == settable(each.settings)


def test_made_up_fronts(problem):
    fast, soft = made_up(0.1, 0.5, 2.0), made_up(0.3, 0.0, 1.0)
    middle, beaten = made_up(0.15, 0.1, 1.2), made_up(0.16, 0.1, 1.3)
    wide, late = made_up(0.05, overshoot=0.021), made_up(None, lacking=1)
    off = made_up(0.05, error=-1.1e-4)
    front = front_of(problem, [beaten, soft, wide, late, off, fast, middle])
    assert front == [fast, middle, soft]
    assert by_preference(front)[0] == 1
    # What cannot be told apart is there once, the first of it.
    twin = made_up(0.1001, 0.5, 2.0)
    assert front_of(problem, [fast, twin]) == [fast]
    with pytest.raises(FitError, match=r"not one of 2 .*2\.1 %.*--overshoot") as problem_found:
        front_of(problem, [late, wide])
    assert problem_found.value.exit_code == 3


def test_what_binds(problem):
    near = replace(made_up(0.1, overshoot=0.019), settings=(0.5, 0.995, 0.5, 0.5))
    kinds = [(each["kind"], each["figure"]) for each in binding(near, problem)]
    assert kinds == [
        *(("worst", name) for name in OBJECTIVES),
        ("limit", "overshoot"),
        ("end of travel", "P2"),
    ]


def test_a_search_gone_on_with_is_the_same(problem, found, tmp_path):
    plan = PLAN
    ran = []
    search(problem, replace(plan, generations=2), tmp_path)
    tried = search(problem, plan, tmp_path, step=ran.append)
    assert tried == found.tried
    assert len(ran) == 4 * 16
    assert search(problem, plan, tmp_path, step=ran.append) == tried
    assert len(ran) == 4 * 16
    for other in (replace(problem, largest_error=1e-3), replace(problem, largest_overshoot=0.1)):
        with pytest.raises(AnalogCardError, match="another study"):
            search(other, plan, tmp_path)
    with pytest.raises(AnalogCardError, match="another study"):
        search(problem, replace(plan, seed=4), tmp_path)


@pytest.mark.parametrize("figures", ['{"settings": [0.5]}', "{}", "[]"])
def test_a_damaged_generation_is_refused(problem, tmp_path, figures):
    plan = replace(PLAN, generations=1)
    search(problem, plan, tmp_path)
    kept = next(tmp_path.rglob("0000.jsonl"))
    lines = kept.read_text().splitlines()
    kept.write_text("\n".join([*lines[:2], f'{{"trial": 1, "figures": {figures}}}']) + "\n")
    with pytest.raises(AnalogCardError, match=r"0000\.jsonl: line 3 .*settings.*run again"):
        search(problem, plan, tmp_path)


def test_the_check_is_a_run_of_a_drawn_card_in_a_drawn_rig(problem, found):
    trials = run_check(problem, found.chosen.settings, 4, seed=4)
    assert trials == found.trials
    values = trials[2]["values"]
    assert values == drawn_rigs(problem, 4).values(2)
    assert 6.5e5 < values["supply.pressure"] < 7.7e5
    assert 1.825 < values["load.mass"] < 11.825
    time, demand = problem.campaign.time, problem.campaign.demand
    rig = problem.campaign.rig.with_values(values)
    plain = simulate(rig, time=time, demand=demand, controller=card_of(found.design))
    settling = max(step.settling_time for step in plain.step_responses())
    # Capacitors of 5 %: the surface is at most a tenth slower or faster, and every card differs.
    assert trials[2]["metrics"]["settling_time"] == pytest.approx(settling, rel=0.15)
    assert trials[2]["metrics"]["steady_state_error"] != trials[1]["metrics"]["steady_state_error"]
    # Never worse than the worst of the set, apart from what offset voltages do.
    for each in judged(problem, found.located, trials):
        if each.figure in ("settling_time", "control_effort"):
            assert each.within == 4
            assert each.highest <= each.limit == found.located.figures[each.figure]


def test_the_check_of_another_choice_goes_into_the_same_folder(problem, found, tmp_path):
    settings, ran = [each.settings for each in found.tried[:2]], []
    checked = [run_check(problem, each, 2, 4, tmp_path) for each in settings]
    assert checked[0] != checked[1]
    assert run_check(problem, settings[0], 2, 4, tmp_path, step=ran.append) == checked[0]
    assert ran == []


def test_the_check_counts_what_is_within(problem):
    worst = made_up(0.2, 0.1, 1.0)
    names = (*OBJECTIVES, *LIMITED)
    trials = [
        {"metrics": dict(zip(names, row, strict=True))}
        for row in ((0.1, 0.0, 1.1, 0.0, -2e-4), (0.3, 0.1, 0.9, 0.02, 5e-5), (None,) * 5)
    ]
    found = {each.figure: each for each in judged(problem, worst, trials)}
    assert [found[name].within for name in names] == [1, 2, 1, 2, 1]
    assert found["steady_state_error"].highest == 2e-4
    assert judged(problem, worst, []) == []


def test_the_summary_is_plain_and_complete(found):
    report = json.loads(json.dumps(summary(found)))
    chosen = report["front"][report["recommended"]["place"]]
    assert report["recommended"]["settings"] == chosen["settings"]
    assert list(chosen["settings"]) == list(POTENTIOMETERS)
    assert report["recommended"]["ohm"]["P1"] == pytest.approx(1e4 * chosen["settings"]["P1"])
    assert report["check"]["trials"] == 4
    turned = [getattr(found.design.turned, item.name) for item in fields(found.design.turned)]
    assert tuple(turned) == found.chosen.settings


def test_the_picture_shows_the_front(found):
    effort, chatter, settings = tuning_figure(found).axes
    assert settings.get_xlabel() == "settling time in the worst rig [ms]"
    assert (effort.get_ylabel(), chatter.get_ylabel()) == ("control effort [V]", "chatter [V]")
    drawn = effort.collections[1].get_offsets()
    times = [1e3 * each.figures["settling_time"] for each in found.front]
    np.testing.assert_allclose(drawn[:, 0], times)
    assert len(settings.get_lines()) == 4


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"controller": "sliding-mode"}, "no potentiometers"),
        ({"card": "circuit"}, "by its figures"),
        ({"vary": {"turned.level": "0.1, 0.2"}}, "what is looked for"),
        ({"vary": {"controller.level": "1, 2 V"}}, "what is looked for"),
        ({"vary": {"spool.null-bias:bias": "0, 0.02"}}, "side by side being of the baseline"),
        ({"vary": {"load.mas": "1 kg"}}, "load.mass"),
        ({"demand": "15 mm"}, "never changes"),
    ],
)
def test_what_is_no_problem(settings, says):
    with pytest.raises(InputError, match=says):
        tuning_problem(settings)


def test_a_recorded_demand_is_tuned_for(tmp_path):
    time = np.arange(600) * 1e-3
    demand = np.where(time < 0.1, 0.015, 0.02)
    path = tmp_path / "step.csv"
    write_recording(Recording("step", time, {"demand": demand, "displacement": demand}), path)
    problem = tuning_problem({"demand": str(path), "vary": {"load.mass": "1.8, 7 kg"}})
    np.testing.assert_array_equal(problem.campaign.demand, demand)
    worst = worst_by_batch(problem, problem.now)
    assert 0.05 < worst.figures["settling_time"] < 0.3


def test_what_is_no_search(problem):
    for plan in ({"population": 3}, {"generations": 0}, {"seed": -1}):
        with pytest.raises(InputError):
            Search(**plan)
    with pytest.raises(InputError, match="largest_error is 0"):
        replace(problem, largest_error=0.0)


def test_nothing_keeps_limits_that_nothing_can(problem):
    impossible = replace(problem, largest_error=1e-9)
    with pytest.raises(FitError, match="not one of 4 settings keeps"):
        run_tuning(impossible, Search(4, 1))


def test_a_repaired_rig_is_tuned_for_without_its_effects(tmp_path):
    model = tmp_path / "model.toml"
    model.write_text('[rig]\nkind = "single-axis"\n[effects."leakage.rod-seal"]\narea = 1e-8\n')
    problem = tuning_problem({"rig": str(model), "vary": {"load.mass": "1.8, 7 kg"}})
    assert problem.left_out == ("leakage.rod-seal",)
    assert not any(rig.effects for rig in problem.rigs)
