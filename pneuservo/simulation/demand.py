"""Demands: what the piston is asked to do."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analog_card.quantities import as_text, to_si_all
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.recordings.reader import SUFFIXES

HOLD, RATE = 0.5, 1000.0
"""How long a set point is held [s], and how often a demand is sampled [Hz], unless said."""

# A sample a microsecond for 20 s; more is a slip in a unit, and would not fit into memory for long.
_MOST_SAMPLES = 20_000_000


def step_demand(values: Sequence[float], hold: float, rate: float) -> tuple[Array, Array]:
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
        When a value is not held for at least one sample, hold or rate is not above 0, or there
        would be too many samples.

    Examples
    --------
    >>> time, demand = step_demand([0.015, 0.024], hold=0.2, rate=10.0)
    >>> demand.tolist()
    [0.015, 0.015, 0.024, 0.024]
    """
    for name, value, unit in (("hold", hold, "s"), ("rate", rate, "Hz")):
        if not value > 0.0:
            raise InputError(f"{name} is {value:g} {unit}; it has to be greater than 0")
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


def set_points(text: str, stroke: float, what: str = "demand") -> list[float]:
    """Return the set points in a text; one without a unit has the unit of the last.

    Parameters
    ----------
    text : str
        Separated by commas.
    stroke : float
        Of the piston [m].
    what : str, optional
        Where the text was given, for the error message.

    Returns
    -------
    list of float
        [m].

    Raises
    ------
    InputError
        When one cannot be read as a length, or is outside the stroke.

    Examples
    --------
    >>> set_points("15, 24, 6 mm", 0.03)
    [0.015, 0.024, 0.006]
    """
    values = to_si_all(text.split(","), "m", what)
    for value in values:
        if not 0.0 <= value <= stroke:
            raise InputError(
                f"{what}: {as_text(value, 'm')} is outside the stroke, 0 to {stroke * 1e3:g} mm; "
                'give the unit once or with each, such as "15,24,6,15 mm"'
            )
    return values


def names_recording(demand: str) -> bool:
    """Return whether a text is the name of a recording rather than set points.

    Examples
    --------
    >>> names_recording("runs/loop.csv"), names_recording("15,24 mm")
    (True, False)
    """
    return Path(demand).suffix.lower() in SUFFIXES
