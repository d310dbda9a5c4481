"""Arrays of samples: their types, and one without the samples that are missing."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


def bridged(time: Array, samples: Array) -> Array:
    """Return samples with a straight line where some are missing.

    Parameters
    ----------
    time : (n,) array
        Time of each sample, rising [s].
    samples : (n,) array
        NaN or infinite where one is missing; at least one is there [any unit].

    Returns
    -------
    (n,) array
        The same where there is a sample; before the first and after the last one, as they are
        [unit of samples].

    Raises
    ------
    ValueError
        When no sample is there.

    Examples
    --------
    >>> bridged(np.array([0.0, 1.0, 3.0, 4.0]), np.array([1.0, np.nan, 4.0, np.nan])).tolist()
    [1.0, 2.0, 4.0, 4.0]
    """
    there = np.isfinite(samples)
    return np.asarray(np.interp(time, time[there], samples[there]), dtype=np.float64)
