"""Names as people type them: which are known, and which was probably meant."""

import difflib
from collections.abc import Collection

from pneuservo.errors import InputError

MOST_LISTED = 40
"""Where more names are known a message lists only the closest ..."""
CLOSEST_LISTED = 6
"""... so many of them."""


def nearest(name: str, known: Collection[str]) -> str:
    """Return a hint that names the known name closest to a mistyped one.

    Parameters
    ----------
    name : str
        What was found.
    known : collection of str
        What would have been accepted.

    Returns
    -------
    str
        A sentence to append to a message; empty when nothing is close.

    Examples
    --------
    >>> nearest("presure_a", ["pressure_a", "force"])
    ". Did you mean 'pressure_a'?"
    """
    folded = {option.casefold(): option for option in known}
    close = difflib.get_close_matches(name.casefold(), list(folded), 1)
    return f". Did you mean {folded[close[0]]!r}?" if close else ""


def require_known(name: str, known: Collection[str], where: str) -> None:
    """Refuse a name that is not one of the known ones.

    Parameters
    ----------
    name : str
        What was found.
    known : collection of str
        What is accepted.
    where : str
        File and table, for the message.

    Raises
    ------
    InputError
        When the name is not known; the message lists the known ones, or the closest of many.
    """
    if name not in known:
        raise InputError(f"{where}: {name!r} is not known; {_there_are(name, known)}")


def _there_are(name: str, known: Collection[str]) -> str:
    """Return what would have been accepted: all of it, or of many the closest."""
    if len(known) > MOST_LISTED:
        close = difflib.get_close_matches(name, list(known), CLOSEST_LISTED, 0.0)
        return f"there are {len(known)}, among them: {', '.join(close)}{nearest(name, known)}"
    return f"there are: {', '.join(known) or 'none'}{nearest(name, known)}"
