"""A rig as the text of a rig file: what differs from the built-in rig of its kind."""

from pathlib import Path
from typing import Any

from pneuservo.errors import InputError
from pneuservo.rigs.rig import Parameter, Rig, load_rig, tolerance_of_another


def rig_document(rig: Rig) -> dict[str, Any]:
    """Return what a rig file has to say so that reading it gives the rig again.

    Parameters
    ----------
    rig : Rig
        The rig.

    Returns
    -------
    dict
        Tables ``rig`` and ``parameters``, and ``effects`` and ``transducers`` where it has any, in
        SI. A valve file is named as one that stands beside the rig file; see `files_beside`.

    Examples
    --------
    >>> rig_document(load_rig("single-axis").with_values({"load.mass": 2.0}))["parameters"]
    {'load.mass': {'value': 2.0, 'unit': 'kg', 'tolerance': '0.05475 kg'}}
    """
    built_in = load_rig(rig.kind)
    head = {"kind": rig.kind, "title": rig.title}
    if rig.valve:
        head["valve"] = Path(rig.valve).name
    entries = {
        key: _entry(parameter, built_in.parameters[key])
        for key, parameter in rig.parameters.items()
    }
    document: dict[str, Any] = {
        "rig": head,
        "parameters": {key: entry for key, entry in entries.items() if entry},
    }
    if rig.effects:
        document["effects"] = {
            effect: {name: {"value": value} for name, value in values.items()}
            for effect, values in rig.effects.items()
        }
    if rig.transducers:
        document["transducers"] = {
            name: transducer.as_table() for name, transducer in rig.transducers.items()
        }
    return document


def files_beside(rig: Rig) -> dict[str, str]:
    """Return the files that have to stand beside a rig file, by name: that of its valve.

    Parameters
    ----------
    rig : Rig
        The rig.

    Raises
    ------
    InputError
        When a file cannot be read.
    """
    if not rig.valve.endswith(".toml"):
        return {}
    path = Path(rig.valve)
    try:
        return {path.name: path.read_text(encoding="utf-8")}
    except OSError as problem:
        raise InputError(f"{path}: cannot be read: {problem.strerror}") from problem
    except UnicodeDecodeError:
        raise InputError(f"{path}: is not UTF-8 text; a valve file is needed") from None


def _entry(parameter: Parameter, built_in: Parameter) -> dict[str, Any]:
    """Return what of a parameter differs; nothing where nothing does."""
    entry: dict[str, Any] = {}
    if parameter.value != built_in.value:
        entry |= {"value": parameter.value, "unit": parameter.unit}
    if parameter.tolerance != tolerance_of_another(built_in, parameter.value):
        entry["tolerance"] = f"{parameter.tolerance!r} {parameter.unit}".strip()
    for name in ("free", "source", "nominal"):
        value = getattr(parameter, name)
        if value != getattr(built_in, name):
            entry[name] = value
    return entry
