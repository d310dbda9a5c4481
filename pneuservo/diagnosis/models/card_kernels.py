"""What limits the op-amps of the card, sample by sample."""

import numpy as np

from pneuservo.plant.compilation import compiled

DIVISIONS = 16
"""Steps from one sample to the next, where an output slews."""


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
def limited_rate(wanted, low, high, most_change):
    """Return a signal within its swing that follows another one at a limited rate [V].

    Parameters
    ----------
    wanted : (n,) array
        Signal without limits, straight between its samples [V].
    low, high : float
        Swing [V].
    most_change : float
        Largest change from one sample to the next [V].
    """
    output = np.empty_like(wanted)
    last = min(max(wanted[0], low), high)
    output[0] = last
    step = most_change / DIVISIONS
    for k in range(1, wanted.size):
        for j in range(1, DIVISIONS + 1):
            between = wanted[k - 1] + (wanted[k] - wanted[k - 1]) * j / DIVISIONS
            goal = min(max(between, low), high)
            last = min(max(goal, last - step), last + step)
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
