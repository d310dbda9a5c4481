"""Text cells turned into numbers, without mistaking a thousands mark for a decimal mark."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from pneuservo.arrays import Array
from pneuservo.errors import InputError

_MISSING = ("", "nan", "-nan", "na", "n/a", "#n/a", "null", "none", "1.#qnan", "-1.#ind")
_NUMBER = r"^[+-]?((\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|(?i:inf|infinity))$"
_WHOLE = r"^[+-]?\d+$"
_ADVICE = "write numbers like 1234.5, without thousands marks"


def column_numbers(
    cells: Mapping[str, Any], path: Path, place: Callable[[int], str], delimiter: str
) -> dict[str, Array]:
    """Return columns of text as numbers.

    Parameters
    ----------
    cells : mapping of str to pyarrow.ChunkedArray
        Column name to its text cells.
    path : Path
        The file, for messages.
    place : callable
        Row index to where the row is, for messages.
    delimiter : str
        What separates the columns.

    Returns
    -------
    dict of str to (n,) array
        The numbers; NaN where a cell is empty or says so.

    Raises
    ------
    InputError
        When a cell is not a number, or it is not clear what a comma or a point in it means.

    Notes
    -----
    A comma is taken for the decimal mark. It is refused as a possible thousands mark when points
    occur as well or a cell has two of them. Where no cell at all shows it to be decimal, it is
    also refused when the columns are separated by commas, or when a column would be whole numbers
    that have a comma only from 1000 on. The last holds for points as well, unless the columns are
    separated by commas.
    """
    present = {name: _without_missing(text) for name, text in cells.items()}
    comma, point = _first_with(",", present), _first_with(".", present)
    if comma and point:
        told = " and ".join(
            f"{place(index)}, column {name!r} has {present[name][index].as_py()!r}"
            for name, index in dict.fromkeys((comma, point))
        )
        raise InputError(
            f"{path}: {told}: both a comma and a point are used, and one of them may be a "
            f"thousands mark; {_ADVICE}"
        )
    mark = "," if comma else "."
    decimal = any(_clearly_decimal(mark, text) for text in present.values())
    for name, text in present.items():
        index = _thousands(mark, text, delimiter, decimal)
        if index is not None:
            raise InputError(
                f"{path}, {place(index)}, column {name!r}: {text[index].as_py()!r} may have a "
                f"thousands mark; {_ADVICE}"
            )
    return {name: _numbers(text, path, place, name) for name, text in present.items()}


def _without_missing(text: Any) -> Any:
    import pyarrow
    import pyarrow.compute as compute

    trimmed = compute.utf8_trim_whitespace(text)
    missing = compute.is_in(compute.utf8_lower(trimmed), pyarrow.array(_MISSING))
    return compute.if_else(missing, pyarrow.scalar(None, pyarrow.string()), trimmed)


def _first(mask: Any) -> int | None:
    """Return the index of the first true value."""
    index = mask.index(True).as_py()
    return None if index < 0 else index


def _first_with(mark: str, columns: Mapping[str, Any]) -> tuple[str, int] | None:
    import pyarrow.compute as compute

    for name, text in columns.items():
        index = _first(compute.match_substring(text, mark))
        if index is not None:
            return name, index
    return None


def _grouped(mark: str, text: Any) -> Any:
    """Return where a cell could be a whole number with one thousands mark."""
    import pyarrow.compute as compute

    return compute.match_substring_regex(text, rf"^[+-]?[1-9]\d{{0,2}}[{mark}]\d{{3}}$")


def _clearly_decimal(mark: str, text: Any) -> bool:
    """Return whether the mark stands in a number where no thousands mark could."""
    import pyarrow.compute as compute

    numeric = compute.match_substring_regex(text, rf"^[+-]?\d*[{mark}]\d*([eE][+-]?\d+)?$")
    return _first(compute.and_not(numeric, _grouped(mark, text))) is not None


def _thousands(mark: str, text: Any, delimiter: str, decimal: bool) -> int | None:
    """Return the first cell in which the mark may stand for thousands."""
    import pyarrow.compute as compute

    twice = compute.match_substring_regex(text, rf"^[+-]?\d{{1,3}}([{mark}]\d{{3}}){{2,}}")
    if _first(twice) is not None:
        return _first(twice)
    grouped = _grouped(mark, text)
    if decimal or _first(grouped) is None or (mark == "." and delimiter == ","):
        return None
    bare = text.filter(compute.invert(grouped))
    whole = compute.all(compute.match_substring_regex(bare, _WHOLE)).as_py()
    return _first(grouped) if delimiter == "," or (len(bare) > 0 and whole) else None


def _numbers(text: Any, path: Path, place: Callable[[int], str], name: str) -> Array:
    import pyarrow
    import pyarrow.compute as compute

    pointed = compute.replace_substring(text, ",", ".")
    index = _first(compute.invert(compute.match_substring_regex(pointed, _NUMBER)))
    if index is not None:
        raise InputError(
            f"{path}, {place(index)}, column {name!r}: {text[index].as_py()!r} is not a number; "
            f"{_ADVICE}, and leave a missing sample empty"
        )
    unsigned = compute.replace_substring_regex(pointed, r"^\+", "")
    return unsigned.cast(pyarrow.float64()).to_numpy()
