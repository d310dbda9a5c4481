"""What the axes of a figure are asked to do."""

import math

import numpy as np

from pneuservo.animated_figure.figure import AnimatedFigure
from pneuservo.arrays import Array
from pneuservo.errors import InputError

# A motion begins after a rest, and gently: over this time it grows to its amplitude [s].
REST, GROWTH = 0.2, 0.5


# A sample a microsecond for 20 s; more is a slip in a unit.
_MOST_SAMPLES = 20_000_000


def sampled_time(duration: float, rate: float) -> Array:
    """Return even times from 0.

    Parameters
    ----------
    duration : float
        [s].
    rate : float
        Samples per second [Hz].

    Returns
    -------
    (n,) array
        [s].

    Raises
    ------
    InputError
        When there would be fewer than two samples, or too many.
    """
    if not 1.0 <= duration * rate <= _MOST_SAMPLES:
        raise InputError(
            f"{duration:g} s at {rate:g} Hz are {duration * rate:.3g} samples; it has to be 1 to "
            f"{_MOST_SAMPLES:.0e}"
        )
    time: Array = np.arange(round(duration * rate) + 1) / rate
    return time


def waving(
    figure: AnimatedFigure,
    time: Array,
    frequency: float = 1.0,
    amplitude: float = 0.25,
    moved: tuple[str, ...] | None = None,
) -> dict[str, Array]:
    """Return demands that swing about mid-stroke, each axis a little later than the one before.

    Parameters
    ----------
    figure : AnimatedFigure
        The figure.
    time : (n,) array
        [s].
    frequency : float, optional
        [Hz].
    amplitude : float, optional
        As a share of each axis' stroke, up to 0.5 [-].
    moved : tuple of str, optional
        Axes that swing; the others are held at mid-stroke. By default all swing.

    Returns
    -------
    dict of str to (n,) array
        By axis, of the rod [m].

    Raises
    ------
    InputError
        When the amplitude leaves the stroke, or there is no such axis.

    Examples
    --------
    >>> from pneuservo.animated_figure import load_figure
    >>> demands = waving(load_figure("arm"), np.linspace(0.0, 2.0, 201), moved=("elbow",))
    >>> float(np.ptp(demands["shoulder"])), round(float(np.ptp(demands["elbow"])), 4)
    (0.0, 0.015)
    """
    _require_amplitude(amplitude)
    if not 0.0 < frequency < math.inf:
        raise InputError(f"frequency is {frequency:g} Hz; it has to be greater than 0")
    swinging = tuple(figure.axes) if moved is None else moved
    for name in swinging:
        if name not in figure.axes:
            raise InputError(f"axis {name!r} is not moved: the axes are: {', '.join(figure.axes)}")
    grown = np.clip((time - time[0] - REST) / GROWTH, 0.0, 1.0)
    demands: dict[str, Array] = {}
    for place, (name, axis) in enumerate(figure.axes.items()):
        demands[name] = np.full(len(time), axis.middle)
        if name in swinging:
            late = 2.0 * math.pi * (frequency * (time - time[0]) - place / len(figure.axes))
            way = amplitude * axis.rig["piston.stroke"] * grown
            demands[name] += way * np.sin(late)
    return demands


def stepping(
    figure: AnimatedFigure, time: Array, hold: float = 0.5, amplitude: float = 0.25
) -> dict[str, Array]:
    """Return demands in which one axis after another steps out and back again.

    Parameters
    ----------
    figure : AnimatedFigure
        The figure.
    time : (n,) array
        [s].
    hold : float, optional
        Between two steps of the figure [s].
    amplitude : float, optional
        As a share of each axis' stroke, up to 0.5 [-].

    Returns
    -------
    dict of str to (n,) array
        By axis, of the rod [m].

    Raises
    ------
    InputError
        When the amplitude leaves the stroke, or the hold is not positive.
    """
    _require_amplitude(amplitude)
    if not 0.0 < hold < math.inf:
        raise InputError(f"hold is {hold:g} s; it has to be greater than 0")
    turn = np.floor((time - time[0]) / hold + 1e-9).astype(int)
    return {
        name: axis.middle
        + amplitude
        * axis.rig["piston.stroke"]
        * ((turn - 1) % len(figure.axes) == place)
        * (turn >= 1)
        for place, (name, axis) in enumerate(figure.axes.items())
    }


def _require_amplitude(amplitude: float) -> None:
    if not 0.0 <= amplitude <= 0.5:
        raise InputError(
            f"amplitude is {amplitude:g} of the stroke; from mid-stroke it can be 0 to 0.5"
        )
