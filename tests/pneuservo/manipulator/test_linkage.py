"""Equations of motion of planar links: printed, derived by computer algebra, and energy."""

import numpy as np
import pytest
import sympy

from pneuservo.manipulator.linkage import (
    ON_BASE,
    Link,
    base_coupling,
    base_force,
    gravity_torque,
    kinetic_energy,
    linkage_of,
    mass_matrix,
    potential_energy,
    velocity_torque,
)
from pneuservo.manipulator.manipulator import GRAVITY, nominal

# Sums of a few products of numbers of order 100 round to 1e-13 of them.
ROUNDING = 1e-11


def test_a_link_comes_after_its_carrier():
    with pytest.raises(ValueError, match="link 0 is carried by 1"):
        linkage_of([Link(1.0, 0.1, 0.1, 0.2, carrier=1), Link(1.0, 0.1, 0.1, 0.2)])


def test_torques_are_those_linear_in_the_parameters():
    """W p (A1.18) and M, V, F, G (A2.2 to A2.8) are written independently of each other."""
    rng = np.random.default_rng(1)
    for share in (0.0, 0.3, -0.2):
        plant = nominal().varied(share)
        for _ in range(5):
            angles, rates, accelerations = rng.normal(0.0, 2.0, (3, 2))
            links = plant.linkage
            torque = mass_matrix(angles, links) @ accelerations
            torque += velocity_torque(angles, rates, links)
            torque += np.array(plant.frictions) * rates + gravity_torque(angles, GRAVITY, links)
            by_parameters = plant.regressor(angles, rates, accelerations) @ plant.parameters
            assert torque == pytest.approx(by_parameters, abs=ROUNDING * 1e3)


def lagrange(links, gravity):
    """Return the generalised forces by Lagrange's equations, as a function of numbers."""
    n = len(links)
    t = sympy.Symbol("t")
    q = [sympy.Function(f"q{i}")(t) for i in range(n + 1)]
    absolute, joints, energy = [], [], 0
    for k, link in enumerate(links):
        carried = link.carrier != ON_BASE
        angle = q[k] + link.rest_angle + (absolute[link.carrier] if carried else 0)
        joint = joints[link.carrier] if carried else (q[n], 0)
        absolute.append(angle)
        along = (sympy.sin(angle), sympy.cos(angle))
        joints.append(tuple(joint[i] + link.length * along[i] for i in range(2)))
        centre = [joint[i] + link.centre * along[i] for i in range(2)]
        squared = sum(sympy.diff(place, t) ** 2 for place in centre)
        energy += link.mass * squared / 2 + link.inertia * sympy.diff(angle, t) ** 2 / 2
        energy -= link.mass * gravity * centre[1]
    rates = [sympy.diff(each, t) for each in q]
    forces = [
        sympy.diff(sympy.diff(energy, v), t) - sympy.diff(energy, x)
        for x, v in zip(q, rates, strict=True)
    ]
    symbols = [sympy.symbols(f"x{i} v{i} a{i}") for i in range(n + 1)]
    accelerations = {sympy.diff(x, t, 2): symbols[i][2] for i, x in enumerate(q)}
    velocities = {sympy.diff(x, t): symbols[i][1] for i, x in enumerate(q)}
    places = {x: symbols[i][0] for i, x in enumerate(q)}
    # The highest derivatives first: a function replaced takes its derivatives with it.
    plain = [force.subs(accelerations).subs(velocities).subs(places) for force in forces]
    return sympy.lambdify([x for triple in symbols for x in triple], plain)


@pytest.mark.parametrize(
    "links",
    [
        [Link(10.0, 0.5, 0.5, 1.0), Link(10.0, 0.5, 0.5, 1.0, carrier=0)],
        # A trunk with two arms, one of them with a forearm.
        [
            Link(3.0, 0.2, 0.3, 0.6),
            Link(0.5, 0.01, 0.12, 0.28, carrier=0, rest_angle=2.5),
            Link(0.3, 0.02, 0.1, 0.2, carrier=1, rest_angle=0.4),
            Link(0.4, 0.01, 0.11, 0.25, carrier=0, rest_angle=-2.0),
        ],
    ],
    ids=["two links", "a tree"],
)
def test_equations_are_those_of_lagrange(links):
    derived, linkage = lagrange(links, GRAVITY), linkage_of(links)
    n = len(links)
    rng = np.random.default_rng(2)
    for _ in range(3):
        x, v, a = rng.normal(0.0, 1.0, (3, n + 1))
        expected = derived(*np.column_stack((x, v, a)).ravel())
        coupling = base_coupling(x[:n], linkage)
        torque = mass_matrix(x[:n], linkage) @ a[:n] + coupling * a[n]
        torque += velocity_torque(x[:n], v[:n], linkage)
        torque += gravity_torque(x[:n], GRAVITY, linkage)
        force = linkage.mass * a[n] + coupling @ a[:n] + base_force(x[:n], v[:n], linkage)
        assert [*torque, force] == pytest.approx(expected, abs=ROUNDING * 1e2)


def test_energy_is_kept_without_friction():
    """A free fall of both links: what potential energy is lost is kinetic energy gained."""
    linkage = nominal().linkage
    state, step = np.array([[0.3, -0.2], [0.0, 0.0]]), 1e-3

    def rate(now):
        left = velocity_torque(now[0], now[1], linkage) + gravity_torque(now[0], GRAVITY, linkage)
        return np.array([now[1], np.linalg.solve(mass_matrix(now[0], linkage), -left)])

    def energy(now):
        return kinetic_energy(now[0], now[1], 0.0, linkage) + potential_energy(
            now[0], GRAVITY, linkage
        )

    start = energy(state)
    moved = 0.0
    for _ in range(2000):
        first = rate(state)
        second = rate(state + 0.5 * step * first)
        third = rate(state + 0.5 * step * second)
        fourth = rate(state + step * third)
        state = state + step / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        moved = max(moved, kinetic_energy(state[0], state[1], 0.0, linkage))
    # A step is 1e-3 of a time of fall of some 0.3 s: (3e-3)^4 = 1e-10 an error per radian.
    assert moved > 100.0
    assert energy(state) == pytest.approx(start, abs=1e-7 * moved)
