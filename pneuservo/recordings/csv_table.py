"""Tables in text files: comma, semicolon or tab, decimal point or comma, header or none."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.recordings.cells import column_numbers
from pneuservo.recordings.sidecar import TableShape
from pneuservo.recordings.table import Table

# In this order where several would do: a comma may be a decimal mark, a tab cannot.
_DELIMITERS = ("\t", ";", ",")
_ENOUGH_LINES, _FEWER_DECIMALS = 20, 2
"""Of so many lines the shortest number tells how many decimals there are, but for so many."""
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")


@dataclass(frozen=True)
class _Rows:
    """The lines with samples, and their numbers in the file."""

    path: Path
    lines: list[str]
    numbers: list[int]
    delimiter: str

    def place(self, index: int) -> str:
        return f"line {self.numbers[index]}"


def open_csv(path: Path, shape: TableShape) -> Table:
    """Return the table of a text file.

    Parameters
    ----------
    path : Path
        The file, in UTF-8.
    shape : TableShape
        Whether it has a header, and the names if not.

    Returns
    -------
    Table
        Its columns.

    Raises
    ------
    InputError
        When it is not UTF-8 text, has no or repeated names, or is cut off.
    """
    text = _decode(path)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers = [number for number, line in enumerate(lines, 1) if line.strip(" ")]
    while numbers and not lines[numbers[-1] - 1].strip(" \t;,"):
        numbers.pop()  # spreadsheets leave rows of bare delimiters at the end
    if not numbers:
        raise InputError(f"{path}: the file holds nothing but blank lines")
    delimiter = _delimiter([lines[number - 1] for number in numbers[:20]])
    if shape.header:
        names = _header(path, numbers[0], lines[numbers[0] - 1], delimiter)
        numbers = numbers[1:]
    else:
        names = list(shape.names)
    blank = numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0
    if blank and len(names) == 1:
        # In a single column a blank line is the only way to leave a sample out.
        numbers, blank = list(range(numbers[0], numbers[-1] + 1)), 0
    rows = _Rows(path, [lines[number - 1] for number in numbers], numbers, delimiter)
    names = _even(names, rows, shape.header)
    if not text.endswith(("\n", "\r")):
        _require_whole_last_line(rows)
    warnings = (f"blank lines between the samples were skipped: {blank}",) if blank else ()

    def load(wanted: Sequence[str]) -> dict[str, Array]:
        return _load(rows, names, wanted)

    return Table(path, tuple(name for name in names if name), load, rows.place, warnings=warnings)


def _decode(path: Path) -> str:
    data = path.read_bytes()
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise InputError(f"{path}, line 1: the text is UTF-16; save the file as UTF-8")
    data = data.removeprefix(b"\xef\xbb\xbf")
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise InputError(f"{path}, line {line}: holds a zero byte; this is not a text file")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        what = "the header" if line == 1 else "the text"
        raise InputError(
            f"{path}, line {line}: {what} is not UTF-8 (byte 0x{data[problem.start]:02x}); "
            "save the file as UTF-8"
        ) from problem


def _split(line: str, delimiter: str) -> list[str]:
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        row = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    except csv.Error:
        # A name longer than csv takes is none, and its quotes are as good as letters.
        return [cell.strip() for cell in line.split(delimiter)]
    return [cell.strip() for cell in row]


def _delimiter(sample: list[str]) -> str:
    def agreement(delimiter: str) -> int:
        counts = [len(_split(line, delimiter)) for line in sample]
        # The second line is the first with samples, or as good as any without a header.
        usual = counts[min(1, len(counts) - 1)]
        return counts.count(usual) if usual > 1 else 0

    return max(_DELIMITERS, key=agreement)  # the first of several equals


def _header(path: Path, number: int, line: str, delimiter: str) -> list[str]:
    where = f"{path}, line {number}"
    if line.count('"') % 2:
        raise InputError(f"{where}: a quotation mark is not closed; keep each name on one line")
    names = _split(line, delimiter)
    if all(_NUMBER.fullmatch(name) for name in names if name):
        raise InputError(
            f"{where}: numbers where the column names should be; for a file without names write "
            'a sidecar with [table] header = false and names = ["...", ...]'
        )
    for name in names:
        if name and names.count(name) > 1:
            raise InputError(
                f"{where}: the column name {name!r} appears more than once; make the names differ"
            )
    return names


def _even(names: list[str], rows: _Rows, header: bool) -> list[str]:
    """Return as many names as every row has fields, or say which row is uneven."""
    delimiter, lines = rows.delimiter, rows.lines
    if any('"' in line for line in lines):
        counts = [len(_split(line, delimiter)) for line in lines]
    else:
        counts = [line.count(delimiter) + 1 for line in lines]
    width = len(names)
    extra = set(counts[:-1] or counts)
    if extra == {width + 1} and all(line.rstrip(" ").endswith(delimiter) for line in lines[:-1]):
        names, width = [*names, ""], width + 1  # every line ends in a delimiter
    elif extra == {width - 1} and not names[-1]:
        names, width = names[:-1], width - 1  # only the header does
    for index, count in enumerate(counts):
        if count == width:
            continue
        where = f"{rows.path}, {rows.place(index)}"
        if index == len(counts) - 1 and count < width and index > 0:
            raise InputError(
                f"{where}: the last line has {count} of {width} fields: the file is cut off; "
                "get a whole copy, or delete that line"
            )
        told = "the header has" if header else "[table] names has"
        hint = (
            "; if the comma is the decimal mark, separate the columns by semicolons or tabs"
            if delimiter == "," and count > width
            else ""
        )
        fields = "1 field" if count == 1 else f"{count} fields"
        raise InputError(f"{where}: has {fields} where {told} {width}{hint}")
    return names


def _decimals(cell: str) -> int:
    """Return how many digits a number has behind its decimal mark."""
    parts = re.split("[.,]", re.split("[eE]", cell)[0])
    return len(parts[1]) if len(parts) > 1 else 0


def _require_whole_last_line(rows: _Rows) -> None:
    """Refuse a last line, without line end, whose last number was evidently cut."""
    if len(rows.lines) < 3:
        return
    cells = [_split(line, rows.delimiter)[-1] for line in rows.lines[-200:]]
    last, others = cells[-1], cells[:-1]
    if not all(_NUMBER.fullmatch(cell) for cell in others):
        return
    decimals = [_decimals(cell) for cell in others]
    whole = _NUMBER.fullmatch(last) and not last.endswith((".", ","))
    if min(decimals) == max(decimals):
        whole = whole and _decimals(last) >= min(decimals)
    elif len(others) >= _ENOUGH_LINES:
        # Zeros at the end are not written, but never many of them.
        whole = whole and _decimals(last) >= min(decimals) - _FEWER_DECIMALS
    if not whole:
        raise InputError(
            f"{rows.path}, {rows.place(len(rows.lines) - 1)}: the last number, {last!r}, is "
            "incomplete: the file is cut off; get a whole copy, or delete that line"
        )


def _load(rows: _Rows, names: list[str], wanted: Sequence[str]) -> dict[str, Array]:
    import pyarrow
    from pyarrow import csv as arrow_csv

    if not rows.lines:
        return {name: np.empty(0) for name in wanted}
    keys = [str(index) for index in range(len(names))]
    key_of = {name: keys[names.index(name)] for name in wanted}
    try:
        table = arrow_csv.read_csv(
            pyarrow.BufferReader("\n".join(rows.lines).encode()),
            arrow_csv.ReadOptions(column_names=keys),
            arrow_csv.ParseOptions(delimiter=rows.delimiter, ignore_empty_lines=False),
            arrow_csv.ConvertOptions(
                column_types=dict.fromkeys(keys, pyarrow.string()),
                include_columns=list(key_of.values()),
            ),
        )
    except pyarrow.ArrowInvalid as problem:
        raise InputError(
            f"{rows.path}: cannot be read as a table: {problem}; look for a stray quotation mark"
        ) from problem
    cells = {name: table.column(key) for name, key in key_of.items()}
    return column_numbers(cells, rows.path, rows.place, rows.delimiter)
