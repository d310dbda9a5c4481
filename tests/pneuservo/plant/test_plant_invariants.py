"""What any run has to obey, whatever its numbers."""

import math
from itertools import pairwise

import numpy as np
import pytest

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.plant import integrator
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.single_axis import PLANT_STATES
from pneuservo.plant.valve import chamber_a_mass_flow, chamber_b_mass_flow
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate, simulate_dead_volume

RIG = load_rig("single-axis")
FRICTIONLESS = {"piston.coulomb_friction": 0.0, "piston.viscous_friction": 0.0}


def stored_energy(run, rig):
    """Kinetic energy, gas, atmosphere and weight: constant in a sealed rig without friction [J]."""
    x, v = run["displacement"], run["velocity"]
    n = rig["chamber.polytropic_index"]
    volume_a = rig["piston.area_a"] * x + rig["chamber.a.dead_volume"]
    volume_b = rig["piston.area_b"] * (rig["piston.stroke"] - x) + rig["chamber.b.dead_volume"]
    gas = (run["pressure_a"] * volume_a + run["pressure_b"] * volume_b) / (n - 1.0)
    rod = rig["piston.area_a"] - rig["piston.area_b"]
    outside = (rig["ambient.pressure"] * rod - rig["load.mass"] * rig["load.gravity"]) * x
    return 0.5 * rig["load.mass"] * v**2 + gas + outside


def test_sealed_rig_without_friction_keeps_its_energy():
    rig = RIG.with_values(FRICTIONLESS)
    time = np.arange(0.0, 0.5, 1e-3)
    run = simulate(rig, time=time, command=0.0, initial=InitialState(0.015, velocity=0.3))
    energy = stored_energy(run, rig)
    # 25 000 steps; the swing exchanges 80 mJ of about 30 J.
    assert np.ptp(energy) < 1e-9 * energy[0]
    assert np.ptp(run["displacement"]) > 1e-3


def test_friction_only_takes_energy():
    time = np.arange(0.0, 0.5, 1e-3)
    run = simulate(time=time, command=0.0, initial=InitialState(0.015, velocity=0.3))
    energy = stored_energy(run, RIG)
    # Coulomb friction brings it to rest, where energy stays what it is.
    assert run["velocity"][-1] == 0.0
    assert np.all(np.diff(energy) <= 1e-12 * energy[0])
    assert energy[0] - energy[-1] == pytest.approx(0.5 * RIG["load.mass"] * 0.3**2, rel=0.2)


def test_gas_spring_frequency():
    rig = RIG.with_values(FRICTIONLESS)
    time = np.arange(0.0, 1.0, 1e-4)
    run = simulate(rig, time=time, command=0.0, initial=InitialState(0.015, velocity=1e-3))
    v = run["velocity"]
    up = np.flatnonzero((v[:-1] < 0.0) & (v[1:] >= 0.0))
    crossings = time[up] - v[up] * 1e-4 / (v[up + 1] - v[up])
    frequency = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    stiffness = 1.4 * (
        run["pressure_a"][0] * rig["piston.area_a"] ** 2 / (rig["piston.area_a"] * 0.015 + 1.7e-6)
        + run["pressure_b"][0] * rig["piston.area_b"] ** 2 / (rig["piston.area_b"] * 0.015 + 1.7e-6)
    )
    # An amplitude of 9 um on 15 mm shifts the frequency by its square; crossings are linear.
    assert frequency == pytest.approx(math.sqrt(stiffness / 1.825) / (2.0 * math.pi), rel=1e-6)


def test_mass_that_flows_in_is_what_the_chambers_gain():
    rate = 50e3
    time = np.arange(0.0, 0.2, 1.0 / rate)
    run = simulate(time=time, command=np.where(time < 0.1, 1.0, -1.5))
    plant, grid = plant_numbers.single_axis(RIG), plant_numbers.valve_grid("ddv-27a1")
    edges = (plant.supply_pressure, plant.ambient_pressure, plant.valve, plant.gas, grid)
    x = run["displacement"]
    for name, flow, area, volume in (
        ("pressure_a", chamber_a_mass_flow, 490.87e-6, 490.87e-6 * x + 1.7e-6),
        ("pressure_b", chamber_b_mass_flow, -412.33e-6, 412.33e-6 * (0.03 - x) + 1.7e-6),
    ):
        p = run[name]
        inflow = [flow(s, each, *edges) for s, each in zip(run["spool"], p, strict=True)]
        # (p V)'/(n - 1) = n/(n - 1) R T m - p V', from (4.12).
        rates = 1.4 / 0.4 * 287.0 * 293.0 * np.array(inflow) - p * area * run["velocity"]
        gained = (p[-1] * volume[-1] - p[0] * volume[0]) / 0.4
        fed = np.trapezoid(rates, time)
        assert abs(gained) > 0.5
        # Trapezoids of 20 us on a process of 5 ms: (20 us/5 ms)^2/12 of the rate's swing.
        assert fed == pytest.approx(gained, rel=2e-5)


@pytest.mark.parametrize(("share", "moves"), [(0.999, False), (-0.999, False), (1.001, True)])
def test_nothing_moves_below_breakaway(share, moves):
    time = np.array([0.0, 0.1, 0.2])
    force = share * RIG["piston.coulomb_friction"] * np.array([0.0, 1.0, 1.0])
    run = simulate(time=time, command=0.0, external_force=force)
    assert run["displacement"][1] == run["displacement"][0]
    assert (run["displacement"][2] != run["displacement"][1]) == moves
    assert np.array_equal(run["force"], force)


def test_a_piston_at_a_stop_stays_until_it_is_pulled_off():
    time = np.arange(0.0, 1.5, 1e-3)
    run = simulate(time=time, command=np.where(time < 0.7, 4.0, -4.0))
    x, v = run["displacement"], run["velocity"]
    assert x.max() == RIG["piston.stroke"]
    assert x.min() == 0.0
    at_stop = (x == 0.0) | (x == RIG["piston.stroke"])
    assert np.count_nonzero(at_stop) > 500
    assert not np.any(v[at_stop & np.roll(at_stop, 1) & np.roll(at_stop, -1)])
    assert np.abs(run["spool"]).max() <= 1.0


def test_a_symmetric_rig_moves_symmetrically():
    plant = plant_numbers.single_axis(
        RIG.with_values({"piston.area_b": RIG["piston.area_a"], "load.gravity": 0.0})
    )
    plant = plant._replace(
        valve=plant.valve._replace(area_b_e=8e-7, area_a_e=8e-7, area_s_a=8e-7, area_s_b=8e-7)
    )
    grid = np.repeat(plant_numbers.valve_grid("ddv-27a1")[:1], 4, axis=0)
    start = np.zeros(PLANT_STATES)
    start[:] = [0.015, 0.0, 4e5, 4e5, 0.0, 0.0]
    time = np.arange(0.0, 0.1, 1e-3)
    runs = [
        integrator.run(time, inputs, start, OPEN_LOOP, plant, grid, 20e-6)
        for inputs in (np.tile([2.0, 0.0], (100, 1)), np.tile([-2.0, 0.0], (100, 1)))
    ]
    place = {name: index for index, name in enumerate(integrator.OUTPUTS)}
    out, back = (run[:, place["displacement"]] - 0.015 for run in runs)
    assert out[-1] > 5e-3
    # Mirrored but for rounding: the two chambers' volumes are computed differently.
    np.testing.assert_allclose(out, -back, atol=1e-13)
    np.testing.assert_allclose(
        runs[0][:, place["pressure_a"]], runs[1][:, place["pressure_b"]], rtol=1e-12
    )


def test_fourth_order_on_a_smooth_stretch():
    # One discharge coefficient, one direction, one side of the critical ratio: no kinks.
    plant = plant_numbers.single_axis(RIG)
    grid = np.full((4, 51, 101), 0.7)
    start = np.array([0.012, 0.05, 4.6e5, 5.5e5, 0.3, 0.0])
    time, inputs = np.array([0.0, 0.02]), np.tile([2.0, 0.0], (2, 1))

    def end(step):
        return integrator.run(time, inputs, start, OPEN_LOOP, plant, grid, step)[-1, :6]

    reference = end(5e-6)
    errors = [abs(end(step)[3] - reference[3]) for step in (1e-3, 0.5e-3, 0.25e-3)]
    orders = [math.log2(a / b) for a, b in pairwise(errors)]
    # Fifth-order terms still show at 1 ms, a tenth of the fastest period.
    assert orders == pytest.approx([4.0, 4.0], abs=0.3), errors


def changes_output(rig, changed):
    time = np.arange(0.0, 0.8, 2e-3)
    # Both directions, both stops, and a controller that reads the transducer.
    command = np.select([time < 0.3, time < 0.7], [3.0, -3.0], 1.0)
    runs = [
        [
            simulate(each, time=time, command=command, initial=InitialState(0.015)),
            simulate(
                each,
                time=time[:50],
                controller=Proportional(),
                demand=0.02,
                initial=InitialState(0.015),
            ),
        ]
        for each in (rig, changed)
    ]
    return any(
        not np.array_equal(before[name], after[name])
        for before, after in zip(*runs, strict=True)
        for name in before.channels
    )


@pytest.mark.parametrize("key", sorted(RIG.parameters))
def test_every_parameter_of_the_single_axis_counts(key):
    assert changes_output(RIG, RIG.with_values({key: 1.01 * RIG[key]}))


@pytest.mark.parametrize("key", sorted(load_rig("dead-volume").parameters))
def test_every_parameter_of_the_dead_volume_counts(key):
    rig = load_rig("dead-volume")
    changed = rig.with_values({key: 1.01 * rig[key]})
    time, command = np.array([0.0, 0.5, 1.0]), np.array([0.3, -0.3, 0.0])
    pressures = [
        [
            simulate_dead_volume(each, time=time, command=command, port=port, initial_pressure=3e5)
            for port in ("a", "b")
        ]
        for each in (rig, changed)
    ]
    assert any(
        not np.array_equal(before["dead_volume_pressure"], after["dead_volume_pressure"])
        for before, after in zip(*pressures, strict=True)
    )


@pytest.mark.parametrize(
    "values",
    [
        FRICTIONLESS,
        {"piston.coulomb_friction": 50.0},
        {"load.mass": 0.01},
        {"valve.spool.frequency": 5000.0},
        {"load.gravity": -9.81},
        {"piston.stroke": 1e-3},
    ],
    ids=str,
)
def test_odd_rigs_neither_hang_nor_leave_their_bounds(values):
    rig = RIG.with_values(values)
    time = np.arange(0.0, 0.3, 1e-3)
    demand = rig["piston.stroke"] * np.where(time < 0.1, 0.3, 0.8)
    run = simulate(rig, time=time, controller=SlidingMode(boundary_layer=0.0), demand=demand)
    assert np.all((run["displacement"] >= 0.0) & (run["displacement"] <= rig["piston.stroke"]))
    assert np.all(np.abs(run["spool"]) <= 1.0)
    assert np.ptp(run["displacement"]) > 0.0
