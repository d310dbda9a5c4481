"""Effects of a rig file reach simulations, replays and the command line."""

import dataclasses
import json

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.design_file import load_design
from pneuservo.command_line import main
from pneuservo.controllers import SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.servo.valve_effects import pressure_behind
from pneuservo.recordings import Recording
from pneuservo.rigs import VARIANTS, load_rig
from pneuservo.rigs.plant_numbers import single_axis
from pneuservo.simulation import InitialState, replay, simulate
from pneuservo.simulation.servo import state_behind

RIG = load_rig("single-axis")
TIME = np.arange(0.0, 0.3, 1e-3)


def with_effects(effects):
    return dataclasses.replace(RIG, effects=effects)


def test_the_command_line_simulates_a_model_with_effects(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.toml").write_text(
        '[rig]\nkind = "single-axis"\n[effects]\n"valve.overlap" = { lap = 0.02 }\n'
    )
    arguments = ["simulate", "--controller", "sliding-mode", "--demand", "15,24 mm", "--json"]
    errors = []
    for rig in (["--rig", "model.toml"], []):
        done = CliRunner().invoke(main, [*arguments, *rig])
        assert done.exit_code == 0, done.output
        errors.append(json.loads(done.stdout)["steps"][-1]["rise_time"])
    assert errors[0] > 1.001 * errors[1]


def test_a_measured_supply_drives_the_valve():
    supply = 6.5e5 + 5e4 * np.sin(20.0 * TIME)
    command = np.where(TIME < 0.1, 2.0, -2.0)
    measured = simulate(time=TIME, command=command, supply_pressure=supply)
    assert measured["supply_pressure"] == pytest.approx(supply)
    recording = Recording(
        "supplied",
        TIME,
        {
            name: measured[name]
            for name in (
                "displacement",
                "pressure_a",
                "pressure_b",
                "valve_voltage",
                "supply_pressure",
            )
        },
        rig="single-axis",
    )
    again = replay(recording)
    assert np.array_equal(again["displacement"], measured["displacement"])
    # Without the measured supply the same command moves it elsewhere.
    other = simulate(time=TIME, command=command)
    assert np.abs(other["displacement"] - measured["displacement"]).max() > 1e-5


def test_gaps_in_the_supply_are_bridged_and_said():
    channels = {"valve_voltage": np.zeros(300), "supply_pressure": np.full(300, 6.5e5)}
    channels["supply_pressure"][50:60] = np.nan
    said = []
    run = replay(Recording("gap", TIME, channels, rig="single-axis"), warn=said.append)
    assert np.all(run["supply_pressure"] == 6.5e5)
    assert any("straight line" in sentence for sentence in said)
    channels["supply_pressure"][:] = np.nan
    run = replay(Recording("none", TIME, channels, rig="single-axis"), warn=said.append)
    assert "supply_pressure" not in run
    assert "throughout" in said[-1]


def test_only_effects_with_a_temperature_show_one():
    warm = with_effects({"chamber.heat-transfer": {"conductance": 0.1}})
    run = simulate(warm, time=TIME, command=3.0)
    assert 5.0 < np.ptp(run["temperature_a"]) < 100.0
    assert "temperature_a" not in simulate(time=TIME, command=3.0)


def test_what_the_transducers_read_starts_from_what_is():
    sensor = {
        "sensor.position-offset": {"offset": 1e-3},
        "sensor.pressure-gain-a": {"gain": 0.02},
        "sensor.pressure-offset-b": {"offset": 5e3},
    }
    rig = with_effects(sensor)
    read = InitialState(0.016, 0.0, 1.02 * 5e5, 4e5 + 5e3)
    true = state_behind(read, rig, single_axis(rig))
    assert (true.displacement, true.pressure_a, true.pressure_b) == pytest.approx((0.015, 5e5, 4e5))
    truth = simulate(rig, time=TIME, command=np.where(TIME < 0.1, 2.0, -2.0))
    recording = Recording("read", TIME, dict(truth.channels), rig="single-axis")
    again = replay(recording, rig)
    assert again["displacement"] == pytest.approx(truth["displacement"], abs=1e-9)


def test_a_piston_on_a_spring_starts_at_rest():
    rig = with_effects({"load.spring": {"stiffness": 2000.0}})
    run = simulate(rig, time=TIME[:50], command=0.0, initial=InitialState(0.025))
    assert np.all(run["displacement"] == 0.025)


def test_the_loop_hears_the_transducer():
    rig = with_effects({"sensor.position-offset": {"offset": 5e-4}})
    controller = SlidingMode(boundary_layer=5.0)
    run = simulate(rig, time=TIME, controller=controller, demand=0.02, initial=InitialState(0.0195))
    # What is read settles on the demand; the piston is 0.5 mm short of it.
    plain = simulate(time=TIME, controller=controller, demand=0.02, initial=InitialState(0.02))
    assert run["displacement"][-1] == pytest.approx(plain["displacement"][-1], abs=5e-5)


def test_what_cannot_be_simulated_is_refused():
    rig = with_effects({"valve.overlap": {"lap": 0.01}})
    with pytest.raises(InputError, match="equally spaced"):
        simulate(rig, time=[0.0, 1e-3, 3e-3], controller=card_of(load_design()), demand=0.02)
    with pytest.raises(InputError, match="supply_pressure has the shape"):
        simulate(time=TIME, command=0.0, supply_pressure=[6e5, 6e5])


@pytest.mark.parametrize("name", VARIANTS)
def test_the_axes_of_the_figure_run_and_say_where_their_values_come_from(name):
    rig = load_rig(name)
    assert rig.kind == "single-axis"
    assert all(parameter.source for parameter in rig.parameters.values())
    assert {"line.restriction", "line.delay"} <= set(rig.effects)
    run = simulate(rig, time=TIME, command=np.where(TIME < 0.15, 2.0, -2.0))
    # 1 m of hose delays the first pressure change by 2.9 ms, and it moves both ways.
    quiet = run["pressure_a"][TIME < 2.9e-3]
    assert np.ptp(quiet) < 1e-9 * quiet[0]
    assert run["pressure_a"][6] > quiet[0] + 100.0
    assert np.ptp(run["displacement"]) > 5e-3


def test_the_hose_of_the_figure_loses_what_was_measured():
    rig = load_rig("figure-linear-axis")
    plant = single_axis(rig)
    # An edge that passes the rated flow of 1.15e-3 kg/s, whatever is behind it.
    edge = 1.15e-3 / gas_mass_flow(13e5, 6.5e5, 1.0, 1.0, plant.gas)
    share = edge / rig.effect_values["line.restriction:area"]
    before = pressure_behind(13e5, 6.2e5, share, plant.gas)
    # 0.3 bar are lost behind it; the area is given to two figures.
    assert before - 6.2e5 == pytest.approx(0.3e5, rel=0.03)
    vane = load_rig("figure-rotary-axis")
    torque = 6.895e5 * vane["piston.area_a"] * 0.0191
    assert torque == pytest.approx(6.779, rel=2e-3)
