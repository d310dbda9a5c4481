"""What limits the op-amps of the card, sample by sample."""

import numpy as np

from pneuservo.plant.compilation import compiled


@compiled
def limited_differentiator(wanted, low, high, most_change, share):
    """Return the output of a differentiator whose op-amp is limited.

    Parameters
    ----------
    wanted : (n,) array
        Output without limits [V].
    low, high : float
        Swing of the op-amp [V].
    most_change : float
        Largest change from one sample to the next [V].
    share : float
        Sampling interval over RC.

    Notes
    -----
    While the op-amp cannot follow, its inverting input leaves ground by p, and the capacitor
    misses charge: RC dp/dt = V - V_wanted - p. The op-amp stays at its limit until p is back at 0.
    """
    output = np.empty_like(wanted)
    error, last = 0.0, min(max(wanted[0], low), high)
    for k in range(wanted.size):
        needed = wanted[k] + error - error / share
        last = min(max(needed, low, last - most_change), high, last + most_change)
        output[k] = last
        error += share * (last - wanted[k] - error)
    return output


@compiled
def limited_rate(wanted, most_change):
    """Return a signal that follows another one by at most so much from sample to sample [V]."""
    output = np.empty_like(wanted)
    last = wanted[0]
    for k in range(wanted.size):
        last = min(max(wanted[k], last - most_change), last + most_change)
        output[k] = last
    return output


@compiled
def with_hysteresis(signal, width):
    """Return a signal with the feedback that moves its switching point away from it [V]."""
    output = np.empty_like(signal)
    side = 1.0 if signal[0] >= 0.0 else -1.0
    for k in range(signal.size):
        if signal[k] * side < -width:
            side = -side
        output[k] = signal[k] + width * side
    return output
