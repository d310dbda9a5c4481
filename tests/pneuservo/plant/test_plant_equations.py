"""The equations one by one, each against its literal form or a law it has to obey."""

import math

import numpy as np
import pytest

from analog_card.design_file import load_design
from analog_card.differentiator import differentiator_pair
from pneuservo.errors import InputError
from pneuservo.plant import valve as valve_kernels
from pneuservo.plant.analogue_card import differentiator_output, differentiator_rates
from pneuservo.plant.flow_paths import FLOW_PATHS, FlowPathTable
from pneuservo.plant.gas import ideal_gas, mass_flow_coefficient, orifice_mass_flow
from pneuservo.plant.piston import (
    AT_EXTENDED_STOP,
    AT_REST,
    AT_RETRACTED_STOP,
    EXTENDING,
    RETRACTING,
    acceleration,
    motion_from,
)
from pneuservo.plant.valve import discharge_coefficient, discharge_grid
from pneuservo.rigs import load_rig, load_valve_tables
from pneuservo.rigs.plant_numbers import single_axis, valve_grid

AIR = (293.0, 287.0, 1.4)


def test_choked_plateau_and_critical_ratio():
    air = ideal_gas(*AIR)
    assert air.critical_pressure_ratio == pytest.approx(0.5283, abs=5e-5)
    assert air.choked_coefficient == pytest.approx(0.040418, abs=5e-7)
    plateau = [mass_flow_coefficient(ratio, air) for ratio in (0.0, 0.2, 0.528)]
    assert plateau == [air.choked_coefficient] * 3


@pytest.mark.parametrize("ratio", [0.53, 0.6, 0.8, 0.95, 0.999, 1.0])
def test_subsonic_coefficient_is_the_printed_one(ratio):
    _, r, g = AIR
    printed = math.sqrt(2 * g / (r * (g - 1)) * (ratio ** (2 / g) - ratio ** ((g + 1) / g)))
    # The printed difference of two powers itself cancels towards ratio 1.
    assert mass_flow_coefficient(ratio, ideal_gas(*AIR)) == pytest.approx(printed, rel=1e-12)


def test_coefficient_is_smooth_at_the_critical_ratio():
    air = ideal_gas(*AIR)
    critical, step = air.critical_pressure_ratio, 1e-5
    above = mass_flow_coefficient(critical + step, air)
    # Value and slope are continuous: the rest is the curvature, of order step^2 times 1/0.3.
    assert abs(above - air.choked_coefficient) < 10.0 * step**2 * air.choked_coefficient


def test_orifice_flow_reverses_and_vanishes():
    forward = orifice_mass_flow(6e5, 4e5, 1e-6, 0.7, *AIR)
    assert forward > 0.0
    assert orifice_mass_flow(4e5, 6e5, 1e-6, 0.7, *AIR) == -forward
    assert orifice_mass_flow(5e5, 5e5, 1e-6, 0.7, *AIR) == 0.0


def test_discharge_coefficients_are_those_of_the_tables():
    tables, grid = load_valve_tables("ddv-27a1"), valve_grid("ddv-27a1")
    random = np.random.default_rng(1)
    for path, key in enumerate(FLOW_PATHS):
        table = tables[key]
        for voltage, ratio in zip(
            random.uniform(-6.0, 6.0, 200), random.uniform(0.0, 1.0, 200), strict=True
        ):
            along = [
                np.interp(ratio, points, values)
                for points, values in zip(
                    table.pressure_ratio, table.discharge_coefficient, strict=True
                )
            ]
            expected = np.interp(abs(voltage), table.command, along)
            found = discharge_coefficient(path, voltage, ratio, grid)
            assert found == pytest.approx(expected, abs=1e-12), (key, voltage, ratio)


@pytest.mark.parametrize(("voltage", "ratio"), [(math.nan, 0.5), (1.0, math.nan), (1e9, 1e9)])
def test_discharge_coefficient_never_leaves_its_table(voltage, ratio):
    grid = valve_grid("ddv-27a1")
    found = discharge_coefficient(valve_kernels.SUPPLY_TO_A, voltage, ratio, grid)
    assert grid.min() <= found <= grid.max()


def test_a_valve_table_off_the_grid_is_refused():
    tables = dict(load_valve_tables("ddv-27a1"))
    good = tables["s_a"]
    tables["s_a"] = FlowPathTable(
        good.command, good.pressure_ratio + 0.005, good.discharge_coefficient
    )
    with pytest.raises(InputError, match=r"s_a, ratio: break point 0.005 is not a multiple"):
        discharge_grid(tables)


def test_flow_paths_follow_the_sign_of_the_opening():
    plant, grid = single_axis(load_rig("single-axis")), valve_grid("ddv-27a1")
    pressures = (4e5, plant.supply_pressure, plant.ambient_pressure)
    rest = (plant.valve, plant.gas, grid)
    into_a = [valve_kernels.chamber_a_mass_flow(s, *pressures, *rest) for s in (0.3, 0.0, -0.3)]
    into_b = [valve_kernels.chamber_b_mass_flow(s, *pressures, *rest) for s in (0.3, 0.0, -0.3)]
    assert into_a[0] > 0.0 == into_a[1] > into_a[2]
    assert into_b[0] < 0.0 == into_b[1] < into_b[2]
    # A path whose flow reverses keeps its area and table, with lower over higher pressure.
    above_supply = valve_kernels.chamber_a_mass_flow(0.3, 8e5, *pressures[1:], *rest)
    coefficient = discharge_coefficient(valve_kernels.SUPPLY_TO_A, 1.5, 6.5 / 8.0, grid)
    expected = orifice_mass_flow(8e5, 6.5e5, 0.3 * 0.87e-6, coefficient, *AIR)
    assert above_supply == pytest.approx(-expected, rel=1e-12)


@pytest.mark.parametrize(
    ("displacement", "velocity", "force", "motion"),
    [
        (0.015, 0.1, -50.0, EXTENDING),
        (0.015, -0.1, 50.0, RETRACTING),
        (0.015, 0.0, 1.0, AT_REST),
        (0.015, 0.0, 1.1, EXTENDING),
        (0.015, 0.0, -1.1, RETRACTING),
        (0.0, 0.0, -50.0, AT_RETRACTED_STOP),
        (0.0, -0.1, 1.0, AT_RETRACTED_STOP),
        (0.0, 0.0, 1.1, EXTENDING),
        (0.03, 0.0, 50.0, AT_EXTENDED_STOP),
        (0.03, 0.1, -1.0, AT_EXTENDED_STOP),
        (0.03, 0.0, -1.1, RETRACTING),
        (0.03, -0.1, 0.0, RETRACTING),
    ],
)
def test_set_valued_friction_and_stops(displacement, velocity, force, motion):
    piston = single_axis(load_rig("single-axis")).piston  # friction 1.013 N, stroke 30 mm
    assert motion_from(displacement, velocity, force, piston) == motion


def test_friction_opposes_motion_and_holds_at_rest():
    piston = single_axis(load_rig("single-axis")).piston
    assert acceleration(10.0, EXTENDING, piston) == pytest.approx((10.0 - 1.013) / 1.825)
    assert acceleration(10.0, RETRACTING, piston) == pytest.approx((10.0 + 1.013) / 1.825)
    for held in (AT_REST, AT_RETRACTED_STOP, AT_EXTENDED_STOP):
        assert acceleration(10.0, held, piston) == 0.0


def card_response(frequency, time_constants, lags):
    """Complex gains of both stages, from the kernels' own rates: they are linear."""

    def rates(state, sensor):
        first = differentiator_rates(sensor, state[0], state[1], *lags)
        between = differentiator_output(state[1], time_constants[0])
        return np.array([*first, *differentiator_rates(between, state[2], state[3], *lags)])

    a = np.column_stack([rates(unit, 0.0) for unit in np.eye(4)])
    b = rates(np.zeros(4), 1.0)
    state = np.linalg.solve(2j * math.pi * frequency * np.eye(4) - a, b)
    return -time_constants[0] * state[1], -time_constants[1] * state[3]


@pytest.mark.parametrize("frequency", [1.0, 200.0, 2840.0, 20e3])
def test_differentiators_have_the_printed_response(frequency):
    lags, s = (56e-6, 56.4e-6), 2j * math.pi * frequency
    stage = [-s * rc / ((1 + s * lags[0]) * (1 + s * lags[1])) for rc in (12e-3, 5e-3)]
    first, second = card_response(frequency, (12e-3, 5e-3), lags)
    # Solved in doubles with rates of 1/56 us.
    assert first == pytest.approx(stage[0], rel=1e-9)
    assert second == pytest.approx(stage[0] * stage[1], rel=1e-9)


def test_differentiators_agree_with_those_of_the_card():
    frequency = 200.0
    pair = differentiator_pair(load_design(), finite_bandwidth=False)
    taps = pair.response(np.array([frequency]))
    first, second = card_response(frequency, (12e-3, 12e-3), (56e-6, 56.4e-6))
    # The same equation in two packages; only rounding differs.
    assert first == pytest.approx(taps.velocity[0], rel=1e-12)
    assert second == pytest.approx(taps.acceleration[0], rel=1e-12)
