"""The card's netlist in closed loop with the plant's netlist, against their behaviour."""

import re
import shutil
import subprocess

import numpy as np
import pytest

import netlists
from analog_card.behaviour import Imperfections
from analog_card.behaviour_elements import nominal_elements, offset_name
from analog_card.design import AMPLIFIERS
from analog_card.design_file import load_design
from analog_card.netlist_text import read_netlist, spice_number
from analog_card.ngspice import Transient, run
from pneuservo.circuit_loop import simulate_circuit_loop
from pneuservo.circuit_loop.loop import CLOSED_LOOP
from pneuservo.circuit_loop.valve_netlist import valve_netlist
from pneuservo.controllers import card_of
from pneuservo.errors import InputError
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate, step_demand

NO_OFFSETS = {offset_name(name): 0.0 for name in AMPLIFIERS}


def test_the_valve_tables_of_the_netlist_are_those_of_the_rig():
    shipped = (netlists.ROOT / "plant" / "ddv-27a1.lib").read_text(encoding="utf-8")
    assert shipped == valve_netlist("ddv-27a1")


def test_the_values_of_the_netlist_are_those_of_the_rig():
    rig, parameters = load_rig("single-axis"), read_netlist(netlists.PLANT).parameters
    values = {name: rig[key] for name, key in rig.conditions.items()}
    assert {name: spice_number(parameters[name]) for name in values} == pytest.approx(values)


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="the ngspice program is not installed")
@pytest.mark.parametrize("path", [netlists.PLANT, CLOSED_LOOP], ids=lambda path: path.stem)
def test_batch_ngspice_runs_it(path):
    # As it stands but for the length of the run, which costs 3 s for each second.
    text = re.sub(r"^\.tran 20u \w+", ".tran 20u 20m", path.read_text(), flags=re.MULTILINE)
    done = subprocess.run(
        ["ngspice", "-b"], input=text, cwd=path.parent, capture_output=True, text=True, timeout=60
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said[-2000:]
    assert re.search(r"No\. of Data Rows : 1\d\d\d", said)
    assert not re.search(r"^(error|warning: can't|.*singular|.*abort)", said, re.I | re.M)


@pytest.mark.ngspice
@pytest.mark.parametrize(
    ("command", "limit"),
    [
        # Solver steps of 20 us; friction smoothed below 1 mm/s lets the piston creep where it
        # should stick, which shows most at small commands.
        (1.0, 10e-6),
        (-1.0, 10e-6),
        (0.3, 25e-6),
        # Into the end stop: a spring that gives 3 um for 300 N, hit at 0.3 m/s or so: v/wn = 40 um.
        (5.0, 40e-6),
    ],
)
def test_the_plant_follows_the_compiled_plant(command, limit):
    time = np.arange(0.0, 0.25, 1e-4)
    pulse = np.where((time >= 0.01 - 1e-9) & (time < 0.21 - 1e-9), command, 0.0)
    waves = run(netlists.shipped()["plant"], Transient(0.25, 20e-6), {"valve_command": command})
    compiled = simulate(time=time, command=pulse, initial=InitialState(0.015))
    moved = waves.at(time, "transducer") * 3e-3
    assert moved == pytest.approx(compiled["displacement"], abs=limit)
    # 500 Pa: what 1 N of friction not yet reversed is worth on 412 mm2 is 2500 Pa.
    pressure = waves.at(time, "xplant.pressure_a") * 1e5
    assert np.abs(pressure - compiled["pressure_a"]).mean() < 500


@pytest.mark.ngspice
def test_the_loop_with_a_boundary_layer_agrees_with_the_behavioural_loop():
    time, demand = step_demand([0.015, 0.024, 0.006, 0.015], hold=0.25, rate=2000.0)
    circuit = simulate_circuit_loop(time=time, demand=demand)
    behaviour = simulate(time=time, demand=demand, controller=card_of(load_design()))
    difference = np.abs(circuit["displacement"] - behaviour["displacement"])
    steps = np.repeat([0.009, 0.009, 0.018, 0.009], 500)  # the first hold is judged by the second
    # What the project asks for: 0.5 % of the step at all times.
    assert np.max(difference / steps) < 5e-3
    assert circuit.limit_cycle() is None
    # The taps: minus R C times the velocity, but for the filters and what the solver's steps leave.
    expected = -circuit["velocity"] * 0.012 * 1e3 / 3
    assert circuit["card_velocity"] == pytest.approx(expected, abs=0.02 * np.abs(expected).max())
    # The integral of the acceleration is the velocity: trapezoidal rule at 2 kHz, oscillations of
    # 170 Hz, (2 pi 170/2000)^2/12 = 2.4 % of their 10 mm/s.
    steps = (circuit["acceleration"][1:] + circuit["acceleration"][:-1]) / 2 * 0.5e-3
    assert np.cumsum(steps) == pytest.approx(circuit["velocity"][1:], abs=0.3e-3)
    assert behaviour.channels.keys() == circuit.channels.keys()


@pytest.mark.ngspice
def test_offsets_move_the_piston_as_far_as_they_are_worth():
    # All offsets 5 mV, by hand. Surface weights c1 (RC)^2 = 0.470, c2 RC = 1.371 and 1. Buffers
    # cancel; the difference amplifier adds 10 mV to the deviation, the inverter leaves 5 mV of
    # rate, the second differentiator 5 mV; the surface amplifier's own offset has the noise gain
    # 1 + 1/1.025 + 1/0.530 + 1 = 4.86, the boundary-layer amplifier needs another 5 mV:
    # 0.470 (e + 10) = 5 (4.86 + 1 - 1.371 - 1), e = 27.1 mV = 81 um. The follower's offset,
    # 5 mV/0.66 at the clamp and 1/31.6 of it at the surface, adds 1.5 um: within 3 um.
    time, demand = step_demand([0.024], hold=0.25, rate=2000.0)
    start = InitialState(0.02395)
    with_offsets = simulate_circuit_loop(time=time, demand=demand, initial=start)
    without = simulate_circuit_loop(time=time, demand=demand, initial=start, elements=NO_OFFSETS)
    shift = with_offsets.steady_state_error() - without.steady_state_error()
    assert shift == pytest.approx(-81e-6, abs=3e-6)


@pytest.mark.ngspice
def test_the_limit_cycle_of_the_relay_agrees_with_the_behavioural_loop():
    time, demand = step_demand([0.024], hold=0.6, rate=20e3)
    start = InitialState(0.015)
    circuit = simulate_circuit_loop(time=time, demand=demand, relay=True, initial=start)
    relay = card_of(load_design(), relay=True)
    behaviour = simulate(time=time, demand=demand, controller=relay, initial=start)
    # Counted on the switching function, over whole periods, once the approach is over.
    measured, expected = circuit.limit_cycle(0.35), behaviour.limit_cycle(0.35)
    assert measured is not None
    assert expected is not None
    # What the project asks for: 1 % in frequency, 5 % in amplitude.
    assert measured.frequency == pytest.approx(expected.frequency, rel=0.01)
    assert measured.high - measured.low == pytest.approx(expected.high - expected.low, rel=0.05)
    # And both are those of a saturated op-amp, 2 to 5 % below an ideal relay.
    ideal = simulate(
        time=time,
        demand=demand,
        controller=card_of(load_design(), Imperfections.none(), relay=True),
        initial=start,
    ).limit_cycle(0.35)
    assert 0.95 < measured.frequency / ideal.frequency < 0.98


def test_the_elements_of_a_whole_card_do_not_close_the_link_of_a_relay():
    run = simulate_circuit_loop(
        time=[0.0, 1e-3],
        demand=0.0152,
        relay=True,
        elements=nominal_elements(load_design()),
        initial=InitialState(0.015),
    )
    # c1 times 0.2 mm is 0.65 m/s2, of a layer of 5 m/s2 only 0.65 V and offsets; a relay gives all.
    assert run["valve_voltage"][0] == pytest.approx(5.0, rel=0.02)


def test_what_the_circuit_cannot_have_is_refused():
    with pytest.raises(InputError, match="dead-volume"):
        simulate_circuit_loop(rig="dead-volume", time=[0.0, 1.0], demand=0.015)
    with pytest.raises(InputError, match="longest_step"):
        simulate_circuit_loop(time=[0.0, 1.0], demand=0.015, longest_step=0.0)
