"""Describing function and exact method: analytic limits, and figures worked out elsewhere."""

import math

import numpy as np
import pytest

from analog_card.linear_servo import LinearServo, limit_cycle
from pneuservo.errors import InputError
from pneuservo.limit_cycle import (
    Loop,
    Signals,
    describing_function_cycles,
    dominant,
    exact_cycles,
    loop_response,
    rig_loop,
)
from pneuservo.linear import without_valve
from pneuservo.rigs import load_rig

# The conventional model of table 5.2, and what reproduces the thesis' chapter 8.
PRINTED = LinearServo(1059.7, 17248.0, 54.945, 200.0, 0.7), (3265.3, 114.286, 1.0)
RECONCILED = LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0)
ALL, SOME = Signals(filtered="all"), Signals(filtered="displacement-velocity")

# Independent figures for both sets, [Hz] and [m/s2], to the digits they were given with.
WORKED_OUT = [
    # signals, valve, printed, reconciled
    (Signals(), True, (193.4, 4.15), (201.8, 3.78)),
    (ALL, True, (140.7, 7.04), (147.4, 6.48)),
    (SOME, True, (195.2, 3.87), (203.0, 3.64)),
    (Signals(sampling_time=1e-3), True, (137.5, 7.06), (144.2, 6.47)),
    (Signals(sampling_time=1e-3, filtered="all"), True, (109.4, 9.64), (115.7, 8.78)),
    (Signals(sampling_time=1e-3), False, (500.0, 3.38), (500.0, 3.33)),
    (Signals("backward", 1e-3), False, (161.9, 6.28), (166.9, 5.77)),
    (Signals("backward", 0.5e-3), False, (328.5, 2.96), (333.6, 2.82)),
    (Signals("backward", 0.1e-3), False, (1661.7, 0.57), (1667.0, 0.56)),
    (Signals("backward", 1e-3), True, (87.9, 13.0), (93.5, 11.4)),
    (Signals("backward", 0.5e-3), True, (121.0, 8.75), (127.2, 7.92)),
    (Signals("backward", 0.1e-3), True, (171.7, 5.19), (179.1, 4.75)),
]


def loop_of(plant, signals=None, valve=True, **changes):
    servo, weights = plant
    servo = servo if valve else without_valve(servo)
    return Loop(servo, weights, signals=signals or Signals(), **changes)


@pytest.mark.parametrize(("signals", "valve", "printed", "reconciled"), WORKED_OUT)
def test_describing_function_against_independent_figures(signals, valve, printed, reconciled):
    for plant, (frequency, amplitude) in ((PRINTED, printed), (RECONCILED, reconciled)):
        cycle = dominant(describing_function_cycles(loop_of(plant, signals, valve)))
        # Half a unit of the last digit given, and 0.05 % for the rounded weights.
        assert cycle.frequency == pytest.approx(frequency, abs=0.05, rel=5e-4)
        digits = 0.05 if amplitude > 10.0 else 0.005
        assert cycle.amplitude == pytest.approx(amplitude, abs=digits, rel=5e-4)
        assert cycle.stable


def test_acceleration_alone_cycles_at_the_valve_frequency():
    # b0/s lags a quarter turn, the valve another at its own frequency, where it is 1/(2 damping).
    loop = Loop(LinearServo(1000.0, 1e-9, 1e-9, 180.0, 0.6), (1e-9, 0.0, 1.0), level=4.0)
    [cycle] = describing_function_cycles(loop)
    expected = 4.0 / math.pi * 4.0 * 1000.0 / (2 * math.pi * 180.0) / (2 * 0.6)
    assert cycle.frequency == pytest.approx(180.0, rel=1e-9)
    assert cycle.amplitude == pytest.approx(expected, rel=1e-9)


def test_differences_of_a_triple_integrator_cycle_at_a_sixth_of_the_sampling_frequency():
    servo = LinearServo(1000.0, 1e-9, 1e-9, math.inf, 0.7)
    loop = Loop(servo, (1e-9, 0.0, 1.0), signals=Signals("backward", 1e-3))
    assert describing_function_cycles(loop)[0].frequency == pytest.approx(1000.0 / 6, rel=1e-6)


def test_the_cards_own_prediction_is_the_same():
    loop = loop_of(RECONCILED, Signals("analogue", velocity_breaks=(3e3, 4e3)))
    f = np.geomspace(20.0, 1000.0, 4000)
    frequency, amplitude = limit_cycle(f, loop_response(loop, f), loop.level)
    cycle, *faster = describing_function_cycles(loop)
    # Another turn later the loop is real again, with a cycle that the slower mode leaves.
    assert not any(other.stable for other in faster)
    # Interpolated there between points 0.1 % apart.
    assert cycle.frequency == pytest.approx(frequency, rel=1e-5)
    assert cycle.amplitude == pytest.approx(amplitude, rel=1e-5)


def test_without_valve_there_is_no_cycle_down_to_13_ms():
    # sqrt(ws) solves ws - sqrt(a1) = sqrt(2 a2 ws), in closed form.
    servo = without_valve(PRINTED[0])
    half = math.sqrt(servo.a2 / 2)
    fastest = 4.0 / (half + math.sqrt(half**2 + math.sqrt(servo.a1))) ** 2
    assert fastest == pytest.approx(0.01256, abs=5e-6)
    for time, cycles in ((1.002 * fastest, 0), (0.998 * fastest, 2)):
        found = describing_function_cycles(Loop(servo, (16 / time**2, 8 / time, 1.0)))
        assert len(found) == cycles
        assert [cycle.stable for cycle in found] == [True, False][:cycles]


def test_a_boundary_layer_as_wide_as_the_loop_allows_ends_the_cycle():
    loop = loop_of(RECONCILED)
    [relay] = describing_function_cycles(loop)
    # Inside the layer the gain is level/layer; it is just enough at pi/4 of the relay's amplitude.
    widest = math.pi / 4 * relay.amplitude
    [cycle] = describing_function_cycles(loop_of(RECONCILED, boundary_layer=0.99 * widest))
    assert cycle.frequency == pytest.approx(relay.frequency, rel=1e-9)
    assert widest * 0.99 < cycle.amplitude < relay.amplitude
    assert describing_function_cycles(loop_of(RECONCILED, boundary_layer=1.01 * widest)) == []


@pytest.mark.parametrize(
    ("plant", "signals", "frequency", "amplitude"),
    [
        (PRINTED, Signals(), 190.7, 4.24),
        (PRINTED, ALL, 139.1, 7.26),
        (PRINTED, SOME, 192.4, 3.95),
        (RECONCILED, Signals(), 199.2, 3.86),
        (RECONCILED, ALL, 146.0, 6.65),
        (RECONCILED, SOME, 200.4, 3.72),
    ],
)
def test_exact_method_against_independent_figures(plant, signals, frequency, amplitude):
    [cycle] = exact_cycles(loop_of(plant, signals))
    assert cycle.frequency == pytest.approx(frequency, abs=0.06)
    assert cycle.amplitude == pytest.approx(amplitude, abs=0.006)
    assert cycle.stable
    assert abs(cycle.mean_error) < 1e-9


def test_exact_amplitude_of_switching_at_every_sample():
    # The acceleration changes by b0 times the voltage times the sampling time, and nothing else.
    servo = LinearServo(1000.0, 1e-9, 1e-9, math.inf, 0.7)
    cycles = exact_cycles(Loop(servo, (1e-6, 0.0, 1.0), signals=Signals(sampling_time=1e-3)))
    fastest = cycles[-1]
    assert fastest.frequency == pytest.approx(500.0)
    assert fastest.high - fastest.low == pytest.approx(1000.0 * 5.0 * 1e-3, rel=1e-6)


def test_bilinear_differences_have_no_stable_cycle():
    # Their ringing at half the sampling frequency grows.
    cycles = exact_cycles(loop_of(PRINTED, Signals("bilinear", 1e-3)))
    assert cycles
    assert not any(cycle.stable for cycle in cycles)


def test_asymmetry_shifts_the_piston_towards_the_stronger_direction():
    loop = loop_of(PRINTED, asymmetry=0.12)
    [exact], [approximate] = exact_cycles(loop), describing_function_cycles(loop)
    for cycle in (exact, approximate):
        assert cycle.mean_error < 0.0
        assert cycle.asymmetry < 0.0
    # First harmonic against all of them: as far apart as the symmetric cycles are, squared.
    assert approximate.mean_error == pytest.approx(exact.mean_error, rel=0.08)
    # The swing that is shifted is the cycle's own, not that of a symmetric relay.
    share = math.sin(0.5 * math.pi * 0.12) / loop.weights[0]
    assert approximate.mean_error == pytest.approx(-share * approximate.amplitude, rel=1e-9)
    mirrored = exact_cycles(loop_of(PRINTED, asymmetry=-0.12))[0]
    assert mirrored.high == pytest.approx(-exact.low, rel=1e-6)
    assert mirrored.mean_error == pytest.approx(-exact.mean_error, rel=1e-6)


def test_the_rigs_loop_is_that_of_its_linear_model():
    rig = load_rig("single-axis")
    loop = rig_loop(rig, 0.015, settling_time=0.07)
    assert loop.weights[0] == pytest.approx(3265.3, abs=0.05)
    up, down = loop.levels
    assert 0.5 * (up + down) == pytest.approx(rig["valve.full_voltage"])
    assert up > down
    assert rig_loop(rig, 0.015, model="conventional").asymmetry == 0.0
    assert math.isinf(rig_loop(rig, 0.015, valve=False).servo.valve_frequency)
    with pytest.raises(InputError, match="there are: advanced, conventional"):
        rig_loop(rig, 0.015, model="conventinal")


def test_impossible_loops_are_refused():
    for values, words in (
        ({"differentiation": "backward"}, "sampling time"),
        ({"differentiation": "forward", "sampling_time": 1e-3}, "forward"),
        ({"filtered": "acceleration"}, "acceleration"),
        ({"sampling_time": -1.0}, "sampling time"),
        ({"sampling_time": 1e-9}, "sampling time"),
        ({"sampling_time": 1.0}, "sampling time is 1 s; it has to be 0, .* or from 1e-06 to 0.1 s"),
        ({"filter_frequency": 0.0}, "frequency"),
        ({"velocity_breaks": (5e3, 1e7)}, "break frequency is 1e.07 Hz; it has to be from"),
    ):
        with pytest.raises(InputError, match=words):
            Signals(**values)
    for values, words in (
        ({"level": 0.0}, "level"),
        ({"weights": (0.0, 1.0, 1.0)}, "c1"),
        ({"boundary_layer": -1.0}, "boundary layer"),
        ({"asymmetry": 1.0}, "asymmetry"),
    ):
        with pytest.raises(InputError, match=words):
            Loop(**{"servo": PRINTED[0], "weights": PRINTED[1], **values})
