"""Coupled axes: alone like the single axis, together without a loss or gain of energy."""

from dataclasses import replace

import numpy as np
import pytest

from pneuservo.animated_figure import AnimatedFigure, Axis, Frame, load_figure, simulate_figure
from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.manipulator.linkage import base_coupling, kinetic_energy, potential_energy
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

GAS_INDEX = 1.4
# Both valves stay shut: no command, no opening, no flow.
SHUT = Proportional(gain=0.0)


def lossless(figure):
    """Return a figure whose pistons and frame have no friction."""
    free = {"piston.coulomb_friction": 0.0, "piston.viscous_friction": 0.0}
    axes = {
        name: replace(axis, rig=axis.rig.with_values(free)) for name, axis in figure.axes.items()
    }
    return replace(figure, axes=axes, frame=replace(figure.frame, damping=0.0))


def total_energy(run):
    """Return the energy of members, rods, frame, air and surroundings at every time [J]."""
    figure = run.figure
    coupling, frame = figure.coupling, figure.frame
    rods = np.column_stack([axis["displacement"] for axis in run.axes.values()])
    speeds = np.column_stack([axis["velocity"] for axis in run.axes.values()])
    energy = 0.5 * frame.mass * run.frame_velocity**2
    energy += 0.5 * frame.stiffness * run.frame_displacement**2
    for k in range(len(run.time)):
        angles = (rods[k] - coupling.middles) / coupling.levers
        rates = speeds[k] / coupling.levers
        energy[k] += kinetic_energy(angles, rates, run.frame_velocity[k], coupling.linkage)
        energy[k] += potential_energy(angles, figure.gravity, coupling.linkage)
    for axis in run.axes.values():
        rig, x = axis.rig, axis["displacement"]
        area_a, area_b = rig["piston.area_a"], rig["piston.area_b"]
        volume_a = area_a * x + rig["chamber.a.dead_volume"]
        volume_b = area_b * (rig["piston.stroke"] - x) + rig["chamber.b.dead_volume"]
        energy += (axis["pressure_a"] * volume_a + axis["pressure_b"] * volume_b) / (
            GAS_INDEX - 1.0
        )
        energy += rig["ambient.pressure"] * (area_a - area_b) * x
        energy += 0.5 * rig["load.mass"] * axis["velocity"] ** 2
    return energy


def moved_energy(run):
    """Return the largest kinetic energy of the rods with what they drive [J]."""
    masses = [
        run.axes[name].rig["load.mass"]
        + (axis.inertia + axis.mass * axis.centre**2) / axis.lever**2
        for name, axis in run.figure.axes.items()
    ]
    return max(
        0.5 * mass * float(np.max(each["velocity"] ** 2))
        for mass, each in zip(masses, run.axes.values(), strict=True)
    )


def test_an_axis_alone_is_the_single_axis():
    """A member balanced on its joint is so much more mass at the rod."""
    rig = replace(load_rig("figure-linear-axis"), effects={}).with_values({"load.mass": 1.0})
    axis = Axis(rig, lever=0.05, mass=0.5, inertia=5e-3, centre=0.0, length=0.2)
    figure = AnimatedFigure("one", "one axis", Frame(20.0, 5.0), {"only": axis})
    time = np.linspace(0.0, 0.3, 301)
    demand = np.where(time < 0.05, 0.015, 0.020)
    alone = simulate_figure(figure, time=time, controller=SlidingMode(), demands={"only": demand})
    same = simulate(
        rig.with_values({"load.mass": 1.0 + 5e-3 / 0.05**2}),
        time=time,
        controller=SlidingMode(),
        demand=demand,
    )
    # Steps of 50 us of order 4, and stops of the piston up to a step late at 1 mm/s.
    assert alone.axes["only"]["displacement"] == pytest.approx(same["displacement"], abs=1e-6)
    assert alone.axes["only"]["pressure_a"] == pytest.approx(same["pressure_a"], rel=1e-3)
    assert np.abs(alone.frame_displacement).max() < 1e-15


def test_energy_is_kept_without_friction_and_flow():
    figure = lossless(load_figure("seven-axes").only("jaw", "left-elbow"))
    time = np.linspace(0.0, 0.25, 251)
    pushed = {"left-shoulder": InitialState(pressure_b=4.0e5, pressure_a=4.6e5)}
    run = simulate_figure(figure, time=time, controller=SHUT, demands={}, initial=pushed)
    energy, moved = total_energy(run), moved_energy(run)
    assert moved > 0.05
    # At a reversal a velocity of up to a step times 20 m/s2 is lost: (1e-3 m/s)^2 of some
    # (0.1 m/s)^2, a few times.
    assert energy == pytest.approx(energy[0], abs=1e-3 * moved)
    # The frame takes part: what the members push it is what it sways.
    assert np.abs(run.frame_velocity).max() > 1e-3


def test_momentum_of_a_free_frame_is_kept():
    figure = lossless(load_figure("arm"))
    # So soft that its spring does nothing in the time.
    figure = replace(figure, frame=Frame(2.0, 1e-4, 0.0), gravity=0.0)
    time = np.linspace(0.0, 0.1, 101)
    pushed = {"elbow": InitialState(pressure_b=3.5e5, pressure_a=4.6e5)}
    run = simulate_figure(figure, time=time, controller=SHUT, demands={}, initial=pushed)
    coupling = figure.coupling
    momentum = (figure.frame.mass + coupling.linkage.mass) * run.frame_velocity
    part = np.zeros(len(time))
    for k in range(len(time)):
        angles, rates = (
            (
                np.array([axis[name][k] for axis in run.axes.values()])
                - (coupling.middles if name == "displacement" else 0.0)
            )
            / coupling.levers
            for name in ("displacement", "velocity")
        )
        part[k] = base_coupling(angles, coupling.linkage) @ rates
    largest = float(np.abs(part).max())
    assert largest > 0.01
    # Only velocities at reversals are lost, see above.
    assert momentum + part == pytest.approx(np.zeros(len(time)), abs=2e-2 * largest)


def test_what_is_lost_is_friction():
    figure = load_figure("arm")
    viscous = {"piston.coulomb_friction": 0.0}
    axes = {
        name: replace(axis, rig=axis.rig.with_values(viscous)) for name, axis in figure.axes.items()
    }
    figure = replace(figure, axes=axes)
    time = np.linspace(0.0, 0.2, 2001)
    pushed = {"elbow": InitialState(pressure_b=3.5e5, pressure_a=4.6e5)}
    run = simulate_figure(figure, time=time, controller=SHUT, demands={}, initial=pushed)
    power = figure.frame.friction * run.frame_velocity**2
    for axis in run.axes.values():
        power += axis.rig["piston.viscous_friction"] * axis["velocity"] ** 2
    lost = np.concatenate(([0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(time))))
    energy = total_energy(run)
    assert lost[-1] > 0.05
    # The trapezium rule over samples of 0.1 ms of a motion of some 10 Hz: (6e-3)^2/12.
    assert energy[0] - energy == pytest.approx(lost, abs=2e-3 * lost[-1])


def test_pistons_hold_what_their_friction_can_hold():
    figure = load_figure("arm")
    held = figure.axes["shoulder"]
    stiff = replace(held, rig=held.rig.with_values({"piston.coulomb_friction": 500.0}))
    figure = replace(figure, axes={**figure.axes, "shoulder": stiff})
    time = np.linspace(0.0, 0.4, 401)
    demand = np.where(time < 0.05, 0.015, 0.022)
    run = simulate_figure(figure, time=time, controller=SlidingMode(), demands={"elbow": demand})
    assert np.ptp(run.axes["shoulder"]["displacement"]) == 0.0
    assert np.ptp(run.axes["shoulder"]["force"]) > 5.0
    assert np.ptp(run.axes["elbow"]["displacement"]) > 6.9e-3


def test_a_blow_against_a_stop_gives_no_energy():
    figure = lossless(load_figure("arm"))
    time = np.linspace(0.0, 0.2, 401)
    thrown = {"elbow": InitialState(pressure_b=1.2e5, pressure_a=6.4e5)}
    run = simulate_figure(figure, time=time, controller=SHUT, demands={}, initial=thrown)
    elbow = run.axes["elbow"]
    # Thrown back at once: a sample misses the stop by what half a millisecond at 0.1 m/s is.
    assert elbow["displacement"].max() == pytest.approx(elbow.rig["piston.stroke"], abs=5e-5)
    assert (elbow["displacement"] <= elbow.rig["piston.stroke"]).all()
    energy, moved = total_energy(run), moved_energy(run)
    assert energy[-1] < energy[0] - 0.1 * moved
    assert np.diff(energy).max() < 1e-3 * moved


def test_shorter_steps_change_little():
    figure, time = load_figure("arm"), np.linspace(0.0, 0.4, 401)
    demand = np.where(time < 0.05, 0.015, 0.022)
    whole, half = (
        simulate_figure(
            figure,
            time=time,
            controller=SlidingMode(),
            demands={"elbow": demand},
            largest_step=step,
        )
        for step in (50e-6, 25e-6)
    )
    for name, axis in whole.axes.items():
        # What LARGEST_STEP of the run states.
        assert axis["displacement"] == pytest.approx(half.axes[name]["displacement"], abs=2e-6)
