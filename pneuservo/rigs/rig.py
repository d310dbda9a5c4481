"""A rig: which chain of blocks it is, and the numbers in them."""

import math
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from analog_card.errors import InputError as QuantityError
from analog_card.quantities import to_si
from analog_card.toml_file import read_toml, table_in
from pneuservo.errors import InputError
from pneuservo.naming import nearest, require_known
from pneuservo.rigs.added_weight import MOVED_MASS, with_added_weight
from pneuservo.rigs.session import Session, read_session
from pneuservo.rigs.transducers import Transducer, read_transducers

BUILT_IN_RIGS = (
    "single-axis",
    "figure-arm",
    "dead-volume",
    "seal-tester",
    "circuit",
    "analogue-card",
)
"""Built-in rigs with the name of their kind."""

VARIANTS = ("figure-linear-axis", "figure-rotary-axis")
"""Built-in rigs that state what differs from that of their kind."""


@dataclass(frozen=True)
class Parameter:
    """One number of a rig.

    Parameters
    ----------
    value : float
        The value in SI.
    unit : str
        Its SI unit; ``""`` for a pure number.
    tolerance : float, optional
        How well the value is known, one standard deviation; 0 when exact [unit].
    free : bool, optional
        Whether nothing is known beforehand, so that a fit has to find it.
    source : str, optional
        Where the value comes from.
    nominal : float, optional
        For a fitted value, what it was taken to be before; None when nothing was fitted [unit].
    """

    value: float
    unit: str
    tolerance: float = 0.0
    free: bool = False
    source: str = ""
    nominal: float | None = None


@dataclass(frozen=True)
class Rig:
    """A rig as data.

    Parameters
    ----------
    name : str
        Its name, or the path of its file.
    kind : str
        Which chain of blocks it is: one of `BUILT_IN_RIGS`.
    title : str
        What people call it.
    parameters : mapping of str to Parameter
        Parameter id, ``block.quantity``, to value, unit, tolerance and source.
    effects : mapping of str to mapping
        Effect id to its parameter values in SI; physics beyond the baseline, as a repaired
        model has it. Empty for the baseline.
    valve : str, optional
        Name of the valve whose tables are used, or path of its file; ``""`` without a valve.
    transducers : mapping of str to Transducer
        By ``displacement`` and ``pressure``: noise and range of what is read. Empty for exact
        readings.
    session : Session, optional
        The recordings that its values were fitted to; None when nothing was fitted.
    """

    name: str
    kind: str
    title: str
    parameters: Mapping[str, Parameter]
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    valve: str = ""
    transducers: Mapping[str, Transducer] = field(default_factory=dict)
    session: Session | None = None

    def __getitem__(self, parameter: str) -> float:
        """Return the value of a parameter in SI."""
        return self.parameters[parameter].value

    @property
    def conditions(self) -> dict[str, str]:
        """Return condition key to parameter id: the id with underscores for dots and hyphens."""
        return {key.replace(".", "_").replace("-", "_"): key for key in self.parameters}

    @property
    def effect_values(self) -> dict[str, float]:
        """Return the parameters of all effects by ``effect:parameter``."""
        return {
            f"{effect}:{name}": value
            for effect, values in self.effects.items()
            for name, value in values.items()
        }

    def with_values(self, values: Mapping[str, float]) -> "Rig":
        """Return the rig with some values of parameters and effects replaced.

        Parameters
        ----------
        values : mapping of str to float
            Parameter id, or ``effect:parameter`` as in `effect_values`, to value in SI. An effect
            that the rig has not had is added.

        Returns
        -------
        Rig
            A new rig; this one is unchanged.

        Raises
        ------
        InputError
            When a parameter is not known; the message names the nearest one.
        """
        parameters = dict(self.parameters)
        effects = {effect: dict(own) for effect, own in self.effects.items()}
        for key, value in values.items():
            effect, colon, name = key.partition(":")
            if colon:
                effects.setdefault(effect, {})[name] = value
                continue
            require_known(key, parameters, f"rig {self.name}")
            parameters[key] = replace(parameters[key], value=value)
        return replace(self, parameters=parameters, effects=effects)

    def with_own_values(self, values: Mapping[str, float]) -> "Rig":
        """Return the rig with its share of some values; those of others are left alone.

        Parameters
        ----------
        values : mapping of str to float
            By parameter id and ``effect:parameter``, as `with_values` takes them, among others.
        """
        own = {k: v for k, v in values.items() if k in self.parameters or ":" in k}
        return self.with_values(own)

    def with_conditions(self, conditions: Mapping[str, float]) -> "Rig":
        """Return the rig with what was measured for one run.

        Parameters
        ----------
        conditions : mapping of str to float
            Condition key, such as ``load_mass``, to value in SI.

        Returns
        -------
        Rig
            A new rig; this one is unchanged.

        Notes
        -----
        A condition that only repeats what a fitted value was taken to be before the fit leaves
        the fitted value alone; one that says something else overrides it. What hangs on the rod is
        another share of another mass (`pneuservo.rigs.added_weight`).
        """
        known = self.conditions
        for key in conditions:
            require_known(key, known, "conditions")
        anew = {
            known[key]: value
            for key, value in conditions.items()
            if not _repeats(value, self.parameters[known[key]])
        }
        hung = {}
        if MOVED_MASS in anew:
            ratio = anew[MOVED_MASS] / self.parameters[MOVED_MASS].value
            hung = with_added_weight(self.effect_values, ratio)
        return self.with_values({**anew, **hung})


def load_rig(name_or_path: str | Path) -> Rig:
    """Return a built-in rig, or the rig in a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        A name of `BUILT_IN_RIGS` or `VARIANTS`, or the path of a file. A file names its ``kind``
        and need only state what differs from the built-in rig of that kind; another value without
        a tolerance is known as well as the built-in one, in share of the value.

    Returns
    -------
    Rig
        The rig, every value in SI.

    Raises
    ------
    InputError
        When there is no such rig or file, or the file holds an unknown key, an unknown
        parameter, or a value of the wrong dimension.

    Examples
    --------
    >>> load_rig("single-axis")["load.mass"]
    1.825
    """
    name = str(name_or_path)
    if name in BUILT_IN_RIGS:
        return _built_in(name)
    known = (*BUILT_IN_RIGS, *VARIANTS)
    if name in VARIANTS:
        return _merge(_read_built_in(name), Path(name))
    path = Path(name)
    if path.suffix != ".toml":
        raise InputError(
            f"rig {name!r} is not known; there are: {', '.join(known)}, "
            "or give the path of a rig file ending in .toml" + nearest(name, known)
        )
    return _merge(read_toml(path, "a rig file", InputError), path)


def built_in_text(name: str) -> str:
    """Return the file of a built-in rig, which is a rig file like any other.

    Parameters
    ----------
    name : str
        A name of `BUILT_IN_RIGS` or `VARIANTS`.

    Returns
    -------
    str
        Its text, comments and sources included.

    Raises
    ------
    InputError
        When there is no such rig.

    Examples
    --------
    >>> '"load.mass" = { value = 1.825, unit = "kg"' in built_in_text("single-axis")
    True
    """
    require_known(name, (*BUILT_IN_RIGS, *VARIANTS), "rig")
    return (files("pneuservo.rigs") / f"{name}.toml").read_text(encoding="utf-8")


def _read_built_in(name: str) -> dict[str, Any]:
    return tomllib.loads(built_in_text(name))


def _built_in(name: str) -> Rig:
    data = _read_built_in(name)
    head = data["rig"]
    parameters = {
        key: _parameter(entry, str(entry["unit"]), key) for key, entry in data["parameters"].items()
    }
    return Rig(name, head["kind"], head["title"], parameters, valve=head.get("valve", ""))


def _merge(data: dict[str, Any], path: Path) -> Rig:
    # `diagnosis` is what a repaired model says of how it came about; it changes nothing.
    for key in data:
        require_known(key, ("rig", "parameters", "effects", "transducers", "diagnosis"), str(path))
    head = table_in(data, "rig", path, InputError)
    kind = head.get("kind")
    if kind not in BUILT_IN_RIGS:
        raise InputError(
            f"{path}: [rig] kind is {kind!r}; allowed are: {', '.join(BUILT_IN_RIGS)}"
            + nearest(str(kind), BUILT_IN_RIGS)
        )
    for key in head:
        require_known(key, ("kind", "title", "valve"), f"{path} [rig]")
    base = _built_in(kind)
    parameters = dict(base.parameters)
    for key, entry in table_in(data, "parameters", path, InputError).items():
        require_known(key, parameters, f"{path} [parameters]")
        parameters[key] = _parameter(entry, parameters[key].unit, f"{path} {key}", parameters[key])
    effects = _effects(table_in(data, "effects", path, InputError), kind, f"{path} [effects]")
    transducers = read_transducers(
        table_in(data, "transducers", path, InputError), kind, f"{path} [transducers]"
    )
    title, valve = head.get("title", base.title), str(head.get("valve", base.valve))
    session = read_session(table_in(data, "diagnosis", path, InputError), f"{path} [diagnosis]")
    valve = _valve(valve, path)
    return Rig(str(path), kind, str(title), parameters, effects, valve, transducers, session)


def _valve(valve: str, path: Path) -> str:
    """Return the name of a built-in valve, or the path of a valve file beside the rig file."""
    if not valve.endswith(".toml"):
        return valve
    if Path(valve).name != valve:
        raise InputError(f"{path} [rig]: valve is {valve!r}; a valve file stands beside the rig's")
    beside = path.parent / valve
    target = Path(os.path.realpath(beside))
    if target.parent != Path(os.path.realpath(path.parent)) or (
        target.exists() and not target.is_file()
    ):
        raise InputError(
            f"{path} [rig]: valve {valve!r} leads to {target}; copy that file beside the rig's"
        )
    return str(beside)


def _parameter(entry: Any, unit: str, what: str, base: Parameter | None = None) -> Parameter:
    if not isinstance(entry, dict):
        entry = {"value": entry}
    fields = ("value", "unit", "tolerance", "free", "source", "nominal", "low", "high")
    for key in entry:
        require_known(key, fields, what)
    base = base or Parameter(float("nan"), unit)
    _require_unit(entry, unit, what)
    try:
        value = to_si(entry["value"], unit, what) if "value" in entry else base.value
        tolerance = tolerance_of_another(base, value)
        if "tolerance" in entry:
            tolerance = _tolerance(entry["tolerance"], value, unit, f"{what} tolerance")
        nominal = to_si(entry["nominal"], unit, what) if "nominal" in entry else base.nominal
    except QuantityError as problem:
        raise InputError(str(problem)) from problem
    free, source = bool(entry.get("free", base.free)), str(entry.get("source", base.source))
    return Parameter(value, unit, tolerance, free, source, nominal)


def tolerance_of_another(parameter: Parameter, value: float) -> float:
    """Return the tolerance of a parameter that has another value and is known no better or worse.

    Parameters
    ----------
    parameter : Parameter
        With its own value and tolerance.
    value : float
        The other [its unit].

    Returns
    -------
    float
        The same share of the value; where either is zero, or not a number, the same tolerance.

    Examples
    --------
    >>> tolerance_of_another(Parameter(2.0, "kg", tolerance=0.06), 4.0)
    0.12
    """
    if not parameter.tolerance or not abs(parameter.value) > 0.0 or value == 0.0:
        return parameter.tolerance
    return parameter.tolerance * abs(value / parameter.value)


def _require_unit(entry: Mapping[str, Any], unit: str, what: str) -> None:
    """Refuse a value that is stated in another unit; answers of a diagnosis write m^2."""
    if str(entry.get("unit", unit)).replace("^", "**") != unit.replace("^", "**"):
        raise InputError(f"{what}: the unit is {entry['unit']!r}, it has to be {unit!r}")


def _repeats(value: float, parameter: Parameter) -> bool:
    return parameter.nominal is not None and math.isclose(value, parameter.nominal, rel_tol=1e-9)


def _tolerance(tolerance: Any, value: float, unit: str, what: str) -> float:
    """Return a tolerance in the unit of the value; a percentage or a number is relative to it."""
    if isinstance(tolerance, str) and not tolerance.strip().endswith("%"):
        return abs(_difference(tolerance, unit, what))
    return abs(to_si(tolerance, "", what) * value)


def _effects(table: dict[str, Any], kind: str, where: str) -> dict[str, dict[str, float]]:
    """Return the effects of a rig file, each one the catalogue has for this kind of rig."""
    if not table:
        return {}
    # The catalogue brings the compiler along: not before it is needed.
    from pneuservo.effects import TABLES, effects_of
    from pneuservo.effects.unexplained import require_table

    entries = effects_of(kind, tables=True)
    known = {effect.id: {p.name: p for p in effect.parameters} for effect in entries}
    tables = {table.id: table for table in TABLES}
    effects = {}
    for key, entry in table.items():
        require_known(key, known, f"{where} of a rig of kind {kind}")
        effects[key] = _effect(entry, known[key], f"{where} {key}")
        if key in tables:
            require_table(tables[key], effects[key], f"{where} {key}")
    return effects


def _effect(entry: Any, known: Mapping[str, Any], what: str) -> dict[str, float]:
    if not isinstance(entry, dict):
        raise InputError(f"{what}: has to be a table of parameter values")
    values: dict[str, float] = {}
    for key, value in entry.items():
        require_known(key, known, what)
        number = value.get("value") if isinstance(value, dict) else value
        where, parameter = f"{what} {key}", known[key]
        if not isinstance(number, int | float | str) or isinstance(number, bool):
            raise InputError(f"{where}: {number!r} is not a number")
        if isinstance(value, dict):
            _require_unit(value, parameter.unit, where)
        values[key] = _size(number, parameter.unit, where)
        if values[key] < 0.0 <= parameter.low:
            raise InputError(f"{what} {key}: is {number:g} {parameter.unit}; it cannot be negative")
    return values


def _size(number: float | str, unit: str, where: str) -> float:
    """Return a parameter of an effect in SI; one in kelvin is a difference of temperatures."""
    try:
        return _difference(number, unit.replace("^", "**"), where)
    except QuantityError as problem:
        raise InputError(str(problem)) from problem


def _difference(number: float | str, unit: str, where: str) -> float:
    """Return a difference in SI: 2 degC would be a temperature."""
    if unit == "K" and isinstance(number, str) and not number.rstrip().endswith("K"):
        raise InputError(f"{where}: {number!r} may be no difference of temperatures; write it in K")
    return to_si(number, unit, where)
