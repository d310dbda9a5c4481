"""Tolerance studies in open loop: drawing, statistics, keeping on, netlist against behaviour."""

import json
import math
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import netlists
from analog_card.amplifier_elements import netlist_elements
from analog_card.analyses import FrequencySweep, OperatingPoint
from analog_card.behaviour_elements import ZENERS, figure_name, nominal_elements, offset_name
from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.ngspice import Session
from analog_card.tolerance import PAIR, TEMPERATURE, Quantity, draw, elements_of, quantities
from analog_card.tolerance_figures import behaviour_figures, netlist_figures
from analog_card.tolerance_statistics import bounds, corners, importance, yield_within
from analog_card.tolerance_study import study_card, study_of
from analog_card.tolerance_trials import run_trials
from analog_card.tuning import tune

# What an independent study of the same card left out: drift, a spread of the op-amps' figures, a
# mismatch of the zeners, that of the resistors in the inverter.
STUDY = {
    "temperature.lowest": 298.15,
    "temperature.highest": 298.15,
    "zener.matching": 0.0,
    "operational_amplifier.offset_drift": 0.0,
    "operational_amplifier.bias_current": 1.0,
    "operational_amplifier.open_loop_gain": 1.0,
    "operational_amplifier.gain_bandwidth": 0.0,
    "operational_amplifier.slew_rate": 0.0,
    "operational_amplifier.positive_swing": 0.0,
    "operational_amplifier.negative_swing": 0.0,
}


COMMAND = Path(sys.executable).parent / "analog-card"
ANALYSES = (OperatingPoint(), FrequencySweep(1.0, 1e4, 5))


def changed(design, changes):
    return replace(design, tolerances=design.tolerances.with_changes(changes))


@pytest.fixture(scope="module")
def design():
    return load_design()


def squares(indices):
    return [{"square": index * index} for index in indices]


def test_a_card_in_the_middle_is_the_design(design):
    values = elements_of({}, changed(design, STUDY))
    nominal = nominal_elements(design) | {
        name: 0.0 for name in nominal_elements(design) if name.endswith("voffset")
    }
    assert values == pytest.approx(nominal, rel=1e-12)


def test_tolerances_and_temperature_move_what_they_should(design):
    design = changed(design, {"temperature.lowest": 288.15, "temperature.highest": 308.15})
    nominal = nominal_elements(design)
    drawn = {"temperature": 1.0, "P3": -1.0, "surface drift": 2.0, PAIR: -1.0}
    drawn |= {figure_name("surface", "open_loop_gain"): -1.0}
    drawn |= {figure_name("surface", "slew_rate"): 1.0}
    drawn |= {figure_name("surface", "positive_swing"): -0.5}
    moved = elements_of(drawn, design)
    ratio = {name: moved[name] / value for name, value in nominal.items() if value}
    # 10 K above 25 degC, by the coefficients of the design file.
    assert ratio["xtaps.xvelocity.rfeedback"] == pytest.approx(1 + 10 * 50e-6)
    assert ratio["xdifference.rground"] == pytest.approx(1 + 10 * 25e-6)
    assert ratio["xtaps.xvelocity.cinput"] == pytest.approx(1 - 10 * 200e-6)
    assert ratio["xboundary.xpotentiometer.rlower"] == pytest.approx(0.8 * (1 + 10 * 100e-6))
    assert moved[offset_name("surface")] == pytest.approx(2 * 8e-6 * 10)
    zener = nominal["xlimiter.dupper[bv]"]
    drifted = zener * (1 - 0.05 + 10 * 400e-6) - 10 * 2e-3
    assert moved["xlimiter.dupper[bv]"] == pytest.approx(drifted, rel=1e-12)
    assert moved["xlimiter.dlower[bv]"] == moved["xlimiter.dupper[bv]"]
    assert ratio[figure_name("surface", "open_loop_gain")] == pytest.approx(1 / 5)
    assert ratio[figure_name("surface", "slew_rate")] == pytest.approx(1.25)
    assert moved[figure_name("surface", "positive_swing")] == pytest.approx(12.5)
    assert ratio[figure_name("velocity", "slew_rate")] == 1


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
    # What has no part in it is not named.
    assert list(found) == ["a", "b"]
    # Rank correlation of normal variables: 6/pi asin(r/2); chance about 1/sqrt(4000).
    rank = 6 / math.pi * math.asin(math.sqrt(0.8) / 2)
    assert found["a"] == pytest.approx(rank**2, abs=0.03)


def test_importance_names_by_chance_one_study_in_twenty():
    random = np.random.default_rng(7)
    named = 0
    for _ in range(200):
        drawn = [dict(enumerate(random.random(20))) for _ in range(50)]
        named += bool(importance(drawn, random.random(50).tolist()))
    # 10 of 200 expected, standard deviation 3.1.
    assert named <= 10 + 3 * 3.1


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


@pytest.mark.ngspice
@pytest.mark.parametrize(
    ("jobs", "trials", "netlist_trials", "file"),
    [(1, 10, 8, "netlist.jsonl"), (2, 250, 0, "behaviour.jsonl")],
)
def test_a_killed_study_goes_on_and_gives_the_same(tmp_path, jobs, trials, netlist_trials, file):
    arguments = ["tolerance", "--trials", str(trials), "--netlist-trials", str(netlist_trials)]
    arguments += ["--json", "--out"]
    whole = CliRunner().invoke(main, [*arguments, str(tmp_path / "whole")])
    killed = [COMMAND, *arguments, str(tmp_path / "killed"), "--jobs", str(jobs)]
    store = tmp_path / "killed" / file
    process = subprocess.Popen(killed, stdout=subprocess.DEVNULL, start_new_session=True)
    # Killed midway: some trials are in the file, some are not.
    while process.poll() is None and trials_in(store) < 2:
        time.sleep(0.01)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    assert 2 <= trials_in(store) < max(trials, netlist_trials)
    # Nothing of it is left running.
    until = time.monotonic() + 20
    while processes_of(process.pid) and time.monotonic() < until:
        time.sleep(0.05)
    assert not processes_of(process.pid)
    kept = store.read_text()
    again = subprocess.run(killed, capture_output=True, text=True, check=True)
    assert store.read_text().startswith(kept)
    assert again.stdout == whole.stdout
    assert (tmp_path / "killed/tolerance.json").read_text() == whole.stdout
    # To the last digit, whatever ran before a trial in the same process.
    lines = (tmp_path / "whole" / file).read_text().splitlines()
    assert sorted(store.read_text().splitlines()) == sorted(lines)


def trials_in(store):
    return store.read_text().count('"trial"') if store.exists() else 0


def processes_of(session):
    """Return the processes that run in a session, by their ids."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, of, *_ = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(of) == session and state != "Z":
            found.append(stat.parent.name)
    return found


@pytest.mark.parametrize(
    "content",
    [
        "my notes\n",
        '{"my": "precious data, one line, no newline"}',
        '{"study": "squares"}\n{"trial": 1e400, "figures": {}}\n',
        '{"study": "squares"}\n' + "[" * 100_000 + "\n",
    ],
    ids=["a line", "half a line", "no number", "deep"],
)
def test_a_file_of_something_else_is_refused(tmp_path, content):
    store = tmp_path / "notes.txt"
    store.write_text(content)
    with pytest.raises(InputError, match=r"notes\.txt: not a file of trials .*; name another"):
        run_trials(squares, 3, "squares", store)
    assert store.read_text() == content


@pytest.mark.parametrize("begun", ["", '{"stu', '{"study": "squares"}'])
def test_a_study_stopped_in_its_first_line_begins_again(tmp_path, begun):
    store = tmp_path / "trials.jsonl"
    store.write_text(begun)
    assert run_trials(squares, 3, "squares", store) == squares(range(3))
    assert len(store.read_text().splitlines()) == 1 + 3


def test_parallel_is_identical_to_serial(design):
    from analog_card.tolerance_study import _behaviour_trials

    trial = partial(_behaviour_trials, design, 5)
    assert run_trials(trial, 25, "x", jobs=2) == run_trials(trial, 25, "x", jobs=1)


@pytest.mark.ngspice
def test_netlist_and_behaviour_agree_on_every_card(design):
    items = quantities(design)
    cards = [elements_of(draw(items, 11, index), design) for index in range(10)]
    for card, measured in zip(cards, netlist_figures(design, cards), strict=True):
        computed = behaviour_figures(design, card)
        for name in ("displacement_weight", "velocity_weight", "boundary_layer"):
            # The second pole and the output resistances that the behaviour leaves out.
            assert computed[name] == pytest.approx(measured[name], rel=3e-4)
        assert computed["rest_error"] == pytest.approx(measured["rest_error"], abs=1e-7)
        for name in ("level_high", "level_low"):
            assert computed[name] == pytest.approx(measured[name], abs=2e-3)
        assert computed["level_asymmetry"] == pytest.approx(measured["level_asymmetry"], abs=1e-4)
        # The behaviour runs from the swing under load, the circuit from that ahead of the output
        # resistance: 60 ohm in about 2 kohm are 3 % of the way and half of that in time.
        assert computed["relay_delay"] == pytest.approx(measured["relay_delay"], rel=0.015)


@pytest.mark.ngspice
@pytest.mark.parametrize(("settling_time", "layer"), [(0.15, 5.0), (0.25, 1.0), (0.5, 15.0)])
def test_netlist_and_behaviour_agree_whatever_a_card_is_turned_to(settling_time, layer):
    # A demand hardly moves slow surfaces, and offsets saturate the amplifier of narrow layers.
    turned = tune(settling_time, boundary_layer=layer).design
    items = quantities(turned)
    cards = [elements_of(draw(items, 11, index), turned) for index in range(2)]
    for card, measured in zip(cards, netlist_figures(turned, cards), strict=True):
        computed = behaviour_figures(turned, card)
        for name in ("displacement_weight", "boundary_layer", "rest_error", "level_asymmetry"):
            assert computed[name] == pytest.approx(measured[name], rel=3e-4), name
        for name in ("level_high", "level_low"):
            assert computed[name] == pytest.approx(measured[name], abs=2e-3)
        assert computed["relay_delay"] == pytest.approx(measured["relay_delay"], rel=0.015)


def test_a_figure_that_no_card_has_keeps_no_other_back(design):
    trials = [{"a": float(index), "b": None} for index in range(5)]
    study = study_of(
        design, 0, {"a": "m", "b": "s"}, {"a": 1.0, "b": None}, trials,
        lambda cards: [{"a": 1.0, "b": None} for _ in cards],
    )  # fmt: skip
    one, other = study.spreads
    assert (one.mean, one.failed) == (2.0, 0)
    assert math.isnan(other.mean)
    assert (other.failed, other.important) == (5, {})


@pytest.mark.ngspice
@pytest.mark.parametrize("celsius", [0.0, 70.0])
def test_netlist_and_behaviour_agree_in_cold_and_heat(design, celsius):
    # The netlist works out its values at a temperature itself; they must be those of the behaviour.
    warm = nominal_elements(design, temperature=celsius + 273.15)
    parameters = design.netlist_parameters(celsius + 273.15)
    with Session(netlists.BENCHES / "channel-ac.cir", parameters) as session:
        alone = [session.run(analysis)["control"] for analysis in ANALYSES]
        elements = netlist_elements(warm, design.soldered.operational_amplifier)
        session.change({f"xone.{name}": value for name, value in elements.items()})
        told = [session.run(analysis)["control"] for analysis in ANALYSES]
    for one, other in zip(alone, told, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    # Both are warmer than the card at 25 degC, where they differ by more than this.
    (measured,) = netlist_figures(design, [warm])
    computed, nominal = behaviour_figures(design, warm), behaviour_figures(design, {})
    for name, least in (("displacement_weight", 5e-3), ("velocity_gain", 3e-3)):
        assert computed[name] == pytest.approx(measured[name], rel=3e-4)
        assert abs(computed[name] / nominal[name] - 1) > least
    # Drift of 8 uV/K over 25 or 45 K, of the offset of 5 mV that makes 81 um.
    assert computed["rest_error"] == pytest.approx(measured["rest_error"], abs=1e-7)
    assert abs(computed["rest_error"] / nominal["rest_error"] - 1) > 0.03
    assert computed["level_high"] == pytest.approx(measured["level_high"], abs=2e-3)


@pytest.mark.parametrize(
    ("changes", "error", "gain", "phase", "c1", "c2", "asymmetry"),
    [
        ({"matched_resistor.tolerance": 0.01}, 0.25, 0.041, 0.23, 0.043, 0.030, 0.0019),
        ({}, 0.20, 0.041, 0.23, 0.042, 0.030, 0.0019),
        (
            {
                "matched_resistor.tolerance": 0.01,
                "capacitor.tolerance": 0.01,
                "operational_amplifier.offset_voltage": 0.0,
            },
            0.13, 0.011, 0.06, 0.016, 0.012, 0.0,
        ),
        (
            {
                "resistor.tolerance": 0.001,
                "capacitor.tolerance": 0.01,
                "operational_amplifier.offset_voltage": 2e-3,
                "zener.tolerance": 0.02,
            },
            0.073, 0.008, 0.05, 0.008, 0.006, 0.0008,
        ),
    ],
)  # fmt: skip
def test_spreads_are_those_of_an_independent_study(
    design, changes, error, gain, phase, c1, c2, asymmetry
):
    # An independent study of 200 cards each, as here; of both studies' standard deviations the
    # standard error is 5 %, three of which make 21 %. Half of its last digit, and P1 and P2,
    # whose tracks it left exact: 20 % of a source resistance of 2.5 kohm in 100 and 51 kohm.
    study = study_card(changed(design, STUDY | changes), count=200, netlist_count=0)
    found = {spread.figure: spread for spread in study.spreads}

    def relative(name):
        return found[name].deviation / abs(found[name].nominal)

    assert found["rest_error"].deviation * 1e3 == pytest.approx(error, rel=0.21, abs=0.005)
    assert relative("acceleration_gain") == pytest.approx(gain, rel=0.21, abs=5e-4)
    assert found["acceleration_phase"].deviation == pytest.approx(phase, rel=0.21, abs=5e-3)
    assert relative("displacement_weight") == pytest.approx(c1, rel=0.21, abs=3e-3)
    assert relative("velocity_weight") == pytest.approx(c2, rel=0.21, abs=5e-3)
    # Both zeners are one draw there: what is left is 2/5 V of the output follower's offset, and
    # 0.01 % by the current of the zeners, which differs with the side.
    assert found["level_asymmetry"].deviation == pytest.approx(asymmetry, rel=0.21, abs=1e-4)


def test_zeners_that_do_not_match_spoil_the_symmetry(design):
    apart = {**STUDY, "zener.tolerance": 0.0, "zener.matching": 0.05}
    apart["operational_amplifier.offset_voltage"] = 0.0
    study = study_card(changed(design, apart), count=200, netlist_count=0)
    found = {spread.figure: spread for spread in study.spreads}
    # 5 % of 6.1 V of breakdown, evenly spread, of each, in a level of 6.9 V: three standard errors
    # of a standard deviation of even numbers, sqrt(0.8/4/200).
    expected = math.sqrt(2) * 0.05 / math.sqrt(3) * nominal_elements(design)[ZENERS[0]] / 6.9
    assert found["level_asymmetry"].deviation == pytest.approx(expected, rel=3 * 0.032)
    assert set(found["level_asymmetry"].important) == set(ZENERS)


@pytest.mark.ngspice
def test_no_card_with_everything_at_its_ends_is_beyond_the_corners(design):
    items, random = quantities(design), np.random.default_rng(8)
    ends = [
        {item.name: float(random.choice([-1, 1])) * item.extreme for item in items}
        for _ in range(150)
    ]
    cards = [elements_of(card, design) for card in ends]
    figures = [behaviour_figures(design, card) for card in cards]
    for spread in study_card(design, count=2, netlist_count=0).spreads:
        found = [each[spread.figure] for each in figures]
        assert spread.corner_low < min(found) < max(found) < spread.corner_high
    # Also so far out the circuit does what the behaviour says.
    for computed, measured in zip(figures, netlist_figures(design, cards[:2]), strict=False):
        assert computed["displacement_weight"] == pytest.approx(
            measured["displacement_weight"], rel=3e-4
        )
        assert computed["rest_error"] == pytest.approx(measured["rest_error"], abs=1e-7)


@pytest.mark.parametrize("celsius", [(0.0, 50.0), (-25.0, 25.0)])
def test_the_corners_have_every_drift_the_same_way(design, celsius):
    # Nothing but drifts of 8 uV/K, which are nothing at 25 degC: the error at rest is linear in
    # them, so that its worst cases are apart by twice the sum of what each does alone.
    parts = ("resistor", "matched_resistor", "capacitor", "potentiometer", "zener")
    nothing = dict.fromkeys((f"{part}.tolerance" for part in parts), 0.0)
    lowest, highest = (value + 273.15 for value in celsius)
    drift = {
        "operational_amplifier.offset_voltage": 0.0,
        "operational_amplifier.offset_drift": 8e-6,
        "temperature.lowest": lowest,
        "temperature.highest": highest,
    }
    only = changed(design, STUDY | nothing | drift)
    far = max((-1.0, 1.0), key=lambda end: abs(np.mean(celsius) + 25.0 * end - 25.0))
    drifts = [item for item in quantities(only) if item.name.endswith(" drift")]
    none, *alone = (
        behaviour_figures(only, elements_of({TEMPERATURE: far} | card, only))["rest_error"]
        for card in ({}, *({item.name: item.extreme} for item in drifts))
    )
    expected = 2.0 * np.sum(np.abs(np.subtract(alone, none)))
    (spread,) = (each for each in study_card(only, 2, 0).spreads if each.figure == "rest_error")
    assert spread.corner_high - spread.corner_low == pytest.approx(expected, rel=0.02)


def test_capacitors_matter_most_for_the_acceleration(design):
    study = study_card(design, count=150, netlist_count=0)
    found = {spread.figure: spread for spread in study.spreads}
    first_two = list(found["acceleration_gain"].important)[:2]
    assert set(first_two) == {"xtaps.xvelocity.cinput", "xtaps.xacceleration.cinput"}
    assert next(iter(found["rest_error"].important)) == offset_name("surface")
    gain_bandwidth = figure_name("boundary_layer", "gain_bandwidth")
    assert next(iter(found["relay_delay"].important)) == gain_bandwidth
    assert found["relay_delay"].important[gain_bandwidth] > 0.9
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
        ("--resistor=2", "from 0 to less than 1"),
        ("--lowest-temperature=90", "the lowest comes first"),
        ("--bias-current=0.5", "a factor of 1 or more"),
    ],
)
def test_bad_options_exit_with_status_2(option, said):
    result = CliRunner().invoke(main, ["tolerance", option])
    assert result.exit_code == 2
    assert said in result.output
