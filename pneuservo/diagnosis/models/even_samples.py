"""Rigs that are simulated at the samples need them evenly spaced."""

import numpy as np

from pneuservo.errors import InputError
from pneuservo.recordings import Recording

_UNEVEN = 0.2
"""A step may differ from the usual one by this share of it: a clock that jitters."""


def even_interval(recording: Recording, kind: str) -> float:
    """Return the interval of a recording whose samples are evenly spaced.

    Parameters
    ----------
    recording : Recording
        With at least two samples.
    kind : str
        Kind of rig that needs it, for the message.

    Returns
    -------
    float
        Time from one sample to the next [s].

    Raises
    ------
    InputError
        When a step differs by more than a fifth of the usual one.

    Examples
    --------
    >>> even_interval(Recording("ramp", 1e-3 * np.arange(5), {"force": np.arange(5.0)}), "circuit")
    0.001
    """
    time, interval = recording.time, recording.sampling_interval
    steps = np.diff(time)
    uneven = np.flatnonzero(np.abs(steps - interval) > _UNEVEN * interval)
    if len(uneven):
        raise InputError(
            f"{recording.source or recording.name}: rig '{kind}' needs evenly spaced samples; "
            f"at {time[uneven[0]]:.6g} s the step is {steps[uneven[0]]:.4g} s against "
            f"{interval:.4g} s elsewhere. Cut the recording there or resample it"
        )
    return interval
