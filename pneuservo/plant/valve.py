"""The servo valve: discharge coefficients, flow through its four paths, spool dynamics."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant.compilation import compiled
from pneuservo.plant.flow_paths import FLOW_PATHS, FlowPathTable
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.lane_arrays import neighbours
from pneuservo.plant.lanes import select, whole

# The break points of the tables are multiples of these, so bilinear interpolation on the even
# grid gives exactly what interpolation along the rows and then between the rows gives.
VOLTAGE_STEP = 0.1
PRESSURE_RATIO_STEP = 0.01
VOLTAGE_CELLS = 50
PRESSURE_RATIO_CELLS = 100

SUPPLY_TO_A, B_TO_EXHAUST, SUPPLY_TO_B, A_TO_EXHAUST = range(4)


class Valve(NamedTuple):
    """The numbers of a servo valve."""

    full_voltage: float
    """Command at which the valve is fully open, and its limit [V]."""
    area_s_a: float
    """Largest area, supply to chamber a [m^2]."""
    area_b_e: float
    """Largest area, chamber b to exhaust [m^2]."""
    area_s_b: float
    """Largest area, supply to chamber b [m^2]."""
    area_a_e: float
    """Largest area, chamber a to exhaust [m^2]."""
    spool_frequency: float
    """Natural frequency of the spool [rad/s]."""
    spool_damping: float
    """Damping ratio of the spool [-]."""


def discharge_grid(tables: Mapping[str, FlowPathTable]) -> Array:
    """Return the discharge coefficients of the four flow paths on an even grid.

    Parameters
    ----------
    tables : mapping of str to FlowPathTable
        The tables of a valve, by flow path.

    Returns
    -------
    (4, 51, 101) array
        Flow path (`SUPPLY_TO_A`, ...), command in steps of 0.1 V from 0, pressure ratio in
        steps of 0.01 from 0 [-].

    Raises
    ------
    InputError
        When a break point lies between the points of the grid.

    Examples
    --------
    >>> from pneuservo.rigs import load_valve_tables
    >>> float(discharge_grid(load_valve_tables("ddv-27a1"))[SUPPLY_TO_A, 50, 90])
    0.65
    """
    voltages = np.arange(VOLTAGE_CELLS + 1) * VOLTAGE_STEP
    ratios = np.arange(PRESSURE_RATIO_CELLS + 1) * PRESSURE_RATIO_STEP
    grid = np.empty((len(FLOW_PATHS), len(voltages), len(ratios)))
    for path, key in enumerate(FLOW_PATHS):
        table = tables[key]
        _require_on_grid(table.command, VOLTAGE_STEP, VOLTAGE_CELLS, f"{key}, command in V")
        _require_on_grid(
            table.pressure_ratio, PRESSURE_RATIO_STEP, PRESSURE_RATIO_CELLS, f"{key}, ratio"
        )
        rows = np.array(
            [
                np.interp(ratios, points, values)
                for points, values in zip(
                    table.pressure_ratio, table.discharge_coefficient, strict=True
                )
            ]
        )
        for column in range(len(ratios)):
            grid[path, :, column] = np.interp(voltages, table.command, rows[:, column])
    return grid


def _require_on_grid(points: Array, step: float, cells: int, what: str) -> None:
    index = np.asarray(points) / step
    off = (np.abs(index - np.round(index)) > 1e-6) | (index < -1e-6) | (index > cells + 1e-6)
    if off.any():
        raise InputError(
            f"valve table {what}: break point {np.asarray(points)[off][0]:g} is not a multiple "
            f"of {step:g} between 0 and {step * cells:g}"
        )


@compiled
def discharge_coefficient(path, voltage, pressure_ratio, grid):
    """Return the discharge coefficient of a flow path.

    Parameters
    ----------
    path : int or float
        `SUPPLY_TO_A`, `B_TO_EXHAUST`, `SUPPLY_TO_B` or `A_TO_EXHAUST`.
    voltage : float
        Command that would hold the spool where it is [V]; its magnitude counts.
    pressure_ratio : float
        Lower over higher pressure across the path [-].
    grid : (4, 51, 101) array
        From `discharge_grid`.

    Returns
    -------
    float
        Linear in pressure ratio and command; held outside the table [-].

    Notes
    -----
    Tables 4.2 to 4.5 of the thesis, measured with a polytropic index of 1.4 assumed.
    """
    across = abs(voltage) * (1.0 / VOLTAGE_STEP)
    along = pressure_ratio * (1.0 / PRESSURE_RATIO_STEP)
    # The comparisons are also false for NaN, which must not become an index.
    across = select(across > 0.0, min(across, 1.0 * VOLTAGE_CELLS), 0.0)
    along = select(along > 0.0, min(along, 1.0 * PRESSURE_RATIO_CELLS), 0.0)
    row = whole(min(across, VOLTAGE_CELLS - 1.0))
    column = whole(min(along, PRESSURE_RATIO_CELLS - 1.0))
    index = (path * (VOLTAGE_CELLS + 1.0) + row) * (PRESSURE_RATIO_CELLS + 1.0) + column
    across -= row
    along -= column
    low, low_next = neighbours(grid, index)
    high, high_next = neighbours(grid, index + (PRESSURE_RATIO_CELLS + 1.0))
    low += (low_next - low) * along
    high += (high_next - high) * along
    return low + (high - low) * across


@compiled
def path_mass_flow(path, opening, area, upstream_pressure, downstream_pressure, valve, gas, grid):
    """Return the mass flow through one path of the valve [kg/s].

    Parameters
    ----------
    path : int
        Which of the four paths.
    opening : float
        Spool position as a fraction of full opening; its magnitude counts [-].
    area : float
        Area of the path at full opening [m^2].
    upstream_pressure, downstream_pressure : float
        Absolute pressures in the path's own direction of flow [Pa]; a flow that reverses keeps
        the area and the table.
    valve, gas, grid
        The numbers of valve and gas, and the discharge coefficients.
    """
    ratio = min(upstream_pressure, downstream_pressure) / max(
        upstream_pressure, downstream_pressure
    )
    coefficient = discharge_coefficient(path, valve.full_voltage * opening, ratio, grid)
    return gas_mass_flow(
        upstream_pressure, downstream_pressure, area * abs(opening), coefficient, gas
    )


@compiled
def chamber_a_mass_flow(opening, pressure, supply_pressure, exhaust_pressure, valve, gas, grid):
    """Return the mass flow out of port a of the valve [kg/s].

    Parameters
    ----------
    opening : float
        Spool position; positive connects a to the supply, negative to the exhaust [-].
    pressure, supply_pressure, exhaust_pressure : float
        Absolute, behind port a and at the other two ports [Pa].
    valve, gas, grid
        As in `path_mass_flow`.
    """
    filling = opening >= 0.0
    flow = path_mass_flow(
        select(filling, SUPPLY_TO_A, A_TO_EXHAUST),
        opening,
        select(filling, valve.area_s_a, valve.area_a_e),
        select(filling, supply_pressure, pressure),
        select(filling, pressure, exhaust_pressure),
        valve,
        gas,
        grid,
    )
    return select(filling, flow, -flow)


@compiled
def chamber_b_mass_flow(opening, pressure, supply_pressure, exhaust_pressure, valve, gas, grid):
    """Return the mass flow out of port b of the valve [kg/s].

    Parameters
    ----------
    opening : float
        Spool position; positive connects b to the exhaust, negative to the supply [-].
    pressure, supply_pressure, exhaust_pressure : float
        Absolute, behind port b and at the other two ports [Pa].
    valve, gas, grid
        As in `path_mass_flow`.
    """
    emptying = opening >= 0.0
    flow = path_mass_flow(
        select(emptying, B_TO_EXHAUST, SUPPLY_TO_B),
        opening,
        select(emptying, valve.area_b_e, valve.area_s_b),
        select(emptying, pressure, supply_pressure),
        select(emptying, exhaust_pressure, pressure),
        valve,
        gas,
        grid,
    )
    return select(emptying, -flow, flow)


@compiled
def spool_acceleration(command, opening, opening_rate, valve):
    """Return the second derivative of the spool's fraction of full opening [1/s^2].

    Parameters
    ----------
    command : float
        Voltage, already limited to the full voltage [V].
    opening : float
        Spool position as a fraction of full opening [-].
    opening_rate : float
        Its rate [1/s].
    valve : Valve
        The numbers of the valve.

    Notes
    -----
    Equation (4.32), second order.
    """
    w = valve.spool_frequency
    return w * w * (command / valve.full_voltage - opening) - (
        2.0 * valve.spool_damping * w * opening_rate
    )
