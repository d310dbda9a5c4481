"""The sidecar: what is known about a recording beyond its samples, as written in its TOML file."""

import datetime
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from analog_card.toml_file import read_toml, table_in
from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.recordings.channels import CHANNELS
from pneuservo.recordings.units import plain_number, quantity

_TABLES = ("recording", "conditions", "controller", "table", "card", "time", "channels")
_LOWEST_RATE = 1e-9  # Hz, a sample in thirty years
_SOURCE_KEYS = ("column", "unit", "gauge", "scale", "offset", "noise_rms")


@dataclass(frozen=True)
class TableShape:
    """What the data file itself does not say.

    Parameters
    ----------
    header : bool
        Whether the first line of a text file holds the column names.
    names : tuple of str
        The column names of a file without them.
    """

    header: bool = True
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class TimeSource:
    """Where the time comes from.

    Parameters
    ----------
    column, unit : str, optional
        The time column and its unit.
    rate : float, optional
        The sample rate, instead of a column [Hz].
    """

    column: str | None = None
    unit: str | None = None
    rate: float | None = None


@dataclass(frozen=True)
class ChannelSource:
    """Where the samples of one channel come from.

    Parameters
    ----------
    column : str
        The column of the file.
    unit : str, optional
        Its unit, after `scale` and `offset`.
    scale, offset : float
        value = raw * scale + offset.
    gauge : bool, optional
        Whether the ambient pressure has to be added; None where only the unit may say so.
    noise_rms : str or float, optional
        The noise as written.
    """

    column: str
    unit: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    gauge: bool | None = None
    noise_rms: str | float | None = None


@dataclass(frozen=True)
class Sidecar:
    """A sidecar as written: names checked, values not yet in SI.

    Parameters
    ----------
    path : Path
        Where the sidecar is, or would be.
    present : bool
        Whether there is one.
    title, rig, taken, notes : str
        The table ``[recording]``.
    conditions, controller, card : mapping
        The tables of these names.
    table : TableShape
        The table ``[table]``.
    time : TimeSource or None
        The table ``[time]``; None when absent.
    channels : mapping of str to ChannelSource, or None
        The table ``[channels]``; None when absent.
    """

    path: Path
    present: bool = False
    title: str = ""
    rig: str = "single-axis"
    taken: str = ""
    notes: str = ""
    conditions: Mapping[str, Any] = field(default_factory=dict)
    controller: Mapping[str, Any] = field(default_factory=dict)
    card: Mapping[str, Any] = field(default_factory=dict)
    table: TableShape = field(default_factory=TableShape)
    time: TimeSource | None = None
    channels: Mapping[str, ChannelSource] | None = None


def read_sidecar(data_path: Path) -> Sidecar:
    """Return the sidecar of a data file.

    Parameters
    ----------
    data_path : Path
        The data file ``NAME.csv`` or any other form; the sidecar is ``NAME.toml``.

    Returns
    -------
    Sidecar
        What it says; `Sidecar.present` is False when there is none.

    Raises
    ------
    InputError
        When it is not valid TOML, or holds an unknown key or a value of the wrong type.
    """
    path = data_path.with_suffix(".toml")
    if not path.exists():
        return Sidecar(path)
    if not path.is_file():
        raise InputError(f"{path}: the sidecar is not a file; move it away")
    data = read_toml(path, "a sidecar", InputError)
    for key in data:
        require_known(key, _TABLES, str(path))
    tables = {key: table_in(data, key, path, InputError) for key in _TABLES}
    head = tables["recording"]
    for key in head:
        require_known(key, ("title", "rig", "taken", "notes"), f"{path}: [recording]")
    return Sidecar(
        path,
        present=True,
        title=_typed(head, "title", str, "", f"{path}: [recording]"),
        rig=_typed(head, "rig", str, "single-axis", f"{path}: [recording]"),
        taken=_date(head.get("taken", ""), f"{path}: [recording] taken"),
        notes=_typed(head, "notes", str, "", f"{path}: [recording]"),
        conditions=tables["conditions"],
        controller=tables["controller"],
        card=tables["card"],
        table=_table_shape(tables["table"], f"{path}: [table]"),
        time=_time_source(tables["time"], f"{path}: [time]") if "time" in data else None,
        channels=_channel_sources(tables["channels"], path) if "channels" in data else None,
    )


def _typed(table: Mapping[str, Any], key: str, kind: type, default: Any, where: str) -> Any:
    value = table.get(key, default)
    if not isinstance(value, kind):
        wanted = {str: 'text in "quotes"', bool: "true or false"}[kind]
        raise InputError(f"{where} {key} is {value!r}; it has to be {wanted}")
    return value


def _number(table: Mapping[str, Any], key: str, default: float, where: str) -> float:
    number = plain_number(table.get(key, default))
    if number is None or not math.isfinite(number):
        raise InputError(
            f"{where} {key} is {table[key]!r}; it has to be a finite number, such as -1.0"
        )
    return number


def _date(value: Any, where: str) -> str:
    if isinstance(value, datetime.date):  # a datetime is one as well
        return value.isoformat()
    if isinstance(value, str):
        return value
    raise InputError(f"{where} is {value!r}; it has to be a date, such as 1998-05-12")


def _table_shape(table: Mapping[str, Any], where: str) -> TableShape:
    for key in table:
        require_known(key, ("header", "names"), where)
    header = _typed(table, "header", bool, True, where)
    names = table.get("names", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f'{where} names is {names!r}; it has to be a list, such as ["t", "x"]')
    names = [name.strip() for name in names]
    if header and names:
        raise InputError(f"{where} names is only for a file without names; add header = false")
    if not header and not names:
        raise InputError(f'{where} header = false needs names, such as names = ["t", "x"]')
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"{where} names holds {name!r} more than once; make the names differ")
    return TableShape(header, tuple(names))


def _time_source(table: Mapping[str, Any], where: str) -> TimeSource:
    for key in table:
        require_known(key, ("column", "unit", "rate"), where)
    if "rate" in table:
        if len(table) > 1:
            raise InputError(f"{where} takes a rate or a column with its unit, not both")
        rate = quantity(table["rate"], "Hz", f"{where} rate")
        if rate < _LOWEST_RATE:
            raise InputError(
                f"{where} rate is {table['rate']!r}; it has to be greater than 0, such as '1 kHz'"
            )
        return TimeSource(rate=rate)
    if "column" not in table:
        raise InputError(f'{where} needs column = "..." with its unit, or rate = "... Hz"')
    column = _typed(table, "column", str, "", where).strip()
    unit = _typed(table, "unit", str, "", where) if "unit" in table else None
    return TimeSource(column=column, unit=unit)


def _channel_sources(table: Mapping[str, Any], path: Path) -> dict[str, ChannelSource]:
    sources: dict[str, ChannelSource] = {}
    if not table:
        raise InputError(f"{path}: [channels] is empty; name at least one channel")
    for name, entry in table.items():
        if name == "time":
            raise InputError(f"{path}: [channels] time does not belong here; use the table [time]")
        require_known(name, CHANNELS, f"{path}: [channels]")
        sources[name] = _channel_source(name, entry, f"{path}: [channels] {name}")
    return sources


def _channel_source(name: str, entry: Any, where: str) -> ChannelSource:
    example = f'{name} = {{ column = "...", unit = "{CHANNELS[name].unit}" }}'
    if not isinstance(entry, dict) or "column" not in entry:
        raise InputError(f"{where} is {entry!r}; it has to say the column: {example}")
    for key in entry:
        require_known(key, _SOURCE_KEYS, where)
    gauge = _typed(entry, "gauge", bool, False, where) if "gauge" in entry else None
    if gauge and not CHANNELS[name].pressure:
        raise InputError(f"{where}: gauge = true is only for pressures; remove it")
    scale = _number(entry, "scale", 1.0, where)
    if scale == 0.0:
        raise InputError(f"{where} scale is 0; every sample would vanish; give another number")
    noise = entry.get("noise_rms")
    if "noise_rms" in entry and (
        isinstance(noise, bool) or not isinstance(noise, str | int | float)
    ):
        raise InputError(f"{where} noise_rms is {noise!r}; write a number with a unit")
    return ChannelSource(
        column=_typed(entry, "column", str, "", where).strip(),
        unit=_typed(entry, "unit", str, "", where) if "unit" in entry else None,
        scale=scale,
        offset=_number(entry, "offset", 0.0, where),
        gauge=gauge,
        noise_rms=noise,
    )
