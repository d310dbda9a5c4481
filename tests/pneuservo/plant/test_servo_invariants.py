"""What a run with effects has to obey: mass, energy, rest, symmetry, the gas spring."""

import dataclasses
import math

import numpy as np
import pytest
from scipy.integrate import simpson

from pneuservo.effects.servo import servo_effects
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo.events import motion_at_start, settle
from pneuservo.plant.servo.layout import (
    INPUTS,
    JOINT_RATE,
    MEMORY,
    MODE_RATE,
    OUTPUTS,
    PAST_COLUMNS,
    PAST_ROWS,
    Servo,
)
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.starting import servo_inputs, servo_state
from pneuservo.plant.single_axis import DISPLACEMENT, VELOCITY
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate

RIG = load_rig("single-axis")
PLANT = plant_numbers.single_axis(RIG)
SMOOTH = np.full((4, 51, 101), 0.7)
FRICTIONLESS = {"piston.coulomb_friction": 0.0, "piston.viscous_friction": 0.0}


def with_effects(effects, values=None):
    return dataclasses.replace(RIG.with_values(values or {}), effects=effects)


def columns(effects, time, start, command, plant=PLANT, grid=SMOOTH, step=20e-6):
    servo = Servo(plant, effects, OPEN_LOOP)
    inputs = servo_inputs(time, plant.supply_pressure, command=command)
    state = servo_state(np.array(start), servo, plant.supply_pressure)
    out = run_servo(inputs, state, servo, grid, step)
    return dict(zip(OUTPUTS, out.T, strict=True))


def gas_masses(run):
    """Mass of the gas in both chambers by the ideal gas law [kg]."""
    x, piston = run["displacement"], PLANT.piston
    volume_a = piston.area_a * x + PLANT.dead_volume_a
    volume_b = piston.area_b * (piston.stroke - x) + PLANT.dead_volume_b
    return (
        run["pressure_a"] * volume_a / (287.0 * run["temperature_a"]),
        run["pressure_b"] * volume_b / (287.0 * run["temperature_b"]),
    )


def test_sealed_chambers_keep_their_mass_while_they_warm_and_move():
    effects = servo_effects({"chamber.heat-transfer:conductance": 0.2})
    run = columns(effects, np.arange(0.0, 0.3, 1e-3), [0.01, 0.2, 5e5, 4e5, 0.0, 0.0], 0.0)
    assert np.ptp(run["temperature_a"]) > 5.0
    for mass in gas_masses(run):
        assert np.ptp(mass) < 1e-9 * mass[0]


def test_what_leaks_past_the_piston_is_lost_by_one_chamber_and_gained_by_the_other():
    effects = servo_effects(
        {"chamber.heat-transfer:conductance": 0.2, "leakage.cross-piston:conductance": 3e-16}
    )
    run = columns(effects, np.arange(0.0, 0.3, 1e-3), [0.01, 0.0, 6e5, 2e5, 0.0, 0.0], 0.0)
    one, other = gas_masses(run)
    assert np.ptp(one) > 0.05 * one[0]
    assert np.ptp(one + other) < 1e-9 * (one[0] + other[0])


def test_what_flows_through_the_valve_is_what_the_chambers_gain():
    effects = servo_effects({"chamber.heat-transfer:conductance": 0.2})
    time = np.arange(0.0, 0.02 + 1e-9, 20e-6)
    run = columns(effects, time, [0.012, 0.05, 4.6e5, 5.5e5, 0.3, 0.0], 1.5)
    for mass, flow in zip(gas_masses(run), (run["mass_flow_a"], run["mass_flow_b"]), strict=True):
        gained = mass[-1] - mass[0]
        assert abs(gained) > 0.05 * mass[0]
        assert simpson(flow, x=time) == pytest.approx(gained, rel=1e-9)


@pytest.mark.parametrize(("conductance", "index"), [(1e-6, 1.4), (1e4, 1.0)])
def test_heat_transfer_runs_from_adiabatic_to_isothermal_on_the_gas_spring(conductance, index):
    """Against (5.42) with either polytropic index."""
    rig = with_effects({"chamber.heat-transfer": {"conductance": conductance}}, FRICTIONLESS)
    time = np.arange(0.0, 0.5, 1e-4)
    # A large conductance is a fast process: m cv/(h A) is a microsecond.
    step = 20e-6 if conductance < 1.0 else 1e-6
    run = simulate(
        rig, time=time, command=0.0, initial=InitialState(0.015, velocity=1e-3), largest_step=step
    )
    v = run["velocity"]
    up = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    crossings = time[up] - v[up] * 1e-4 / (v[up + 1] - v[up])
    frequency = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    stiffness = index * sum(
        run[pressure][0] * rig[area] ** 2 / (rig[area] * 0.015 + 1.7e-6)
        for pressure, area in (("pressure_a", "piston.area_a"), ("pressure_b", "piston.area_b"))
    )
    expected = math.sqrt(stiffness / 1.825) / (2.0 * math.pi)
    # An amplitude of 9 um on 15 mm shifts it by its square; what heat leaks in a period is the
    # period over the time constant, 1e-6 either way.
    assert frequency == pytest.approx(expected, rel=1e-5)


def stored_energy(run, rig):
    """Kinetic energy, gas, atmosphere and weight of a sealed rig [J]."""
    x, v = run["displacement"], run["velocity"]
    volume_a = rig["piston.area_a"] * x + rig["chamber.a.dead_volume"]
    volume_b = rig["piston.area_b"] * (rig["piston.stroke"] - x) + rig["chamber.b.dead_volume"]
    gas = (run["pressure_a"] * volume_a + run["pressure_b"] * volume_b) / 0.4
    rod = rig["piston.area_a"] - rig["piston.area_b"]
    outside = (rig["ambient.pressure"] * rod - rig["load.mass"] * rig["load.gravity"]) * x
    return 0.5 * rig["load.mass"] * v**2 + gas + outside


@pytest.mark.parametrize(
    "effect",
    [
        {"friction.stribeck": {"excess": 3.0, "speed": 0.01}},
        {"friction.pressure": {"sum": 5e-6, "difference": 5e-6}},
        {"friction.asymmetric": {"difference": 0.9, "viscous": 20.0}},
        {"friction.position": {"sine": 1.0, "cosine": -0.6, "length": 0.011}},
        {"friction.breakaway-dwell": {"excess": 5.0, "time": 0.1}},
        {"friction.speed-curve": {"quadratic": 100.0}},
        {"friction.run-in": {"coulomb": 0.1, "viscous": 0.1}},
        {"friction.side-load": {"force": 3.0}},
    ],
    ids=lambda effect: next(iter(effect)),
)
def test_friction_only_takes_energy(effect):
    time = np.arange(0.0, 0.5, 1e-3)
    start = InitialState(0.015, velocity=0.3)
    run = simulate(with_effects(effect), time=time, command=0.0, initial=start)
    energy = stored_energy(run, RIG)
    assert run["velocity"][-1] == 0.0
    # Rounding of an energy of 30 J over 25 000 steps.
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    plain = stored_energy(simulate(time=time, command=0.0, initial=start), RIG)
    assert energy[-1] != plain[-1]


def test_bristles_give_back_no_more_than_they_stored():
    rig = with_effects({"friction.presliding": {"travel": 5e-5, "exponent": 1.0}})
    time = np.arange(0.0, 0.5, 1e-3)
    run = simulate(rig, time=time, command=0.0, initial=InitialState(0.015, velocity=0.3))
    energy = stored_energy(run, RIG)
    # At most Fc times the travel, 51 uJ, is in the bristles.
    assert np.max(energy - np.minimum.accumulate(energy)) < 1.013 * 5e-5
    assert energy[0] - energy[-1] == pytest.approx(0.5 * 1.825 * 0.3**2, rel=0.2)


@pytest.mark.parametrize(("share", "moves"), [(0.999, False), (-0.999, False), (1.001, True)])
def test_nothing_moves_below_breakaway(share, moves):
    # At rest for 2 s, so that the dwell gives 1 - exp(-2) of 2 N.
    excess = {
        "friction.stribeck": {"excess": 1.5, "speed": 0.005},
        "friction.breakaway-dwell": {"excess": 2.0, "time": 1.0},
    }
    breakaway = RIG["piston.coulomb_friction"] + 1.5 + 2.0 * (1.0 - math.exp(-2.0))
    time = np.array([0.0, 2.0, 2.005])
    run = simulate(
        with_effects(excess),
        time=time,
        command=0.0,
        external_force=share * breakaway * np.array([0.0, 1.0, 1.0]),
    )
    assert run["displacement"][1] == run["displacement"][0]
    assert (run["displacement"][2] != run["displacement"][1]) == moves


def test_a_symmetric_rig_with_effects_moves_symmetrically():
    plant = plant_numbers.single_axis(
        RIG.with_values({"piston.area_b": RIG["piston.area_a"], "load.gravity": 0.0})
    )
    plant = plant._replace(
        valve=plant.valve._replace(area_b_e=8e-7, area_a_e=8e-7, area_s_a=8e-7, area_s_b=8e-7)
    )
    effects = servo_effects(
        {
            "valve.overlap:lap": 0.01,
            "spool.hysteresis:half_width": 0.005,
            "spool.delay:time": 7e-4,
            "line.resonance:frequency": 60.0,
            "leakage.cross-piston:conductance": 1e-16,
            "chamber.heat-transfer:conductance": 0.1,
            "friction.stribeck:excess": 2.0,
            "supply.sag:volume": 2e-4,
            "supply.sag:area": 2e-6,
            "endstop.contact:stiffness": 1e6,
        }
    )
    time = np.arange(0.0, 0.15, 1e-3)
    command = 3.0 * np.sin(2.0 * np.pi * 7.0 * time)
    start = [0.015, 0.0, 4e5, 4e5, 0.0, 0.0]
    out, back = (columns(effects, time, start, u, plant) for u in (command, -command))
    assert np.ptp(out["displacement"]) > 5e-3
    # Mirrored but for rounding: 1e-16 of the displacement in every one of 7500 steps.
    assert out["displacement"] - 0.015 == pytest.approx(0.015 - back["displacement"], abs=1e-11)
    assert out["pressure_a"] == pytest.approx(back["pressure_b"], rel=1e-9)


def test_a_reservoir_settles_where_it_passes_what_is_drawn():
    effects = servo_effects(
        {"supply.sag:volume": 2e-4, "supply.sag:area": 3e-7, "valve.null-leakage:share": 0.05}
    )
    run = columns(effects, np.array([0.0, 20.0]), [0.015, 0.0, 4e5, 4e5, 0.0, 0.0], 0.0, step=1e-4)
    supply = run["supply_pressure"][-1]
    assert supply < 6.5e5 - 1e3
    settled = [run["mass_flow_a"][-1], run["mass_flow_b"][-1]]
    # What still flows into the chambers against what the leaks draw, some 4e-5 kg/s.
    assert settled == pytest.approx([0.0, 0.0], abs=1e-8)


def test_more_command_delay_is_the_same_run_later():
    time = np.arange(0.0, 0.1, 1e-3)
    command = np.where(time < 0.0195, 0.0, 2.0)
    start = [0.015, 0.0, 4.8e5, 5.2e5, 0.0, 0.0]
    at_once = columns(NEUTRAL, time, start, command)
    late = columns(servo_effects({"spool.delay:time": 5e-3}), time, start, command)
    # The command of 20 ms acts at 25 ms. The last stage of the step that ends there may already
    # see it: a sixth of 20 us at the spool's fastest, 0.46 w times its step of 0.4.
    early = 20e-6 / 6.0 * 0.46 * PLANT.valve.spool_frequency * 0.4
    assert late["spool"][25:60] == pytest.approx(at_once["spool"][20:55], abs=early)
    assert np.all(late["spool"][:25] == 0.0)


@pytest.mark.parametrize(
    ("values", "rate"),
    [
        ({"load.transverse-mode:share": 0.4}, MODE_RATE),
        ({"load.compliance:share": 0.5}, JOINT_RATE),
    ],
)
def test_a_load_keeps_its_speed_when_the_piston_strikes_a_stop(values, rate):
    servo = Servo(PLANT, servo_effects(values), OPEN_LOOP)
    state = servo_state(np.array([1e-3, -0.25, 2e5, 6e5, 0.0, 0.0]), servo, PLANT.supply_pressure)
    modes, memory, rows = (
        np.zeros(3, np.int64),
        np.zeros(MEMORY),
        np.empty((PAST_ROWS, PAST_COLUMNS)),
    )
    drive = np.zeros((2, INPUTS))
    motion_at_start(state, modes, memory, drive, servo)
    state[DISPLACEMENT] = -1e-9
    before = state[VELOCITY] + state[rate]
    settle(state, modes, memory, rows, drive, 0.0, servo)
    assert state[VELOCITY] == state[DISPLACEMENT] == 0.0
    assert state[rate] == before == -0.25
