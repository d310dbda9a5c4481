"""The figures of chapter 8 of the thesis, redrawn with the printed parameters.

The reconciled ones reproduce more of the tables, but their c2 = wn has the steps overshoot.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from pneuservo.limit_cycle import Signals, StepCourse, simulate_linear
from pneuservo.limit_cycle.comparison import Finding, measured
from pneuservo.limit_cycle.pictures import draw_bode, draw_error, draw_surface
from pneuservo.report.picture_files import write_pictures
from pneuservo.thesis.chapter_8_loops import Plants, StatedLoop, stated_loop
from pneuservo.thesis.chapter_8_statements import ideal_error

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_FOLLOWED = 0.8
_ANALOGUE = {"8.1": "valve", "8.2": "valve, filter on x, v, a", "8.3": "valve, filter on x, v"}
_RATES = {"1 kHz": 1e-3, "2 kHz": 0.5e-3, "10 kHz": 0.1e-3}


def draw_all(folder: Path, plant: Plants) -> list[Path]:
    """Draw every figure into a folder and return the files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    plant : Plants
        Of the printed parameters.
    """
    figures = {
        "chapter-8-bode-analogue": _bode_analogue(plant),
        "chapter-8-bode-sampled": _bode_sampled(plant),
        "chapter-8-analogue-steps": _analogue_steps(plant),
        "chapter-8-analogue-surfaces": _analogue_surfaces(plant),
        "chapter-8-1kHz": _steps_and_surfaces(plant, ("8.4-servo", "8.4-valve")),
        "chapter-8-sampling-rates": _sampling_rates(plant),
        "chapter-8-differences": _steps_and_surfaces(plant, ("8.9-1kHz", "8.10-1kHz")),
    }
    return write_pictures(figures, folder)


def _figure(width: float, height: float) -> "Figure":
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _bode_analogue(plant: Plants) -> "Figure":
    """Figures 8.2, 8.5, 8.9 and 8.13."""
    loops = {"no valve": plant.loop_with(valve=False)}
    loops |= {label: plant.loop(stated_loop(name)) for name, label in _ANALOGUE.items()}
    figure = _figure(6.0, 5.0)
    magnitude, phase = figure.subplots(2, 1, sharex=True)
    for label, loop in loops.items():
        draw_bode(loop, magnitude, phase, label)
    magnitude.set_xlabel("")
    return figure


def _bode_sampled(plant: Plants) -> "Figure":
    """Figures 8.17 to 8.19, 8.27 and 8.28."""
    names = {
        "8.4-servo": "no valve",
        "8.4-valve": "valve",
        "8.4-filter": "valve, filter",
        "8.9-1kHz": "no valve, differences",
        "8.10-1kHz": "valve, differences",
    }
    figure = _figure(6.0, 5.0)
    magnitude, phase = figure.subplots(2, 1, sharex=True)
    for name, label in names.items():
        draw_bode(plant.loop(stated_loop(name)), magnitude, phase, label)
    magnitude.set_title("sampled at 1 kHz", fontsize="medium")
    magnitude.set_xlabel("")
    return figure


def _courses(plant: Plants, stated: StatedLoop) -> dict[str, StepCourse]:
    loop = plant.loop(stated)
    return {
        "linear_simulation": simulate_linear(loop, duration=_FOLLOWED),
        "nonlinear_simulation": plant.simulate(loop, _FOLLOWED),
    }


def _findings(courses: Mapping[str, StepCourse]) -> Mapping[str, Finding]:
    return {name: measured(course) for name, course in courses.items()}


def _labelled(courses: Mapping[str, StepCourse]) -> dict[str, StepCourse]:
    labels = {"linear_simulation": "linear", "nonlinear_simulation": "non-linear"}
    return {labels[name]: course for name, course in courses.items()}


def _analogue_steps(plant: Plants) -> "Figure":
    """Figures 8.3, 8.6, 8.10 and 8.14."""
    figure = _figure(11.0, 3.4)
    bare = plant.loop_with(valve=False)
    runs = {
        "no valve": {
            "linear": simulate_linear(bare, duration=0.3),
            "non-linear": plant.simulate(bare, 0.3),
        }
    }
    for name, title in list(_ANALOGUE.items())[:2]:
        runs[title] = _labelled(_courses(plant, stated_loop(name)))
    for ax, (title, courses) in zip(figure.subplots(1, 3, sharey=True), runs.items(), strict=True):
        draw_error(courses, ax)
        time = courses["linear"].time
        first = time <= 0.25
        ideal = 1e3 * ideal_error(plant, time[first])
        ax.plot(time[first][::50], ideal[::50], color="0.4", ls="--", lw=1.0, label="ideal")
        ax.legend(loc="upper right", fontsize="small", frameon=False)
        ax.set_title(title, fontsize="medium")
        ax.label_outer()
    return figure


def _analogue_surfaces(plant: Plants) -> "Figure":
    """Figures 8.7, 8.11 and 8.15."""
    figure = _figure(11.0, 3.4)
    for ax, (name, title) in zip(figure.subplots(1, 3), _ANALOGUE.items(), strict=True):
        draw_surface(_findings(_courses(plant, stated_loop(name))), ax)
        ax.set_title(title, fontsize="medium")
    return figure


def _steps_and_surfaces(plant: Plants, names: tuple[str, ...]) -> "Figure":
    """Figures 8.20 to 8.23 and 8.29 to 8.32."""
    figure = _figure(9.0, 6.0)
    for row, name in zip(figure.subplots(len(names), 2), names, strict=True):
        stated = stated_loop(name)
        courses = _courses(plant, stated)
        draw_error(_labelled(courses), row[0], until=0.4)
        draw_surface(_findings(courses), row[1])
        for ax in row:
            ax.set_title(stated.title, fontsize="small")
    return figure


def _sampling_rates(plant: Plants) -> "Figure":
    """Figures 8.24 and 8.25, with valve."""
    figure = _figure(9.0, 3.4)
    loops = {
        label: plant.loop_with(True, Signals(sampling_time=period))
        for label, period in _RATES.items()
    }
    loops["analogue"] = plant.loop_with(True)
    linear, nonlinear = figure.subplots(1, 2, sharey=True)
    draw_error({key: simulate_linear(loop, duration=0.3) for key, loop in loops.items()}, linear)
    draw_error({key: plant.simulate(loop, 0.3) for key, loop in loops.items()}, nonlinear)
    for ax, title in ((linear, "linear model"), (nonlinear, "non-linear model")):
        ax.set_title(title, fontsize="medium")
        ax.set_ylim(-1.0, 2.0)
        ax.label_outer()
    return figure
