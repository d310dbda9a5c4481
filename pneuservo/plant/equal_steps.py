"""Spans of time divided into equal steps, for kernels."""

import math

from pneuservo.plant.compilation import compiled


@compiled
def steps_between(first, last, largest_step):
    """Return into how many equal steps a span of time is divided, and their length [s].

    Parameters
    ----------
    first, last, largest_step : float
        Ends of the span, and what no step may exceed [s].
    """
    # A span that is a step but for rounding is one.
    steps = max(math.ceil((last - first) / largest_step - 1e-9), 1)
    return steps, (last - first) / steps
