from dataclasses import replace

import numpy as np
import pytest

from analog_card.design_file import load_design
from analog_card.differentiator import differentiator_pair
from analog_card.errors import InputError

FREQUENCY = np.geomspace(1, 100e3, 101)
S = 2j * np.pi * FREQUENCY


def with_amplifier(design, **figures):
    amplifier = replace(design.soldered.operational_amplifier, **figures)
    return replace(design, soldered=replace(design.soldered, operational_amplifier=amplifier))


@pytest.fixture
def design():
    return load_design()


def formula(parts):
    """Thesis (9.3)."""
    return (
        -S
        * (parts.resistance * parts.capacitance)
        / (1 + S * parts.feedback_capacitance * parts.resistance)
        / (1 + S * parts.capacitance * parts.series_resistance)
    )


def test_ideal_op_amps_give_the_formula_of_the_thesis(design):
    slower = replace(design.soldered.acceleration_differentiator, resistance=47e3)
    design = replace(design, soldered=replace(design.soldered, acceleration_differentiator=slower))
    taps = differentiator_pair(design, finite_bandwidth=False).response(FREQUENCY)
    first = formula(design.soldered.velocity_differentiator)
    # Rounding of a 4 x 4 solve.
    np.testing.assert_allclose(taps.velocity, first, rtol=1e-12)
    np.testing.assert_allclose(taps.acceleration, first * formula(slower), rtol=1e-12)


def test_a_finite_stage_alone_gives_the_feedback_formula(design):
    # Without output resistance the second stage does not load the first.
    design = with_amplifier(design, output_resistance=0.0)
    parts, amplifier = (
        design.soldered.velocity_differentiator,
        (design.soldered.operational_amplifier),
    )
    gain = amplifier.open_loop_gain
    open_loop = gain / (1 + S * gain / (2 * np.pi * amplifier.gain_bandwidth))
    ratio = (
        parts.resistance
        / (1 + S * parts.resistance * parts.feedback_capacitance)
        / (parts.series_resistance + 1 / (S * parts.capacitance))
    )
    expected = -ratio / (1 + (1 + ratio) / open_loop)
    taps = differentiator_pair(design).response(FREQUENCY)
    np.testing.assert_allclose(taps.velocity, expected, rtol=1e-10)
    np.testing.assert_allclose(taps.acceleration, expected**2, rtol=1e-10)


def test_fast_op_amps_approach_ideal_ones(design):
    fast = with_amplifier(design, gain_bandwidth=1e14, open_loop_gain=1e12, output_resistance=1e-6)
    real = differentiator_pair(fast).response(FREQUENCY)
    ideal = differentiator_pair(fast, finite_bandwidth=False).response(FREQUENCY)
    # What is left is the noise gain over the open-loop gain, below 2e3/1e9 at 100 kHz, twice.
    np.testing.assert_allclose(real.acceleration, ideal.acceleration, rtol=5e-6)


def test_taps_at_200_hz_as_measured_on_a_netlist(design):
    # An independent circuit study: 0.996 at -8.1 degrees and 0.991 at -16.2 degrees of ideal
    # differentiators; tolerances are half the last digit.
    taps = differentiator_pair(design).response(np.array([200.0]))
    s = 2j * np.pi * 200
    for tap, ideal, gain, phase in (
        (taps.velocity, -12e-3 * s, 0.996, -8.1),
        (taps.acceleration, (12e-3 * s) ** 2, 0.991, -16.2),
    ):
        ratio = tap[0] / ideal
        assert abs(ratio) == pytest.approx(gain, abs=5e-4)
        assert np.angle(ratio, deg=True) == pytest.approx(phase, abs=0.05)


def test_slow_movements_are_differentiated(design):
    # A ramp of 1 V/s: after the filter has settled (10 of its 56 us time constants) the tap
    # stands at -RC. The open-loop gain of 1e5 leaves 1e-5, the offset is taken out.
    design = with_amplifier(design, input_offset_voltage=0.0)
    time = np.arange(0, 5e-3, 5e-6)
    taps = differentiator_pair(design).transient(time, 3.0 + time)
    assert taps.velocity[0] == pytest.approx(0, abs=1e-9)
    assert taps.velocity[-1] == pytest.approx(-12e-3, rel=2e-5)


def test_a_sine_settles_at_the_frequency_response(design):
    design = with_amplifier(design, input_offset_voltage=0.0)
    pair = differentiator_pair(design)
    frequency, time = 500.0, np.arange(0, 20e-3, 1e-6)
    taps = pair.transient(time, np.sin(2 * np.pi * frequency * time))
    gain = pair.response(np.array([frequency])).acceleration[0]
    late = time > 10e-3
    expected = np.imag(gain * np.exp(2j * np.pi * frequency * time))
    # Straight lines between points 1 us apart: (2 pi 500 1e-6)^2/12 of the amplitude.
    np.testing.assert_allclose(taps.acceleration[late], expected[late], atol=2e-6 * abs(gain))


def test_at_rest_each_tap_stands_at_its_offset(design):
    time = np.arange(10) * 1e-5
    taps = differentiator_pair(design).transient(time, np.full(10, 5.0))
    # The open-loop gain of 1e5 takes 1e-5 of it.
    np.testing.assert_allclose(taps.velocity, 5e-3, rtol=2e-5)
    np.testing.assert_allclose(taps.acceleration, 5e-3, rtol=2e-5)


@pytest.mark.parametrize("time", [[0.0], [0.0, 1e-3, 3e-3], [0.0, -1e-3, -2e-3]])
def test_uneven_times_are_refused(design, time):
    with pytest.raises(InputError, match="equally spaced"):
        differentiator_pair(design).transient(np.array(time), np.zeros(len(time)))
