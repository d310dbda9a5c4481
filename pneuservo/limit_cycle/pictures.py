"""Pictures of a limit cycle: the open loop with its crossing, the surface, the step."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.limit_cycle.comparison import DESCRIBING_FUNCTION, Finding
from pneuservo.limit_cycle.linear_simulation import StepCourse
from pneuservo.limit_cycle.loop import Loop, loop_response
from pneuservo.thinning import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELS = {"linear_simulation": "linear model", "nonlinear_simulation": "non-linear model"}
# Points of a curve over time.
_POINTS = 800
# Periods of the surface that are shown, and how long without a cycle [s].
_PERIODS, _SHOWN = 6, 0.03


def draw_bode(
    loop: Loop, magnitude: "Axes", phase: "Axes", label: str = "", lowest: float = 5.0
) -> tuple["Axes", "Axes"]:
    """Draw magnitude and phase of an open loop.

    Parameters
    ----------
    loop : Loop
        The loop.
    magnitude, phase : matplotlib.axes.Axes
        Where to draw, one above the other.
    label : str, optional
        Of the curve.
    lowest : float, optional
        Frequency from which on [Hz].

    Returns
    -------
    tuple of matplotlib.axes.Axes
        The same axes, labelled.
    """
    f = np.geomspace(lowest, min(2e3, loop.highest_frequency), 300)
    response = loop_response(loop, f)
    magnitude.loglog(f, np.abs(response), lw=1.2, label=label or None)
    phase.semilogx(f, np.degrees(np.unwrap(np.angle(response))), lw=1.2)
    magnitude.set_ylabel("|G| [m/(s² V)]")
    phase.set_ylabel("phase of G [°]")
    phase.set_xlabel("frequency [Hz]")
    phase.axhline(-180.0, color="0.5", lw=0.8, ls="--")
    for ax in (magnitude, phase):
        ax.grid(which="both", alpha=0.25)
    if label:
        magnitude.legend(loc="best", fontsize="small", frameon=False)
    return magnitude, phase


def draw_nyquist(loop: Loop, ax: "Axes", finding: Finding | None = None) -> "Axes":
    """Draw an open loop in the complex plane near where it meets -1/N of the relay.

    Parameters
    ----------
    loop : Loop
        The loop.
    ax : matplotlib.axes.Axes
        Where to draw.
    finding : Finding, optional
        What the describing function found; its cycle is marked.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    f = np.geomspace(10.0, min(5e3, loop.highest_frequency), 600)
    response = loop_response(loop, f)
    cycle = None if finding is None else finding.cycle
    shown = loop_response(loop, np.array([cycle.frequency if cycle else 100.0]))[0]
    extent = 3.0 * float(np.abs(shown))
    ax.plot(response.real, response.imag, lw=1.2, label="G(jω)")
    ax.plot([-extent, 0.0], [0.0, 0.0], color="0.5", ls="--", lw=1.0, label="−1/N of the relay")
    if cycle:
        kind = "stable" if cycle.stable else "unstable"
        ax.plot(shown.real, 0.0, "o", color="C3", label=f"{cycle.frequency:.1f} Hz, {kind}")
    ax.set_xlim(-extent, 0.4 * extent)
    ax.set_ylim(-extent, 0.7 * extent)
    ax.set_xlabel("real part of G [m/(s² V)]")
    ax.set_ylabel("imaginary part of G [m/(s² V)]")
    ax.grid(alpha=0.25)
    ax.legend(loc="lower right", fontsize="small", frameon=False)
    return ax


def draw_surface(found: Mapping[str, Finding], ax: "Axes") -> "Axes":
    """Draw the last periods of the switching function of every simulation.

    Parameters
    ----------
    found : mapping of str to Finding
        From `pneuservo.limit_cycle.compare`.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    slowest = [f.cycle.frequency for f in found.values() if f.course and f.cycle]
    shown = _PERIODS / min(slowest) if slowest else _SHOWN
    for method, finding in found.items():
        if finding.course is None:
            continue
        course = finding.course
        last = course.time >= course.time[-1] - shown
        since = 1e3 * (course.time[last] - course.time[-1] + shown)
        ax.plot(
            *thinned(since, course.surface[last], _POINTS),
            lw=1.0,
            label=_LABELS[method],
            drawstyle="steps-post" if finding.course.sampled else "default",
        )
    ax.margins(y=0.25)
    ax.axhline(0.0, color="0.5", lw=0.6)
    ax.set_xlabel("time, end of the run [ms]")
    ax.set_ylabel("switching function σ [m/s²]")
    ax.grid(alpha=0.25)
    ax.legend(loc="upper center", ncols=2, fontsize="small", frameon=False)
    return ax


def draw_error(courses: Mapping[str, StepCourse], ax: "Axes", until: float = 0.25) -> "Axes":
    """Draw what is left of a step over time.

    Parameters
    ----------
    courses : mapping of str to StepCourse
        By label.
    ax : matplotlib.axes.Axes
        Where to draw.
    until : float, optional
        End of the time shown [s].

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    for label, course in courses.items():
        first = course.time <= until
        ax.plot(
            *thinned(course.time[first], 1e3 * course.error[first], _POINTS), lw=1.0, label=label
        )
    ax.axhline(0.0, color="0.5", lw=0.6)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("demand less displacement [mm]")
    ax.grid(alpha=0.25)
    ax.legend(loc="best", fontsize="small", frameon=False)
    return ax


def overview(loop: Loop, found: Mapping[str, Finding]) -> "Figure":
    """Return a figure of one loop: its crossing, the surface, and the step.

    Parameters
    ----------
    loop : Loop
        The loop.
    found : mapping of str to Finding
        From `pneuservo.limit_cycle.compare`.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; save it with its ``savefig``.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    nyquist, surface, error = figure.subplots(1, 3)
    draw_nyquist(loop, nyquist, found[DESCRIBING_FUNCTION])
    draw_surface(found, surface)
    draw_error(
        {_LABELS[name]: f.course for name, f in found.items() if f.course is not None}, error
    )
    return figure
