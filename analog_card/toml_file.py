"""Reading TOML that somebody else has written."""

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from analog_card.errors import InputError

_LEAST = -(2**63)
"""The least integer of TOML."""


def read_toml(path: str | Path, what: str, error: type[Exception] = InputError) -> dict[str, Any]:
    """Return what a TOML file holds.

    Parameters
    ----------
    path : str or Path
        The file, in UTF-8.
    what : str
        What is needed, with its article, for the message when the file cannot be read.
    error : type of exception, optional
        What is raised.

    Returns
    -------
    dict
        As it is written, unchecked.

    Raises
    ------
    InputError
        Or what is asked for: when the file cannot be read, or is not UTF-8 or not valid TOML.
    """
    try:
        data = tomllib.loads(Path(path).read_text(encoding="utf-8-sig"))
    except OSError as problem:
        raise error(f"{path}: cannot be read: {problem.strerror}; {what} is needed") from problem
    except UnicodeDecodeError as problem:
        raise error(f"{path}: is not UTF-8 text; save it as UTF-8") from problem
    # Very deep nesting and very long integers make the parser give up in its own ways.
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as problem:
        raise error(f"{path}: is not valid TOML: {problem}") from problem
    if _holds_longer_integer(data):
        raise error(f"{path}: is not valid TOML: an integer has more than 64 bits")
    return data


def _holds_longer_integer(data: Any) -> bool:
    """Return whether there is an integer beyond what TOML allows, which nothing could print."""
    left = [data]
    while left:
        value = left.pop()
        if isinstance(value, dict):
            left.extend(value.values())
        elif isinstance(value, list):
            left.extend(value)
        elif isinstance(value, int) and not _LEAST <= value <= -_LEAST - 1:
            return True
    return False


def table_in(
    data: Mapping[str, Any], key: str, where: object, error: type[Exception] = InputError
) -> dict[str, Any]:
    """Return a table of what was read, empty where there is none.

    Parameters
    ----------
    data : mapping
        What was read.
    key : str
        Name of the table.
    where : object
        Where it stands, for the message.
    error : type of exception, optional
        What is raised.

    Raises
    ------
    InputError
        Or what is asked for: when there is something else by that name.

    Examples
    --------
    >>> table_in({"rig": {"kind": "circuit"}}, "rig", "rig.toml")
    {'kind': 'circuit'}
    >>> table_in({"rig": 3}, "rig", "rig.toml")
    Traceback (most recent call last):
    analog_card.errors.InputError: rig.toml: rig is 3; it has to be a table, [rig]
    """
    table = data.get(key, {})
    if not isinstance(table, dict):
        raise error(f"{where}: {key} is {table!r}; it has to be a table, [{key}]")
    return table
