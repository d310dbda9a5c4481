"""Where a recording of the servo has nothing, and what cannot be judged for it."""

from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.recordings import Recording

GAP = 3.0
"""Samples that are farther apart than so many intervals have a gap between them."""
FORGOTTEN = 0.06
"""How long what a piston did while nobody saw what drove it goes on to show in where it is [s]."""


def with_gaps_as_missing(recording: Recording) -> Recording:
    """Return a recording in which gaps in time are samples that are missing.

    Parameters
    ----------
    recording : Recording
        With samples left out.

    Returns
    -------
    Recording
        With samples at the usual intervals in every gap, NaN in all channels; the same recording
        where there is no gap.

    Raises
    ------
    InputError
        When more is missing than there is.

    Examples
    --------
    >>> ramp = Recording("ramp", np.array([0.0, 1.0, 2.0, 6.0, 7.0]), {"force": np.arange(5.0)})
    >>> filled = with_gaps_as_missing(ramp)
    >>> filled.time.tolist(), filled["force"][2:6].tolist()
    ([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], [2.0, nan, nan, nan])
    """
    time, steps = recording.time, np.diff(recording.time)
    interval = recording.sampling_interval
    gaps = np.flatnonzero(steps > GAP * interval)
    if not len(gaps):
        return recording
    counts = np.round(steps[gaps] / interval).astype(int) - 1
    if counts.sum() > len(time):
        longest = gaps[np.argmax(counts)]
        raise InputError(
            f"{recording.source or recording.name}: more time lies in gaps between samples than "
            f"was recorded, most of it from {time[longest]:g} to {time[longest + 1]:g} s; "
            "use the stretch before or after it (--window)"
        )
    places = np.repeat(gaps + 1, counts)
    within = [
        np.linspace(time[gap], time[gap + 1], count + 2)[1:-1]
        for gap, count in zip(gaps, counts, strict=True)
    ]
    channels = {
        name: np.insert(values, places, np.nan) for name, values in recording.channels.items()
    }
    return replace(
        recording, time=np.insert(time, places, np.concatenate(within)), channels=channels
    )


def blind(time: Array, present: Mask) -> Mask:
    """Return where what was not recorded may still show.

    Parameters
    ----------
    time : (n,) array
        [s].
    present : (n,) array of bool
        Whether all that a servo is followed by was recorded.

    Returns
    -------
    (n,) array of bool
        From the first sample of each stretch that lacks something until some time after it.

    Examples
    --------
    >>> present = np.array([True, True, False, True, True, True])
    >>> blind(0.05 * np.arange(6.0), present).astype(int).tolist()
    [0, 0, 1, 1, 0, 0]
    """
    last = np.maximum.accumulate(np.where(present, -np.inf, time))
    return np.asarray(time < last + FORGOTTEN) | ~present
