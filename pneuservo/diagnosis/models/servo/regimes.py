"""Parts of a servo's recording that have a name."""

import numpy as np

from pneuservo.arrays import Mask
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.rigs import Rig

SLOW = 0.01
"""Near zero velocity [m/s]."""
NEAR_NULL = 0.02
"""Small openings, as a share of full opening: where overlap and leakage of the spool act."""
SMALL = 0.1
"""Openings that are small beside the lands' rounding."""
AFTER_STEP = 0.05
"""The first moments after a jump of the command [s]."""
JUMP = 0.2
"""A jump of the command, as a share of full opening."""
AT_THE_END = 0.2
"""Share of the recorded stroke that counts as its end."""


def regimes_of(feed: Feed, rig: Rig) -> dict[str, Mask]:
    """Return phrases that name parts of a recording, with the samples they cover.

    Parameters
    ----------
    feed : Feed
        The recording.
    rig : Rig
        The rig it was taken on.

    Returns
    -------
    dict of str to (n,) array of bool
        By motion, place, opening, pressure ratio and time.
    """
    displacement, velocity, _ = feed.motion
    opening = np.abs(feed.voltage) / rig["valve.full_voltage"]
    low, high = np.percentile(displacement, [1.0, 99.0])
    reach = AT_THE_END * (high - low)
    supply = feed.supply if feed.supply is not None else rig["supply.pressure"]
    ratio = feed.pressures / supply
    elapsed = feed.time - feed.time[0]
    return {
        "near zero velocity": np.abs(velocity) < SLOW,
        "sliding in the extending direction": velocity > SLOW,
        "sliding in the retracting direction": velocity < -SLOW,
        "in the retracted fifth of the recorded stroke": displacement < low + reach,
        "in the extended fifth of the recorded stroke": displacement > high - reach,
        "with the valve near null": opening < NEAR_NULL,
        "at small openings": opening < SMALL,
        "at large openings": opening > 0.5,
        "just after a jump of the command": _after_jumps(feed, JUMP * rig["valve.full_voltage"]),
        "at pressures near the supply": np.max(ratio, axis=0) > 0.9,
        "at low chamber pressure": np.min(ratio, axis=0) < 0.4,
        "in the last third of the recording": elapsed > elapsed[-1] * 2.0 / 3.0,
    }


def _after_jumps(feed: Feed, jump: float) -> Mask:
    steps = np.abs(np.diff(feed.voltage, prepend=feed.voltage[0]))
    moments = feed.time[steps > jump]
    if not len(moments):
        return np.zeros(len(feed.time), dtype=bool)
    last = np.searchsorted(moments, feed.time, side="right") - 1
    since = np.where(last >= 0, feed.time - moments[np.maximum(last, 0)], np.inf)
    return np.asarray(since < AFTER_STEP)
