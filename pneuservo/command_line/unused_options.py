"""Options that were given and would not be used: they are refused rather than ignored."""

from collections.abc import Mapping
from typing import Any

from pneuservo.errors import InputError
from pneuservo.loop_controller import written


def refuse_unused(options: Mapping[str, Any], what: str) -> None:
    """Refuse options where nothing uses them.

    Parameters
    ----------
    options : mapping of str to anything
        By name of the variable; None where an option was not given.
    what : str
        What does not use them.

    Raises
    ------
    InputError
        When one was given.
    """
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{written(name)} is not used by {what}; leave it out")
