"""Chapter 6 of the thesis, concepts of sliding-mode control: its figures as calculations."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.arrays import Array
from pneuservo.report.picture_files import write_pictures
from pneuservo.sliding_mode.second_order import (
    PhaseTrajectory,
    SecondOrderPlant,
    phase_trajectory,
    slides_at_once,
    sliding_displacement,
    structure_trajectory,
)
from pneuservo.thesis.chapter_6_discrete import discrete_rows
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.statements import Finding, statement_row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The thesis gives its textbook plant (6.1) no numbers: a = b = 10, level 1, from rest at 1.
_PLANT, _LEVEL, _START = SecondOrderPlant(10.0, 0.0, 10.0), 1.0, (1.0, 0.0)
# Lines less steep than a, steeper than a, and so steep that the plant swings across.
_GENTLE, _STEEP, _STEEPEST = 6.0, 40.0, 200.0
_DURATION = 2.5
_SAMPLING_TIME = 1e-3


def rows() -> list[Row]:
    """Return the statements of chapter 6 beside ours."""
    return [*_phase_plane(), *_sliding_domain(), *_differences(), *discrete_rows()]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of chapter 6 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    figures = {"chapter-6-phase-plane": _phase_figure(), "chapter-6-domain": _domain_figure()}
    return write_pictures(figures, folder)


def _trajectory(slope: float) -> PhaseTrajectory:
    return phase_trajectory(_PLANT, slope, _LEVEL, _START, _DURATION)


def _phase_plane() -> Iterator[Row]:
    limit = _PLANT.gain * _LEVEL / _PLANT.friction
    away = structure_trajectory(_PLANT, _LEVEL, _START, _DURATION)
    yield statement_row(
        "6.1-structures",
        "either structure of the plant (6.1) alone",
        "limited in velocity, not stable",
        Finding(
            bool(away.velocity.max() <= limit * (1 + 1e-9)) and away.displacement[-1] > 1.0,
            f"velocity up to {away.velocity.max():.3f} of {limit:g} m/s, displacement without end",
        ),
        "Fig 6.1",
    )
    gentle, steep, steepest = (_trajectory(slope) for slope in (_GENTLE, _STEEP, _STEEPEST))
    yield statement_row(
        "6.2-sliding",
        f"line with c1 = {_GENTLE / _PLANT.friction:g} a",
        "reaching, then sliding",
        Finding(gentle.switchings == 1, f"slides from {gentle.sliding_from:.2f} s, first contact"),
        "Fig 6.2",
    )
    yield statement_row(
        "6.3-steep-line",
        f"line with c1 = {_STEEP / _PLANT.friction:g} a",
        "not followed where it is first met; reached again in another quadrant",
        Finding(
            steep.switchings > 1 and not slides_at_once(_PLANT, _STEEP),
            f"met {steep.switchings} times before it slides",
        ),
        "Fig 6.3",
        "the thesis' condition c1 < a is sufficient; with the velocity limited, c1 < 2 a is enough",
    )
    yield statement_row(
        "6.4-oscillatory",
        f"line with c1 = {_STEEPEST / _PLANT.friction:g} a",
        "damped oscillation",
        Finding(
            steepest.switchings > steep.switchings and steepest.displacement.min() < 0.0,
            f"met {steepest.switchings} times, over {-steepest.displacement.min():.3f} m to the "
            "other side",
        ),
        "Fig 6.4",
    )


def _sliding_domain() -> Iterator[Row]:
    def domain(slope: float, level: float = 1.0, damping: float = 0.4, wn: float = 10.0) -> float:
        return sliding_displacement(
            SecondOrderPlant(2 * damping * wn, wn * wn, 100.0), slope, level
        )

    cases = (
        ("6.7-slope", "grows as c1 falls", domain(20.0), domain(40.0), "Fig 6.7"),
        ("6.8-level", "grows with Umax", domain(20.0, level=2.0), domain(20.0), "Fig 6.8"),
        ("6.9-damping", "grows with damping", domain(20.0, damping=0.8), domain(20.0), "Fig 6.9"),
        (
            "6.10-frequency",
            "shrinks as wn grows",
            domain(20.0, wn=10.0),
            domain(20.0, wn=40.0),
            "Fig 6.10",
        ),
    )
    for row, statement, larger, smaller, source in cases:
        yield statement_row(
            row,
            "sliding domain of a plant of second order",
            statement,
            Finding(larger > smaller, f"up to {larger:.3f} against {smaller:.3f} m"),
            source,
        )
    whole = domain(10.0, damping=1.0)
    yield statement_row(
        "6.9-whole",
        "sliding domain with damping 1 and c1 = wn",
        "infinite",
        Finding(math.isinf(whole), "infinite" if math.isinf(whole) else f"{whole:.3f} m"),
        "Fig 6.9",
    )


def _differences() -> Iterator[Row]:
    for order, name, lag in ((1, "velocity", 180.0), (2, "acceleration", 360.0)):
        yield number_row(
            f"6.{16 + order}-{name}",
            f"lag of the backward difference for the {name} at the sampling frequency",
            "deg",
            lag,
            float(_lag(order)[1][-1]),
            None,
            f"Fig 6.{16 + order}",
        )


def _lag(order: int) -> tuple[Array, Array]:
    """Return frequencies up to the sampling frequency [Hz] and the lag of a difference [deg]."""
    import control

    step = control.tf([1.0, -1.0], [_SAMPLING_TIME, 0.0], _SAMPLING_TIME)
    # Just short of the sampling frequency itself, where the difference is zero.
    frequency = np.linspace(1.0, 0.9999 / _SAMPLING_TIME, 2000)
    s = 2j * np.pi * frequency
    ratio = (step(np.exp(s * _SAMPLING_TIME)) / s) ** order
    return frequency, -np.degrees(np.unwrap(np.angle(ratio)))


def _phase_figure() -> "Figure":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 5.4), layout="constrained")
    top, bottom = figure.subplots(2, 3)
    titles = ("6.2: c1 < a", "6.3: c1 > a", "6.4: c1 far above a")
    for slope, title, plane, course in zip(
        (_GENTLE, _STEEP, _STEEPEST), titles, top, bottom, strict=True
    ):
        found = _trajectory(slope)
        plane.plot(found.displacement, found.velocity)
        edge = np.array([-0.2, 1.0])
        plane.plot(edge, -slope * edge, "--", color="0.5", lw=0.8, label="line sigma = 0")
        plane.set_ylim(-1.2, 1.2)
        plane.set_xlabel("displacement [m]")
        plane.set_ylabel("velocity [m/s]")
        plane.set_title(title)
        plane.legend(fontsize="x-small")
        course.plot(found.time, found.displacement)
        course.set_xlabel("time [s]")
        course.set_ylabel("displacement [m]")
        course.grid(alpha=0.3)
    return figure


def _domain_figure() -> "Figure":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 3.0), layout="constrained")
    slopes, lags, lags_of_acceleration = figure.subplots(1, 3)
    _draw_domain(slopes)
    for ax, order, name in ((lags, 1, "velocity"), (lags_of_acceleration, 2, "acceleration")):
        frequency, lag = _lag(order)
        ax.plot(frequency, lag)
        ax.set_xlabel("frequency [Hz]")
        ax.set_ylabel("lag [deg]")
        ax.set_title(f"6.{16 + order}: difference for the {name}, 1 kHz", fontsize="small")
        ax.grid(alpha=0.3)
    return figure


def _draw_domain(ax: "Axes") -> None:
    slopes = np.linspace(1.0, 40.0, 400)
    for damping in (0.2, 0.4, 0.8, 1.0):
        plant = SecondOrderPlant(20.0 * damping, 100.0, 100.0)
        domain = [sliding_displacement(plant, float(c1), 1.0) for c1 in slopes]
        ax.semilogy(slopes, domain, label=f"damping {damping:g}")
    ax.set_ylim(0.05, 50.0)
    ax.set_xlabel("c1 [1/s]")
    ax.set_ylabel("largest displacement [m]")
    ax.set_title("6.7, 6.9: sliding domain, wn = 10 rad/s", fontsize="small")
    ax.legend(fontsize="x-small")
    ax.grid(alpha=0.3)
