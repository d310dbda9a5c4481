"""The noise of the displacement's transducer that a loop hears, where it stays for an interval."""

import numpy as np

from pneuservo.arrays import Array, Mask

ORDER = 4
"""Of differences: of a slow swing next to nothing is left, of noise all."""
_A_JUMP = 8.0
"""So many times the median difference of a command is a jump of it, and no noise."""
_CERTAIN = 10.0
"""Standard errors that the gain of a loop has to be from none."""


def gain_of_noise(voltage: Array, noise: Array, limited: Mask) -> float:
    """Return what a loop takes off its command per metre of noise that it hears [V/m].

    Parameters
    ----------
    voltage : (n,) array
        Command at the samples [V].
    noise : (n,) array
        Displacement as measured less what the piston has moved [m].
    limited : (n,) array of bool
        Where nothing passes.

    Returns
    -------
    float
        0 where it cannot be told from none.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> noise, slow = 2e-5 * rng.standard_normal(4000), np.sin(0.03 * np.arange(4000))
    >>> round(gain_of_noise(slow - 3e3 * noise, noise, np.zeros(4000, dtype=bool)))
    3000
    >>> gain_of_noise(slow + 0.06 * rng.standard_normal(4000), noise, np.zeros(4000, dtype=bool))
    0.0
    """
    from scipy.ndimage import binary_dilation

    cause, given = np.diff(noise, ORDER), -np.diff(voltage, ORDER)
    free = ~binary_dilation(limited, np.ones(2 * ORDER + 1))[ORDER // 2 : -(ORDER // 2)]
    if not free.any():
        return 0.0
    # What jumps for other reasons tells nothing of noise.
    free &= np.abs(given) < _A_JUMP * np.median(np.abs(given[free]))
    cause, given = cause[free], given[free]
    size = float(cause @ cause)
    if size <= 0.0:
        return 0.0
    gain = float(given @ cause) / size
    # Neighbouring differences share samples.
    error = float(np.std(given - gain * cause)) * np.sqrt(2.0 * ORDER / size)
    return gain if gain > _CERTAIN * error else 0.0
