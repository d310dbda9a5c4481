"""Tables in HDF5 files: datasets at the root or in groups; MATLAB's v7.3 files are HDF5 too."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pneuservo.errors import InputError
from pneuservo.recordings.sidecar import TableShape
from pneuservo.recordings.table import Table, matrix_columns, rename_matrix, require_few, take

_DEEPEST_GROUP = 16


@dataclass(frozen=True)
class _Column:
    """Where a column is: a dataset, and a field of it or a place in it."""

    dataset: str
    field: str | None = None
    place: tuple[int, int] | None = None


def open_hdf5(
    path: Path, shape: TableShape, refuse: Callable[[str, Any], None] | None = None
) -> Table:
    """Return the table of an HDF5 file.

    Parameters
    ----------
    path : Path
        The file.
    shape : TableShape
        Names for the columns of its only matrix, if any.
    refuse : callable, optional
        Called with name and object of everything in the file; raises `InputError` when the
        file cannot be accepted.

    Returns
    -------
    Table
        One column for each vector of numbers, named ``group/name``; ``name/field`` for the
        fields of a compound dataset; ``name[0]``, ``name[1]``... for the columns of a matrix.

    Raises
    ------
    InputError
        When it is cut off or not an HDF5 file, or takes its data from other files.
    """
    found: dict[str, _Column] = {}
    with _opened(path) as file:
        _collect(file, "", found, path, refuse, set())
    columns, short = rename_matrix(found, shape.names, path)

    def load(names: Sequence[str]) -> dict[str, Any]:
        with _opened(path) as file:
            return {name: _array(file, columns[name]) for name in names}

    return Table(path, tuple(columns), load, short_names=short)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    import h5py

    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, RuntimeError, LookupError, ValueError, TypeError, MemoryError) as problem:
        # h5py reports damage in any of these, depending on what it was reading.
        raise InputError(
            f"{path}: is cut off or not an HDF5 file ({problem}); get a whole copy"
        ) from problem


def _collect(
    group: Any,
    prefix: str,
    found: dict[str, _Column],
    path: Path,
    refuse: Callable[[str, Any], None] | None,
    visited: set[int],
) -> None:
    import h5py

    # A group that hangs in several places is visited in one: ten can hang in each other.
    address = h5py.h5o.get_info(group.id).addr
    if address in visited:
        return
    visited.add(address)
    if prefix.count("/") > _DEEPEST_GROUP:
        raise InputError(f"{path}: groups are nested deeper than {_DEEPEST_GROUP}: {prefix!r}")
    for key in group:
        name = f"{prefix}{key}"
        link = group.get(key, getlink=True)
        if isinstance(link, h5py.ExternalLink):
            raise InputError(
                f"{path}: {name!r} is a link to another file, {link.filename!r}; "
                "store the samples in the file itself"
            )
        if isinstance(link, h5py.SoftLink):
            continue  # what it points to is visited under its own name
        member = group[key]
        if refuse is not None:
            refuse(name, member)
        if isinstance(member, h5py.Group):
            _collect(member, f"{name}/", found, path, refuse, visited)
        elif isinstance(member, h5py.Dataset):
            found.update(_columns(name, member, path))


def _columns(name: str, dataset: Any, path: Path) -> dict[str, _Column]:
    if dataset.is_virtual or dataset.external:
        raise InputError(
            f"{path}: {name!r} takes its samples from another file; store them in the file itself"
        )
    if dataset.size is None or dataset.size < 2:
        return {}  # empty, or a single value beside the samples
    # In numbers, however long the strings beside them.
    require_few(path, repr(name), max(dataset.size, dataset.size * dataset.dtype.itemsize // 8))
    if dataset.dtype.names:
        return {
            f"{name}/{field}": _Column(name, field=field)
            for field in dataset.dtype.names
            if dataset.ndim == 1 and dataset.dtype[field].kind in "fiub"
        }
    if dataset.dtype.kind not in "fiub":
        return {}
    places = matrix_columns(name, dataset.shape)
    return {column: _Column(name, place=place) for column, place in places.items()}


def _array(file: Any, column: _Column) -> Any:
    values = file[column.dataset][()]
    return values[column.field] if column.field else take(values, column.place)
