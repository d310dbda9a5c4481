"""What a settled signal does well below its chattering."""

import numpy as np

from pneuservo.arrays import Array

# Well under any chattering of the servo [Hz], and what a filter spoils at the end [s].
_CORNER, _EDGE = 60.0, 0.05


def slow_range(time: Array, signal: Array, settled: float) -> float:
    """Return the range of a signal below 60 Hz, in its unit.

    Parameters
    ----------
    time, signal : (n,) array
        Equally spaced [s], and in any unit.
    settled : float
        From when it is looked at [s].
    """
    from scipy.signal import butter, sosfiltfilt

    rate = 1.0 / (time[1] - time[0])
    slow = sosfiltfilt(butter(4, _CORNER, fs=rate, output="sos"), signal)
    return float(np.ptp(slow[(time > settled) & (time < time[-1] - _EDGE)]))
