"""Laws and the plants they are tried on; each remedy against the plain law."""

import math

import numpy as np
import pytest

from analog_card.linear_servo import LinearServo
from pneuservo.controllers import SlidingMode
from pneuservo.controllers.boundary_layer import boundary_layer, smooth_boundary_layer
from pneuservo.errors import InputError
from pneuservo.linear import advanced_servo, table_5_2, without_valve
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate
from pneuservo.sliding_mode.boundary_layer import layer_cut_off, layer_width
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.laws import (
    IntegralAction,
    PiecewiseLinear,
    SwitchedGains,
    Switching,
    balanced_levels,
    equal_jerk_levels,
    reaching_gains,
)
from pneuservo.sliding_mode.loop import run_loop
from pneuservo.sliding_mode.plants import LinearPlant, NonlinearPlant, UpdatePlant
from pneuservo.sliding_mode.second_order import (
    SecondOrderPlant,
    phase_trajectory,
    slides_at_once,
    sliding_displacement,
)
from pneuservo.sliding_mode.surface import surface_from_settling_time

SURFACE = surface_from_settling_time(0.07)
RIG = load_rig("single-axis")


@pytest.fixture(scope="module")
def data():
    return table_5_2()


def test_the_boundary_layers():
    sigma = np.linspace(-20.0, 20.0, 81)
    fixed = np.array([boundary_layer(s, 5.0, 5.0) for s in sigma])
    smooth = np.array([smooth_boundary_layer(s, 5.0, 5.0) for s in sigma])
    assert fixed == pytest.approx(np.clip(sigma, -5.0, 5.0))
    assert np.all(np.abs(smooth) < 5.0)
    # Equal gains at the surface.
    assert smooth_boundary_layer(1e-9, 5.0, 5.0) == pytest.approx(1e-9, rel=1e-6)
    assert boundary_layer(0.0, 5.0, 0.0) == 0.0
    assert layer_width(1045.0, 5.0, layer_cut_off(1045.0, 5.0, 7.0)) == pytest.approx(7.0)


def test_the_linear_plant_is_exact(data):
    servo = advanced_servo(data, 0.015, True)
    coarse, fine = LinearPlant(servo, 0.0), LinearPlant(servo, 0.0)
    coarse.advance(3.0, 0.02)
    for _ in range(200):
        fine.advance(3.0, 1e-4)
    assert coarse.motion() == pytest.approx(fine.motion(), rel=1e-8)
    # The derivatives are those of the displacement.
    before, step = fine.motion(), 1e-6
    fine.advance(3.0, step)
    after = fine.motion()
    for k in range(4):
        assert (after[k] - before[k]) / step == pytest.approx(before[k + 1], rel=1e-2, abs=1e-6)


def test_the_update_plant_without_a_change_of_position_is_linear(data):
    update = UpdatePlant(data, 0.015)
    linear = LinearPlant(advanced_servo(data, 0.015, True), 0.015)
    for _ in range(40):
        update.advance(1e-3, 5e-5)
        linear.advance(1e-3, 5e-5)
    assert update.motion() == pytest.approx(linear.motion()[:3], rel=1e-5)


def test_the_non_linear_plant_is_the_simulated_one():
    plant = NonlinearPlant(RIG, 0.012)
    step = 20e-6
    for _ in range(1000):
        plant.advance(2.0, step)
    run = simulate(
        RIG,
        time=[0.0, 0.02],
        command=2.0,
        initial=InitialState(displacement=0.012),
        largest_step=step,
    )
    found = [run[name][-1] for name in ("displacement", "velocity", "acceleration")]
    assert plant.motion() == pytest.approx(found, rel=1e-6)


def test_the_plain_law_chatters_as_in_table_8_1():
    run = run_loop(NonlinearPlant(RIG, 0.006), Switching(SURFACE, 5.0), 0.015, 0.5, 20e-6)
    time = np.arange(0.0, 0.5, 2e-5)
    compiled = simulate(
        RIG,
        time=time,
        controller=SlidingMode(boundary_layer=0.0),
        demand=0.015,
        initial=InitialState(displacement=0.006),
    )
    # The same law in the compiled plant; switching up to one step of 20 us late each time, of
    # some 2.6 ms, moves the mean by the asymmetry's share of that.
    assert run.mean_error() == pytest.approx(compiled.steady_state_error(0.3), abs=15e-6)
    assert run.swing() == pytest.approx(np.ptp(compiled.surface[-7500:]), rel=0.05)


def test_levels_by_direction():
    strong, weak = LinearServo(b0=1000.0), LinearServo(b0=800.0)
    assert equal_jerk_levels(weak, strong, 5.0) == pytest.approx((5.0, 4.0))
    # A valve that follows the switching would need equal jerk; a slow one needs less.
    reduced, full = balanced_levels(strong, weak, 5.0, strong.valve_frequency)
    assert 4.0 < reduced < full == 5.0
    assert balanced_levels(weak, strong, 5.0, 200.0) == (full, reduced)
    # The sine about the mean level spends equal jerk on either side; at its own frequency the
    # valve passes 1/(2 damping) of it.
    mean, offset = 0.5 * (full + reduced), 0.5 * (full - reduced)
    sine = np.sin(np.linspace(0, 2 * np.pi, 200_001)[:-1])
    w = 4 / math.pi * mean / (2 * strong.valve_damping) * sine - offset
    assert np.mean(np.where(w > 0, 1000.0, 800.0) * w) == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize(
    "plant", [lambda data: UpdatePlant(data, 0.006), lambda _: NonlinearPlant(RIG, 0.006)]
)
def test_levels_by_direction_remove_the_error_of_asymmetric_switching(data, plant):
    plain = run_loop(plant(data), Switching(SURFACE, 5.0), 0.015, 0.4)
    out, back = (advanced_servo(data, 0.015, way) for way in (True, False))
    # It chatters at some 190 Hz.
    up, down = balanced_levels(out, back, 5.0, 190.0)
    remedy = run_loop(plant(data), Switching(SURFACE, up, retracting_level=down), 0.015, 0.4)
    assert abs(plain.mean_error()) > 0.1e-3
    assert abs(remedy.mean_error()) < 0.3 * abs(plain.mean_error())


@pytest.mark.parametrize(
    "plant", [lambda data: UpdatePlant(data, 0.006), lambda _: NonlinearPlant(RIG, 0.006)]
)
def test_integral_action_removes_the_error_of_asymmetric_switching(data, plant):
    plain = run_loop(plant(data), Switching(SURFACE, 5.0), 0.015, 0.6)
    law = IntegralAction(Switching(SURFACE, 5.0), rate=10.0, within=0.5e-3)
    remedy = run_loop(plant(data), law, 0.015, 0.6)
    assert abs(plain.mean_error(0.2)) > 0.1e-3
    # Some 0.4 s after arriving an integral of 10 1/s has exp(-4) of the error left, and the
    # non-linear plant, whose asymmetry changes as its pressures settle, a little more.
    assert abs(remedy.mean_error(0.2)) < 0.15 * abs(plain.mean_error(0.2))
    # No more overshoot than a fortieth of the step.
    assert remedy.displacement.max() < 0.015 + 0.009 / 40


def test_a_surface_that_takes_in_the_valve_chatters_no_more(data):
    servo = advanced_servo(data, 0.015, True)
    plain = run_loop(LinearPlant(servo, 0.006), Switching(SURFACE, 5.0), 0.015, 0.3, 2e-5)
    whole = surface_from_settling_time(0.07, order=4, further=8.0)
    remedy = run_loop(LinearPlant(servo, 0.006), Switching(whole, 5.0), 0.015, 0.3, 2e-5)
    ripple = [np.ptp(run.acceleration[-2000:]) for run in (plain, remedy)]
    # The plain law swings by some 9 m/s2 at about 190 Hz, the other only as fast as it is stepped.
    assert ripple[0] > 8.0
    assert ripple[1] < 0.01 * ripple[0]


def test_a_piecewise_linear_surface_keeps_a_large_step_controllable(data):
    servo = without_valve(advanced_servo(data, 0.015, True))
    gains = servo_gains(servo, SURFACE)
    plain = run_loop(LinearPlant(servo, 0.0), Switching(SURFACE, 5.0), 0.03, 0.25)
    law = PiecewiseLinear(Switching(SURFACE, 5.0), largest_velocity=0.2)
    bent = run_loop(LinearPlant(servo, 0.0), law, 0.03, 0.25)
    needed = [
        np.max(np.abs(gains[1] * run.velocity + gains[2] * run.acceleration))
        for run in (plain, bent)
    ]
    assert needed[0] > 5.0 > needed[1]
    assert bent.velocity.max() < 0.25
    # Both arrive; inside the inner piece both laws are the same.
    for run in (plain, bent):
        assert run.displacement[-1] == pytest.approx(0.03, abs=1e-4)
    assert law.sigma((0.001, 0.1, 3.0)) == SURFACE.value(0.001, 0.1, 3.0)
    with pytest.raises(InputError, match="largest velocity"):
        PiecewiseLinear(Switching(SURFACE, 5.0), 0.0)


def test_switched_gains_chatter_less_near_the_goal(data):
    servos = [without_valve(advanced_servo(data, 0.015, way)) for way in (True, False)]
    relay = run_loop(LinearPlant(servos[0], 0.006), Switching(SURFACE, 5.0), 0.015, 0.3)
    gains = reaching_gains(servos, SURFACE, displacement_gain=2000.0)
    switched = run_loop(
        LinearPlant(servos[0], 0.006), SwitchedGains(SURFACE, gains, 5.0), 0.015, 0.3
    )
    assert switched.displacement[-1] == pytest.approx(0.015, abs=2e-5)
    last = slice(-1000, None)
    assert np.abs(switched.voltage[last]).max() < 0.2 * np.abs(relay.voltage[last]).max()
    with pytest.raises(InputError, match="displacement gain"):
        reaching_gains(servos, SURFACE, 0.0)


def test_reaching_gains_drive_every_state_to_the_surface(data):
    # (6.15) by the equation of motion, for both directions, as long as the level is not reached.
    servos = [without_valve(advanced_servo(data, 0.015, way)) for way in (True, False)]
    law = SwitchedGains(SURFACE, reaching_gains(servos, SURFACE, 100.0), level=math.inf)
    c1, c2, c3 = SURFACE.weights
    generator = np.random.default_rng(2)
    for e, v, a in generator.uniform(-1.0, 1.0, (200, 3)) * (0.03, 0.3, 60.0):
        sigma, u = law.sigma((e, v, a)), law.voltage((e, v, a), 1e-5)
        for servo in servos:
            jerk = servo.b0 * u - servo.a1 * v - servo.a2 * a
            assert sigma * -(c1 * v + c2 * a + c3 * jerk) < 0.0


def test_the_sliding_domain_of_the_second_order_plant():
    plant = SecondOrderPlant(friction=8.0, stiffness=100.0, gain=50.0)  # wn 10, damping 0.4
    for slope in (5.0, 12.0, 30.0):
        x = sliding_displacement(plant, slope, 2.0)
        # At the edge one of the two voltages no longer turns the motion back to the line.
        v = -slope * x
        rates = [slope * v + plant.acceleration(x, v, u) for u in (-2.0, 2.0)]
        assert min(abs(rate) for rate in rates) == pytest.approx(0.0, abs=1e-9)
    # Figures 6.7 to 6.10: grows with the level, the damping; falls with c1 and wn.
    assert sliding_displacement(plant, 30.0, 2.0) < sliding_displacement(plant, 20.0, 2.0)
    assert sliding_displacement(plant, 20.0, 4.0) == 2 * sliding_displacement(plant, 20.0, 2.0)
    assert sliding_displacement(SecondOrderPlant(20.0, 100.0, 50.0), 10.0, 1.0) == math.inf


def test_phase_trajectories_of_section_6_2():
    plant = SecondOrderPlant(friction=10.0, stiffness=0.0, gain=10.0)
    gentle = phase_trajectory(plant, 6.0, 1.0, (1.0, 0.0), 3.0)
    assert gentle.switchings == 1
    later = gentle.time > gentle.sliding_from
    assert gentle.velocity[later] == pytest.approx(-6.0 * gentle.displacement[later], abs=1e-12)
    # Before the line it is the motion at full voltage: v = -b U/a (1 - exp(-a t)).
    before = gentle.time < gentle.sliding_from
    assert gentle.velocity[before] == pytest.approx(
        -(1 - np.exp(-10.0 * gentle.time[before])), abs=1e-9
    )
    # A line too steep for the plant is crossed before it is followed.
    steep = phase_trajectory(plant, 40.0, 1.0, (1.0, 0.0), 3.0)
    assert not slides_at_once(plant, 40.0)
    assert slides_at_once(plant, 15.0)
    assert steep.switchings > 1
    with pytest.raises(InputError, match="no stiffness"):
        slides_at_once(SecondOrderPlant(1.0, 1.0, 1.0), 1.0)
