"""Design files: reading a card from TOML and writing it back."""

import tomllib
from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, get_type_hints

import tomli_w

from analog_card.design import Design
from analog_card.design_fields import require_allowed
from analog_card.design_tolerances import PartTolerance
from analog_card.errors import InputError
from analog_card.netlist_text import nearest
from analog_card.quantities import as_text, to_si
from analog_card.toml_file import read_toml

DEFAULT = "default.toml"


def load_design(path: str | Path | None = None) -> Design:
    """Read a design file.

    Parameters
    ----------
    path : str or Path, optional
        A TOML file with the values that differ from the recommended card; without it the
        recommended card.

    Returns
    -------
    Design
        All values in SI units.

    Raises
    ------
    InputError
        When the file cannot be read, holds an unknown name, a value that is not a quantity of
        the right kind, or one that is out of range.

    Examples
    --------
    >>> design = load_design()
    >>> design.soldered.velocity_differentiator.resistance
    120000.0
    """
    shipped = files("analog_card") / "designs" / DEFAULT
    content = tomllib.loads(shipped.read_text(encoding="utf-8"))
    where = DEFAULT
    if path is not None:
        where = str(path)
        content = _overlaid(content, read_toml(path, "a design file"), _shape(Design), where)
    notes: dict[str, dict[str, Any]] = {}
    title = _text(content.get("title", ""), f"{where}: title")
    sections = {
        name: _read(kind, content[name], where, name, notes)
        for name, kind in _shape(Design).items()
    }
    sources = {name: note.pop("source") for name, note in notes.items() if "source" in note}
    own = {name.removeprefix("soldered."): note for name, note in notes.items() if note}
    return Design(title=title, own_tolerances=own, sources=sources, **sections)


def design_to_toml(design: Design) -> str:
    """Return a design as the text of a file that `load_design` reads back.

    Parameters
    ----------
    design : Design
        The card.

    Returns
    -------
    str
        TOML, each value with its unit and, where known, its source.
    """
    notes: dict[str, dict[str, str | float]] = {
        f"soldered.{name}": {
            item.name: _written(own[item.name], item.metadata["unit"])
            for item in fields(PartTolerance)
            if item.name in own
        }
        for name, own in design.own_tolerances.items()
    }
    for name, source in design.sources.items():
        notes.setdefault(name, {})["source"] = source
    blocks = [_entry("title", design.title, {})]
    for name in _shape(Design):
        blocks.extend(_blocks(getattr(design, name), name, notes))
    return "\n\n".join(blocks) + "\n"


def _shape(kind: type) -> dict[str, Any]:
    """Return the sections of a dataclass: its fields that are dataclasses themselves."""
    return {name: hint for name, hint in get_type_hints(kind).items() if is_dataclass(hint)}


def _overlaid(
    base: Mapping[str, Any], changes: Any, shape: Mapping[str, Any], where: str, prefix: str = ""
) -> dict[str, Any]:
    """Return the base with the changes in place, refusing names the base does not have."""
    if not isinstance(changes, Mapping):
        raise InputError(f"{where}: {prefix[:-1]} is {changes!r}, a table of values is needed")
    result = dict(base)
    for name, value in changes.items():
        if name not in base:
            raise InputError(f"{where}: unknown name {prefix + name!r}{nearest(name, base)}")
        if name in shape:
            result[name] = _overlaid(
                base[name], value, _shape(shape[name]), where, f"{prefix}{name}."
            )
        else:
            result[name] = value
    return result


def _read(kind: Any, content: Any, where: str, path: str, notes: dict[str, dict[str, Any]]) -> Any:
    sections = _shape(kind)
    values = {}
    for item in fields(kind):
        name = f"{path}.{item.name}"
        if item.name in sections:
            section = sections[item.name]
            values[item.name] = _read(section, content[item.name], where, name, notes)
        else:
            values[item.name] = _value(content[item.name], item, where, name, notes)
    try:
        return kind(**values)
    except InputError as problem:
        raise InputError(f"{where}: {path}: {problem}") from problem


def _value(
    found: Any, item: "Field[Any]", where: str, name: str, notes: dict[str, dict[str, Any]]
) -> float:
    """Return a value in SI; what stands beside it in its table goes to the notes."""
    if isinstance(found, Mapping):
        # Parts whose spread matters may have a tolerance of their own.
        own = {each.name: each for each in fields(PartTolerance)} if item.metadata["kind"] else {}
        allowed = ["value", "source", *own]
        for key in found.keys() - set(allowed):
            raise InputError(f"{where}: unknown name {f'{name}.{key}'!r}{nearest(key, allowed)}")
        if "value" not in found:
            raise InputError(f"{where}: {name} has no value")
        note: dict[str, Any] = {
            key: _number(found[key], each, f"{where}: {name}.{key}")
            for key, each in own.items()
            if key in found
        }
        if "source" in found:
            note["source"] = _text(found["source"], f"{where}: {name}.source")
        notes[name] = note
        found = found["value"]
    return _number(found, item, f"{where}: {name}")


def _text(found: Any, what: str) -> str:
    if not isinstance(found, str):
        raise InputError(f"{what} is {found!r}, a text is needed")
    return found


def _number(found: Any, item: "Field[Any]", what: str) -> float:
    number = to_si(found, item.metadata["unit"], what)
    require_allowed(number, item.metadata, what, found)
    return number


def _blocks(section: Any, path: str, notes: Mapping[str, Mapping[str, str | float]]) -> list[str]:
    """Return the text of a section and of the sections in it."""
    inner = _shape(type(section))
    lines = []
    for item in fields(section):
        if item.name not in inner:
            value, unit = getattr(section, item.name), item.metadata["unit"]
            note = notes.get(f"{path}.{item.name}", {})
            lines.append(_entry(item.name, _written(value, unit), note))
    blocks = ["\n".join([f"[{path}]", *lines])] if lines else []
    for name in inner:
        blocks.extend(_blocks(getattr(section, name), f"{path}.{name}", notes))
    return blocks


def _written(value: float, unit: str) -> str | float:
    if not unit:
        return value
    # A prefix would go to the kelvin: 50 1/MK.
    return f"{value * 1e6:.12g} ppm/K" if unit == "1/K" else as_text(value, unit)


def _entry(name: str, value: str | float, note: Mapping[str, str | float]) -> str:
    if not note:
        return tomli_w.dumps({name: value}).strip()
    inline = tomli_w.dumps({"value": value, **note}).strip().replace("\n", ", ")
    return f"{name} = {{ {inline} }}"
