"""The gas with heat transfer against its limits, and what a fixed index makes of it."""

import numpy as np
import pytest

from pneuservo.calibration import flow_curve
from pneuservo.calibration.heat_transfer import (
    STEEL_WOOL_CONDUCTANCE,
    apparent_coefficient,
    transient_with_heat,
)

# Against the exact slope: a parabola through a fortieth of the change.
CURVE = 2e-3


@pytest.mark.parametrize("opening", [1.0, 0.02])
def test_an_adiabatic_charge_is_what_1_4_assumes(opening):
    found = apparent_coefficient("s_a", opening, wall_conductance=0.0)
    assert found.ratio[found.pressure_ratio < 0.95] == pytest.approx(1.0, abs=CURVE)


def test_an_adiabatic_discharge_cools_by_the_isentropic_law():
    found = apparent_coefficient("b_e", 1.0, wall_conductance=0.0)
    start = found.pressure_ratio[0]
    # The slope is that of gas at T, (4.34) takes it to be at T0: sqrt(T/T0) is left.
    exact = (found.pressure_ratio / start) ** (-0.5 * 0.4 / 1.4) * found.ratio[0]
    kept = found.pressure_ratio < 0.95
    assert found.ratio[kept] == pytest.approx(exact[kept], abs=CURVE)


def test_an_adiabatic_discharge_conserves_entropy():
    transient = transient_with_heat("b_e", 1.0, wall_conductance=0.0)
    # The gas that is left expands along p = p0 (m/m0)^1.4; its mass from the flow that left.
    gas, wall = 287.0, 293.0
    volume, area = 120e-6, 0.8 * 0.810e-6
    temperature = wall * (transient.pressure / transient.pressure[0]) ** (0.4 / 1.4)
    ratio = np.minimum(1.013e5 / transient.pressure, 1.0)
    choked = (2.0 / 2.4) ** 3.5
    r = np.maximum(ratio, choked)
    speed = np.sqrt(7.0 * gas * temperature * (1.0 - r ** (0.4 / 1.4)))
    flow = area * transient.pressure / (gas * temperature) * r ** (1.0 / 1.4) * speed
    left = np.trapezoid(flow, transient.time)
    mass = transient.pressure * volume / (gas * temperature)
    assert left == pytest.approx(mass[0] - mass[-1], rel=1e-4)


def test_a_slow_charge_leaves_one_over_the_index():
    found = apparent_coefficient("s_a", 0.001)
    # So slow that the gas is at wall temperature but for the very beginning.
    assert found.choked == pytest.approx(1.0 / 1.4, rel=5e-3)


def test_at_two_percent_opening_70_percent_is_left():
    # Section 4.3.1 of the thesis: "lower by a factor of up to 70 %".
    for path in ("s_a", "a_e"):
        assert apparent_coefficient(path, 0.02).choked == pytest.approx(0.70, abs=0.04)


def test_the_smaller_the_opening_the_lower_the_coefficient():
    left = [apparent_coefficient("s_a", opening).choked for opening in (1.0, 0.2, 0.08, 0.02)]
    assert all(np.diff(left) < 0.0)
    assert left[0] > 0.95


@pytest.mark.parametrize("path", ["s_a", "a_e"])
@pytest.mark.parametrize("opening", [1.0, 0.02])
def test_steel_wool_and_an_index_of_one_find_the_truth(path, opening):
    found = apparent_coefficient(path, opening, 1.0, STEEL_WOOL_CONDUCTANCE)
    # 300 times the surface leaves the gas up to a few kelvin off at full opening: 1.5 %.
    assert found.ratio[found.pressure_ratio < 0.9] == pytest.approx(1.0, abs=0.02)


def test_a_steel_wool_chamber_taken_for_adiabatic_is_off_by_the_index():
    transient = transient_with_heat("s_a", 0.2, STEEL_WOOL_CONDUCTANCE)
    ratio = flow_curve(transient, 1.4).coefficient / 0.8
    assert ratio[:20] == pytest.approx(1.0 / 1.4, rel=5e-3)
