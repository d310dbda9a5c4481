"""Figures from TOML files: a frame, and for each axis its rig and the member it turns."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any

from analog_card.errors import InputError as QuantityError
from analog_card.quantities import to_si
from analog_card.toml_file import read_toml, table_in
from pneuservo.animated_figure.figure import BUILT_IN_FIGURES, FRAME, AnimatedFigure, Axis, Frame
from pneuservo.errors import InputError
from pneuservo.naming import nearest, require_known
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, Rig, load_rig

# SI units of the entries; what is not here is text or a table.
_FRAME = {"mass": "kg", "frequency": "Hz", "damping": ""}
_MEMBER = {"mass": "kg", "inertia": "kg*m**2", "centre": "m", "length": "m"}
_AXIS = {"lever": "m", "rest_angle": "rad"}
_AXIS_KEYS = (*_AXIS, "rig", "member", "carried_by", "parameters", "source")
_NAME = re.compile(r"[\w-]+")


def load_figure(name_or_path: str | Path) -> AnimatedFigure:
    """Return a built-in figure, or the figure in a TOML file.

    Parameters
    ----------
    name_or_path : str or Path
        A name of `BUILT_IN_FIGURES`, or the path of a file ending in .toml. A rig it names is a
        built-in one, or a file beside it.

    Returns
    -------
    AnimatedFigure
        Every value in SI.

    Raises
    ------
    InputError
        When there is no such figure or file, or it holds an unknown key, an impossible value or
        one of the wrong dimension.

    Examples
    --------
    >>> len(load_figure("fourteen-axes").axes)
    14
    """
    name = str(name_or_path)
    if name in BUILT_IN_FIGURES:
        folder = files("pneuservo.animated_figure") / "figures"
        text = (folder / f"{name}.toml").read_text(encoding="utf-8")
        return _figure(tomllib.loads(text), name, None)
    path = Path(name)
    if path.suffix != ".toml":
        raise InputError(
            f"figure {name!r} is not known; there are: {', '.join(BUILT_IN_FIGURES)}, or give the "
            "path of a figure file ending in .toml" + nearest(name, BUILT_IN_FIGURES)
        )
    return _figure(read_toml(path, "a figure file", InputError), name, path.parent)


def _figure(data: dict[str, Any], name: str, folder: Path | None) -> AnimatedFigure:
    for key in data:
        require_known(key, ("figure", "frame", "axes"), name)
    head = table_in(data, "figure", name, InputError)
    frame = table_in(data, "frame", name, InputError)
    for key in head:
        require_known(key, ("title", "source", "gravity"), f"{name} [figure]")
    listed = table_in(data, "axes", name, InputError)
    for key in listed:
        _require_name(key, f"{name} [axes]")
    axes = {
        key: _axis(table_in(listed, key, f"{name} [axes]", InputError), where, folder)
        for key in listed
        for where in [f"{name} [axes.{key}]"]
    }
    if FRAME in axes:
        raise InputError(f"{name}: an axis is called {FRAME!r}, which is what all stand on")
    gravity = _quantity(head.get("gravity", 9.81), "m/s**2", f"{name} [figure] gravity")
    title = str(head.get("title", name))
    return AnimatedFigure(
        name, title, Frame(**_quantities(frame, _FRAME, f"{name} [frame]")), axes, gravity
    )


def _require_name(name: str, where: str) -> None:
    # The recording of an axis is a file of its name.
    if _NAME.fullmatch(name) is None:
        raise InputError(
            f"{where}: {name!r} cannot be the name of an axis, after which its recording is "
            "called; use letters, digits, - and _, such as left-hip"
        )


def _axis(entry: dict[str, Any], where: str, folder: Path | None) -> Axis:
    for key in entry:
        require_known(key, _AXIS_KEYS, where)
    member = table_in(entry, "member", where, InputError)
    numbers = {key: value for key, value in entry.items() if key in _AXIS}
    values = _quantities(member, _MEMBER, f"{where} member", whole=True)
    values |= _quantities(numbers, _AXIS, where)
    if "lever" not in values:
        raise InputError(f'{where}: lever is missing; state it, such as lever = "60 mm"')
    rig = _rig(str(entry.get("rig", "")), where, folder)
    changed = {}
    for key, value in table_in(entry, "parameters", where, InputError).items():
        require_known(key, rig.parameters, f"{where} parameters")
        changed[key] = _quantity(value, rig.parameters[key].unit, f"{where} parameters {key}")
    try:
        return Axis(
            rig=rig.with_values(changed), carrier=str(entry.get("carried_by", FRAME)), **values
        )
    except InputError as problem:
        raise InputError(f"{where}: {problem}") from problem


def _rig(name: str, where: str, folder: Path | None) -> Rig:
    if name in (*BUILT_IN_RIGS, *VARIANTS):
        return load_rig(name)
    if folder is None or Path(name).name != name or Path(name).suffix != ".toml":
        raise InputError(
            f"{where}: rig is {name!r}; there are: {', '.join((*BUILT_IN_RIGS, *VARIANTS))}, or "
            "name a rig file that stands beside the figure's" + nearest(name, VARIANTS)
        )
    return load_rig(folder / name)


def _quantities(
    entries: dict[str, Any], units: dict[str, str], where: str, whole: bool = False
) -> dict[str, float]:
    for key in entries:
        require_known(key, units, where)
    required = units if whole else [key for key in ("mass", "frequency") if key in units]
    for key in required:
        if key not in entries:
            raise InputError(f"{where}: {key} is missing; it is a number in {units[key]}")
    return {key: _quantity(value, units[key], f"{where} {key}") for key, value in entries.items()}


def _quantity(value: Any, unit: str, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise InputError(f"{what}: {value!r} is not a quantity; give a number with its unit")
    try:
        return to_si(value, unit, what)
    except QuantityError as problem:
        raise InputError(str(problem)) from problem
