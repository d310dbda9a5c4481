"""A measured spool position held against where the command would have it."""

import numpy as np

from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.models.servo.command import followed_by_spool
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.supply import beyond_wander
from pneuservo.plant.valve import Valve

SPOOL_ZERO, SPOOL_GAIN = "spool_zero", "spool_gain"
"""What the spool's transducer reads at null, and at full opening beyond that, in one recording [-].
"""
ZERO_SPREAD, GAIN_SPREAD = 0.01, 0.02
"""How well both are known of a transducer that valves have built in [-]."""


def beyond_expected(fed: Feed, opening: Array, zero: float, gain: float, valve: Valve) -> Array:
    """Return what the spool's transducer reads beyond what was expected, as large as its noise.

    Parameters
    ----------
    fed : Feed
        With the reading.
    opening : (n,) array
        Where the command would have the spool [-].
    zero, gain : float
        Of the transducer [-].
    valve : Valve
        The numbers of the valve.

    Returns
    -------
    (n,) array
        [-].
    """
    shares = shares_of_spool(fed, valve)
    return shares * beyond_wander(fed.time, fed.spool_reading - (zero + gain * opening), shares)


def shares_of_spool(fed: Feed, valve: Valve) -> Array:
    """Return the noise of each reading of the spool over the spread of what is beyond expected.

    Parameters
    ----------
    fed, valve
        As in `beyond_expected`.

    Returns
    -------
    (n,) array
        Less than one where a command that runs on bends between two samples, and until the spool
        has followed it: what it did in between is not known; 0 where there is no reading [-].
    """
    _, off = followed_by_spool(fed.unseen, fed.interval, valve.spool_frequency, valve.spool_damping)
    noise = fed.noise["spool"]
    there = np.isfinite(fed.spool_reading)
    return np.where(there, noise / np.hypot(noise, off / valve.full_voltage), 0.0)
