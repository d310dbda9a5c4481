"""Tables in Parquet files."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pneuservo.errors import InputError
from pneuservo.recordings.sidecar import TableShape
from pneuservo.recordings.table import Table, rename_matrix, require_few


def open_parquet(path: Path, shape: TableShape) -> Table:
    """Return the table of a Parquet file.

    Parameters
    ----------
    path : Path
        The file.
    shape : TableShape
        Names to use instead of the file's, if any.

    Returns
    -------
    Table
        Its columns.

    Raises
    ------
    InputError
        When it is cut off or not a Parquet file, or repeats a column name.
    """
    import pyarrow
    from pyarrow import parquet

    try:
        with path.open("rb") as stream:
            file = parquet.ParquetFile(stream)
            require_few(path, "the table", file.metadata.num_rows * file.metadata.num_columns)
            table = file.read()
            own = list(table.column_names)
    except (pyarrow.ArrowException, OSError, ValueError) as problem:
        raise InputError(
            f"{path}: is cut off or not a Parquet file ({problem}); get a whole copy"
        ) from problem
    for name in own:
        if own.count(name) > 1:
            raise InputError(f"{path}: the column name {name!r} appears more than once")
    columns, _ = rename_matrix({name: name for name in own}, shape.names, path)

    def load(names: Sequence[str]) -> dict[str, Any]:
        return {name: _array(table.column(columns[name])) for name in names}

    return Table(path, tuple(columns), load)


def _array(column: Any) -> Any:
    import pyarrow

    if pyarrow.types.is_dictionary(column.type):
        # As it is, a missing sample would be read as another value.
        column = column.cast(column.type.value_type)
    kind = column.type
    if pyarrow.types.is_decimal(kind) or pyarrow.types.is_integer(kind):
        column = column.cast(pyarrow.float64(), safe=False)
    return column.to_numpy()
