"""Recordings whose numbers no rig can have: mostly a unit or a zero that was not stated."""

import numpy as np

from pneuservo.errors import InputError
from pneuservo.recordings import Recording


def require_absolute(recording: Recording, *channels: str) -> None:
    """Refuse pressures that are not above nothing.

    Parameters
    ----------
    recording : Recording
        The recording.
    *channels : str
        Those of its channels that are pressures; one that was not recorded is passed over.

    Raises
    ------
    InputError
        When one is zero or less.
    """
    for channel in channels:
        if channel not in recording:
            continue
        lowest = float(np.nanmin(recording[channel]))
        if lowest <= 0.0:
            moment = recording.time[int(np.nanargmin(recording[channel]))]
            raise InputError(
                f"{recording.source or recording.name}: {channel} is {lowest:.6g} Pa at "
                f"{moment:g} s; absolute pressures are greater than 0. Where it was measured "
                f"against the air, say gauge = true for it in the sidecar's [channels]"
            )


def require_within_reach(recording: Recording, channel: str, reach: float, what: str) -> None:
    """Refuse a channel that is nowhere near what it can be.

    Parameters
    ----------
    recording : Recording
        The recording.
    channel : str
        A channel of it.
    reach : float
        It lies between 0 and this, or as much again to either side, zeros being what they are [SI].
    what : str
        What reaches so far, for the message.

    Raises
    ------
    InputError
        When a sample is beyond that.
    """
    low, high = float(np.nanmin(recording[channel])), float(np.nanmax(recording[channel]))
    if low < -reach or high > 2.0 * reach:
        raise InputError(
            f"{recording.source or recording.name}: {channel} goes from {low:.6g} to {high:.6g} m, "
            f"but {what} is {reach:.6g} m; check its unit, scale and offset in the sidecar's "
            "[channels], or name another rig with --rig"
        )
