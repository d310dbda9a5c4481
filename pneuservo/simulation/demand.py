"""Demands: what the piston is asked to do."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pneuservo.errors import InputError

# A sample a microsecond for 20 s; more is a slip in a unit, and would not fit into memory for long.
_MOST_SAMPLES = 20_000_000


def step_demand(
    values: Sequence[float], hold: float, rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a demand that holds each value in turn.

    Parameters
    ----------
    values : sequence of float
        Set points, in order [m].
    hold : float
        How long each is held [s].
    rate : float
        Samples per second [Hz].

    Returns
    -------
    time, demand : (n,) array
        [s], [m].

    Raises
    ------
    InputError
        When a value is not held for at least one sample, or there would be too many samples.

    Examples
    --------
    >>> time, demand = step_demand([0.015, 0.024], hold=0.2, rate=10.0)
    >>> demand.tolist()
    [0.015, 0.015, 0.024, 0.024]
    """
    samples = round(hold * rate) if hold * rate < _MOST_SAMPLES else _MOST_SAMPLES
    if samples < 1:
        raise InputError(
            f"hold of {hold:g} s is shorter than one sample at {rate:g} Hz; "
            "give a longer hold or a higher rate"
        )
    if samples * len(values) >= _MOST_SAMPLES:
        raise InputError(
            f"{len(values)} set points held for {hold:g} s at {rate:g} Hz are "
            f"{_MOST_SAMPLES:.0e} samples or more; give a shorter hold or a lower rate"
        )
    demand = np.repeat(np.asarray(values, dtype=float), samples)
    return np.arange(len(demand)) / rate, demand
