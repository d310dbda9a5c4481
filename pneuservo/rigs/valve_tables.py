"""Discharge-coefficient tables of a servo valve, one per flow path."""

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from pneuservo.errors import InputError

FLOW_PATHS = ("s_a", "b_e", "s_b", "a_e")


@dataclass(frozen=True)
class FlowPathTable:
    """Discharge coefficient of one flow path over command and pressure ratio.

    Parameters
    ----------
    command : (n,) array
        Magnitude of the command, increasing [V].
    pressure_ratio : (n, 5) array
        Break points of each row, downstream over upstream pressure [-].
    discharge_coefficient : (n, 5) array
        Coefficient at the break points; linear between them [-].
    """

    command: NDArray[np.float64]
    pressure_ratio: NDArray[np.float64]
    discharge_coefficient: NDArray[np.float64]


@cache
def load_valve_tables(name: str) -> dict[str, FlowPathTable]:
    """Return the discharge-coefficient tables of a built-in valve.

    Parameters
    ----------
    name : str
        Name of the valve, such as ``"ddv-27a1"``.

    Returns
    -------
    dict of str to FlowPathTable
        One table per flow path: ``s_a``, ``b_e``, ``s_b``, ``a_e``
        (supply, exhaust, chamber a, chamber b).

    Raises
    ------
    InputError
        When there is no such valve.

    Examples
    --------
    >>> float(load_valve_tables("ddv-27a1")["s_a"].discharge_coefficient[-1, 0])
    0.8
    """
    folder = files("pneuservo.rigs") / "valves"
    known = sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir())
    if name not in known:
        raise InputError(f"valve {name!r} is not known; there are: {', '.join(known)}")
    data = tomllib.loads((folder / f"{name}.toml").read_text(encoding="utf-8"))
    return {
        path: FlowPathTable(
            np.array(table["command_volts"]),
            np.array(table["pressure_ratio"]),
            np.array(table["discharge_coefficient"]),
        )
        for path, table in data["path"].items()
    }
