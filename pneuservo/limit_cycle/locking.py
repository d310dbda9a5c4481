"""To how many samples a digital loop locks, over many starts."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.limit_cycle.comparison import followed, measured
from pneuservo.limit_cycle.linear_simulation import simulate_sampled
from pneuservo.limit_cycle.loop import Loop

# Largest start error [m].
LARGEST_START = 10e-3


@dataclass(frozen=True)
class Locking:
    """Limit cycles of a digital loop from many starts.

    Attributes
    ----------
    frequency, high, low, mean_error : (n,) array
        Of each start that ends in a cycle [Hz], extremes of the surface [m/s2], demand less
        displacement [m].
    """

    frequency: Array
    high: Array
    low: Array
    mean_error: Array


def locking(loop: Loop, starts: int = 25, seed: int = 1) -> Locking:
    """Return the limit cycles of the linear servo under a digital relay, from many starts.

    Parameters
    ----------
    loop : Loop
        A sampled loop.
    starts : int, optional
        How many, at rest, with errors drawn evenly up to 10 mm either way.
    seed : int, optional
        Of the draws.

    Raises
    ------
    InputError
        When the loop is not sampled.

    Notes
    -----
    An ideal relay that switches at samples only locks to periods of whole samples. Which, and how
    the surface splits into its extremes, depends on the start: a shift of the displacement by less
    than its margin leaves every decision as it is.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> from pneuservo.limit_cycle.loop import Signals
    >>> servo = LinearServo(1059.7, 17248.0, 54.945, float("inf"), 0.7)
    >>> found = locking(Loop(servo, (3265.3, 114.3, 1.0), signals=Signals(sampling_time=1e-3)), 3)
    >>> found.frequency.round(1).tolist()
    [500.0, 500.0, 500.0]
    """
    if not loop.signals.sampled:
        raise InputError("only a sampled loop locks to whole samples; give a sampling time")
    errors = np.random.default_rng(seed).uniform(-LARGEST_START, LARGEST_START, starts)
    courses = simulate_sampled(loop, errors, followed(loop, LARGEST_START))
    cycles = [measured(course).cycle for course in courses]
    rows = [(c.frequency, c.high, c.low, c.mean_error) for c in cycles if c is not None]
    return Locking(*np.array(rows).reshape(-1, 4).T)
