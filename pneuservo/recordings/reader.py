"""Reading a recording: the raw table and its sidecar joined into channels in SI."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.naming import nearest
from pneuservo.recordings.channels import CHANNELS
from pneuservo.recordings.conditions import read_card, read_conditions, read_controller, rig_of
from pneuservo.recordings.csv_table import open_csv
from pneuservo.recordings.hdf5_table import open_hdf5
from pneuservo.recordings.matlab_table import open_matlab
from pneuservo.recordings.parquet_table import open_parquet
from pneuservo.recordings.recording import Recording
from pneuservo.recordings.sample_checks import check_samples, fill_short_gaps
from pneuservo.recordings.sidecar import (
    ChannelSource,
    Sidecar,
    TableShape,
    TimeSource,
    read_sidecar,
)
from pneuservo.recordings.sources import (
    TIME,
    channel_sources,
    noise_in_si,
    sample_rate,
    samples_in_si,
    time_source,
)
from pneuservo.recordings.table import Table
from pneuservo.recordings.tdms_table import open_tdms
from pneuservo.recordings.time_checks import check_time, require_enough
from pneuservo.recordings.units import conversion
from pneuservo.rigs import load_rig

_OPENERS: dict[str, Callable[[Path, TableShape], Table]] = {
    ".csv": open_csv,
    ".tsv": open_csv,
    ".txt": open_csv,
    ".parquet": open_parquet,
    ".h5": open_hdf5,
    ".hdf5": open_hdf5,
    ".mat": open_matlab,
    ".tdms": open_tdms,
}
SUFFIXES = tuple(_OPENERS)
"""What the name of a recording's data file ends in."""


def read_recording(path: str | Path, rig: str | Path | None = None) -> Recording:
    r"""Read a recording and its sidecar.

    Parameters
    ----------
    path : str or Path
        The data file: CSV, Parquet, HDF5, MATLAB or TDMS, by its suffix. The sidecar is the
        file of the same name ending in ``.toml``.
    rig : str or Path, optional
        A built-in rig or a rig file, instead of the one that the sidecar names.

    Returns
    -------
    Recording
        Time [s] and channels in SI, pressures absolute; what was worked around is in its
        `warnings`.

    Raises
    ------
    InputError
        When anything about the file or its sidecar cannot be used. The message names the
        file, the line or column, what was found and what would be accepted.

    Notes
    -----
    Without a table ``[channels]`` the columns with canonical names are read, in SI. A time
    column called ``time`` in s counts from the start of the recording already; any other is
    shifted to begin at 0. Missing samples are interpolated over at most three in a row, and
    stay NaN beyond that.

    Examples
    --------
    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "rest.csv"
    >>> _ = path.write_text("time,displacement\n" + "".join(f"{i},0.015\n" for i in range(20)))
    >>> recording = read_recording(path)
    >>> recording.rig, len(recording), float(recording["displacement"][0])
    ('single-axis', 20, 0.015)
    """
    path = Path(path)
    opener = _opener(path)
    _require_file(path)
    sidecar = read_sidecar(path)
    loaded_rig = rig_of(sidecar) if rig is None else load_rig(rig)
    conditions, condition_warnings = read_conditions(sidecar, loaded_rig)
    controller = read_controller(sidecar)
    card, card_warnings = read_card(sidecar)
    table = opener(path, sidecar.table)
    sources, source_warnings = channel_sources(table, sidecar)
    clock = time_source(table, sidecar)
    raw = _read_columns(table, sidecar, clock, sources)
    time, keep, time_warnings = _time(table, sidecar, clock, raw)
    channels: dict[str, Array] = {}
    sample_warnings: list[str] = []
    for name, source in sources.items():
        column = table.find(source.column, str(sidecar.path))
        usable = _usable(table, column, raw[column], keep)
        values = samples_in_si(source, name, usable, sidecar, loaded_rig)
        sample_warnings += check_samples(values, CHANNELS[name])
        channels[name], filled = fill_short_gaps(time, values, name)
        sample_warnings += filled
    return Recording(
        name=path.stem,
        time=time,
        channels=channels,
        rig=loaded_rig.name,
        conditions=conditions,
        noise_rms=noise_in_si(sources, sidecar),
        controller=controller,
        card=card,
        title=sidecar.title,
        taken=sidecar.taken,
        notes=sidecar.notes,
        warnings=(
            *condition_warnings,
            *card_warnings,
            *table.warnings,
            *source_warnings,
            *time_warnings,
            *sample_warnings,
        ),
        source=path,
    )


def _opener(path: Path) -> Callable[[Path, TableShape], Table]:
    suffix = path.suffix.lower()
    if suffix not in _OPENERS:
        found = f"ends in {path.suffix!r}" if path.suffix else "has no suffix"
        raise InputError(
            f"{path}: {found}; a recording ends in one of: {', '.join(_OPENERS)}"
            + nearest(suffix, _OPENERS)
        )
    return _OPENERS[suffix]


def _require_file(path: Path) -> None:
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name the data file in it")
    if not path.exists():
        folder = path.parent
        others = sorted(p.name for p in folder.iterdir()) if folder.is_dir() else []
        raise InputError(f"{path}: there is no such file{nearest(path.name, others)}")
    if not path.is_file():
        raise InputError(f"{path}: is not a regular file; copy the recording into one")
    if path.stat().st_size == 0:
        raise InputError(f"{path}: the file is empty; get a whole copy")


def _read_columns(
    table: Table,
    sidecar: Sidecar,
    clock: TimeSource,
    sources: Mapping[str, ChannelSource],
) -> dict[str, Array]:
    wanted: list[str] = []
    if clock.column is not None:
        wanted.append(table.find(clock.column, f"{sidecar.path}: [time]"))
    for name, source in sources.items():
        wanted.append(table.find(source.column, f"{sidecar.path}: [channels] {name}"))
    return table.read(list(dict.fromkeys(wanted)))


def _time(
    table: Table,
    sidecar: Sidecar,
    source: TimeSource,
    raw: Mapping[str, Array],
) -> tuple[Array, Mask, list[str]]:
    """Return the time of the usable samples, which those are, and warnings."""
    if source.column is None:
        count = len(next(iter(raw.values())))
        require_enough(count, str(table.path))
        rate, warnings = sample_rate(table, sidecar, source, list(raw))
        return np.arange(count) / rate, np.ones(count, dtype=bool), warnings
    column = table.find(source.column, f"{sidecar.path}: [time]")
    scale = conversion(source.unit or "", "s", f"{sidecar.path}: [time] unit").scale
    time = raw[column] * scale
    keep, warnings = check_time(time, str(table.path), column, table.place)
    kept = time[keep]
    from_the_start = (source.column, source.unit) == (TIME, "s")
    return (kept if from_the_start else kept - kept[0]), keep, warnings


def _usable(table: Table, column: str, values: Array, keep: Mask) -> Array:
    """Return the samples that have a time; refuse infinite ones, and a column without any."""
    infinite = np.flatnonzero(np.isinf(values))
    if len(infinite):
        raise InputError(
            f"{table.path}, {table.place(int(infinite[0]))}, column {column!r}: the value is "
            "infinite; leave a sample that is not known empty"
        )
    usable = values[keep]
    if np.isnan(usable).all():
        raise InputError(
            f"{table.path}, column {column!r}: holds no number at all; "
            "name another column, or leave the channel out"
        )
    return usable
