"""A transducer's wandering zero, followed beside what it reads."""

import numpy as np

from pneuservo.arrays import Array
from pneuservo.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.compilation import compiled


def beyond_wander(time: Array, left: Array, shares: Array | None = None) -> Array:
    """Return what a transducer's wandering zero did not make expected, as large as its noise.

    Parameters
    ----------
    time : (n,) array
        [s].
    left : (n,) array
        Reading less what it should be; NaN where there is none [any unit].
    shares : (n,) array, optional
        Noise of each reading over its spread; 1 where it is not given [-].

    Returns
    -------
    (n,) array
        White where nothing is missing; 0 where there is no reading [unit of left].

    Notes
    -----
    The zero is followed as those of the other transducers are: a stationary Kalman filter of a
    first-order drift in white noise (Kalman 1960). Left in, a drift of a fifth of the noise passes
    for a slow swing of the supply: five times the least gain in recordings without any.

    Examples
    --------
    A step is seen when it comes, and then taken for the zero's by and by:

    >>> t = np.arange(3000) * 1e-3
    >>> seen = beyond_wander(t, np.where(t < 1.0, 0.0, 1.0))
    >>> seen[[999, 1000, 2999]].round(1).tolist()
    [0.0, 1.0, 0.1]
    """
    kept = float(np.exp(-float(np.median(np.diff(time))) / WANDER_TIME))
    step = LIKELY_WANDER**2 * (1.0 - kept**2)
    # How well the zero is known before a reading, in noise: what a step adds is what it takes away.
    half = 0.5 * (step - (1.0 - kept**2))
    known = half + float(np.sqrt(half**2 + step))
    certain = np.ones_like(left) if shares is None else shares**2
    followed: Array = _beyond_wander(left, kept, known / (1.0 + known) * certain)
    return followed / np.sqrt(1.0 + known)


@compiled
def _beyond_wander(left, kept, gain):
    found, zero = np.zeros_like(left), 0.0
    for k in range(left.shape[0]):
        if np.isfinite(left[k]):
            found[k] = left[k] - zero
            zero += gain[k] * found[k]
        zero *= kept
    return found
