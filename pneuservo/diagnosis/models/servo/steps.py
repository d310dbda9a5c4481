"""Into how many steps each sampling interval is divided where the chambers are carried on."""

import math
from collections.abc import Set

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array

Steps = NDArray[np.int64]

# With these, innovations of sixteen recordings differ from those with steps of 25 us by a sum of
# squares of less than 10 in each channel, or 16 of a chattering relay with a pressure missing. They
# follow the recording, the baseline and which effects are looked at: steps that followed fitted
# values would make innovations jump by as much when a parameter is moved a little.
_LONGEST = 1e-3
_JUMP = 0.05
"""What a command that jumps moves by between two intervals, as a share of the full voltage [-] (one
that runs on is followed by one step of a millisecond, to 0.5 in the sum of squares) ..."""
_ARRIVED = 10e-3
"""... and after how long the spool has followed it, the longest delay included [s]."""
_STIFFEST = 0.3
"""Step times the rate at which a pressure's deviation decays, at the most."""
FINEST = 250e-6
"""No finer step is made for the baseline's sake [s]."""
_LONGEST_BESIDE = {
    "load.mode_share": 500e-6,
    "supply.reservoir_volume": FINEST,
    "line.delay": FINEST,
    "valve.attached_loss": FINEST,
    "valve.exhaust_area": FINEST,
    "line.frequency": 100e-6,
    "load.joint_share": 100e-6,
    "stop.cushion_length": 100e-6,
}
"""Longest step beside what changes within a millisecond or remembers its past by steps [s]. With
these it adds to those differences less than 10 again, but for joints that hold nearly all the mass
and cushions. Gas and walls have states too, but warm up slowly; a lag is followed exactly, and what
the spool does and remembers it does by steps of its own."""


def dividing(time: Array, longest: float) -> Steps:
    """Return the number of equal steps no longer than something, in each interval.

    Parameters
    ----------
    time : (n,) array
        Of the samples [s].
    longest : float
        [s].

    Returns
    -------
    (n,) array of int
        The last one is that of no interval.

    Examples
    --------
    >>> dividing(np.array([0.0, 1e-3, 3e-3]), 250e-6).tolist()
    [4, 8, 8]
    """
    interval = np.diff(time)
    steps = np.ceil(np.append(interval, interval[-1:]) / longest - 1e-9)
    return np.maximum(steps, 1).astype(np.int64)


def steps_along(time: Array, command: Array, full_voltage: float, decays: Array) -> Steps:
    """Return the number of steps of each interval of a recording.

    Parameters
    ----------
    time : (n,) array
        [s].
    command : (n, m + 1) array
        Between its samples, see `pneuservo.diagnosis.models.servo.command` [V].
    full_voltage : float
        Command that opens the valve fully [V].
    decays : (n,) array
        From `pneuservo.diagnosis.models.servo.covariance.carry_on`.

    Examples
    --------
    >>> time = np.arange(12) * 1e-3
    >>> voltage = np.where(time < 2e-3, 0.0, 5.0)
    >>> held = np.column_stack([voltage, voltage])
    >>> steps_along(time, held, 10.0, np.zeros(12)).tolist()
    [1, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4]
    >>> runs_on = np.column_stack([voltage, np.append(voltage[1:], 5.0)])
    >>> steps_along(time, runs_on, 10.0, np.zeros(12)).tolist()
    [1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]
    """
    from scipy.ndimage import maximum_filter1d

    interval = float(np.median(np.diff(time)))
    jumps = np.abs(np.append(command[1:, 0] - command[:-1, -1], 0.0)) > _JUMP * full_voltage
    followed = math.ceil(_ARRIVED / interval - 1e-9)
    # The window ends at each interval and looks back.
    beside = maximum_filter1d(jumps, followed + 1, mode="constant", origin=followed // 2)
    steps = np.where(beside, dividing(time, FINEST), dividing(time, _LONGEST))
    steps = np.maximum(steps, np.ceil(decays / _STIFFEST).astype(np.int64))
    return np.minimum(steps, dividing(time, FINEST))


def steps_beside(steps: Steps, time: Array, fields: Set[str]) -> Steps:
    """Return the number of steps that effects need, whatever their size.

    Parameters
    ----------
    steps : (n,) array of int
        What the recording needs.
    time : (n,) array
        [s].
    fields : set of str
        What the effects act on, see `pneuservo.effects.servo.SERVO_FIELDS`.
    """
    longest = [_LONGEST_BESIDE[field] for field in fields if field in _LONGEST_BESIDE]
    return np.maximum(steps, dividing(time, min(longest))) if longest else steps
