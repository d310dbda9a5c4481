"""Recordings as people keep them: column names, units and gauge readings by habit."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import tomli_w

from analog_card.files import write_whole
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

# Unit, how much of it is one SI unit, digits after the point.
_UNITS: dict[str, tuple[tuple[str, float, int], ...]] = {
    "valve_voltage": (("V", 1.0, 4),),
    "displacement": (("m", 1.0, 8), ("mm", 1e3, 5)),
    "demand": (("m", 1.0, 8), ("mm", 1e3, 5)),
    "pressure": (("Pa", 1.0, 1), ("bar", 1e-5, 6), ("kPa", 1e-3, 4)),
}
_NAMES: dict[str, tuple[str, ...]] = {
    "valve_voltage": ("valve_voltage", "u", "AO0"),
    "displacement": ("displacement", "x", "pot"),
    "demand": ("demand", "xd", "AO1"),
    "pressure_a": ("pressure_a", "pA", "AI1"),
    "pressure_b": ("pressure_b", "pB", "AI2"),
    "supply_pressure": ("supply_pressure", "pS", "AI3"),
}


@dataclass(frozen=True)
class Habit:
    """How somebody keeps recordings.

    Parameters
    ----------
    names : dict of str to str
        Canonical channel to column name.
    units : dict of str to (unit, scale, digits)
        Canonical channel to how it is written.
    gauge : bool
        Whether pressures are above the ambient pressure.
    """

    names: dict[str, str]
    units: dict[str, tuple[str, float, int]]
    gauge: bool


def draw_habit(rng: np.random.Generator, transducers: Sequence[str]) -> Habit:
    """Draw a habit.

    Parameters
    ----------
    rng : Generator
        Draws it.
    transducers : sequence of str
        Canonical channels beside valve voltage and demand.

    Returns
    -------
    Habit
        The same for all recordings of a case.
    """
    style, pressure = int(rng.integers(3)), int(rng.integers(3))
    channels = ("valve_voltage", "demand", *transducers)
    units = {}
    for name in channels:
        choices = _UNITS["pressure" if "pressure" in name else name]
        units[name] = choices[pressure % len(choices)]
    return Habit({name: _NAMES[name][style] for name in channels}, units, bool(rng.integers(2)))


def write_dressed(recording: Recording, habit: Habit, rig: Rig, rig_file: str, path: Path) -> None:
    """Write a recording and its sidecar in somebody's habit.

    Parameters
    ----------
    recording : Recording
        In SI, absolute.
    habit : Habit
        How.
    rig : Rig
        The rig; gauge readings refer to its ambient pressure.
    rig_file : str
        Name of its file beside the recording.
    path : Path
        Of the table; the sidecar goes beside it.
    """
    columns = {"t": np.round(recording.time * 1e3, 3)}
    channels: dict[str, Any] = {}
    for name, values in recording.channels.items():
        unit, scale, digits = habit.units[name]
        gauge = habit.gauge and "pressure" in name
        shown = (values - rig["ambient.pressure"] if gauge else values) * scale
        columns[habit.names[name]] = np.round(shown, digits)
        channels[name] = {"column": habit.names[name], "unit": unit}
        if gauge:
            channels[name]["gauge"] = True
        if name in recording.noise_rms:
            channels[name]["noise_rms"] = f"{recording.noise_rms[name] * scale:.4g} {unit}"
    units = {key: rig.parameters[name].unit for key, name in rig.conditions.items()}
    sidecar = {
        "recording": {"title": recording.title, "rig": rig_file},
        "time": {"column": "t", "unit": "ms"},
        "channels": channels,
        "conditions": {k: f"{v!r} {units[k]}" for k, v in recording.conditions.items()},
    }
    write_whole(path.with_suffix(".toml"), tomli_w.dumps(sidecar))
    write_whole(path, pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))
