"""Tolerance studies in open loop: drawing, statistics, keeping on, netlist against behaviour."""

import json
import math
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.behaviour_elements import nominal_elements, offset_name
from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.tolerance import Quantity, Tolerances, draw, elements_of, quantities
from analog_card.tolerance_figures import behaviour_figures, netlist_figures
from analog_card.tolerance_statistics import bounds, corners, importance, yield_within
from analog_card.tolerance_study import study_card
from analog_card.tolerance_trials import run_trials

# Without drift: as the published study of the same card had it.
STUDY = {"lowest_temperature": 25.0, "highest_temperature": 25.0, "offset_drift": 0.0}


@pytest.fixture(scope="module")
def design():
    return load_design()


def squares(indices):
    return [{"square": index * index} for index in indices]


def test_a_card_in_the_middle_is_the_design(design):
    tolerances = Tolerances(lowest_temperature=25, highest_temperature=25)
    values = elements_of({}, design, tolerances)
    nominal = nominal_elements(design) | {
        name: 0.0 for name in nominal_elements(design) if name.endswith("voffset")
    }
    assert values == pytest.approx(nominal, rel=1e-12)


def test_tolerances_and_temperature_move_what_they_should(design):
    tolerances = Tolerances(lowest_temperature=15, highest_temperature=35)
    nominal = nominal_elements(design)
    moved = elements_of({"temperature": 1.0, "P3": -1.0, "surface drift": 2.0}, design, tolerances)
    ratio = {name: moved[name] / value for name, value in nominal.items() if value}
    assert ratio["xtaps.xvelocity.rfeedback"] == pytest.approx(1 + 10 * 50e-6)
    assert ratio["xtaps.xvelocity.cinput"] == pytest.approx(1 - 10 * 200e-6)
    assert ratio["xboundary.xpotentiometer.rlower"] == pytest.approx(0.8 * (1 + 10 * 50e-6))
    assert moved[offset_name("surface")] == pytest.approx(2 * 8e-6 * 10)


def test_draws_have_the_distributions_stated():
    items = (Quantity("even", 0.01), Quantity("normal", 5e-3, normal=True))
    drawn = [draw(items, 3, index) for index in range(4000)]
    even = np.array([d["even"] for d in drawn])
    normal = np.array([d["normal"] for d in drawn])
    assert np.abs(even).max() <= 1
    # Standard errors of the deviations: 0.58 0.45/sqrt(4000), 1/sqrt(8000); five of them.
    assert even.std() == pytest.approx(1 / math.sqrt(3), abs=0.02)
    assert normal.std() == pytest.approx(1, abs=0.056)


def test_bounds_hold_their_content(design):
    # 400 studies of 100: bounds for 90 % at 95 % confidence fail at most 5 % of the time, plus
    # three standard errors of 1.1 %.
    random = np.random.default_rng(1)
    failures = 0
    for _ in range(400):
        found = bounds(random.random(100).tolist(), content=0.9)
        failures += (found.high - found.low) < 0.9
    assert failures / 400 < 0.05 + 3 * 0.011
    few = bounds(range(10))
    assert (few.low, few.high) == (0, 9)
    assert few.confidence == pytest.approx(1 - 10 * 0.95**9 + 9 * 0.95**10)


def test_importance_is_the_share_of_the_variance():
    random = np.random.default_rng(2)
    drawn = [dict(zip("abc", random.standard_normal(3), strict=True)) for _ in range(4000)]
    found = importance(drawn, [2 * d["a"] + d["b"] for d in drawn])
    assert list(found) == ["a", "b", "c"]
    # Rank correlation of normal variables: 6/pi asin(r/2); chance about 1/sqrt(4000).
    rank = 6 / math.pi * math.asin(math.sqrt(0.8) / 2)
    assert found["a"] == pytest.approx(rank**2, abs=0.03)
    assert found["c"] < 0.005


def test_corners_find_both_ends_of_a_sum():
    found = corners(
        lambda cards: [{"y": 3 * d["a"] - d["b"], "z": d["b"]} for d in cards], {"a": 1.0, "b": 3.0}
    )
    assert found == {"y": (-6.0, 6.0), "z": (-3.0, 3.0)}


def test_yield_counts_what_is_within_and_not_a_number_is_not():
    trials = [{"x": value} for value in (1.0, 2.0, math.nan, 4.0)]
    assert yield_within(trials, {"x": (0.0, 3.0)}).share == 0.5
    with pytest.raises(InputError, match="there is x"):
        yield_within(trials, {"y": (0.0, 1.0)})


def test_a_stopped_study_goes_on_and_gives_the_same(tmp_path):
    store = tmp_path / "trials.jsonl"
    asked = []

    def trial(indices):
        for index in indices:
            if index == 13 and not asked:
                asked.append(index)
                raise KeyboardInterrupt
            yield {"square": index * index}

    with pytest.raises(KeyboardInterrupt):
        run_trials(trial, 30, "squares", store)
    assert len(store.read_text().splitlines()) == 1 + 13
    with store.open("a") as stream:
        stream.write('{"trial": 13, "fig')  # killed in the middle of a line
    ran = []

    def rest(indices):
        ran.extend(indices)
        return squares(indices)

    assert run_trials(rest, 30, "squares", store) == squares(range(30))
    assert ran == list(range(13, 30))
    assert run_trials(squares, 30, "squares", store) == squares(range(30))
    with pytest.raises(InputError, match="another study"):
        run_trials(squares, 30, "cubes", store)


def test_a_file_of_something_else_is_refused(tmp_path):
    store = tmp_path / "notes.txt"
    store.write_text("my notes\n")
    with pytest.raises(InputError, match="not a file of trials"):
        run_trials(squares, 3, "squares", store)
    assert store.read_text() == "my notes\n"


def test_parallel_is_identical_to_serial(design):
    from analog_card.tolerance_study import _behaviour_trials

    trial = partial(_behaviour_trials, design, Tolerances(), 5)
    assert run_trials(trial, 25, "x", jobs=2) == run_trials(trial, 25, "x", jobs=1)


@pytest.mark.ngspice
def test_netlist_and_behaviour_agree_on_every_card(design):
    tolerances = Tolerances()
    items = quantities(design, tolerances)
    cards = [elements_of(draw(items, 11, index), design, tolerances) for index in range(12)]
    for card, measured in zip(cards, netlist_figures(design, cards), strict=True):
        computed = behaviour_figures(design, card)
        for name in ("displacement_weight", "velocity_weight", "boundary_layer"):
            # The second pole and the output resistances that the behaviour leaves out.
            assert computed[name] == pytest.approx(measured[name], rel=3e-4)
        assert computed["rest_error"] == pytest.approx(measured["rest_error"], abs=1e-7)
        for name in ("level_high", "level_low"):
            assert computed[name] == pytest.approx(measured[name], abs=2e-3)


@pytest.mark.parametrize(
    ("changes", "error", "gain", "phase", "c1", "c2"),
    [
        ({"matched_resistor": 0.01}, 0.25, 0.041, 0.23, 0.043, 0.030),
        ({}, 0.20, 0.041, 0.23, 0.042, 0.030),
        (
            {"matched_resistor": 0.01, "capacitor": 0.01, "offset_voltage": 0.0},
            0.13, 0.011, 0.06, 0.016, 0.012,
        ),
        (
            {"resistor": 0.001, "capacitor": 0.01, "offset_voltage": 2e-3, "zener": 0.02},
            0.073, 0.008, 0.05, 0.008, 0.006,
        ),
    ],
)  # fmt: skip
def test_spreads_are_those_of_an_independent_study(design, changes, error, gain, phase, c1, c2):
    # An independent study of 200 cards each; of both studies' standard deviations the standard
    # error is 5 % and 3.5 %, three of which make 19 %. Half of its last digit, and P1 and P2,
    # whose tracks it left exact: 20 % of a source resistance of 2.5 kohm in 100 and 51 kohm.
    study = study_card(design, Tolerances(**STUDY, **changes), count=400, netlist_count=0)
    found = {spread.figure: spread for spread in study.spreads}

    def relative(name):
        return found[name].deviation / abs(found[name].nominal)

    assert found["rest_error"].deviation * 1e3 == pytest.approx(error, rel=0.19, abs=0.005)
    assert relative("acceleration_gain") == pytest.approx(gain, rel=0.19, abs=5e-4)
    assert found["acceleration_phase"].deviation == pytest.approx(phase, rel=0.19, abs=5e-3)
    assert relative("displacement_weight") == pytest.approx(c1, rel=0.19, abs=3e-3)
    assert relative("velocity_weight") == pytest.approx(c2, rel=0.19, abs=5e-3)


def test_capacitors_matter_most_for_the_acceleration(design):
    study = study_card(design, count=300, netlist_count=0)
    found = {spread.figure: spread for spread in study.spreads}
    first_two = list(found["acceleration_gain"].important)[:2]
    assert set(first_two) == {"xtaps.xvelocity.cinput", "xtaps.xacceleration.cinput"}
    assert next(iter(found["rest_error"].important)) == offset_name("surface")
    for spread in study.spreads:
        assert spread.corner_low < spread.low < spread.high < spread.corner_high


@pytest.mark.ngspice
def test_command_prints_json_and_keeps_trials(tmp_path):
    arguments = ["tolerance", "--trials", "30", "--netlist-trials", "2", "--json"]
    arguments += ["--limit", "rest_error=-0.3mm..0.3mm", "--out", str(tmp_path)]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    found = json.loads(result.output)
    assert found["yield"]["share"] > 0.5
    assert {figure["figure"] for figure in found["figures"]} >= {"rest_error", "level_high"}
    assert len((tmp_path / "behaviour.jsonl").read_text().splitlines()) == 31
    assert CliRunner().invoke(main, arguments).output == result.output


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("--limit=rest_error", "FIGURE=LOW..HIGH"),
        ("--limit=rest=0..1", "the figures are"),
        ("--limit=rest_error=0V..1V", "a length is needed"),
        ("--resistor=2", "not from 0 to 1"),
        ("--lowest-temperature=90", "the lowest comes first"),
    ],
)
def test_bad_options_exit_with_status_2(option, said):
    result = CliRunner().invoke(main, ["tolerance", option])
    assert result.exit_code == 2
    assert said in result.output
