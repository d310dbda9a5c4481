"""Tolerance studies in closed loop."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.command_line.tolerance import parsed_limits
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.tolerance import draw, elements_of, quantities
from analog_card.tolerance_figures import behaviour_figures
from analog_card.tolerance_trials import run_trials
from analog_card.tuning import with_transducer_gain
from pneuservo.circuit_loop import simulate_circuit_loop
from pneuservo.command_line import main
from pneuservo.controllers import card_of
from pneuservo.rigs import Transducer, load_rig
from pneuservo.simulation import simulate
from pneuservo.tolerance import ALL_FIGURES, _trials, closed_loop_figures, study_loop


@pytest.fixture(scope="module")
def design():
    return load_design()


def test_figures_of_the_recommended_card(design):
    found = closed_loop_figures(design, {}, load_rig("single-axis"))
    # A like plant in an independent study: 43.8 ms, 126 ms, none, 167 Hz, 6.9 m/s2; its friction
    # and discharge coefficients were simpler.
    assert found["rise_time"] == pytest.approx(43.8e-3, rel=0.03)
    assert found["settling_time"] == pytest.approx(0.126, rel=0.1)
    assert found["chatter"] < 0.01
    assert found["limit_cycle_frequency"] == pytest.approx(167, rel=0.03)
    assert found["limit_cycle_amplitude"] == pytest.approx(6.9, rel=0.05)


def test_the_loop_is_that_of_the_rigs_transducer(design):
    # The same card on the same rig, whatever its design has for a transducer.
    rig, other = load_rig("single-axis"), with_transducer_gain(design, 200.0)
    assert closed_loop_figures(other, {}, rig) == pytest.approx(
        closed_loop_figures(design, {}, rig)
    )


def test_the_loop_holds_where_the_open_loop_says(design):
    items = quantities(design)
    for index in range(2):
        elements = elements_of(draw(items, 0, index), design)
        loop = closed_loop_figures(design, elements, load_rig("single-axis"))
        if loop["chatter"] > 0.1:
            continue
        at_rest = behaviour_figures(design, elements)["rest_error"]
        # 24 mm of 30 mm is the share of full scale that the open-loop figure is taken at; the
        # valve's own zero and the follower's offset divide by the gain of the layer.
        assert loop["steady_state_error"] == pytest.approx(at_rest, abs=5e-6)


@pytest.mark.ngspice
def test_a_drawn_card_closes_the_loop_alike_as_circuit_and_as_behaviour(design):
    elements = elements_of(draw(quantities(design), 4, 0), design)
    time = np.linspace(0, 0.15, 1501)
    demand = np.where(time < 5e-5, 15e-3, 24e-3)
    circuit = simulate_circuit_loop(design, time=time, demand=demand, elements=elements)
    card = card_of(design, elements=elements)
    found = simulate("single-axis", time=time, demand=demand, controller=card)
    apart = np.abs(circuit["displacement"] - found["displacement"])
    # As for the card as designed: 0.5 % of the step.
    assert apart.max() < 0.005 * 9e-3
    # The card as designed does something else: its layer is wider or narrower.
    alike = simulate("single-axis", time=time, demand=demand, controller=card_of(design))
    assert np.abs(alike["displacement"] - found["displacement"]).max() > 0.01 * 9e-3


def test_a_trial_is_the_same_alone_and_among_others(design):
    trial = partial(_trials, design, load_rig("single-axis"), 3)
    assert run_trials(trial, 2, "x")[1] == next(iter(trial([1])))


def test_trials_of_another_rig_are_not_taken_for_those_of_this_one(design, tmp_path, monkeypatch):
    def stopped(*_):
        raise RuntimeError

    monkeypatch.setattr("pneuservo.tolerance.closed_loop_figures", stopped)
    rig = load_rig("single-axis")
    with pytest.raises(RuntimeError):
        study_loop(design, rig, 1, folder=tmp_path)
    others = (
        replace(rig, effects={"spool.null-bias": {"bias": 0.01}}),
        replace(rig, transducers={"displacement": Transducer(2e-5)}),
        replace(rig, valve="ddv-27a1-uncalibrated"),
    )
    for other in others:
        with pytest.raises(InputError, match="another study"):
            study_loop(design, other, 1, folder=tmp_path)


def test_command_prints_json_and_goes_on(tmp_path):
    arguments = ["tolerance", "--trials", "3", "--json", "--out", str(tmp_path)]
    # Corners of every quantity would be a hundred runs: only one is spread.
    nothing = (
        "resistor matched-resistor capacitor potentiometer zener zener-matching offset-voltage "
        "offset-drift gain-bandwidth slew-rate positive-swing negative-swing"
    )
    tight = [f"--{name}=0" for name in nothing.split()]
    tight += ["--bias-current=1", "--open-loop-gain=1", "--potentiometer=0.1"]
    tight += ["--lowest-temperature=25", "--highest-temperature=25"]
    tight += ["--limit", "steady_state_error=-0.3mm..0.3mm"]
    result = CliRunner().invoke(main, arguments + tight)
    assert result.exit_code == 0, result.output
    found = json.loads(result.output)
    assert [figure["figure"] for figure in found["figures"]] == list(ALL_FIGURES)
    assert len((tmp_path / "loop.jsonl").read_text().splitlines()) == 4
    assert CliRunner().invoke(main, arguments + tight).output == result.output
    other = CliRunner().invoke(main, [*arguments, *tight, "--seed", "1"])
    assert other.exit_code == 2
    assert "another study" in other.output


def test_limits_of_every_figure_are_read():
    texts = tuple(f"{name}=1 {unit}..2 {unit}" for name, unit in ALL_FIGURES.items())
    assert parsed_limits(texts, ALL_FIGURES) == dict.fromkeys(ALL_FIGURES, (1.0, 2.0))


def test_bad_limits_exit_with_status_2():
    result = CliRunner().invoke(main, ["tolerance", "--limit", "settling=0..1"])
    assert result.exit_code == 2
    assert "the figures are" in result.output
