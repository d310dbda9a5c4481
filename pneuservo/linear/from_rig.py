"""Where the numbers of a linear model come from: any rig, or the thesis' table 5.2."""

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from pneuservo.errors import InputError
from pneuservo.linear.quiescent import at_quiescent_pressures
from pneuservo.linear.servo_data import FlowAreas, ServoData
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.plant.valve import discharge_coefficient
from pneuservo.rigs import Rig, load_rig, plant_numbers

# Table 5.2 of the thesis, right column (as corrected), where it differs from the rig's own data.
TABLE_5_2: Mapping[str, float] = MappingProxyType(
    {
        "piston.viscous_friction": 100.0,
        "load.mass": 1.82,
        "ambient.pressure": 1.0e5,
        "piston.area_a": 490.9e-6,
        "piston.area_b": 412.3e-6,
    }
)
TABLE_5_2_PRESSURES = (4.49e5, 5.57e5)
TABLE_5_2_FLOW_AREA = 0.70 * 0.81e-6
# Quiescent pressures and the coefficients that depend on them settle within a few rounds.
_ROUNDS, _SETTLED = 100, 1e-3


def servo_data(
    rig: Rig,
    *,
    opening: float = 1.0,
    pressures: tuple[float, float] | None = None,
    flow_area: float | None = None,
) -> ServoData:
    """Return what the linear models of a rig are worked out from.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    opening : float, optional
        Share of the full voltage at which the discharge coefficients are read [-].
    pressures : tuple of float, optional
        Quiescent pressures of chambers a and b, absolute; without them those of retraction, which
        the thesis uses in both directions [Pa].
    flow_area : float, optional
        Effective area of every path at full opening; without it from the valve's tables [m^2].

    Returns
    -------
    ServoData
        The numbers.

    Raises
    ------
    InputError
        When the rig is of another kind, or a value is one that no rig can have.

    Notes
    -----
    Section 5.2.3 of the thesis: over a cycle of both directions the chambers stay closer to the
    pressures of a retracting piston. Coulomb friction has no place in a linear model.

    Examples
    --------
    >>> data = servo_data(load_rig("single-axis"))
    >>> round(data.pressure_a / 1e5, 2), round(data.pressure_b / 1e5, 2)
    (4.43, 5.52)
    """
    if rig.kind != "single-axis":
        raise InputError(f"rig {rig.name} is of kind {rig.kind}; single-axis is needed here")
    if not 0.0 < opening <= 1.0:
        raise InputError(f"opening is {opening:g}; it has to be greater than 0 and at most 1")
    plant = plant_numbers.single_axis(rig)
    start = pressures or (0.7 * plant.supply_pressure, 0.85 * plant.supply_pressure)
    data = _unopened(plant, start, flow_area or 1.0)
    for _ in range(_ROUNDS):
        before = (data.pressure_a, data.pressure_b)
        if flow_area is None:
            data = replace(data, flow_areas=_tabulated_areas(plant, rig.valve, data, opening))
        if pressures is None:
            data = at_quiescent_pressures(data, extending=False)
        if abs(data.pressure_a - before[0]) + abs(data.pressure_b - before[1]) < _SETTLED:
            break
    return data


def table_5_2() -> ServoData:
    """Return the single-axis rig as the thesis' linear models have it.

    Notes
    -----
    Right column of table 5.2 with 4.49 bar for the pressure in chamber a: the 5.49 of the scan
    balances neither with (5.40) nor with the load.

    Examples
    --------
    >>> table_5_2().pressure_b
    557000.0
    """
    rig = load_rig("single-axis").with_values(TABLE_5_2)
    return servo_data(rig, pressures=TABLE_5_2_PRESSURES, flow_area=TABLE_5_2_FLOW_AREA)


def equal_areas(data: ServoData) -> ServoData:
    """Return the same servo with the rod-side area on both sides, lying, without load.

    Parameters
    ----------
    data : ServoData
        The servo.

    Notes
    -----
    Left column of table 5.2 of the thesis; its quiescent pressures are equal, (5.37).

    Examples
    --------
    >>> round(equal_areas(table_5_2()).pressure_a / 1e5, 2)
    5.25
    """
    equal = replace(data, area_a=data.area_b, load=0.0)
    return at_quiescent_pressures(equal, extending=False)


def _unopened(plant: SingleAxis, pressures: tuple[float, float], flow_area: float) -> ServoData:
    piston, valve = plant.piston, plant.valve
    return ServoData(
        area_a=piston.area_a,
        area_b=piston.area_b,
        stroke=piston.stroke,
        dead_volume_a=plant.dead_volume_a,
        dead_volume_b=plant.dead_volume_b,
        mass=piston.mass,
        viscous_friction=piston.viscous_friction,
        load=piston.mass * piston.gravity,
        polytropic_index=plant.polytropic_index,
        gas=plant.gas,
        supply_pressure=plant.supply_pressure,
        exhaust_pressure=plant.ambient_pressure,
        pressure_a=pressures[0],
        pressure_b=pressures[1],
        flow_areas=FlowAreas(*[flow_area] * 4),
        full_voltage=valve.full_voltage,
        valve_frequency=valve.spool_frequency / (2.0 * math.pi),
        valve_damping=valve.spool_damping,
    )


def _tabulated_areas(plant: SingleAxis, valve: str, data: ServoData, opening: float) -> FlowAreas:
    full, grid = plant.valve, plant_numbers.valve_grid(valve)
    # In the order of the paths of the tables, which is that of `FlowAreas`.
    areas = (full.area_s_a, full.area_b_e, full.area_s_b, full.area_a_e)
    ratios = (
        data.pressure_a / data.supply_pressure,
        data.exhaust_pressure / data.pressure_b,
        data.pressure_b / data.supply_pressure,
        data.exhaust_pressure / data.pressure_a,
    )
    voltage = opening * data.full_voltage
    return FlowAreas(
        *(
            area * float(discharge_coefficient(path, voltage, ratio, grid))
            for path, (area, ratio) in enumerate(zip(areas, ratios, strict=True))
        )
    )
