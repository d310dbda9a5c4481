"""Chatter, oscillations and control effort, against what is known of made-up signals."""

import numpy as np
import pytest

from pneuservo.simulation.metrics import control_effort, final_swings, holds, limit_cycles

TIME = np.arange(2000) * 1e-3
DEMAND = np.where(TIME < 1.0, 0.015, 0.024)


def test_holds_are_between_changes_of_the_demand():
    assert holds(DEMAND) == [slice(0, 1000), slice(1000, 2000)]
    assert holds(np.zeros(5)) == [slice(0, 5)]


def test_a_swing_is_peak_to_peak_without_what_creeps():
    swing = 0.2 * np.sin(2 * np.pi * 50.0 * TIME)
    first, second = final_swings(TIME, DEMAND, np.where(TIME < 1.0, swing, 3.0 * TIME))
    # The best line through ten periods of an amplitude of 1 falls by 6/(10 pi) from end to end, a
    # tenth of the swing; a straight line is all creep.
    assert first.size == pytest.approx(0.4, rel=0.1)
    assert second.size == pytest.approx(0.0, abs=1e-9)
    assert (first.start, first.end) == pytest.approx((0.8, 0.999))
    # A swing on a creep is the swing alone.
    on_creep = final_swings(TIME, DEMAND, swing + 3.0 * TIME)[0]
    assert on_creep.size == pytest.approx(first.size, rel=1e-9)


def test_a_single_sample_swings_by_nothing():
    assert [each.size for each in final_swings(TIME[:3], DEMAND[:3], TIME[:3])] == [0.0]


def test_the_effort_of_a_square_wave_is_its_height_whatever_the_sampling():
    times = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 500))
    assert control_effort(times, np.where(times < 0.4, 5.0, -5.0)) == pytest.approx(5.0)
    # Half of the time 3 V, then nothing: 3 V over the square root of 2.
    assert control_effort(np.array([0.0, 1.0, 2.0]), np.array([3.0, 0.0, 9.0])) == pytest.approx(
        3.0 / np.sqrt(2.0)
    )


def test_limit_cycles_of_each_hold():
    frequency = np.where(TIME < 1.0, 40.0, 60.0)
    signal = np.sin(2 * np.pi * frequency * TIME)
    assert [round(each.frequency, 1) for each in limit_cycles(TIME, DEMAND, signal)] == [40.0, 60.0]
    quiet = np.where(TIME < 1.0, signal, np.exp(-10.0 * TIME))
    assert [round(each.frequency, 1) for each in limit_cycles(TIME, DEMAND, quiet)] == [40.0]
