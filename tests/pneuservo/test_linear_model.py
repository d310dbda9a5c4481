"""The linear model of the single axis against the thesis' tables."""

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.linear_model import TABLE_5_2, detectable_frequencies, linear_servo
from pneuservo.rigs import load_rig


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis").with_values(TABLE_5_2)


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
def test_the_linear_model_over_the_stroke(rig, position, stiffness, extending, retracting):
    out, back = (linear_servo(rig, position, direction) for direction in (True, False))
    assert out.a1 == pytest.approx(stiffness, rel=1e-4)
    assert out.b0 == pytest.approx(extending, rel=1e-3)
    assert back.b0 == pytest.approx(retracting, rel=1e-3)


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


def test_acceleration_is_seen_at_any_switching_frequency(rig):
    # The thesis: 0.04 m/s2 at 950 Hz, extending at mid-stroke; a 12-bit converter sees 0.0394.
    servo = linear_servo(rig, 0.015, True)
    amplitude = 5.0 * abs(servo.response(np.array([950.0]))[0]) * (2 * np.pi * 950.0) ** 2
    assert amplitude == pytest.approx(0.0400, abs=5e-5)


def test_what_has_no_linear_model_is_refused(rig):
    with pytest.raises(InputError, match="outside the stroke"):
        linear_servo(rig, 0.031, True)
    with pytest.raises(InputError, match="single-axis"):
        linear_servo(load_rig("dead-volume"), 0.01, True)
