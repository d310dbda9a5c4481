"""How a value of a design file is declared: its SI unit and what it may be."""

from collections.abc import Mapping
from dataclasses import field
from typing import Any

from analog_card.errors import InputError

# What a value may be: the condition, and how it is said.
_ALLOWED = {
    "positive": (lambda value: value > 0, "a positive value"),
    "not negative": (lambda value: value >= 0, "a not negative value"),
    "any": (lambda value: True, "a number"),
    "fraction": (lambda value: 0 <= value <= 1, "a fraction of travel, 0 to 1,"),
    "share": (lambda value: 0 <= value < 1, "a relative deviation, from 0 to less than 1,"),
    "factor": (lambda value: value >= 1, "a factor of 1 or more"),
}


def quantity(unit: str, allowed: str = "positive", help_text: str = "", kind: str = "") -> Any:
    """Declare a field of a design.

    Parameters
    ----------
    unit : str
        Its SI unit; ``""`` for a pure number.
    allowed : str, optional
        ``positive``, ``not negative``, ``any``, ``fraction`` (0 to 1), ``share`` (0 to less than 1)
        or ``factor`` (1 or more).
    help_text : str, optional
        What a command says of it, where it is an option.
    kind : str, optional
        Of a part whose spread matters, its kind in
        `analog_card.design_tolerances.Tolerances`.
    """
    return field(metadata={"unit": unit, "allowed": allowed, "help": help_text, "kind": kind})


def require_allowed(value: float, metadata: Mapping[str, str], what: str, found: Any) -> None:
    """Refuse a value that a field must not have.

    Parameters
    ----------
    value : float
        In the field's unit.
    metadata : mapping of str to str
        Of the field.
    what : str
        Which value, for the message.
    found : object
        As it was written, for the message.

    Raises
    ------
    InputError
        When the field does not allow it.

    Examples
    --------
    >>> require_allowed(0.01, {"allowed": "share"}, "tolerance", "1 %")
    """
    holds, needed = _ALLOWED[metadata["allowed"]]
    if not holds(value):
        raise InputError(f"{what} is {found!r}, {needed} is needed")
