"""The rig's numbers as the truth's."""

import math
from collections.abc import Mapping

from pneuservo.challenge.truth.parameters import (
    Chambers,
    Friction,
    Load,
    Network,
    Spool,
    Truth,
    Valve,
)
from pneuservo.challenge.truth.valve_map import valve_map
from pneuservo.rigs import Rig

# Parameter of the rig: group and field of the truth, and what the rig's value is multiplied by.
_FIELDS: dict[str, tuple[str, str, float]] = {
    "supply.pressure": ("network", "supply_pressure", 1.0),
    "ambient.pressure": ("network", "ambient_pressure", 1.0),
    "temperature": ("network", "temperature", 1.0),
    "gas.constant": ("network", "gas_constant", 1.0),
    "chamber.polytropic_index": ("chambers", "polytropic", 1.0),
    "chamber.a.dead_volume": ("chambers", "dead_volume_a", 1.0),
    "chamber.b.dead_volume": ("chambers", "dead_volume_b", 1.0),
    "piston.area_a": ("chambers", "area_a", 1.0),
    "piston.area_b": ("chambers", "area_b", 1.0),
    "piston.stroke": ("chambers", "stroke", 1.0),
    "piston.viscous_friction": ("friction", "viscous", 1.0),
    "piston.coulomb_friction": ("friction", "coulomb", 1.0),
    "load.mass": ("load", "mass", 1.0),
    "load.gravity": ("load", "gravity", 1.0),
    "valve.spool.frequency": ("spool", "frequency", 2.0 * math.pi),
    "valve.spool.damping": ("spool", "damping", 1.0),
    "valve.full_voltage": ("spool", "full_voltage", 1.0),
    "valve.flow.area_s_a": ("valve", "area_s_a", 1.0),
    "valve.flow.area_s_b": ("valve", "area_s_b", 1.0),
    "valve.flow.area_b_e": ("valve", "area_b_e", 1.0),
    "valve.flow.area_a_e": ("valve", "area_a_e", 1.0),
}


def truth_of(rig: Rig) -> Truth:
    """Return the truth with a rig's numbers and no effect.

    Parameters
    ----------
    rig : Rig
        A rig of the kind ``single-axis``.

    Returns
    -------
    Truth
        The servo.
    """
    truth = Truth(Valve(*valve_map(rig.valve)), Spool(), Network(), Chambers(), Friction(), Load())
    return with_rig_values(truth, {key: rig[key] for key in _FIELDS})


def with_rig_values(truth: Truth, values: Mapping[str, float]) -> Truth:
    """Return the truth with some of the rig's parameters replaced, effects kept.

    Parameters
    ----------
    truth : Truth
        The servo.
    values : mapping of str to float
        Parameter id of the rig to value in SI; ids without a place in the truth are left out.

    Returns
    -------
    Truth
        A new one.
    """
    for key, value in values.items():
        if key in _FIELDS:
            group, field, factor = _FIELDS[key]
            truth = changed(truth, group, **{field: value * factor})
    return truth


def changed(truth: Truth, group: str, **values: float) -> Truth:
    """Return the truth with some numbers of one group replaced."""
    return truth._replace(**{group: getattr(truth, group)._replace(**values)})


def rig_value(truth: Truth, key: str) -> float:
    """Return the value of a rig's parameter in a truth, in SI."""
    group, field, factor = _FIELDS[key]
    return float(getattr(getattr(truth, group), field)) / factor
