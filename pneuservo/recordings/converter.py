"""Steps in which a converter has read a channel, and the noise that they are."""

import numpy as np

from pneuservo.arrays import Array

_FEWEST_LEVELS = 3
"""Of two levels it does not show whether they are steps of a converter."""
_NEIGHBOURS = 1.5
"""Times the least distance of two levels within which they are neighbours."""
_OFF, _MAY_BE_OFF = 0.1, 0.1
"""Share of a step by which a level may be off its place, as written with few digits, and share of
the levels that may be off by more: what was interpolated lies on none."""


def converter_step(values: Array) -> float:
    """Return the step of the converter that a channel was read with.

    Parameters
    ----------
    values : (n,) array
        The channel; NaN are passed over [any unit].

    Returns
    -------
    float
        0 where none shows, as where the steps are fine beside the noise [unit of values].

    Notes
    -----
    Neighbouring levels that come again are one step apart, and the others so many steps.

    Examples
    --------
    >>> ramp = np.linspace(0.0, 1.0, 1000)
    >>> float(np.round(converter_step(np.round(ramp / 0.02) * 0.02), 12)), converter_step(ramp)
    (0.02, 0.0)
    """
    levels, times = np.unique(values[np.isfinite(values)], return_counts=True)
    # Of an even ramp, or without steps, no level comes again.
    again = levels[times > 1]
    if len(again) < _FEWEST_LEVELS:
        return 0.0
    steps = np.diff(again)
    step = float(np.mean(steps[steps < _NEIGHBOURS * steps.min()]))
    multiples = np.diff(levels) / step
    off = np.abs(multiples - np.maximum(np.round(multiples), 1.0)) > _OFF
    return step if np.mean(off) < _MAY_BE_OFF else 0.0


def noise_of_steps(step: float) -> float:
    """Return the root-mean-square error of readings that are rounded to steps.

    Parameters
    ----------
    step : float
        Of the converter [any unit].

    Returns
    -------
    float
        [unit of step].

    Notes
    -----
    As if every place within a step were as likely (Bennett 1948).

    Examples
    --------
    >>> round(noise_of_steps(7.3e-6), 8)
    2.11e-06
    """
    return float(step / np.sqrt(12.0))
