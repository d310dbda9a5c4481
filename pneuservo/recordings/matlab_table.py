"""Tables in MATLAB files: v5 by scipy, v7.3 as the HDF5 file that it is. Objects are refused."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pneuservo.errors import InputError
from pneuservo.recordings.hdf5_table import open_hdf5
from pneuservo.recordings.sidecar import TableShape
from pneuservo.recordings.table import Table, matrix_columns, rename_matrix, require_few, take

_V73 = b"MATLAB 7.3"
_DATA_CLASSES = (
    *("double", "single", "logical", "char", "struct", "sparse"),
    *("int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"),
)
_DEEPEST_STRUCT = 16


def open_matlab(path: Path, shape: TableShape) -> Table:
    """Return the table of a MATLAB file.

    Parameters
    ----------
    path : Path
        The file, v5 or v7.3.
    shape : TableShape
        Names for the columns of its only matrix, if any.

    Returns
    -------
    Table
        One column for each vector of numbers; ``struct/field`` for the fields of a struct;
        ``name[0]``, ``name[1]``... for the columns of a matrix.

    Raises
    ------
    InputError
        When it is cut off or not a MATLAB file, or holds objects, function handles or cells.
    """
    import h5py

    with path.open("rb") as stream:
        start = stream.read(len(_V73))
    if start == _V73 or h5py.is_hdf5(path):
        return open_hdf5(path, shape, lambda name, member: _refuse_v73(path, name, member))
    return _open_v5(path, shape)


def _refusal(path: Path, name: str, what: str) -> InputError:
    return InputError(
        f"{path}: {name!r} is {what}; a recording holds only arrays of numbers, "
        "or structs of them: save those alone"
    )


def _refuse_v73(path: Path, name: str, member: Any) -> None:
    import h5py

    attributes = member.attrs
    if "MATLAB_object_decode" in attributes:
        raise _refusal(path, name, "an object")
    if "MATLAB_class" in attributes:
        kind = attributes["MATLAB_class"]
        kind = kind.decode("ascii", "replace") if isinstance(kind, bytes) else str(kind)
        if kind not in _DATA_CLASSES:
            raise _refusal(path, name, f"of class {kind!r}")
    if isinstance(member, h5py.Dataset) and h5py.check_ref_dtype(member.dtype) is not None:
        raise _refusal(path, name, "an array of references, as cells and objects are stored")


def _open_v5(path: Path, shape: TableShape) -> Table:
    from scipy.io import loadmat, whosmat

    try:
        with path.open("rb") as stream:
            listed = whosmat(stream)
        for name, dimensions, kind in listed:
            if kind not in _DATA_CLASSES:
                raise _refusal(path, name, f"of class {kind!r}")
            require_few(path, repr(name), math.prod(map(int, dimensions)))
        with path.open("rb") as stream:
            variables = loadmat(stream)
    except InputError:
        raise
    except Exception as problem:
        # scipy reports damage by whatever exception the part it was reading raises.
        raise InputError(
            f"{path}: is cut off or not a MATLAB file ({problem}); get a whole copy"
        ) from problem
    arrays: dict[str, Any] = {}
    for name, value in variables.items():
        if not name.startswith("__"):
            _collect(path, name, value, arrays)
    found = {
        column: (name, place)
        for name, array in arrays.items()
        for column, place in matrix_columns(name, array.shape).items()
    }
    columns, short = rename_matrix(found, shape.names, path)

    def load(names: Sequence[str]) -> dict[str, Any]:
        return {name: take(arrays[columns[name][0]], columns[name][1]) for name in names}

    return Table(path, tuple(columns), load, short_names=short)


def _collect(path: Path, name: str, value: Any, arrays: dict[str, Any]) -> None:
    """Gather the arrays of numbers in a variable; refuse what is neither number nor text."""
    from scipy.io.matlab import MatlabFunction, MatlabObject, MatlabOpaque

    if isinstance(value, MatlabFunction | MatlabObject | MatlabOpaque):
        raise _refusal(path, name, "an object or a function handle")
    if name.count("/") > _DEEPEST_STRUCT:
        raise InputError(f"{path}: structs are nested deeper than {_DEEPEST_STRUCT}: {name!r}")
    if not isinstance(value, np.ndarray):
        return  # a sparse matrix
    if value.dtype.names:
        for field in value.dtype.names:
            for element in value[field].ravel():
                _collect(path, f"{name}/{field}", element, {} if value.size > 1 else arrays)
    elif value.dtype.kind == "O":
        raise _refusal(path, name, "a cell array")
    elif value.dtype.kind in "fiub" and value.size > 1:
        arrays[name] = value
