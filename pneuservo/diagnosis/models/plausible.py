"""Recordings whose numbers no rig can have: mostly a unit or a zero that was not stated."""

import math

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


def require_on_stroke(recording: Recording, stroke: float) -> None:
    """Refuse a displacement that is nowhere near the stroke.

    Parameters
    ----------
    recording : Recording
        The recording.
    stroke : float
        The piston moves from 0 to this; zeros being what they are, a transducer may read as much
        again to either side [m].

    Raises
    ------
    InputError
        When a sample is beyond that.
    """
    place = recording["displacement"]
    low, high = float(np.nanmin(place)), float(np.nanmax(place))
    if low < -stroke or high > 2.0 * stroke:
        raise InputError(
            f"{recording.source or recording.name}: displacement goes from {low:.6g} to "
            f"{high:.6g} m, but the rig's stroke is {stroke:.6g} m; check its unit, scale and "
            "offset in the sidecar's [channels], or name another rig with --rig"
        )


def require_times(
    recording: Recording, shortest: float = 0.0, longest: float = math.inf, span: float = math.inf
) -> None:
    """Refuse a recording that is sampled as no recorder does, or lasts for ever.

    Parameters
    ----------
    recording : Recording
        The recording.
    shortest, longest : float, optional
        Its sampling interval lies in between [s].
    span : float, optional
        It lasts for no more than this [s].

    Raises
    ------
    InputError
        When it is not so: mostly the unit of the time is another one.
    """
    interval, lasts = recording.sampling_interval, float(recording.time[-1] - recording.time[0])
    if shortest <= interval <= longest and lasts <= span:
        return
    found = f"one sample in {interval:.3g} s, {lasts:.3g} s in all"
    allowed = f"{shortest:g} to {longest:g} s" if longest < math.inf else f"up to {span:g} s in all"
    raise InputError(
        f"{recording.source or recording.name}: {found}; a diagnosis takes {allowed}. Check the "
        "unit in the sidecar's [time]"
    )
