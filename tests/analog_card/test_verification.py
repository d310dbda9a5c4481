"""Netlist against behaviour: the recommended card, another, and a model that lacks something."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.behaviour import Imperfections
from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.verification import Deviation, verify
from analog_card.verification_plot import picture

pytestmark = pytest.mark.ngspice


@pytest.fixture(scope="module")
def result():
    return verify()


def test_every_stage_and_every_transient_is_compared_and_passes(result):
    assert result.passed
    assert {item.quantity for item in result.deviations} == {
        "gain", "phase", "sine", "triangle", "step", "overload", "relay",
    }  # fmt: skip
    assert len({item.stage for item in result.deviations if item.quantity == "gain"}) == 12
    limits = {item.unit: item.limit for item in result.deviations}
    assert limits == {"dB": 0.1, "degree": 1.0, "% of range": 1.0}


def test_the_frequency_response_agrees_far_better_than_the_limit(result):
    # Left out: second pole and input capacitances, 20 kHz squared over (9 MHz x 140 kHz) at worst.
    gains = [item.worst for item in result.deviations if item.quantity == "gain"]
    phases = [item.worst for item in result.deviations if item.quantity == "phase"]
    assert max(gains) < 0.01
    assert max(phases) < 0.15


def test_the_overload_saturates_both_taps_and_recovers(result):
    case = next(item for item in result.transients if item.name == "overload")
    assert case.netlist["first"].min() < -14
    assert case.netlist["second"].max() > 13
    assert abs(case.netlist["second"][-1]) < 0.1


def test_another_card_passes_too():
    design = load_design()
    parts = design.soldered
    design = replace(
        design,
        soldered=replace(
            parts,
            velocity_differentiator=replace(
                parts.velocity_differentiator, resistance=100e3, feedback_capacitance=330e-12
            ),
            acceleration_differentiator=replace(
                parts.acceleration_differentiator, capacitance=82e-9, series_resistance=680
            ),
            operational_amplifier=replace(
                parts.operational_amplifier, gain_bandwidth=3e6, output_resistance=100.0
            ),
        ),
    )
    failed = [item for item in verify(design).deviations if not item.passed]
    assert not failed


def test_a_model_without_saturation_fails_in_the_overload():
    found = verify(imperfections=Imperfections().without("saturation"))
    failed = {(item.stage, item.quantity) for item in found.deviations if not item.passed}
    assert ("first", "overload") in failed
    assert not {quantity for _, quantity in failed} & {"gain", "phase"}


def test_numbers_and_pictures(result):
    numbers = json.loads(json.dumps(result.to_dict()))
    assert numbers["passed"] is True
    assert {"stage", "worst", "limit", "at", "unit", "passed"} <= numbers["deviations"][0].keys()

    from matplotlib.figure import Figure

    axes = Figure().subplots(2, 2).ravel()
    assert result.plot(axes) is axes
    for axis in axes:
        assert axis.get_xlabel()
        assert axis.get_ylabel()
        assert axis.has_data()
    assert picture(result).startswith(b"\x89PNG")


def test_only_what_switches_is_allowed_play_and_only_where_it_needs_it(result):
    played = {(item.stage, item.quantity) for item in result.deviations if item.play}
    switched = {"comparator", "clamped", "control"}
    assert played == {(node, case) for node in switched for case in ("step", "overload", "relay")}
    for item in result.deviations:
        assert item.play in (0.0, 1e-6)
        if item.play:
            assert item.worst < item.limit < item.without_play
        else:
            assert item.worst == item.without_play


def test_play_is_one_microsecond(result):
    case = result.transients[0]
    late = {node: np.roll(wave, 1) for node, wave in case.netlist.items()}
    later = {node: np.roll(wave, 3) for node, wave in case.netlist.items()}
    inside = slice(5, -5)
    assert replace(case, model=late).deviation("comparator", 1e-6)[inside].max() == 0
    assert replace(case, model=late).deviation("comparator")[inside].max() > 0
    assert replace(case, model=later).deviation("comparator", 1e-6)[inside].max() > 1


def test_the_table_says_where_edges_may_shift():
    done = CliRunner().invoke(main, ["verify"], env={"COLUMNS": "140"})
    assert done.exit_code == 0, done.output
    assert re.search(r"control .* overload .* pass, edges ±1 µs; without 1\d %", done.output)
    assert re.search(r"control .* sine .* pass *│$", done.output, re.MULTILINE)
    assert "Edges: behind the boundary-layer amplifier" in done.output


def test_a_deviation_beyond_its_limit_fails():
    assert not Deviation("first", "gain", "dB", "", 0.2, 1e3, 0.1, 0.0, 0.2).passed
