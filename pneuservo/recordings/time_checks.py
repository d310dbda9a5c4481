"""Checks on the time column: what is refused, and what is worked around with a warning."""

from collections.abc import Callable

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError

FEWEST_SAMPLES = 16
_GAP = 3.0  # median steps
_JITTER = 0.01  # of the median step, root mean square


def require_enough(count: int, where: str) -> None:
    """Refuse a recording that is too short.

    Parameters
    ----------
    count : int
        How many usable samples there are.
    where : str
        The file, for the message.

    Raises
    ------
    InputError
        When there are fewer than 16.
    """
    if count < FEWEST_SAMPLES:
        raise InputError(
            f"{where}: has {count} usable samples; at least {FEWEST_SAMPLES} are needed"
        )


def check_time(
    time: Array, where: str, column: str, place: Callable[[int], str]
) -> tuple[Mask, list[str]]:
    """Return which samples have a usable time stamp, and what was found.

    Parameters
    ----------
    time : (n,) array
        Time as recorded [s].
    where : str
        The file, for messages.
    column : str
        Name of the time column, for messages.
    place : callable
        Sample index to where it is in the file, for messages.

    Returns
    -------
    keep : (n,) array of bool
        False where the time is missing or repeats the one before.
    warnings : list of str
        Missing and repeated time stamps, gaps and jitter.

    Raises
    ------
    InputError
        When the time is infinite, goes backwards, is the same throughout, or fewer than 16
        samples are left.
    """
    infinite = np.flatnonzero(np.isinf(time))
    if len(infinite):
        raise InputError(
            f"{where}, {place(infinite[0])}, column {column!r}: the time is infinite; "
            "correct or delete that sample"
        )
    keep = np.isfinite(time)
    warnings: list[str] = []
    missing = len(time) - int(np.count_nonzero(keep))
    if missing:
        first = place(int(np.argmin(keep)))
        warnings.append(f"{_left_out(missing, 'without a time')}, the first at {first}")
    stamped = np.flatnonzero(keep)
    steps = np.diff(time[stamped])
    back = np.flatnonzero(steps < 0.0)
    if len(back):
        before, after = time[stamped[back[0]]], time[stamped[back[0] + 1]]
        raise InputError(
            f"{where}, {place(stamped[back[0] + 1])}, column {column!r}: the time goes backwards, "
            f"from {before:.9g} s to {after:.9g} s; sort the samples, or split the recording there"
        )
    repeated = stamped[1:][steps == 0.0]
    if len(repeated) and len(repeated) == len(stamped) - 1:
        raise InputError(
            f"{where}, column {column!r}: the time is {time[stamped[0]]:g} s throughout; "
            'name another column, or give [time] rate = "... Hz"'
        )
    if len(repeated):
        keep[repeated] = False
        warnings.append(
            f"{_left_out(len(repeated), 'with a repeated time stamp')}, "
            f"the first at {place(repeated[0])}"
        )
    require_enough(int(np.count_nonzero(keep)), where)
    return keep, warnings + _irregularities(time[keep])


def _irregularities(time: Array) -> list[str]:
    """Return warnings about gaps and jitter of a strictly increasing time."""
    steps = np.diff(time)
    median = float(np.median(steps))
    gaps = np.flatnonzero(steps > _GAP * median)
    warnings: list[str] = []
    if len(gaps):
        longest = gaps[np.argmax(steps[gaps])]
        count = "1 gap" if len(gaps) == 1 else f"{len(gaps)} gaps"
        warnings.append(
            f"{count} in the time, the longest of {steps[longest]:.3g} s after "
            f"{time[longest] - time[0]:.6g} s (the usual step is {median:.3g} s)"
        )
    regular = np.delete(steps, gaps)
    jitter = float(np.sqrt(np.mean((regular - np.mean(regular)) ** 2)))
    if jitter > _JITTER * median:
        warnings.append(
            f"the time step varies by {jitter:.2g} s rms about its median of {median:.3g} s, "
            f"from {regular.min():.2g} s to {regular.max():.3g} s"
        )
    return warnings


def _left_out(count: int, which: str) -> str:
    return (
        f"1 sample {which} was left out" if count == 1 else f"{count} samples {which} were left out"
    )
