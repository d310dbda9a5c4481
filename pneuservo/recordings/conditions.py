"""What was measured or set for one run: the tables [conditions], [controller] and [card] in SI."""

from collections.abc import Mapping
from typing import Any

from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.recordings.paths import inside_folder
from pneuservo.recordings.sidecar import Sidecar
from pneuservo.recordings.units import parse_pressure, quantity
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, Rig, load_rig

AMBIENT_PRESSURE = "ambient_pressure"
# Facts of a run that any sidecar may state, also when the rig has no use for them.
_POSITIVE = ("kg", "m**3", "Pa", "m**2")
_GENERAL_CONDITIONS = {
    "supply_pressure": "Pa",
    AMBIENT_PRESSURE: "Pa",
    "temperature": "K",
    "load_mass": "kg",
}
CONTROLLER_KINDS = (
    "analogue-card",
    "digital",
    "hybrid",
    "state-feedback",
    "proportional",
    "none",
)
CONTROLLER_UNITS = {"settling_time": "s"}
CARD_UNITS = {
    "rc_velocity": "s",
    "rc_acceleration": "s",
    "break_frequency": "Hz",
    "weight_displacement": "",
    "weight_velocity": "",
    "weight_acceleration": "",
    "surface_limit": "V",
    "output_gain": "",
    "level": "V",
}
_POSITIVE_CARD_FIGURES = (
    "rc_velocity",
    "rc_acceleration",
    "break_frequency",
    "surface_limit",
    "level",
)


def rig_of(sidecar: Sidecar) -> Rig:
    """Return the rig that a sidecar names.

    Parameters
    ----------
    sidecar : Sidecar
        Its `rig` is a built-in name or the path of a rig file in the recording's folder.

    Returns
    -------
    Rig
        The rig.

    Raises
    ------
    InputError
        When there is no such rig, or the path leaves the recording's folder.
    """
    where = f"{sidecar.path}: [recording] rig"
    if not sidecar.rig.endswith(".toml") and "/" not in sidecar.rig:
        require_known(sidecar.rig, (*BUILT_IN_RIGS, *VARIANTS), where)
        return load_rig(sidecar.rig)
    path = inside_folder(sidecar.rig, sidecar.path.parent, where)
    if path.suffix != ".toml":
        raise InputError(f"{where}: {sidecar.rig!r} is not a rig file; its name ends in .toml")
    return load_rig(path)


def ambient_pressure(sidecar: Sidecar, rig: Rig) -> float | None:
    """Return the ambient pressure of a run.

    Parameters
    ----------
    sidecar : Sidecar
        Its condition ``ambient_pressure`` comes first.
    rig : Rig
        Its parameter ``ambient.pressure`` otherwise.

    Returns
    -------
    float or None
        Absolute pressure [Pa]; None when neither states one.
    """
    if AMBIENT_PRESSURE in sidecar.conditions:
        where = f"{sidecar.path}: [conditions] {AMBIENT_PRESSURE}"
        return parse_pressure(sidecar.conditions[AMBIENT_PRESSURE], None, where)
    parameter = rig.conditions.get(AMBIENT_PRESSURE)
    return rig[parameter] if parameter is not None else None


def read_conditions(sidecar: Sidecar, rig: Rig) -> tuple[dict[str, float], list[str]]:
    """Return the rig parameters that were measured for a run.

    Parameters
    ----------
    sidecar : Sidecar
        Its table ``[conditions]``.
    rig : Rig
        The rig, which says which conditions there are and their units.

    Returns
    -------
    conditions : dict of str to float
        Condition key to value in SI; pressures absolute.
    warnings : list of str
        Conditions that the rig has no parameter for.

    Raises
    ------
    InputError
        When a condition is unknown, or its value or unit cannot be used.
    """
    known = rig.conditions
    units = {key: rig.parameters[parameter].unit for key, parameter in known.items()}
    ambient = ambient_pressure(sidecar, rig)
    conditions: dict[str, float] = {}
    warnings: list[str] = []
    for key, value in sidecar.conditions.items():
        where = f"{sidecar.path}: [conditions]"
        require_known(key, {**units, **_GENERAL_CONDITIONS}, where)
        unit = units.get(key, _GENERAL_CONDITIONS.get(key, ""))
        if unit == "Pa":
            reference = None if key == AMBIENT_PRESSURE else ambient
            number = parse_pressure(value, reference, f"{where} {key}")
        else:
            number = quantity(value, unit, f"{where} {key}")
        if unit == "K" and number <= 0.0:
            raise InputError(f"{where} {key}: {value!r} is {number:g} K, below absolute zero")
        if key in known:
            if unit in _POSITIVE and number <= 0.0:
                raise InputError(f"{where} {key}: {value!r} has to be greater than 0")
            conditions[key] = number
        elif key != AMBIENT_PRESSURE:
            warnings.append(f"condition {key} is not a parameter of the rig {rig.name}: not used")
    return conditions, warnings


def read_controller(sidecar: Sidecar) -> dict[str, Any]:
    """Return the table ``[controller]`` in SI; empty when absent.

    Parameters
    ----------
    sidecar : Sidecar
        The sidecar.

    Returns
    -------
    dict
        ``kind`` (str), and ``settling_time`` [s] where given.

    Raises
    ------
    InputError
        When the kind is missing or unknown, or a value cannot be used.
    """
    table = sidecar.controller
    if not table:
        return {}
    where = f"{sidecar.path}: [controller]"
    for key in table:
        require_known(key, ("kind", *CONTROLLER_UNITS), where)
    kind = table.get("kind")
    if not isinstance(kind, str):
        raise InputError(f"{where} needs kind = one of: {', '.join(CONTROLLER_KINDS)}")
    require_known(kind, CONTROLLER_KINDS, f"{where} kind")
    figures = _figures(table, CONTROLLER_UNITS, tuple(CONTROLLER_UNITS), where)
    return {"kind": kind, **figures}


def read_card(sidecar: Sidecar) -> tuple[dict[str, Any], list[str]]:
    """Return the table ``[card]`` in SI; empty when absent.

    Parameters
    ----------
    sidecar : Sidecar
        The sidecar.

    Returns
    -------
    card : dict
        ``design``, the absolute path of a design file, or the nominal figures in SI.
    warnings : list of str
        Figures that are not given.

    Raises
    ------
    InputError
        When design and figures are mixed, the path leaves the recording's folder, or a value
        cannot be used.
    """
    table = sidecar.card
    if not table:
        return {}, []
    where = f"{sidecar.path}: [card]"
    for key in table:
        require_known(key, ("design", *CARD_UNITS), where)
    if "design" in table:
        if len(table) > 1:
            raise InputError(f"{where} takes a design file or the nominal figures, not both")
        if not isinstance(table["design"], str):
            raise InputError(f"{where} design is {table['design']!r}; write the file's name")
        path = inside_folder(table["design"], sidecar.path.parent, f"{where} design")
        return {"design": str(path)}, []
    missing = [key for key in CARD_UNITS if key not in table]
    warnings = []
    if missing:
        warnings.append(f"[card] does not give {', '.join(missing)}: the default design's are used")
    return _figures(table, CARD_UNITS, _POSITIVE_CARD_FIGURES, where), warnings


def _figures(
    table: Mapping[str, Any], units: Mapping[str, str], positive: tuple[str, ...], where: str
) -> dict[str, float]:
    figures = {
        key: quantity(table[key], unit, f"{where} {key}")
        for key, unit in units.items()
        if key in table
    }
    for key in positive:
        if figures.get(key, 1.0) <= 0.0:
            raise InputError(f"{where} {key} is {table[key]!r}; it has to be greater than 0")
    return figures
