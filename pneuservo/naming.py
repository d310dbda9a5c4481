"""Names as people type them: which are known, and which was probably meant."""

import difflib
from collections.abc import Collection

from pneuservo.errors import InputError


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
        When the name is not known; the message lists the known ones and the nearest.
    """
    if name not in known:
        there_are = ", ".join(known) or "none"
        raise InputError(
            f"{where}: {name!r} is not known; there are: {there_are}{nearest(name, known)}"
        )
