"""Discharge-coefficient tables of a servo valve, one per flow path."""

import tomllib
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.toml_file import read_toml
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant.flow_paths import FLOW_PATHS, FlowPathTable

VALVES_KEPT = 32
"""Of so many valves what is worked out is kept."""


def load_valve_tables(name: str) -> dict[str, FlowPathTable]:
    """Return the discharge-coefficient tables of a valve.

    Parameters
    ----------
    name : str
        Name of a built-in valve, such as ``"ddv-27a1"``, or the path of a valve file ending in
        ``.toml``, such as a calibration writes.

    Returns
    -------
    dict of str to FlowPathTable
        One table per flow path: ``s_a``, ``b_e``, ``s_b``, ``a_e``
        (supply, exhaust, chamber a, chamber b).

    Raises
    ------
    InputError
        When there is no such valve, or the file holds no tables.

    Examples
    --------
    >>> float(load_valve_tables("ddv-27a1")["s_a"].discharge_coefficient[-1, 0])
    0.8
    """
    return _tables_of(name, valve_content(name))


def valve_content(name: str) -> bytes:
    """Return what the file of a valve holds now, by which what is worked out of it may be kept.

    Parameters
    ----------
    name : str
        As `load_valve_tables` takes it.

    Returns
    -------
    bytes
        Nothing of a built-in valve, which never changes, or of a file that cannot be read.
    """
    try:
        return Path(name).read_bytes() if name.endswith(".toml") else b""
    except OSError:
        return b""


@lru_cache(VALVES_KEPT)
def _tables_of(name: str, content: bytes) -> dict[str, FlowPathTable]:
    """Return the tables of a valve, read anew when its file holds something else."""
    if name.endswith(".toml"):
        return _tables(read_toml(name, "a valve file", InputError), name)
    folder = files("pneuservo.rigs") / "valves"
    known = sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir())
    if name not in known:
        raise InputError(
            f"valve {name!r} is not known; there are: {', '.join(known)}, or give the name of a "
            "valve file ending in .toml"
        )
    return _tables(tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8")), name)


def _tables(data: dict[str, Any], where: str) -> dict[str, FlowPathTable]:
    paths = data.get("path")
    if not isinstance(paths, dict) or set(paths) != set(FLOW_PATHS):
        found = ", ".join(paths) if isinstance(paths, dict) else "no such tables"
        raise InputError(
            f"{where}: a valve needs the tables {', '.join(f'[path.{key}]' for key in FLOW_PATHS)}"
            f"; there are: {found}"
        )
    return {path: _table(table, f"{where} [path.{path}]") for path, table in paths.items()}


def _table(table: Any, where: str) -> FlowPathTable:
    names = ("command_volts", "pressure_ratio", "discharge_coefficient")
    try:
        command, ratio, coefficient = (_numbers(table[name], name) for name in names)
    except (KeyError, TypeError, ValueError, OverflowError) as problem:
        raise InputError(
            f"{where}: needs {', '.join(names)}, the latter two with as many numbers in every row "
            f"({problem})"
        ) from problem
    if command.ndim != 1 or ratio.ndim != 2 or ratio.shape != coefficient.shape:
        raise InputError(f"{where}: {', '.join(names)} are not one row of points per command")
    if len(command) != len(ratio) or not len(command):
        raise InputError(f"{where}: {len(command)} commands for {len(ratio)} rows")
    if not ratio.size:
        raise InputError(f"{where}: the rows are empty; each needs one point or more")
    everything = np.concatenate((command, ratio.ravel(), coefficient.ravel()))
    if not np.isfinite(everything).all() or (everything < 0.0).any():
        raise InputError(f"{where}: every number has to be finite and 0 or more")
    if (np.diff(command) <= 0.0).any() or (np.diff(ratio, axis=1) <= 0.0).any():
        raise InputError(f"{where}: commands and the pressure ratios of a row have to increase")
    return FlowPathTable(command, ratio, coefficient)


def _numbers(value: Any, name: str) -> Array:
    # Taken as it is, true would be 1, and a text what it reads as.
    if not _only_numbers(value):
        raise ValueError(f"{name} holds what is no number")
    return np.array(value, dtype=float)


def _only_numbers(value: Any) -> bool:
    if isinstance(value, list):
        return all(map(_only_numbers, value))
    return isinstance(value, int | float) and not isinstance(value, bool)
