"""The figures of section 9.3 of the thesis, redrawn."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.controllers import SampledController
from pneuservo.simulation import Simulation
from pneuservo.thesis.chapter_9_frequency import (
    CENTRE,
    FREQUENCIES,
    controllers,
    decibel,
    degrees,
    frequency_response,
    open_loop,
    stick_slip_run,
    surface_response,
)
from pneuservo.thesis.chapter_9_loops import (
    HOLD,
    analogue,
    digital,
    fast_analogue,
    hybrid,
    step_run,
    with_accelerometer,
)
from pneuservo.thesis.chapter_9_robustness import MASSES

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Settling times of figure 9.18 [s], the last two with the card soldered for them.
_SETTLING_TIMES = (0.25, 0.10, 0.07, 0.05)
_FAST_TIMES = (0.02, 0.01)


def figures() -> dict[str, "Figure"]:
    """Return every figure by the name of its file."""
    return {
        "chapter-9-digital": _digital(),
        "chapter-9-hybrid": _hybrid(),
        "chapter-9-compared": _compared(),
        "chapter-9-robustness": _robustness(),
        "chapter-9-stick-slip": _stick_slip(),
        "chapter-9-frequency": _frequency(),
    }


def draw_runs(runs: Mapping[str, Simulation], ax: "Axes") -> "Axes":
    """Draw displacements and their common demand.

    Parameters
    ----------
    runs : mapping of str to Simulation
        By label.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    first = next(iter(runs.values()))
    ax.plot(first.time, 1e3 * first["demand"], color="0.6", ls="--", lw=0.8, label="demand")
    for label, run in runs.items():
        ax.plot(run.time, 1e3 * run["displacement"], lw=0.9, label=label)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("displacement [mm]")
    ax.grid(alpha=0.25)
    ax.legend(loc="lower right", fontsize="small", frameon=False)
    return ax


def _figure(width: float, height: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _both_rates(
    make: Callable[[float, float], SampledController], layer: float
) -> dict[str, Simulation]:
    return {f"{1e3 * period:g} ms": step_run(make(layer, period)) for period in (1e-3, 2e-3)}


def _digital() -> "Figure":
    """Figures 9.11 to 9.14."""
    figure = _figure(10.0, 6.4)
    panels = {
        "(a) differences, relay": _both_rates(digital, 0.0),
        "(a) differences, boundary layer 5 m/s²": {"1 ms": step_run(digital())},
        "(b) accelerometer, relay": _both_rates(with_accelerometer, 0.0),
        "(b) accelerometer, boundary layer 5 m/s²": {"1 ms": step_run(with_accelerometer())},
    }
    for ax, (title, runs) in zip(
        figure.subplots(2, 2, sharex=True, sharey=True).flat, panels.items(), strict=True
    ):
        draw_runs(runs, ax).set_title(title, fontsize="medium")
        ax.label_outer()
    return figure


def _hybrid() -> "Figure":
    """Figures 9.15 and 9.16."""
    figure = _figure(10.0, 3.4)
    panels = {
        "(c) hybrid, relay": _both_rates(hybrid, 0.0),
        "(c) hybrid, boundary layer 5 m/s²": {"1 ms": step_run(hybrid())},
    }
    for ax, (title, runs) in zip(figure.subplots(1, 2, sharey=True), panels.items(), strict=True):
        draw_runs(runs, ax).set_title(title, fontsize="medium")
        ax.label_outer()
    return figure


def _compared() -> "Figure":
    """Figure 9.17, and what the control does."""
    figure = _figure(10.0, 5.6)
    runs = {
        "(b) accelerometer": step_run(with_accelerometer()),
        "(c) hybrid": step_run(hybrid()),
        "(d) analogue card": step_run(analogue()),
    }
    axes = figure.subplot_mosaic([["whole", "whole", "whole"], ["b", "c", "d"]])
    draw_runs(runs, axes["whole"])
    for k, (name, run) in enumerate(runs.items()):
        ax = axes[name[1]]
        last = (run.time > 3.0 * HOLD - 0.02) & (run.time < 3.0 * HOLD + 0.3)
        ax.plot(run.time[last], run["acceleration"][last], color=f"C{k}", lw=0.7)
        ax.set_ylim(-35.0, 35.0)
        ax.set_title(name, fontsize="medium")
        ax.set_xlabel("time [s]")
        ax.grid(alpha=0.25)
    axes["b"].set_ylabel("acceleration [m/s²]")
    return figure


def _robustness() -> "Figure":
    """Figures 9.18 and 9.19."""
    figure = _figure(10.0, 6.4)
    slow = {f"{settling:g} s": step_run(analogue(settling)) for settling in _SETTLING_TIMES}
    fast = {f"{settling:g} s": step_run(fast_analogue(settling)) for settling in _FAST_TIMES}
    masses = {f"{mass:g} kg": step_run(analogue(), mass) for mass in MASSES}
    measured = {f"{mass:g} kg": step_run(with_accelerometer(), mass) for mass in MASSES}
    panels = {
        "(d) settling time of the surface": slow,
        "(d) settling time of the surface, fast range": fast,
        "(d) moved mass, surface 0.07 s": masses,
        "(b) moved mass, surface 0.07 s": measured,
    }
    for ax, (title, runs) in zip(
        figure.subplots(2, 2, sharex=True, sharey=True).flat, panels.items(), strict=True
    ):
        draw_runs(runs, ax).set_title(title, fontsize="medium")
        ax.label_outer()
    return figure


def _stick_slip() -> "Figure":
    """Figures 9.23 and 9.24."""
    figure = _figure(10.0, 5.0)
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    for column, name in zip(axes.T, ("state feedback", "analogue card"), strict=True):
        run = stick_slip_run(controllers()[name])
        last = run.time >= 1.0
        time = run.time[last]
        column[0].plot(time, 1e3 * run["demand"][last], color="0.6", ls="--", lw=0.8)
        column[0].plot(time, 1e3 * run["displacement"][last], lw=0.9)
        column[1].plot(time, 1e3 * run["velocity"][last], lw=0.8)
        column[0].set_title(f"{name}, 1 Hz", fontsize="medium")
        column[1].set_xlabel("time [s]")
        for ax in column:
            ax.grid(alpha=0.25)
    axes[0, 0].set_ylabel("displacement [mm]")
    axes[1, 0].set_ylabel("velocity [mm/s]")
    return figure


def _frequency() -> "Figure":
    """Figures 9.25 and 9.26."""
    figure = _figure(10.0, 5.6)
    (magnitude, open_magnitude), (phase, open_phase) = figure.subplots(2, 2, sharex=True)
    frequency = np.array(FREQUENCIES)
    responses = {"sliding surface": surface_response(frequency)}
    responses |= {name: frequency_response(each) for name, each in controllers().items()}
    for k, (name, response) in enumerate(responses.items()):
        style = {"color": "0.4", "ls": "--"} if k == 0 else {"color": f"C{k - 1}", "marker": "."}
        magnitude.semilogx(frequency, decibel(response), lw=0.9, label=name, **style)
        phase.semilogx(frequency, degrees(response), lw=0.9, **style)
    fine = np.geomspace(FREQUENCIES[0], 100.0, 400)
    servo = open_loop()
    response = servo.response(fine)
    open_magnitude.semilogx(fine, decibel(response), lw=0.9)
    open_phase.semilogx(fine, degrees(response), lw=0.9)
    magnitude.set_title("closed loops, 2 mm about mid-stroke", fontsize="medium")
    open_magnitude.set_title(
        f"open loop, displacement over voltage at {1e3 * CENTRE:g} mm", fontsize="medium"
    )
    magnitude.set_ylim(-40.0, 6.0)
    phase.set_ylim(-280.0, 10.0)
    magnitude.legend(loc="lower left", fontsize="small", frameon=False)
    magnitude.set_ylabel("displacement over demand [dB]")
    open_magnitude.set_ylabel("magnitude [dB re 1 m/V]")
    phase.set_ylabel("phase [degrees]")
    open_phase.set_ylabel("phase [degrees]")
    for ax in (phase, open_phase):
        ax.set_xlabel("frequency [Hz]")
    for ax in (magnitude, open_magnitude, phase, open_phase):
        ax.grid(which="both", alpha=0.25)
    return figure
