"""The bench procedure, on cards whose right settings are known."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.behaviour import Imperfections
from analog_card.design_file import load_design
from analog_card.tuning import read_settings, tune
from pneuservo.bench_tuning import bench_tune, effective_settings, match_response, satisfactory
from pneuservo.command_line import main
from pneuservo.controllers import SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 0.3, 5e-4)
DEMAND = np.where(TIME < 0.02, 0.015, 0.024)


def response(design, elements=None):
    return simulate(time=TIME, demand=DEMAND, controller=card_of(design, elements=elements))


def displacement(design):
    return response(design)["displacement"]


def quick(design):
    """Return the displacement with the card by its figures alone, ten times as fast."""
    card = card_of(design, Imperfections.none())
    return simulate(time=TIME, demand=DEMAND, controller=card)["displacement"]


def test_settings_are_found_again():
    right, wrong = tune(0.07).design, tune(0.1, damping=0.8).design
    found = match_response(quick, quick(right), wrong)
    # The target can be met exactly; the search ends at 1e-4 of travel, the derivatives it uses are
    # good to 1e-3: half a per cent of the weights is easily reached.
    assert found.after < 0.01 * found.before
    assert read_settings(found.design).achieved["c1"] == pytest.approx(3265.3, rel=5e-3)
    assert read_settings(found.design).achieved["c2"] == pytest.approx(114.286, rel=5e-3)


def test_a_recording_says_how_far_to_turn_a_card_with_wrong_parts():
    # R1 10 % large: P1 has to be turned up for the same weight.
    design = load_design()
    off = {"xsurface.xdisplacement.rinput": 110e3}
    recorded = response(design, off)["displacement"]
    found = effective_settings(recorded, displacement, displacement(design), design)
    turned = response(found.design, off)["displacement"]
    assert found.design.turned.displacement_weight > design.turned.displacement_weight
    difference = turned - displacement(design)
    # The part acts as P1 does but for the load of the wiper: nine tenths of the difference go.
    assert np.std(difference) < 0.1 * found.before


def test_the_layer_is_the_narrowest_that_is_quiet():
    found = bench_tune(load_design(), SlidingMode(0.07), TIME, DEMAND)
    # An independent study of this card: limit cycle below 4.6 m/s2, with another plant.
    assert found.boundary_layer == pytest.approx(4.6, rel=0.15)
    quiet = [layer for layer, ok in found.tried if ok]
    loud = [layer for layer, ok in found.tried if not ok]
    assert found.boundary_layer == min(quiet)
    # Raised until it is quiet, then found to 2 %.
    assert 1.0 < min(quiet) / max(loud) < 1.025
    assert satisfactory(response(found.design))
    assert found.match.after <= found.match.before


def test_a_demand_without_a_step_is_refused():
    with pytest.raises(InputError, match="never changes"):
        bench_tune(load_design(), SlidingMode(0.07), TIME, np.full(len(TIME), 0.015))


def test_responses_of_other_lengths_are_refused():
    with pytest.raises(InputError, match="samples"):
        match_response(displacement, np.zeros(3), load_design())


def test_the_command_turns_a_recorded_card(tmp_path):
    recording, out = tmp_path / "step.csv", tmp_path / "tuned.toml"
    table = np.column_stack([TIME, DEMAND, displacement(load_design())])
    np.savetxt(recording, table, delimiter=",", header="time,demand,displacement", comments="")
    result = CliRunner().invoke(
        main, ["bench-tune", "--recording", str(recording), "--out", str(out), "--json"]
    )
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert set(found["settings"]) == {"P1", "P2", "P3", "P4"}
    written = load_design(out).turned
    assert written.boundary_layer == pytest.approx(found["settings"]["P3"]["fraction"], rel=1e-9)
    # The recording is of the card itself: it seems to stand where it stands, and turns as far as
    # the search for the ideal response says, which leaves less than it was.
    assert found["difference"]["after"] <= found["difference"]["before"]
    assert found["achieved"]["c1"] == pytest.approx(3265.3, rel=0.3)


def test_a_recording_without_a_demand_is_refused(tmp_path):
    recording = tmp_path / "step.csv"
    table = np.column_stack([TIME, DEMAND])
    np.savetxt(recording, table, delimiter=",", header="time,displacement", comments="")
    result = CliRunner().invoke(main, ["bench-tune", "--recording", str(recording)])
    assert result.exit_code == 2
    assert "no channel demand" in result.stderr


def test_the_detectable_command_prints_the_thesis_tables():
    result = CliRunner().invoke(main, ["detectable", "--threshold", "3.98 um", "--json"])
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert found["with_valve"]["extend"] == pytest.approx([204, 165, 196], rel=0.01)
    shown = CliRunner().invoke(main, ["detectable"])
    assert "3.662 um" in shown.stdout
