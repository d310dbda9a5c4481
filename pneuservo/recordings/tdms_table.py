"""Tables in National Instruments' TDMS files."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

from pneuservo.errors import InputError
from pneuservo.recordings.sidecar import TableShape
from pneuservo.recordings.table import Table, rename_matrix, require_few

_BIG_ENDIAN = 1 << 6  # this bit of a segment's contents
_LEAD_IN = 28  # bytes: tag, contents, version, length of the segment, length of its description


def open_tdms(path: Path, shape: TableShape) -> Table:
    """Return the table of a TDMS file.

    Parameters
    ----------
    path : Path
        The file.
    shape : TableShape
        Names to use instead of the file's, if any.

    Returns
    -------
    Table
        Its channels, named ``group/channel``; a waveform's sample rate from ``wf_increment``.

    Raises
    ------
    InputError
        When it is cut off or not a TDMS file.
    """
    _require_whole(path)
    found: dict[str, tuple[str, str]] = {}
    rates: dict[tuple[str, str], float] = {}
    with _opened(path) as file:
        for group in file.groups():
            for channel in group.channels():
                key = (group.name, channel.name)
                found["/".join(key)] = key
                require_few(path, repr("/".join(key)), len(channel))
                step = channel.properties.get("wf_increment")
                if isinstance(step, float) and math.isfinite(step) and step > 0.0:
                    rates[key] = 1.0 / step
    columns, short = rename_matrix(found, shape.names, path)

    def load(names: Sequence[str]) -> dict[str, Any]:
        with _opened(path) as file:
            return {name: file[columns[name][0]][columns[name][1]][:] for name in names}

    known = {name: rates[key] for name, key in columns.items() if key in rates}
    return Table(path, tuple(columns), load, short_names=short, rates=known)


def _require_whole(path: Path) -> None:
    """Refuse a file whose segments do not end where the file ends; npTDMS takes what is left."""
    size, position = path.stat().st_size, 0
    with path.open("rb") as stream:
        while position < size:
            stream.seek(position)
            lead_in = stream.read(_LEAD_IN)
            contents = int.from_bytes(lead_in[4:8], "little")
            order: Literal["big", "little"] = "big" if contents & _BIG_ENDIAN else "little"
            length = int.from_bytes(lead_in[12:20], order)
            if lead_in[:4] != b"TDSm" or position + _LEAD_IN + length > size:
                raise InputError(
                    f"{path}: is cut off or not a TDMS file (its segment at byte {position} is "
                    "incomplete); get a whole copy"
                )
            position += _LEAD_IN + length


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    from nptdms import TdmsFile

    try:
        # As a stream, so that an index file beside it cannot stand in for what is in it.
        with path.open("rb") as stream, TdmsFile.open(stream) as file:
            yield file
    except InputError:
        raise
    except Exception as problem:
        # npTDMS reports damage by whatever exception the part it was reading raises.
        raise InputError(
            f"{path}: is cut off or not a TDMS file ({problem}); get a whole copy"
        ) from problem
