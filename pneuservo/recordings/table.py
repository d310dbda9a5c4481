"""The raw table of a data file: named columns of numbers, before units and meaning."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.naming import nearest

# A file of a few kilobytes can claim any number of samples; this many still fit into memory.
MAX_SAMPLES = 50_000_000


def require_few(path: Path, name: str, values: int) -> None:
    """Refuse what has too many values to be read.

    Parameters
    ----------
    path : Path
        The data file.
    name : str
        What is refused in it.
    values : int
        How many it has, as the file says.

    Raises
    ------
    InputError
        When there are more than 50 million.
    """
    if values > MAX_SAMPLES:
        raise InputError(
            f"{path}: {name} has {values} values, more than {MAX_SAMPLES}; cut it shorter"
        )


def sample_place(index: int) -> str:
    """Return where a sample is, in a file that has no lines."""
    return f"sample {index + 1}"


@dataclass(frozen=True)
class Table:
    """The raw table of a data file.

    Parameters
    ----------
    path : Path
        The data file.
    names : tuple of str
        All its columns.
    load : callable
        Reads columns: sequence of names to mapping of name to array.
    place : callable, optional
        Sample index to where it is in the file, for messages: ``"line 7"``.
    short_names : mapping of str to str, optional
        Other names of columns: the part after the group, where only one column has it.
    rates : mapping of str to float, optional
        Sample rate of a column, where the file knows it [Hz].
    warnings : tuple of str, optional
        What was worked around when the file was opened.
    """

    path: Path
    names: tuple[str, ...]
    load: Callable[[Sequence[str]], Mapping[str, Any]]
    place: Callable[[int], str] = sample_place
    short_names: Mapping[str, str] = field(default_factory=dict)
    rates: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __contains__(self, name: str) -> bool:
        """Return whether there is a column of this name."""
        return name in self.names or name in self.short_names

    def find(self, name: str, where: str) -> str:
        """Return the full name of a column.

        Parameters
        ----------
        name : str
            The name, or its part after the group where that is enough.
        where : str
            Who asks, for the message.

        Returns
        -------
        str
            The name as it is in `names`.

        Raises
        ------
        InputError
            When there is no such column; the message lists those that exist.
        """
        if name in self.names:
            return name
        if name in self.short_names:
            return self.short_names[name]
        listed = ", ".join(repr(column) for column in self.names[:40]) or "none"
        more = f" and {len(self.names) - 40} more" if len(self.names) > 40 else ""
        raise InputError(
            f"{where}: there is no column {name!r} in {self.path}; "
            f"its columns are: {listed}{more}{nearest(name, self.names)}"
        )

    def holds_time_stamps(self, name: str) -> bool:
        """Return whether a column holds dates and times, which `read` turns into seconds.

        Parameters
        ----------
        name : str
            Its full name.
        """
        return np.asarray(self.load([name])[name]).dtype.kind == "M"

    def read(self, names: Sequence[str]) -> dict[str, Array]:
        """Return columns as numbers.

        Parameters
        ----------
        names : sequence of str
            Full names, without repetition.

        Returns
        -------
        dict of str to (n,) array
            The columns; NaN where a cell is empty.

        Raises
        ------
        InputError
            When a column does not hold numbers, or the columns differ in length.
        """
        raw = self.load(names)
        columns = {name: as_numbers(raw[name], f"{self.path}, column {name!r}") for name in names}
        lengths = {name: len(values) for name, values in columns.items()}
        if len(set(lengths.values())) > 1:
            listed = ", ".join(f"{name!r} has {length}" for name, length in lengths.items())
            raise InputError(
                f"{self.path}: the columns differ in length: {listed}; "
                "all columns of a recording need the same number of samples"
            )
        return columns


def as_numbers(values: Any, where: str) -> Array:
    """Return a column as floating-point numbers.

    Parameters
    ----------
    values : array_like
        Numbers, or time stamps, which become seconds since the first.
    where : str
        File and column, for the message.

    Returns
    -------
    (n,) array
        The numbers.

    Raises
    ------
    InputError
        When the column holds anything else.
    """
    array = np.asarray(values)
    if array.dtype.kind == "M":
        stamps = array.astype("datetime64[ns]")
        valid = stamps[~np.isnat(stamps)]
        start = valid[0] if len(valid) else stamps[:1]
        return (stamps - start) / np.timedelta64(1, "s")
    if array.dtype.kind not in "fiub":
        raise InputError(f"{where} holds {array.dtype}, not numbers; name a column of real numbers")
    return array.astype(np.float64).ravel()


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Return the last parts of grouped column names, where only one column has that part.

    Parameters
    ----------
    names : sequence of str
        Names such as ``"group/name"``.

    Returns
    -------
    dict of str to str
        Last part to full name.

    Examples
    --------
    >>> short_names(["a/time", "b/time", "a/force"])
    {'force': 'a/force'}
    """
    last = [name.rpartition("/")[2] for name in names]
    return {
        part: name
        for part, name in zip(last, names, strict=True)
        if last.count(part) == 1 and part not in names
    }


def matrix_columns(name: str, shape: tuple[int, ...]) -> dict[str, tuple[int, int] | None]:
    """Return the columns that an array of numbers holds.

    Parameters
    ----------
    name : str
        Name of the array.
    shape : tuple of int
        Its shape. The longer axis of a matrix is the time.

    Returns
    -------
    dict of str to (axis, index) or None
        Column name to the axis to index and where; None for a vector. A matrix of several
        columns gives ``name[0]``, ``name[1]`` and so on; anything else gives nothing.

    Examples
    --------
    >>> matrix_columns("x", (100, 1))
    {'x': None}
    >>> matrix_columns("x", (2, 100))
    {'x[0]': (0, 0), 'x[1]': (0, 1)}
    """
    sizes = [size for size in shape if size != 1]
    if len(sizes) == 1:
        return {name: None}
    if len(shape) != 2 or 0 in shape:
        return {}
    axis = 1 if shape[0] >= shape[1] else 0
    return {f"{name}[{index}]": (axis, index) for index in range(shape[axis])}


def take(array: NDArray[Any], place: tuple[int, int] | None) -> NDArray[Any]:
    """Return one column of an array, as `matrix_columns` placed it."""
    return array.ravel() if place is None else np.take(array, place[1], axis=place[0])


def rename_matrix(
    columns: Mapping[str, Any], names: Sequence[str], path: Path
) -> tuple[dict[str, Any], dict[str, str]]:
    """Return columns under the names that the sidecar gives, and their short names.

    Parameters
    ----------
    columns : mapping
        Column name to where it is, in the order of the file.
    names : sequence of str
        The sidecar's names; empty to keep the file's own.
    path : Path
        The data file, for the message.

    Returns
    -------
    columns : dict
        The same under the names to use.
    short_names : dict of str to str
        As `short_names`.

    Raises
    ------
    InputError
        When the numbers of names and columns differ.
    """
    if not names:
        return dict(columns), short_names(list(columns))
    if len(names) != len(columns):
        raise InputError(
            f"{path}: [table] names has {len(names)} names for {len(columns)} columns "
            f"({', '.join(columns)}); give one name for each"
        )
    return dict(zip(names, columns.values(), strict=True)), {}
