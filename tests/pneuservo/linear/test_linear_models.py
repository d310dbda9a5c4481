"""The linear models against the thesis' tables and against closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.linear import (
    advanced_servo,
    at_quiescent_pressures,
    conventional_servo,
    equal_areas,
    quiescent_pressures,
    servo_data,
    state_space,
    table_5_2,
    transfer_function,
    without_valve,
)
from pneuservo.linear.characteristics import (
    damping_ratio,
    natural_frequency,
    over_stroke,
    ultimate_gain,
    worst_linearisation,
)
from pneuservo.linear.detectability import detectable_frequencies
from pneuservo.rigs import load_rig

# Volts of the transducer for each metre.
SENSITIVITY = 10.0 / 0.03


@pytest.fixture(scope="module")
def data():
    return table_5_2()


@pytest.mark.parametrize(
    ("position", "stiffness", "extending", "retracting"),
    # Worked out from table 5.2 of the thesis by hand: a1 and b0 at the full 5 V over 5.
    [
        (1.5e-3, 39577, 2427, 1815),
        (6e-3, 24198, 1461, 1110),
        (15e-3, 18421, 1077, 844),
        (24e-3, 23624, 1338, 1083),
        (28.5e-3, 36720, 2047, 1683),
    ],
)
def test_the_advanced_model_over_the_stroke(data, position, stiffness, extending, retracting):
    out, back = (advanced_servo(data, position, direction) for direction in (True, False))
    assert out.a1 == pytest.approx(stiffness, rel=1e-4)
    assert out.b0 == pytest.approx(extending, rel=1e-3)
    assert back.b0 == pytest.approx(retracting, rel=1e-3)


def test_the_conventional_model(data):
    servo = without_valve(conventional_servo(data))
    # (5.27): a1 = 3.2 n Ps A/(m l + D), b0 = 3.6 n R sqrt(T) Cd Cm* Av kv Ps/(m l + D).
    length = 1.82 * 0.03 + 2 * 1.82 * 1.7e-6 / 412.3e-6
    assert servo.a1 == pytest.approx(3.2 * 1.4 * 6.5e5 * 412.3e-6 / length, rel=1e-12)
    choked = 0.04041841989407281
    flow = 287 * math.sqrt(293) * 0.7 * choked * 0.81e-6 / 5
    assert servo.b0 == pytest.approx(3.6 * 1.4 * flow * 6.5e5 / length, rel=1e-9)
    # (5.29), in transducer volts: 2.68 V/V.
    assert ultimate_gain(servo) / SENSITIVITY == pytest.approx(2.68, abs=0.005)
    # Away from the middle one direction gains what the other loses.
    for away in (1e-3, 9e-3):
        out = conventional_servo(data, 0.015 + away, extending=True)
        back = conventional_servo(data, 0.015 - away, extending=False)
        assert (out.a1, out.b0) == pytest.approx((back.a1, back.b0), rel=1e-12)


def test_equal_areas_have_the_closed_form_of_the_quiescent_pressure(data):
    equal = equal_areas(data)
    # (5.37) with D = 3.864, in full: 0.80746 of the supply.
    d = math.sqrt(2 / 0.4 * 1.2 ** (2.4 / 0.4))
    ratio = (d / 2 * (math.sqrt(d * d + 4) - d)) ** 3.5
    assert equal.pressure_a / 6.5e5 == pytest.approx(ratio, rel=1e-9)
    assert equal.pressure_b == pytest.approx(equal.pressure_a, rel=1e-12)


@pytest.mark.parametrize(
    ("extending", "area_ratio"), [(True, 412.3 / 490.9), (False, 490.9 / 412.3)]
)
def test_unequal_areas_have_the_closed_form_of_the_charged_pressure(data, extending, area_ratio):
    d = math.sqrt(2 / 0.4 * 1.2 ** (2.4 / 0.4)) * area_ratio
    ratio = (d / 2 * (math.sqrt(d * d + 4) - d)) ** 3.5
    charged = quiescent_pressures(data, extending)[0 if extending else 1]
    assert charged / 6.5e5 == pytest.approx(ratio, rel=1e-9)


def test_table_5_3_of_the_thesis(data):
    at_sea_level = replace(data, exhaust_pressure=1.013e5)
    # Printed; the charged chambers to the last digit, the others as the load leaves them.
    assert quiescent_pressures(at_sea_level, True) == pytest.approx((4.85e5, 6.00e5), rel=3e-3)
    assert quiescent_pressures(at_sea_level, False) == pytest.approx((4.49e5, 5.57e5), rel=4e-3)


def test_a_load_too_large_is_refused(data):
    with pytest.raises(InputError, match="no steady motion"):
        quiescent_pressures(replace(data, load=-300.0), True)


def test_characteristics(data):
    servo = without_valve(advanced_servo(data, 0.015, True))
    assert natural_frequency(servo) / (2 * math.pi) == pytest.approx(21.60, abs=0.005)
    assert damping_ratio(servo) == pytest.approx(0.202, abs=5e-4)
    assert ultimate_gain(servo) / SENSITIVITY == pytest.approx(2.82, abs=0.005)
    # The gain at the border of stability puts a pair of poles on the imaginary axis.
    poles = np.roots([1.0, servo.a2, servo.a1, servo.b0 * ultimate_gain(servo)])
    assert np.max(poles.real) == pytest.approx(0.0, abs=1e-9 * abs(poles).max())


def test_the_ultimate_gain_with_the_valve_is_where_the_loop_swings(data):
    servo = advanced_servo(data, 0.015, True)
    gain = ultimate_gain(servo)
    assert gain < ultimate_gain(without_valve(servo))
    valve = 2 * math.pi * servo.valve_frequency
    poles = np.roots(
        np.polyadd(
            np.polymul([1.0, servo.a2, servo.a1, 0.0], [1 / valve**2, 1.4 / valve, 1.0]),
            [gain * servo.b0],
        )
    )
    assert np.max(poles.real) == pytest.approx(0.0, abs=1e-6 * abs(poles).max())


def test_over_the_stroke_as_in_figures_5_9_and_5_10(data):
    table = over_stroke(data)
    assert table.natural_frequency.argmin() == pytest.approx(30, abs=1)
    # Lower and more damped fully extended than fully retracted.
    assert table.natural_frequency[-1] < table.natural_frequency[0]
    assert table.damping_ratio[-1] > table.damping_ratio[0]
    assert np.all(np.diff(table.gain_extending) > 0)
    assert np.all(table.gain_extending < table.gain_retracting)


def test_the_guideline_takes_the_lowest_ultimate_gain(data):
    worst = worst_linearisation(data)
    assert (worst.extending, worst.displacement) == (True, 0.0)
    # At the pressures that belong to extension, extending is still the worse direction.
    assert worst_linearisation(at_quiescent_pressures(data, True)).extending
    with pytest.raises(InputError, match="viscous"):
        worst_linearisation(replace(data, viscous_friction=0.0))


def test_systems_of_python_control(data):
    servo = advanced_servo(data, 0.006, False)
    frequency = np.array([1.0, 25.0, 200.0])
    for model in (servo, without_valve(servo)):
        expected = model.response(frequency)
        s = 2j * np.pi * frequency
        assert transfer_function(model)(s) == pytest.approx(expected, rel=1e-9)
        assert state_space(model)(s)[0, 0] == pytest.approx(expected, rel=1e-9)
        # Outputs are displacement and its two derivatives.
        assert state_space(model)(s)[2, 0] == pytest.approx(s * s * expected, rel=1e-9)


def test_tables_9_1_and_9_2_of_the_thesis():
    found = detectable_frequencies(threshold=3.98e-6)
    # Printed; the first entry of each extending row is unreadable and follows from the text.
    # 1 %: what a threshold of -108 dB leaves.
    printed = {
        "without_valve": {"extend": [233, 176, 218], "retract": [210, 163, 205]},
        "with_valve": {"extend": [204, 165, 196], "retract": [190, 155, 187]},
    }
    for table, rows in printed.items():
        for direction, values in rows.items():
            assert getattr(found, table)[direction] == pytest.approx(values, rel=0.01)


def test_half_a_bit_is_a_little_above_the_printed_tables():
    found = detectable_frequencies()
    assert found.threshold == pytest.approx(3.662e-6, abs=0.5e-9)
    loose = detectable_frequencies(threshold=3.98e-6)
    ratio = found.with_valve["extend"] / loose.with_valve["extend"]
    # |X/U| falls as f^3 to f^5 there: (3.98/3.662)^(1/5) to ^(1/3).
    assert np.all((ratio > 1.0168) & (ratio < 1.0282))


def test_acceleration_is_seen_at_any_switching_frequency(data):
    # The thesis: 0.04 m/s2 at 950 Hz, extending at mid-stroke; a 12-bit converter sees 0.0394.
    servo = advanced_servo(data, 0.015, True)
    amplitude = 5.0 * abs(servo.response(np.array([950.0]))[0]) * (2 * np.pi * 950.0) ** 2
    assert amplitude == pytest.approx(0.0400, abs=5e-5)


def test_what_has_no_linear_model_is_refused(data):
    with pytest.raises(InputError, match="outside the stroke"):
        advanced_servo(data, 0.031, True)
    with pytest.raises(InputError, match="single-axis"):
        servo_data(load_rig("dead-volume"))
