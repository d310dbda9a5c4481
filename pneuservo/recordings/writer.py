"""Writing a recording and its sidecar, so that reading them gives the same values."""

import datetime
import io
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from analog_card.files import write_whole
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.recordings.channels import CHANNELS
from pneuservo.recordings.conditions import CARD_UNITS, CONTROLLER_KINDS, CONTROLLER_UNITS
from pneuservo.recordings.recording import Recording
from pneuservo.recordings.sidecar import read_sidecar
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, load_rig

_Columns = Mapping[str, Array]


def write_recording(recording: Recording, path: str | Path) -> Path:
    """Write a recording and its sidecar.

    Parameters
    ----------
    recording : Recording
        What to write.
    path : str or Path
        Where to: ``.csv``, ``.parquet``, ``.h5`` or ``.hdf5``. The sidecar goes beside it. A rig
        file, with its valve file, or a card design that it refers to is copied there.

    Returns
    -------
    Path
        The data file.

    Raises
    ------
    InputError
        When the suffix is another, a channel or condition is not known, or the files that the
        recording was read from, the sidecar of a recording of the same name in another form, or
        another file that is no sidecar, would be written over.

    Notes
    -----
    Values are in SI and to full precision: reading the files gives equal numbers. Each file is
    written whole or not at all, the sidecar first, since samples without it could be taken for
    another rig's.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from pneuservo.recordings.reader import read_recording
    >>> time = np.arange(20) * 0.001
    >>> written = write_recording(
    ...     Recording("ramp", time, {"displacement": 0.1 * time}), tempfile.mkdtemp() + "/ramp.csv"
    ... )
    >>> bool(np.all(read_recording(written)["displacement"] == 0.1 * time))
    True
    """
    path = require_recording_file(path)
    encode = _ENCODERS[path.suffix.lower()]
    for name in recording.channels:
        require_known(name, CHANNELS, f"{path}: channel")
    sidecar_path = path.with_suffix(".toml")
    _protect_source(recording, path, sidecar_path)
    sidecar = _sidecar(recording, path)
    _protect_another(path, sidecar)
    data = encode({"time": recording.time, **recording.channels})
    write_whole(sidecar_path, sidecar)
    return write_whole(path, data)


def require_recording_file(path: str | Path) -> Path:
    """Return where a recording is going to be written; refuse what cannot become one.

    Parameters
    ----------
    path : str or Path
        As `write_recording` takes it.

    Raises
    ------
    InputError
        When the suffix is another, it is a folder, or the sidecar would take the place of another
        kind of file, such as a rig or a card design of the same name.
    """
    path = Path(path)
    if path.suffix.lower() not in _ENCODERS:
        raise InputError(
            f"{path}: a recording is written to a file ending in one of: {', '.join(_ENCODERS)}"
        )
    # Found out only when it is written, it would leave the sidecar behind.
    if path.is_dir():
        raise InputError(
            f"{path}: is a folder; a recording is a file: name one in it, such as "
            f"{path / 'recording'}{path.suffix}"
        )
    try:
        read_sidecar(path)
    except InputError as problem:
        raise InputError(
            f"{path}: its sidecar would take the place of another file; choose another name "
            f"({problem})"
        ) from problem
    return path


def _protect_source(recording: Recording, path: Path, sidecar_path: Path) -> None:
    if recording.source is None:
        return
    inputs = {recording.source.resolve(), recording.source.with_suffix(".toml").resolve()}
    for target in (path, sidecar_path):
        if target.resolve() in inputs:
            raise InputError(
                f"{target}: belongs to the recording that was read, which is never written over; "
                "choose another name"
            )


def _protect_another(path: Path, sidecar: str) -> None:
    """Refuse a sidecar that would say of a recording in another form what is not so."""
    from pneuservo.recordings.reader import SUFFIXES

    there = path.with_suffix(".toml")
    if path.exists() or not there.is_file() or there.read_bytes() == sidecar.encode():
        return
    for suffix in SUFFIXES:
        other = path.with_suffix(suffix)
        if suffix != path.suffix.lower() and other.exists():
            raise InputError(
                f"{path}: its sidecar would take the place of that of {other}; choose another name"
            )


def _csv(columns: _Columns) -> bytes:
    import pandas

    # The shortest text that reads back as the same number.
    return pandas.DataFrame(dict(columns)).to_csv(index=False, lineterminator="\n").encode()


def _parquet(columns: _Columns) -> bytes:
    import pyarrow
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(pyarrow.table(dict(columns)), stream)
    return stream.getvalue()


def _hdf5(columns: _Columns) -> bytes:
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        for name, values in columns.items():
            dataset = file.create_dataset(name, data=values)
            dataset.attrs["unit"] = CHANNELS[name].unit if name in CHANNELS else "s"
    return stream.getvalue()


_ENCODERS: dict[str, Callable[[_Columns], bytes]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".h5": _hdf5,
    ".hdf5": _hdf5,
}


def _sidecar(recording: Recording, path: Path) -> str:
    import tomli_w

    head: dict[str, Any] = {"title": recording.title, "rig": recording.rig}
    if recording.rig not in (*BUILT_IN_RIGS, *VARIANTS):
        head["rig"] = _beside(Path(recording.rig), path)
        valve = load_rig(recording.rig).valve
        if valve.endswith(".toml"):
            _beside(Path(valve), (path.parent / head["rig"]).parent / path.name)
    if recording.taken:
        head["taken"] = _date(recording.taken)
    head["notes"] = recording.notes
    document: dict[str, Any] = {"recording": head}
    if recording.conditions:
        units = _condition_units(recording, path)
        document["conditions"] = _with_units(recording.conditions, units)
    if recording.controller:
        document["controller"] = _controller(recording, path)
    if recording.card:
        document["card"] = _card(recording, path)
    document["time"] = {"column": "time", "unit": "s"}
    document["channels"] = {name: _channel(recording, name) for name in recording.channels}
    return tomli_w.dumps(document)


def _channel(recording: Recording, name: str) -> dict[str, Any]:
    unit = CHANNELS[name].unit
    entry: dict[str, Any] = {"column": name}
    if unit:
        entry["unit"] = unit
    if name in recording.noise_rms:
        entry["noise_rms"] = _written(recording.noise_rms[name], unit)
    return entry


def _condition_units(recording: Recording, path: Path) -> dict[str, str]:
    rig = load_rig(recording.rig)
    for key in recording.conditions:
        require_known(key, rig.conditions, f"{path}: condition")
    return {key: rig.parameters[rig.conditions[key]].unit for key in recording.conditions}


def _controller(recording: Recording, path: Path) -> dict[str, Any]:
    figures = dict(recording.controller)
    kind = str(figures.pop("kind", ""))
    require_known(kind, CONTROLLER_KINDS, f"{path}: controller kind")
    for key in figures:
        require_known(key, CONTROLLER_UNITS, f"{path}: controller")
    return {"kind": kind, **_with_units(figures, CONTROLLER_UNITS)}


def _card(recording: Recording, path: Path) -> dict[str, Any]:
    if "design" in recording.card:
        return {"design": _beside(Path(recording.card["design"]), path)}
    for key in recording.card:
        require_known(key, CARD_UNITS, f"{path}: card")
    return _with_units(recording.card, CARD_UNITS)


def _with_units(values: Mapping[str, float], units: Mapping[str, str]) -> dict[str, Any]:
    return {key: _written(value, units[key]) for key, value in values.items()}


def _written(value: float, unit: str) -> str | float:
    return f"{float(value)!r} {unit}" if unit else float(value)


def _date(text: str) -> datetime.date | str:
    try:
        return datetime.date.fromisoformat(text)
    except ValueError:
        return text


def _beside(path: Path, recording: Path) -> str:
    """Return the name of a file relative to a recording's folder, copied there from elsewhere."""
    folder = recording.parent
    try:
        content = path.read_bytes()
    except OSError as problem:
        raise InputError(f"{path}: cannot be read: {problem.strerror}") from problem
    if path.resolve().is_relative_to(folder.resolve()):
        return path.resolve().relative_to(folder.resolve()).as_posix()
    target = folder / path.name
    if target == recording.with_suffix(".toml"):
        raise InputError(
            f"{recording}: its sidecar would take the place of {path.name}, which the recording "
            "refers to; choose another name"
        )
    if target.exists() and target.read_bytes() != content:
        raise InputError(
            f"{target}: is another file than {path}, which the recording refers to; "
            "write the recording into another folder"
        )
    write_whole(target, content)
    return path.name
