"""Eight numbers side by side: what lanes do is what floats do, in wide registers."""

import math
import re
from typing import NamedTuple

import numba
import numpy as np
import pytest

from pneuservo.plant.gas import ideal_gas, mass_flow_coefficient, subsonic_coefficient
from pneuservo.plant.lane_arrays import (
    load_lane,
    load_lanes,
    load_row,
    load_tuple,
    neighbours,
    store_row,
    store_rows,
)
from pneuservo.plant.lanes import WIDTH, both, first_lane, lanes_that, select, whole
from pneuservo.plant.valve import chamber_a_mass_flow, chamber_b_mass_flow
from pneuservo.rigs import load_rig, plant_numbers


class Numbers(NamedTuple):
    first: float
    kind: int
    more: tuple[float, float]


compiled = numba.njit(error_model="numpy")


@compiled
def formula(x, table, numbers):
    """Every operation that lanes have."""
    low, high = neighbours(table, whole(abs(x) * 3.0))
    y = select(both(x > numbers.first, x <= 1.5), 2.0 * x, -x) + min(x, 1.0) - max(0.5, x)
    y += math.sqrt(abs(x)) / numbers.more[1]
    y -= 0.25 * x
    y *= select(x != 0.0, 1.0, 2.0)
    return y * low + (1.0 / (high + x * x)) * numbers.more[0] + numbers.kind


@compiled
def both_ways(rows, columns, table, like, out):
    (x,) = load_lanes(rows, (0.0,))
    numbers = load_lanes(columns, like)
    y = formula(x, table, numbers)
    store_row(out, 0, y)
    store_rows(out[1:], (x, load_row(rows, 0)))
    each = np.empty(WIDTH)
    for lane in range(WIDTH):
        each[lane] = formula(rows[0, lane], table, load_lane(columns, lane, like))
    return each, lanes_that(x > 0.0), first_lane(x), load_tuple(rows[0], (0.0, 0.0))


def test_lanes_do_what_floats_do():
    x = np.linspace(-2.0, 2.0, WIDTH)[np.newaxis]
    columns = np.random.default_rng(1).uniform(0.5, 2.0, (3, WIDTH))
    out = np.empty((3, WIDTH))
    like = Numbers(0.0, 7, (0.0, 0.0))
    each, positive, first, pair = both_ways(x, columns, np.arange(8.0), like, out)
    # Only a product and a sum fused here and not there can differ.
    np.testing.assert_allclose(out[0], each, rtol=1e-14)
    np.testing.assert_array_equal(out[1:], [x[0], x[0]])
    assert positive == sum(1 << lane for lane in range(WIDTH) if x[0, lane] > 0.0)
    assert (first, pair) == (x[0, 0], (x[0, 0], x[0, 1]))


@compiled
def flows(columns, plant, grid, out):
    opening, pressure = load_lanes(columns, (0.0, 0.0))
    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    ports = (opening, pressure, supply, ambient, plant.valve, plant.gas, grid)
    store_row(out, 0, chamber_a_mass_flow(*ports))
    store_row(out, 1, chamber_b_mass_flow(*ports))


def test_valve_flow_in_lanes_is_that_of_one_run():
    plant, grid = (
        plant_numbers.single_axis(load_rig("single-axis")),
        plant_numbers.valve_grid("ddv-27a1"),
    )
    opening = np.array([-1.2, -0.4, -1e-3, 0.0, math.nan, 0.01, 0.5, 1.2])
    pressure = np.array([1e5, 2e5, 7e5, 4e5, 4e5, 1.1e5, 6.6e5, 3e5])
    out = np.empty((2, WIDTH))
    flows(np.array([opening, pressure]), plant, grid, out)
    ports = (plant.supply_pressure, plant.ambient_pressure, plant.valve, plant.gas, grid)
    for row, flow in zip(out, (chamber_a_mass_flow, chamber_b_mass_flow), strict=True):
        expected = [flow(s, p, *ports) for s, p in zip(opening, pressure, strict=True)]
        np.testing.assert_allclose(row, expected, rtol=1e-13, atol=1e-18)
        # NaN does not leave the table, and does not go unseen.
        assert np.flatnonzero(np.isnan(row)).tolist() == [4]


def test_lanes_are_kept_in_wide_registers():
    plant, grid = (
        plant_numbers.single_axis(load_rig("single-axis")),
        plant_numbers.valve_grid("ddv-27a1"),
    )
    out = np.empty((2, WIDTH))
    flows(np.full((2, WIDTH), 0.5), plant, grid, out)
    (assembly,) = flows.inspect_asm().values()
    wide = re.findall(r"\bv?(?:mul|add|sub|fmadd\w*|fnmadd\w*)pd\b|\bfm\w+\s+v\d+\.2d", assembly)
    single = re.findall(r"\bv?(?:mul|add|sub|fmadd\w*|fnmadd\w*)sd\b", assembly)
    assert len(wide) > 50
    assert len(wide) > 5 * len(single)


@pytest.mark.parametrize("exponent", [1.1, 1.3, 1.4, 1.67])
def test_subsonic_polynomial_is_the_printed_equation(exponent):
    gas = ideal_gas(293.0, 287.0, exponent)
    ratios = np.linspace(gas.critical_pressure_ratio, 1.0, 1001)[1:-1]
    found = np.array([mass_flow_coefficient(ratio, gas) for ratio in ratios])
    printed = [subsonic_coefficient(ratio, exponent, gas.subsonic_factor) for ratio in ratios]
    # 6e-13 for air, as a study of the same polynomial found, 5e-12 for the highest exponent; at
    # equal pressures the printed difference cancels to 1e-16 over 1 - Pr.
    np.testing.assert_allclose(found, printed, rtol=1e-11)
