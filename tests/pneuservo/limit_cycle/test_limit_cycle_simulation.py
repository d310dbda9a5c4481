"""Limit cycles in simulation: against the exact method, and against the plant's own events."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analog_card.linear_servo import LinearServo
from analog_card.surface_weights import state_weights
from analog_card.tuning import tune
from pneuservo.controllers import AnalogueCard, SlidingMode
from pneuservo.errors import InputError
from pneuservo.limit_cycle import (
    Loop,
    Signals,
    compare,
    exact_cycles,
    rig_loop,
    simulate_linear,
    simulate_nonlinear,
)
from pneuservo.limit_cycle.comparison import measured
from pneuservo.limit_cycle.linear_simulation import output
from pneuservo.limit_cycle.locking import locking
from pneuservo.linear import without_valve
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

SERVO = LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7)
WEIGHTS = (3265.3, 114.286, 1.0)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.mark.parametrize(
    ("signals", "asymmetry"),
    [
        (Signals(), 0.0),
        (Signals(), 0.12),
        (Signals(filtered="all"), 0.0),
        (Signals("analogue"), -0.05),
    ],
)
def test_the_linear_loop_settles_on_the_exact_cycle(signals, asymmetry):
    loop = Loop(SERVO, WEIGHTS, asymmetry=asymmetry, signals=signals)
    [exact] = exact_cycles(loop)
    shown = measured(simulate_linear(loop, duration=0.8)).cycle
    # What is left of the transient, and extremes read at samples 20 us apart.
    assert shown.frequency == pytest.approx(exact.frequency, rel=1e-4)
    assert shown.high == pytest.approx(exact.high, rel=1e-3)
    assert shown.low == pytest.approx(exact.low, rel=1e-3)
    assert shown.mean_error == pytest.approx(exact.mean_error, abs=2e-6)


def test_without_valve_the_loop_slides_on_the_ideal_course():
    loop = Loop(without_valve(SERVO), WEIGHTS)
    course = simulate_linear(loop, duration=0.3)
    assert measured(course).cycle is None
    sliding = course.time > 0.02
    assert np.max(np.abs(course.surface[sliding])) < 1e-9
    # On the surface the error decays as the double pole has it, from where it was reached.
    k = int(np.flatnonzero(sliding)[0])
    w, e = math.sqrt(WEIGHTS[0]), course.error[k]
    rate = (course.error[k + 1] - course.error[k - 1]) / (course.time[k + 1] - course.time[k - 1])
    since = course.time[k:] - course.time[k]
    ideal = (e + (rate + w * e) * since) * np.exp(-w * since)
    assert np.max(np.abs(course.error[k:] - ideal)) < 1e-6


def test_a_fast_surface_cycles_from_afar_and_slides_from_nearby():
    # 0.01 s is below the 0.0126 s of the loop without valve: a stable cycle outside an unstable.
    time = 0.01
    loop = Loop(without_valve(SERVO), (16 / time**2, 8 / time, 1.0))
    stable, unstable = exact_cycles(loop)
    assert (stable.stable, unstable.stable) == (True, False)
    far = measured(simulate_linear(loop, start_error=0.05, duration=0.8)).cycle
    assert far.frequency == pytest.approx(stable.frequency, rel=1e-3)
    assert measured(simulate_linear(loop, start_error=1e-5, duration=0.4)).cycle is None


def test_a_wide_boundary_layer_is_quiet_and_a_narrow_one_is_not():
    quiet = measured(simulate_linear(Loop(SERVO, WEIGHTS, boundary_layer=5.0), duration=0.5))
    assert quiet.cycle is None
    assert abs(quiet.mean_error) < 1e-6
    narrow = measured(simulate_linear(Loop(SERVO, WEIGHTS, boundary_layer=0.5), duration=0.5))
    [relay] = exact_cycles(Loop(SERVO, WEIGHTS))
    # A layer of an eighth of the amplitude.
    assert narrow.cycle.frequency == pytest.approx(relay.frequency, rel=0.01)


def test_output_of_relay_and_layer():
    relay = Loop(SERVO, WEIGHTS, asymmetry=0.1)
    assert output(relay, np.array([-2.0, 0.0, 3.0])) == pytest.approx([-4.5, 5.5, 5.5])
    layered = Loop(SERVO, WEIGHTS, boundary_layer=2.0)
    assert output(layered, np.array([-4.0, -1.0, 0.0, 1.0])) == pytest.approx([-5, -2.5, 0, 2.5])


@pytest.mark.parametrize(
    ("servo", "period", "allowed"),
    [
        (without_valve(LinearServo(1059.7, 17248.0, 54.945)), 1e-3, {500.0}),
        (LinearServo(1059.7, 17248.0, 54.945, 200.0, 0.7), 1e-3, {125.0, 166.7}),
        (LinearServo(1059.7, 17248.0, 54.945, 200.0, 0.7), 0.5e-3, {142.9, 166.7}),
    ],
)
def test_a_digital_relay_locks_to_whole_samples(servo, period, allowed):
    loop = Loop(servo, WEIGHTS, signals=Signals(sampling_time=period))
    found = locking(loop, starts=12)
    assert set(found.frequency.round(1)) <= allowed
    exact = {round(cycle.frequency, 1) for cycle in exact_cycles(loop)}
    assert set(found.frequency.round(1)) <= exact
    assert np.array_equal(found.frequency, locking(loop, starts=12).frequency)
    with pytest.raises(InputError, match="sampled"):
        locking(Loop(servo, WEIGHTS))


def test_the_ticked_plant_cycles_as_the_one_with_located_switching(rig):
    servo = LinearServo(valve_frequency=200.0, valve_damping=0.7)
    ticked = measured(simulate_nonlinear(rig, Loop(servo, WEIGHTS), duration=0.6)).cycle
    time = np.arange(0.0, 0.6, 20e-6)
    located = simulate(
        rig,
        time=time,
        controller=SlidingMode(boundary_layer=0.0),
        demand=0.015,
        initial=InitialState(displacement=0.006),
    ).limit_cycle(start=0.3)
    # A switching is up to one tick of 5 us late, twice a period, and the lag is answered by the
    # loop's phase: 0.3 %; extremes near 3 and 4 m/s2 follow by three times that.
    assert ticked.frequency == pytest.approx(located.frequency, rel=5e-3)
    assert ticked.high == pytest.approx(located.high, rel=0.02)
    assert ticked.low == pytest.approx(located.low, rel=0.02)


def test_analogue_differentiators_are_those_of_the_card(rig):
    figures = tune(settling_time=0.07, boundary_layer=5.0).figures
    signals = Signals(
        "analogue",
        velocity_breaks=figures.velocity_breaks,
        acceleration_breaks=figures.acceleration_breaks,
    )
    servo = LinearServo(valve_frequency=200.0, valve_damping=0.7)
    weights = (*state_weights(0.07, 1.0), 1.0)
    ticked = measured(simulate_nonlinear(rig, Loop(servo, weights, signals=signals))).cycle
    card = simulate(
        rig,
        time=np.arange(0.0, 0.4, 20e-6),
        controller=AnalogueCard(replace(figures, output_gain=math.inf)),
        demand=0.015,
        initial=InitialState(displacement=0.006),
    ).limit_cycle(start=0.2)
    # As above; the card's settings meet the weights to 0.1 %, and its surface is in volts.
    assert ticked.frequency == pytest.approx(card.frequency, rel=5e-3)
    assert ticked.high / ticked.low == pytest.approx(card.high / card.low, rel=0.02)


def test_digital_differences_are_those_of_the_displacement(rig):
    period = 1e-3
    loop = Loop(SERVO, WEIGHTS, signals=Signals("backward", period))
    course = simulate_nonlinear(rig, loop, duration=0.2)
    every = round(period / (course.time[1] - course.time[0]))
    error, surface = -course.error[::every], course.surface[::every]
    c1, c2, c3 = loop.weights
    # Equation (8.6).
    expected = -(
        (c3 / period**2 + c2 / period + c1) * error[2:]
        - (2 * c3 / period**2 + c2 / period) * error[1:-1]
        + c3 / period**2 * error[:-2]
    )
    # Rounding of metres over the square of the period.
    assert surface[2:] == pytest.approx(expected, abs=1e-8)
    assert set(np.unique(course.voltage)) <= {-5.0, 5.0}


def test_without_valve_the_non_linear_loop_slides(rig):
    found = measured(simulate_nonlinear(rig, Loop(without_valve(SERVO), WEIGHTS)))
    assert found.cycle is None
    assert "slides" in found.note


def test_a_long_stroke_is_followed_until_it_cycles(rig):
    stroke = replace(rig.parameters["piston.stroke"], value=0.5)
    long = replace(rig, parameters={**rig.parameters, "piston.stroke": stroke})
    loop = rig_loop(long, 0.25)
    found = compare(loop, long, 0.25)
    [exact] = exact_cycles(loop)
    # The step of 150 mm takes half a second at full voltage.
    assert found["linear_simulation"].cycle.frequency == pytest.approx(exact.frequency, rel=1e-3)
    assert found["nonlinear_simulation"].cycle.frequency == pytest.approx(exact.frequency, rel=0.1)


def test_what_was_not_followed_long_enough_is_not_said_to_settle():
    loop = Loop(SERVO, WEIGHTS)
    afar = measured(simulate_linear(loop, start_error=0.15, duration=0.3))
    assert afar.cycle is None
    assert "still on the way to the surface after 0.15 of the 0.3 s" in afar.note
    brief = measured(simulate_linear(loop, duration=0.04))
    assert brief.cycle is None
    assert "too few whole periods" in brief.note


def test_all_methods_side_by_side(rig):
    found = compare(Loop(SERVO, WEIGHTS), rig, 0.003)
    assert list(found) == [
        "describing_function",
        "exact",
        "linear_simulation",
        "nonlinear_simulation",
    ]
    for finding in found.values():
        values = finding.to_dict()
        assert {"frequency", "amplitude", "stable", "mean_error"} <= set(values)
        # A second-order valve at 202 Hz limits all of them.
        assert 170.0 < values["frequency"] < 240.0
        assert values["stable"]
    # Controlled to 3 mm, the step comes from the side with room.
    assert found["nonlinear_simulation"].course.error[0] < 0.0
    layered = compare(Loop(SERVO, WEIGHTS, boundary_layer=5.0))
    assert [finding.cycle for finding in layered.values()] == [None, None, None]
    assert all(finding.note for finding in layered.values())
