"""The phase plane of a closed loop, with its sliding surface and boundary layer.

The surface of a third-order loop is a plane in displacement error, velocity and acceleration:
c1 e + c2 v + a = 0. Looked at from above, along the acceleration, it shows as the line where it
meets zero acceleration; looked at along the surface it is an edge, and every state beside it is
seen at its true distance.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from pneuservo.controllers import AnalogueCard, Controller, SlidingMode
from pneuservo.errors import InputError
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.rigs import Rig

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pneuservo.simulation.result import Simulation

_SURFACE: dict[str, Any] = {"color": "0.25", "lw": 1.2, "zorder": 1}
_LAYER: dict[str, Any] = {"color": "0.85", "lw": 0.0, "zorder": 0}
# Free space about the trajectories, as a share of what they take.
_MARGIN = 0.08
# A demand that changes more often is no row of steps: one line, one colour.
_MOST_HOLDS = 10


@dataclass(frozen=True)
class SlidingSurface:
    """A sliding surface in the terms of the piston.

    Attributes
    ----------
    displacement, velocity : float
        State weights c1 [1/s^2] and c2 [1/s], for c3 = 1.
    boundary_layer : float
        Half width; 0 for a relay [m/s^2].
    scale : float
        The controller's switching function for each m/s^2; 1, or volts on a card.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> surface = sliding_surface(SlidingMode(settling_time=0.07), load_rig("single-axis"))
    >>> round(surface.displacement, 1), round(surface.velocity, 2), surface.boundary_layer
    (3265.3, 114.29, 5.0)
    """

    displacement: float
    velocity: float
    boundary_layer: float
    scale: float


def require_surface(controller: Controller | None) -> SlidingMode | AnalogueCard:
    """Return a controller that has a sliding surface.

    Raises
    ------
    InputError
        When it has none.
    """
    if not isinstance(controller, SlidingMode | AnalogueCard):
        what = "a replayed command" if controller is None else f"the controller {controller.kind}"
        raise InputError(
            f"{what} has no sliding surface, so that there is no phase plane to draw; close the "
            f"loop with {SlidingMode.kind} or {AnalogueCard.kind}"
        )
    return controller


def sliding_surface(controller: Controller | None, rig: Rig) -> SlidingSurface:
    """Return the sliding surface of a controller on a rig.

    Parameters
    ----------
    controller : Controller or None
        A sliding mode controller or an analogue card.
    rig : Rig
        Its transducer is the card's.

    Returns
    -------
    SlidingSurface
        State weights and boundary layer; of a card by its nominal figures.

    Raises
    ------
    InputError
        When the controller has no sliding surface.

    Notes
    -----
    A card's taps are volts: S RC1 for each m/s and S RC1 RC2 for each m/s^2, S being the gain of
    the transducer (equation (9.3) of the thesis below the break frequencies).
    """
    law = require_surface(controller).law(rig)
    weights = [law.weight_displacement, law.weight_velocity, law.weight_acceleration]
    if law.source == CARD_TAPS:
        weights[0] *= law.sensitivity
        weights[1] *= law.sensitivity * law.velocity_time_constant
        weights[2] *= law.sensitivity * law.velocity_time_constant * law.acceleration_time_constant
    scale = weights[2]
    if scale == 0.0:
        raise InputError("the acceleration has no weight in this card's surface; give it one")
    layer = 0.0 if math.isinf(law.gain) else law.level / law.gain / scale
    return SlidingSurface(weights[0] / scale, weights[1] / scale, layer, scale)


def draw_phase_plane(simulation: "Simulation", ax: "Axes") -> "Axes":
    """Draw velocity over displacement error, with the surface where the acceleration is zero.

    Parameters
    ----------
    simulation : Simulation
        A closed loop under sliding mode control.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.

    Raises
    ------
    InputError
        When the run has no sliding surface.
    """
    surface = sliding_surface(simulation.controller, simulation.rig)
    error, velocity = _error(simulation), simulation["velocity"]
    _trajectories(simulation, ax, 1e3 * error, velocity)
    ends = _span(1e3 * error)
    ax.set_xlim(ends)
    ax.set_ylim(_span(velocity))

    def edge(distance: float) -> np.ndarray:
        return (distance - surface.displacement * np.array(ends) * 1e-3) / surface.velocity

    _draw_surface(ax, ends, edge, surface.boundary_layer, "surface, where a = 0")
    ax.set_xlabel("displacement less demand [mm]")
    ax.set_ylabel("velocity [m/s]")
    return _finished(ax)


def draw_edge_view(simulation: "Simulation", ax: "Axes") -> "Axes":
    """Draw the acceleration over c1 e + c2 v: a view along the surface, which is a line in it.

    Parameters
    ----------
    simulation : Simulation
        A closed loop under sliding mode control.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.

    Raises
    ------
    InputError
        When the run has no sliding surface.
    """
    surface = sliding_surface(simulation.controller, simulation.rig)
    approach = surface.displacement * _error(simulation) + surface.velocity * simulation["velocity"]
    acceleration = simulation["acceleration"]
    _trajectories(simulation, ax, approach, acceleration)
    ends = _span(approach)
    ax.set_xlim(ends)
    ax.set_ylim(_span(acceleration))
    _draw_surface(
        ax, ends, lambda distance: distance - np.array(ends), surface.boundary_layer, "surface"
    )
    ax.set_xlabel("$c_1 e + c_2 v$ [m/s²]")
    ax.set_ylabel("acceleration $a$ [m/s²]")
    return _finished(ax)


def draw_switching_function(simulation: "Simulation", ax: "Axes") -> "Axes":
    """Draw the controller's own switching function over time, with the boundary layer.

    Parameters
    ----------
    simulation : Simulation
        A closed loop under sliding mode control.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.

    Raises
    ------
    InputError
        When the run has no sliding surface.

    Notes
    -----
    On a card it is the voltage of the surface amplifier, with what the filters, offsets and
    limits of the card make of it.
    """
    surface = sliding_surface(simulation.controller, simulation.rig)
    assert simulation.surface is not None
    _trajectories(simulation, ax, simulation.time, simulation.surface / surface.scale)
    ends = (float(simulation.time[0]), float(simulation.time[-1]))
    ax.set_xlim(ends)
    _draw_surface(ax, ends, lambda distance: np.full(2, distance), surface.boundary_layer, None)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("switching function [m/s²]")
    return _finished(ax)


def phase_figure(simulation: "Simulation") -> "Figure":
    """Return a figure of the phase plane, the view along the surface, and the switching function.

    Parameters
    ----------
    simulation : Simulation
        A closed loop under sliding mode control.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; save it with its ``savefig``.

    Raises
    ------
    InputError
        When the run has no sliding surface.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    axes = figure.subplot_mosaic([["plane", "edge"], ["time", "time"]], height_ratios=[2.0, 1.0])
    draw_phase_plane(simulation, axes["plane"])
    draw_edge_view(simulation, axes["edge"])
    draw_switching_function(simulation, axes["time"])
    for place in ("plane", "edge"):
        axes[place].legend(loc="best", fontsize="small", frameon=False)
    return figure


def _error(simulation: "Simulation") -> np.ndarray:
    return simulation["displacement"] - simulation["demand"]


def _trajectories(
    simulation: "Simulation", ax: "Axes", horizontal: np.ndarray, vertical: np.ndarray
) -> None:
    """Draw one line for each step of the demand."""
    for number, (first, last) in enumerate(_holds(simulation["demand"])):
        part = slice(first, last)
        word = "to" if number else "at"
        ax.plot(
            horizontal[part],
            vertical[part],
            color=f"C{number % 10}",
            lw=1.0,
            zorder=2,
            label=f"{word} {simulation['demand'][first] * 1e3:.4g} mm",
        )


def _holds(demand: np.ndarray) -> Iterator[tuple[int, int]]:
    """Yield where each hold of the demand begins and ends."""
    changes = np.flatnonzero(np.diff(demand) != 0.0) + 1
    if len(changes) >= _MOST_HOLDS:
        changes = changes[:0]
    yield from pairwise([0, *changes, len(demand)])


def _span(values: np.ndarray) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    margin = _MARGIN * (high - low) or 1.0
    return low - margin, high + margin


def _draw_surface(
    ax: "Axes",
    ends: tuple[float, float],
    edge: Callable[[float], np.ndarray],
    layer: float,
    label: str | None,
) -> None:
    """Draw a surface seen as a line, and the layer about it."""
    ax.plot(ends, edge(0.0), label=label, **_SURFACE)
    if layer > 0.0:
        name = f"boundary layer ±{layer:.3g} m/s²"
        ax.fill_between(ends, edge(-layer), edge(layer), label=name, **_LAYER)


def _finished(ax: "Axes") -> "Axes":
    ax.grid(alpha=0.3)
    return ax
