"""A measured spool position held against where the command would have it."""

from pneuservo.arrays import Array
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.wander import beyond_wander

SPOOL_ZERO, SPOOL_GAIN = "spool_zero", "spool_gain"
"""What the spool's transducer reads at null, and at full opening beyond that, in one recording [-].
"""
ZERO_SPREAD, GAIN_SPREAD = 0.01, 0.02
"""How well both are known of a transducer that valves have built in [-]."""


def beyond_expected(fed: Feed, opening: Array, zero: float, gain: float) -> Array:
    """Return what the spool's transducer reads beyond what was expected, as large as its noise.

    Parameters
    ----------
    fed : Feed
        With the reading.
    opening : (n,) array
        Where the command would have the spool [-].
    zero, gain : float
        Of the transducer [-].

    Returns
    -------
    (n,) array
        [-].
    """
    shares = fed.spool_shares
    return shares * beyond_wander(fed.time, fed.spool_reading - (zero + gain * opening), shares)
