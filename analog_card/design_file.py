"""Design files: reading a card from TOML and writing it back."""

import tomllib
from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, get_type_hints

import tomli_w

from analog_card.design import Design
from analog_card.errors import InputError
from analog_card.netlist_text import nearest
from analog_card.quantities import as_text, to_si

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
        content = _overlaid(content, _parsed(Path(path)), _shape(Design), where)
    sources: dict[str, str] = {}
    title = content.get("title", "")
    if not isinstance(title, str):
        raise InputError(f"{where}: title is {title!r}, a text is needed")
    sections = {
        name: _read(kind, content[name], where, name, sources)
        for name, kind in _shape(Design).items()
    }
    return Design(title=title, sources=sources, **sections)


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
    blocks = [_entry("title", design.title)]
    for name in _shape(Design):
        blocks.extend(_blocks(getattr(design, name), name, design.sources))
    return "\n\n".join(blocks) + "\n"


def _parsed(path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise InputError(f"{path}: {problem.strerror}; a design file is needed") from problem
    except UnicodeDecodeError as problem:
        raise InputError(f"{path}: not UTF-8 text; save it as UTF-8") from problem
    except tomllib.TOMLDecodeError as problem:
        raise InputError(f"{path}: not TOML: {problem}") from problem


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


def _read(kind: Any, content: Any, where: str, path: str, sources: dict[str, str]) -> Any:
    sections = _shape(kind)
    values = {}
    for item in fields(kind):
        name = f"{path}.{item.name}"
        if item.name in sections:
            section = sections[item.name]
            values[item.name] = _read(section, content[item.name], where, name, sources)
        else:
            values[item.name] = _value(content[item.name], item, where, name, sources)
    return kind(**values)


def _value(found: Any, item: "Field[Any]", where: str, name: str, sources: dict[str, str]) -> float:
    if isinstance(found, Mapping):
        for key in found.keys() - {"value", "source"}:
            raise InputError(
                f"{where}: unknown name {f'{name}.{key}'!r}{nearest(key, ['value', 'source'])}"
            )
        if "value" not in found:
            raise InputError(f"{where}: {name} has no value")
        if "source" in found:
            sources[name] = str(found["source"])
        found = found["value"]
    number = to_si(found, item.metadata["unit"], f"{where}: {name}")
    allowed = {
        "positive": number > 0,
        "not negative": number >= 0,
        "any": True,
        "fraction": 0 <= number <= 1,
    }
    if not allowed[item.metadata["allowed"]]:
        needed = (
            "a fraction of travel, 0 to 1,"
            if item.metadata["allowed"] == "fraction"
            else (f"a {item.metadata['allowed']} value")
        )
        raise InputError(f"{where}: {name} is {found!r}, {needed} is needed")
    return number


def _blocks(section: Any, path: str, sources: Mapping[str, str]) -> list[str]:
    """Return the text of a section and of the sections in it."""
    inner = _shape(type(section))
    lines = []
    for item in fields(section):
        if item.name not in inner:
            value, unit = getattr(section, item.name), item.metadata["unit"]
            source = sources.get(f"{path}.{item.name}")
            lines.append(_entry(item.name, as_text(value, unit) if unit else value, source))
    blocks = ["\n".join([f"[{path}]", *lines])] if lines else []
    for name in inner:
        blocks.extend(_blocks(getattr(section, name), f"{path}.{name}", sources))
    return blocks


def _entry(name: str, value: str | float, source: str | None = None) -> str:
    if source is None:
        return tomli_w.dumps({name: value}).strip()
    inline = tomli_w.dumps({"value": value, "source": source}).strip().replace("\n", ", ")
    return f"{name} = {{ {inline} }}"
