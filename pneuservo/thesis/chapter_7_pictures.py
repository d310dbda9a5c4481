"""The figures of chapter 7 of the thesis, redrawn, and the remedies its chapter 10 asks for."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.linear import advanced_servo, table_5_2, without_valve
from pneuservo.report.picture_files import write_pictures
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.laws import (
    IntegralAction,
    Law,
    PiecewiseLinear,
    Switching,
    balanced_levels,
)
from pneuservo.sliding_mode.loop import run_loop
from pneuservo.sliding_mode.pictures import draw_motion, draw_range_space, draw_reserve
from pneuservo.sliding_mode.plants import LinearPlant, UpdatePlant
from pneuservo.sliding_mode.range_space import linear_limits
from pneuservo.sliding_mode.reaching import reaching_phase
from pneuservo.sliding_mode.surface import surface_from_settling_time
from pneuservo.thesis.chapter_7_reachability import at_supply_pressure, changed_servos, fastest
from pneuservo.thesis.chapter_7_surface import (
    RESERVE_STEP,
    chosen_surface,
    level,
    printed_space,
    servo_of,
    stated,
)
from pneuservo.thesis.parameter_sets import PRINTED
from pneuservo.thinning import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Chattering of the parameter-update model with its valve, about which the levels are balanced [Hz].
_CHATTER = 190.0


def draw_all(folder: Path) -> list[Path]:
    """Draw every figure into a folder and return the files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    figures = {
        "chapter-7-limits": _limits(),
        "chapter-7-domains": _domains(),
        "chapter-7-fastest": _fastest(),
        "chapter-7-remedies": _remedies(),
    }
    return write_pictures(figures, folder)


def _figure(width: float, height: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _limits() -> "Figure":
    figure = _figure(10.5, 3.0)
    frequency = np.geomspace(1.0, 1000.0, 400)
    response = level() * np.abs(servo_of(PRINTED).response(frequency))
    names = ("velocity [m/s]", "acceleration [m/s²]", "jerk [m/s³]")
    for order, (ax, name) in enumerate(zip(figure.subplots(1, 3), names, strict=True), 1):
        ax.loglog(frequency, (2 * np.pi * frequency) ** order * response)
        ax.set_xlabel("frequency [Hz]")
        ax.set_ylabel(name)
        ax.set_title(f"7.1: {name.split()[0]} at 5 V")
        ax.grid(alpha=0.3)
    return figure


def _domains() -> "Figure":
    figure = _figure(11.5, 7.0)
    servo, error = servo_of(PRINTED), stated()["motion"]["initial_error"]
    linear = linear_limits(servo, level()).range_space(error)
    cases = (
        (0.25, printed_space(), "7.2"),
        (0.25, linear, "7.3"),
        (0.09, printed_space(), "7.4"),
        (0.07, printed_space(), "7.5"),
        (0.05, printed_space(), "7.6, 7.10"),
        (0.02, printed_space(), "7.9, 7.11"),
    )
    for ax, (settling_time, space, number) in zip(
        figure.subplots(2, 3).ravel(), cases, strict=True
    ):
        surface = surface_from_settling_time(settling_time)
        draw_range_space(ax, servo, surface, space, level())
        if settling_time <= 0.05:
            states = reaching_phase(servo, surface, level(), -error).states
            ax.plot(states[:, 1], states[:, 2], "k", lw=0.9, label="motion from 30 mm")
            ax.legend(loc="lower left", fontsize="xx-small")
        ax.set_title(f"{number}: settling time {settling_time:g} s", fontsize="small")
    return figure


def _fastest() -> "Figure":
    figure = _figure(10.5, 3.4)
    left, right = figure.subplots(1, 2)
    openings, space = np.linspace(0.8, 3.0, 23), printed_space()
    curves = {
        "6.5 bar, nominal": ([servo_of(PRINTED)], "-"),
        "6.5 bar, with parameter changes": (changed_servos(PRINTED), "--"),
        "10 bar, stiffness of 6.5 bar": ([at_supply_pressure(10e5, stiffer=False)], "-."),
        "10 bar": ([at_supply_pressure(10e5)], ":"),
    }
    for label, (servos, style) in curves.items():
        times = [fastest(servos, float(opening), space) for opening in openings]
        left.plot(openings, times, style, label=label)
    left.set_xlabel("fractional valve opening [-]")
    left.set_ylabel("settling time [s]")
    left.set_title("7.7: fastest reachable surface")
    left.set_ylim(bottom=0.0)
    left.legend(fontsize="x-small")
    left.grid(alpha=0.3)
    draw_reserve(right, table_5_2(), level(), RESERVE_STEP[1] - RESERVE_STEP[0])
    right.set_title("7.13, 7.14: reserve in sliding")
    return figure


def _remedies() -> "Figure":
    figure = _figure(11.5, 6.4)
    (step, error), (ripple, control) = figure.subplots(2, 2)
    _draw_errors(step, error)
    _draw_ripple(ripple)
    _draw_control(control)
    return figure


def _draw_errors(step: "Axes", error: "Axes") -> None:
    data, surface = table_5_2(), chosen_surface()
    plain = Switching(surface, level())
    out, back = (advanced_servo(data, 0.5 * data.stroke, way) for way in (True, False))
    up, down = balanced_levels(out, back, level(), _CHATTER)
    laws: dict[str, Law] = {
        "plain": plain,
        f"levels {up:.2f} V out, {down:.2f} V in": Switching(surface, up, retracting_level=down),
        "integral action": IntegralAction(plain, rate=10.0, within=0.5e-3),
    }
    runs = {
        label: run_loop(UpdatePlant(data, 0.006), law, 0.015, 0.5) for label, law in laws.items()
    }
    draw_motion(step, runs)
    step.set_title("parameter-update model with valve, relay 5 V", fontsize="small")
    for label, run in runs.items():
        error.plot(
            *thinned(run.time, 1e6 * (run.demand - run.displacement), 800), lw=0.9, label=label
        )
    error.set_ylim(-250.0, 250.0)
    error.set_xlabel("time [s]")
    error.set_ylabel("error [um]")
    error.set_title("the error that asymmetric switching leaves", fontsize="small")
    error.legend(fontsize="x-small")
    error.grid(alpha=0.3)


def _draw_ripple(ax: "Axes") -> None:
    servo = advanced_servo(table_5_2(), 0.015, extending=True)
    values = chosen_surface().settling_time
    laws = {
        "second order": Switching(chosen_surface(), level()),
        "fourth order, with the valve": Switching(
            surface_from_settling_time(values, order=4, further=8.0), level()
        ),
    }
    for label, law in laws.items():
        run = run_loop(LinearPlant(servo, 0.006), law, 0.015, 0.2, 2e-5)
        late = run.time > 0.17
        ax.plot(*thinned(run.time[late], run.acceleration[late], 400), lw=0.9, label=label)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("acceleration [m/s²]")
    ax.set_title("linear model with valve: surfaces of two orders", fontsize="small")
    ax.legend(fontsize="x-small")
    ax.grid(alpha=0.3)


def _draw_control(ax: "Axes") -> None:
    servo = without_valve(advanced_servo(table_5_2(), 0.015, extending=True))
    surface = chosen_surface()
    plain = Switching(surface, level())
    gains = servo_gains(servo, surface)
    laws: dict[str, Law] = {
        "plain": plain,
        "piecewise linear, 0.2 m/s": PiecewiseLinear(plain, 0.2),
    }
    for label, law in laws.items():
        run = run_loop(LinearPlant(servo, 0.0), law, 0.03, 0.25)
        needed = gains[1] * run.velocity + gains[2] * run.acceleration
        ax.plot(*thinned(run.time, needed, 400), lw=0.9, label=label)
    ax.axhline(level(), color="0.5", ls="--", lw=0.8)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("equivalent control [V]")
    ax.set_title("step of 30 mm: is sliding possible where it is?", fontsize="small")
    ax.legend(fontsize="x-small")
    ax.grid(alpha=0.3)
