"""Surfaces, their weights, and the spaces in which they are reachable."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from analog_card.linear_servo import LinearServo
from pneuservo.errors import InputError
from pneuservo.linear import (
    advanced_servo,
    conventional_servo,
    state_space,
    table_5_2,
    without_valve,
)
from pneuservo.sliding_mode.equivalent_control import (
    equivalent_gains,
    is_attracted,
    is_controllable,
    servo_gains,
    worst_equivalent_control,
)
from pneuservo.sliding_mode.range_space import RangeSpace, linear_limits
from pneuservo.sliding_mode.reachability import (
    control_along_motion,
    fastest_along_motions,
    fastest_settling_time,
    opened,
    reachability,
    shortest_without_limit_cycle,
)
from pneuservo.sliding_mode.reaching import reaching_phase, sliding_phase
from pneuservo.sliding_mode.sizing import required_opening, required_supply_pressure
from pneuservo.sliding_mode.surface import (
    Surface,
    damping_from_overshoot,
    equal_pole_surface,
    largest_rate,
    surface_from_settling_time,
)

# The thesis' (7.13).
PRINTED_SPACE = RangeSpace((-0.03, 0.03), (-0.25, 0.356), (-67.0, 82.0))


@pytest.fixture(scope="module")
def servo():
    return without_valve(conventional_servo(table_5_2()))


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_surfaces_of_any_order_settle_in_the_time_asked_for(order):
    surface = surface_from_settling_time(0.07, 0.8, order)
    assert surface.order == order
    assert surface.settling_time == pytest.approx(0.07, rel=1e-6)
    poles = np.sort(-surface.poles.real)
    assert poles[0] == pytest.approx(4 / 0.07, rel=1e-6)


def test_weights_of_the_thesis():
    # (7.15).
    assert surface_from_settling_time(0.07).weights == pytest.approx(
        (3265.306, 114.2857, 1.0), rel=1e-6
    )
    assert equal_pole_surface(57.142857, 2).weights == pytest.approx(
        (3265.306, 114.2857, 1.0), rel=1e-6
    )


def test_an_unstable_surface_is_refused():
    with pytest.raises(InputError, match="not stable"):
        Surface((-1.0, 2.0, 1.0))
    with pytest.raises(InputError, match="not stable"):
        Surface((5.0, 1.0, 1.0, 1.0))
    with pytest.raises(InputError, match="two finite weights"):
        Surface((1.0,))
    with pytest.raises(InputError, match="settling time"):
        surface_from_settling_time(-1.0)


def test_rate_limits():
    assert largest_rate(structural_frequency=30.0) == pytest.approx(2 * math.pi * 10.0)
    assert largest_rate(structural_frequency=30.0, delay=0.01) == pytest.approx(1 / 0.03)


def test_overshoot_and_damping_are_inverse():
    for damping in (0.3, 0.7, 0.95):
        overshoot = math.exp(-math.pi * damping / math.sqrt(1 - damping**2))
        assert damping_from_overshoot(overshoot) == pytest.approx(damping)
    assert damping_from_overshoot(0.0) == 1.0


def test_equivalent_control_is_7_7(servo):
    surface = surface_from_settling_time(0.07)
    c1, c2, c3 = surface.weights
    expected = (0.0, (c3 * servo.a1 - c1) / (c3 * servo.b0), (c3 * servo.a2 - c2) / (c3 * servo.b0))
    assert servo_gains(servo, surface) == pytest.approx(expected)


def test_parameter_changes_are_7_10(servo):
    surface = surface_from_settling_time(0.07)
    c1, c2, c3 = surface.weights
    actual = replace(servo, b0=1.3 * servo.b0, a1=0.8 * servo.a1, a2=1.5 * servo.a2)
    db, da1, da2 = actual.b0 - servo.b0, actual.a1 - servo.a1, actual.a2 - servo.a2
    ratio = db / servo.b0
    expected = np.array(
        [0.0, da1 - ratio * (servo.a1 - c1 / c3), da2 - ratio * (servo.a2 - c2 / c3)]
    ) / (servo.b0 + db)
    assert servo_gains(actual, surface) - servo_gains(servo, surface) == pytest.approx(expected)


def test_equivalent_control_keeps_a_plant_of_fifth_order_on_its_surface():
    # (6.22), (6.23): along the surface the rate of sigma is zero.
    system = state_space(advanced_servo(table_5_2(), 0.015, True))
    # To the canonical states, the displacement and its derivatives: rows of c A^k.
    c = np.eye(1, 5)
    rows = np.vstack([c @ np.linalg.matrix_power(system.A, k) for k in range(5)])
    a, b = rows @ system.A @ np.linalg.inv(rows), rows @ system.B
    surface = surface_from_settling_time(0.07, order=4)
    gains = equivalent_gains(a, b, surface)
    weights = np.array(surface.weights)
    assert weights @ (a + b @ gains[np.newaxis]) == pytest.approx(
        np.zeros(5), abs=1e-3 * abs(weights @ a).max()
    )
    with pytest.raises(InputError, match="weights"):
        equivalent_gains(a, b, surface_from_settling_time(0.07))


def test_the_worst_control_is_that_of_a_linear_programme(servo):
    generator = np.random.default_rng(0)
    for _ in range(40):
        surface = surface_from_settling_time(
            generator.uniform(0.01, 0.5), generator.uniform(0.3, 1)
        )
        gains = servo_gains(servo, surface)
        low, high = -generator.uniform(0.1, 1.0, 3), generator.uniform(0.1, 1.0, 3)
        scale = np.array([0.03, 0.4, 90.0])
        space = RangeSpace(
            *[(float(a), float(b)) for a, b in zip(low * scale, high * scale, strict=True)]
        )
        bounds = [space.displacement, space.velocity, space.acceleration]
        best = [
            linprog(sign * gains, A_eq=[surface.weights], b_eq=[0.0], bounds=bounds).fun
            for sign in (1.0, -1.0)
        ]
        found = worst_equivalent_control(gains, surface, space)
        assert found.voltage == pytest.approx(-min(best), rel=1e-6)
        assert surface.value(*found.state) == pytest.approx(0.0, abs=1e-9 * surface.weights[0])


def test_attraction_is_7_6(servo):
    surface = surface_from_settling_time(0.05)
    gains = servo_gains(servo, surface)
    generator = np.random.default_rng(1)
    e, v, a = (generator.uniform(-s, s, 500) for s in (0.03, 0.75, 95.0))
    sigma = np.array([surface.value(*row) for row in zip(e, v, a, strict=True)])
    u = 5.0 * np.sign(sigma)
    # The rate of sigma by the equation of motion.
    jerk = servo.b0 * u - servo.a1 * v - servo.a2 * a
    c1, c2, c3 = surface.weights
    rate = -(c1 * v + c2 * a + c3 * jerk)
    assert np.array_equal(is_attracted(gains, surface, (e, v, a), 5.0), sigma * rate < 0.0)
    # Inside the controllability space both signs of the voltage move sigma their own way.
    inside = is_controllable(gains, v, a, 5.0)
    assert np.all(is_attracted(gains, surface, (e, v, a), 5.0)[inside])
    assert inside.any()
    assert not inside.all()


def test_linear_limits_are_peaks_of_the_frequency_response(servo):
    limits = linear_limits(servo, 5.0)
    frequency = np.linspace(0.01, 2000.0, 2_000_001)
    w = 2 * np.pi * frequency
    response = 5.0 * np.abs(servo.response(frequency))
    assert limits.velocity == pytest.approx((w * response).max(), rel=1e-6)
    assert limits.acceleration == pytest.approx((w**2 * response).max(), rel=1e-6)
    assert limits.jerk_peak == pytest.approx((w**3 * response).max(), rel=1e-6)
    assert limits.jerk_high == pytest.approx((w**3 * response)[-1], rel=1e-3)
    # (7.12): 0.75 m/s, 95 m/s2, 12696 and 5225 m/s3, which the reconciled b0 and a1 give.
    reconciled = linear_limits(replace(servo, b0=1045.0, a1=17046.0), 5.0)
    found = (
        reconciled.velocity,
        reconciled.acceleration,
        reconciled.jerk_peak,
        reconciled.jerk_high,
    )
    assert found == pytest.approx((0.75, 95.0, 12696.0, 5225.0), rel=0.007)
    damped = linear_limits(replace(servo, a2=300.0), 5.0)
    assert damped.velocity == pytest.approx(5.0 * servo.b0 / servo.a1)
    with pytest.raises(InputError, match="no viscous friction"):
        linear_limits(replace(servo, a2=0.0), 5.0)


def test_figure_7_7_at_6_5_bar(servo):
    # The thesis: opening 1.2 at the least, 0.05 s at opening 2; E21 of the errata 1.16 and 0.055 s.
    def fastest(opening):
        return fastest_settling_time([opened(servo, opening)], PRINTED_SPACE, 5.0)

    assert fastest(1.1) is None
    assert fastest(1.2) == pytest.approx(0.122, abs=2e-3)
    assert fastest(2.0) == pytest.approx(0.054, abs=1e-3)
    assert reachability(
        [opened(servo, 2.0)], surface_from_settling_time(0.0545), PRINTED_SPACE, 5.0
    ).reachable
    # Whether a set is reachable follows from its worst member.
    assert fastest_settling_time([servo, opened(servo, 2.0)], PRINTED_SPACE, 5.0) is None


def test_slower_surfaces_can_violate_where_faster_ones_do_not(servo):
    # Figures 7.10 and 7.11: 0.05 s is repelled on its way from 30 mm, 0.02 s is not.
    for settling_time, repelled in ((0.05, True), (0.02, False)):
        surface = surface_from_settling_time(settling_time)
        states = reaching_phase(servo, surface, 5.0, -0.03).states[:-1]
        gains = servo_gains(servo, surface)
        attracted = is_attracted(gains, surface, tuple(states.T), 5.0)
        assert (not attracted.all()) == repelled


def test_the_boundary_along_motions(servo):
    found = fastest_along_motions([servo], 5.0, [-0.03])
    assert found == pytest.approx(0.0881, abs=5e-4)
    for factor, within in ((1.02, True), (0.98, False)):
        surface = surface_from_settling_time(factor * found)
        assert (control_along_motion(servo, surface, 5.0, -0.03) <= 5.0) == within
    # With the sliding motion it takes longer: where it begins all of the velocity is there.
    assert fastest_along_motions([servo], 5.0, [-0.03], sliding=True) > found
    # Symmetric plant, symmetric errors.
    assert fastest_along_motions([servo], 5.0, [0.03]) == pytest.approx(found, abs=2e-5)


def test_reaching_time_of_the_chosen_surface():
    # Thesis: 0.065 s from 30 mm. E: extending 0.0634 s, with the valve 0.0645 s.
    surface = surface_from_settling_time(0.07)
    servo = advanced_servo(table_5_2(), 0.015, True)
    assert reaching_phase(without_valve(servo), surface, 5.0, -0.03).time == pytest.approx(
        0.0634, abs=5e-5
    )
    assert reaching_phase(servo, surface, 5.0, -0.03).time == pytest.approx(0.0645, abs=5e-5)
    # At a fiftieth of the level full speed takes 5 s: the surface is met a little before.
    slow = without_valve(servo)
    alone = 0.03 * slow.a1 / (slow.b0 * 0.1)
    assert 0.9 * alone < reaching_phase(slow, surface, 0.1, -0.03).time < alone
    with pytest.raises(
        InputError, match=r"within 2 s at 0\.001 V from a step of 30 mm; give a small"
    ):
        reaching_phase(LinearServo(1.0, 1e-9, 1.0), surface, 1e-3, -0.03)
    with pytest.raises(InputError, match="error is 0"):
        reaching_phase(servo, surface, 5.0, 0.0)


def test_sliding_is_the_motion_of_a_double_pole():
    surface = surface_from_settling_time(0.07)
    w = 4 / 0.07
    states = sliding_phase(surface, np.array([-0.01, 0.4, -(0.4 * 2 * w - 0.01 * w * w)]))
    time = np.linspace(0.0, 2 * 0.07, len(states))
    # e = (e0 + (v0 + w e0) t) exp(-w t).
    expected = (-0.01 + (0.4 - 0.01 * w) * time) * np.exp(-w * time)
    assert states[:, 0] == pytest.approx(expected, abs=1e-12)
    assert [surface.value(*row) for row in states] == pytest.approx(np.zeros(len(states)), abs=1e-9)


def test_the_shortest_settling_time_without_limit_cycle(servo):
    shortest = shortest_without_limit_cycle(servo)
    assert shortest == pytest.approx(0.0126, abs=5e-5)  # thesis: 0.013 s

    def crosses(settling_time):
        c1, c2, c3 = surface_from_settling_time(settling_time).weights
        frequency = np.geomspace(1.0, 1e4, 200_001)
        s = 2j * np.pi * frequency
        loop = servo.response(frequency) * (c3 * s * s + c2 * s + c1)
        # Continuous phase, from -90 degrees at the low end.
        return np.unwrap(np.angle(loop)).min() <= -np.pi

    assert crosses(0.99 * shortest)
    assert not crosses(1.01 * shortest)


def test_sizing(servo):
    data, surface = table_5_2(), surface_from_settling_time(0.05)

    def models(changed):
        return [conventional_servo(changed)]

    opening = required_opening([servo], surface, PRINTED_SPACE, 5.0)
    enlarged = opened(servo, opening)
    worst = worst_equivalent_control(servo_gains(enlarged, surface), surface, PRINTED_SPACE)
    assert worst.voltage == pytest.approx(5.0)
    # A wider surface and a narrow box: a lower supply is softer, and then enough.
    narrow = RangeSpace((-0.03, 0.03), (-0.1, 0.1), (-10.0, 10.0))
    pressure = required_supply_pressure(data, models, surface, narrow, 5.0)
    assert pressure is not None
    assert required_supply_pressure(data, models, surface, PRINTED_SPACE, 5.0) is None
