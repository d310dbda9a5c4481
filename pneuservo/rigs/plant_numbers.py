"""The numbers of a rig, as the kernels take them."""

import math
from collections.abc import Mapping
from functools import lru_cache

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant.dead_volume import DeadVolume
from pneuservo.plant.gas import Gas, ideal_gas
from pneuservo.plant.piston import Piston
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.plant.valve import Valve, discharge_grid
from pneuservo.rigs import Rig, load_valve_tables
from pneuservo.rigs.valve_tables import VALVES_KEPT, valve_content

# Parameters that may be zero; gravity may also be negative. All others have to be positive.
_MAY_BE_ZERO = ("piston.coulomb_friction", "piston.viscous_friction", "valve.spool.damping")
_ANY_SIGN = ("load.gravity",)


def single_axis(rig: Rig) -> SingleAxis:
    """Return the numbers of a single-axis rig.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.

    Returns
    -------
    SingleAxis
        All in SI.

    Raises
    ------
    InputError
        When a value is one that no rig can have.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> single_axis(load_rig("single-axis")).piston.mass
    1.825
    """
    value = _possible_values(rig)
    return SingleAxis(
        supply_pressure=value["supply.pressure"],
        ambient_pressure=value["ambient.pressure"],
        dead_volume_a=value["chamber.a.dead_volume"],
        dead_volume_b=value["chamber.b.dead_volume"],
        polytropic_index=value["chamber.polytropic_index"],
        gas=_gas(value),
        valve=_valve(
            value,
            2.0 * math.pi * value["valve.spool.frequency"],
            value["valve.spool.damping"],
        ),
        piston=Piston(
            area_a=value["piston.area_a"],
            area_b=value["piston.area_b"],
            stroke=value["piston.stroke"],
            mass=value["load.mass"],
            gravity=value["load.gravity"],
            viscous_friction=value["piston.viscous_friction"],
            coulomb_friction=value["piston.coulomb_friction"],
        ),
    )


def all_numbers(rig: Rig) -> tuple[object, ...]:
    """Return all that a simulation takes from a rig with a valve: another answer, another run.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.

    Returns
    -------
    tuple
        Values of parameters and effects, transducers, and the valve's tables.
    """
    return (
        {name: parameter.value for name, parameter in rig.parameters.items()},
        rig.effect_values,
        rig.transducers,
        valve_grid(rig.valve).tobytes(),
    )


def dead_volume(rig: Rig) -> DeadVolume:
    """Return the numbers of a closed test volume behind a valve.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``dead-volume``.

    Returns
    -------
    DeadVolume
        All in SI. The spool is held still, so that its dynamics are not among them.

    Raises
    ------
    InputError
        When a value is one that no rig can have.
    """
    value = _possible_values(rig)
    return DeadVolume(
        supply_pressure=value["supply.pressure"],
        ambient_pressure=value["ambient.pressure"],
        volume=value["dead-volume.volume"],
        polytropic_index=value["dead-volume.polytropic_index"],
        gas=_gas(value),
        valve=_valve(value, math.inf, 1.0),
    )


def valve_grid(valve: str) -> Array:
    """Return the discharge coefficients of a valve on the kernels' grid.

    Parameters
    ----------
    valve : str
        Name of the valve, such as ``"ddv-27a1"``, or path of its file.

    Returns
    -------
    (4, 51, 101) array
        See `pneuservo.plant.valve.discharge_grid`.
    """
    return _grid(valve, valve_content(valve))


@lru_cache(VALVES_KEPT)
def _grid(valve: str, content: bytes) -> Array:
    return discharge_grid(load_valve_tables(valve))


def _gas(value: Mapping[str, float]) -> Gas:
    gas: Gas = ideal_gas(
        value["temperature"], value["gas.constant"], value["gas.isentropic_exponent"]
    )
    return gas


def _valve(value: Mapping[str, float], spool_frequency: float, spool_damping: float) -> Valve:
    return Valve(
        full_voltage=value["valve.full_voltage"],
        area_s_a=value["valve.flow.area_s_a"],
        area_b_e=value["valve.flow.area_b_e"],
        area_s_b=value["valve.flow.area_s_b"],
        area_a_e=value["valve.flow.area_a_e"],
        spool_frequency=spool_frequency,
        spool_damping=spool_damping,
    )


def _possible_values(rig: Rig) -> dict[str, float]:
    """Return every value of a rig as a float; an integer would have the kernels compiled anew."""
    values = {key: float(parameter.value) for key, parameter in rig.parameters.items()}
    for key, value in values.items():
        lowest = 1.0 if key == "gas.isentropic_exponent" else 0.0
        if key in _ANY_SIGN:
            possible, allowed = math.isfinite(value), "any finite number"
        elif key in _MAY_BE_ZERO:
            possible, allowed = 0.0 <= value < math.inf, "0 or more"
        else:
            possible, allowed = lowest < value < math.inf, f"greater than {lowest:g}"
        if not possible:
            unit = rig.parameters[key].unit
            raise InputError(
                f"rig {rig.name}: {key} is {value:g} {unit}".rstrip() + f"; it has to be {allowed}"
            )
    return values
