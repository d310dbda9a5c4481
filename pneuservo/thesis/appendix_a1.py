"""Appendix A1 of the thesis: four controllers of a manipulator with two links, ideal actuators."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.arrays import Array
from pneuservo.manipulator.adaptive import VariableStructureAdaptive
from pneuservo.manipulator.controllers import (
    ComputedTorque,
    Controller,
    ProportionalDerivative,
    StateFeedback,
    decoupling_gain,
    joint_models,
)
from pneuservo.manipulator.manipulator import bounds, nominal, printed_state_feedback
from pneuservo.manipulator.simulation import TARGETS, ManipulatorRun, simulate_manipulator
from pneuservo.report.picture_files import write_pictures
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.statements import Finding, statement_row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

VARIED = 0.3
# How long runs last: until a linear loop has settled, and until an oscillation shows to stay [s].
_SETTLED, _SUSTAINED = 12.0, 20.0
# Joints that move less than this at the end are at rest, and come this near to the target [rad].
_AT_REST, _ON_TARGET = 0.01, 0.005
# How much of a run shows the switching of its parameters [s], how often each then crosses the
# middle of its bounds at the least, and by what share of them its mean may move at rest.
_SHOWN, _SWITCHES, _NO_DRIFT = 1.5, 10, 0.01
# Significantly better leaves at most this share of what was wrong [-].
_SIGNIFICANTLY = 0.5
_DIGITS_OF_K = "printed to one digit after the point: 1.325 became 1.3"


def rows() -> list[Row]:
    """Return the results of appendix A1 beside ours."""
    return [*_design_rows(), *_linear_rows(), *_computed_torque_rows(), *_adaptive_rows()]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of appendix A1 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    figures = {
        "appendix-a1-responses": _responses(),
        "appendix-a1-estimates": _estimates(),
    }
    return write_pictures(figures, folder)


@cache
def _run(kind: type[Controller], share: float, duration: float) -> ManipulatorRun:
    # With the lengths off as well, what adapts has no parameter that could make up for them.
    plant = nominal().varied(share, lengths=kind is not VariableStructureAdaptive)
    return simulate_manipulator(kind(), plant, duration=duration)


def _words(run: ManipulatorRun) -> str:
    (high_1, high_2), (final_1, final_2) = run.highest, run.final
    return f"up to {high_1:.3f} and {high_2:.3f} rad, final {final_1:.3f} and {final_2:.3f} rad"


def _error(run: ManipulatorRun) -> float:
    return float(abs(run.final - TARGETS).max())


def _excess(run: ManipulatorRun) -> float:
    return float((run.highest - TARGETS).max())


def _from_demand(run: ManipulatorRun) -> float:
    """Return the largest distance of a joint from its filtered reference [rad]."""
    return float(abs(run.angles - run.demanded).max())


def _distance(run: ManipulatorRun) -> float:
    """Return the root mean square distance of both joints from their references [rad]."""
    return float(np.sqrt(np.mean((run.angles - run.demanded) ** 2)))


def _design_rows() -> Iterator[Row]:
    a, b = joint_models(nominal())
    proportional, derivative = ProportionalDerivative().gains
    printed = {
        "A1.7-gain": ("rad/(s² V)", (3.077, 8.205), a, "equation (A1.7)"),
        "A1.7-pole": ("1/s", (5.769, 4.103), b, "equation (A1.7)"),
        "A1.2-kp": ("V/rad", (5.2, 1.95), proportional, "Table A1.2"),
        "A1.2-kd": ("V s/rad", (0.7228, 0.4758), derivative, "Table A1.2"),
    }
    for name, (unit, stated, ours, source) in printed.items():
        for joint in range(2):
            quantity = name.split("-")[1]
            yield number_row(
                f"{name}-{joint + 1}",
                f"joint {joint + 1}: {quantity}",
                unit,
                stated[joint],
                float(ours[joint]),
                None,
                source,
            )
    exact = decoupling_gain(nominal())
    for (i, k), gain in np.ndenumerate(printed_state_feedback()):
        yield number_row(
            f"A1.12-{i + 1}{k + 1}",
            f"state feedback, K[{i + 1}, {k + 1}] for every pole at -4",
            "V/rad" if k % 2 == 0 else "V s/rad",
            float(gain),
            float(exact[i, k]),
            None,
            "equation (A1.12)",
            "" if exact[i, k] == gain else _DIGITS_OF_K,
        )


def _linear_rows() -> Iterator[Row]:
    runs = {
        (kind.kind, share): _run(kind, share, _SETTLED)
        for kind in (ProportionalDerivative, StateFeedback)
        for share in (0.0, VARIED)
    }
    pd, feedback = runs["pd", 0.0], runs["state-feedback", 0.0]
    pd_varied, feedback_varied = runs["pd", VARIED], runs["state-feedback", VARIED]
    yield statement_row(
        "A1.4",
        "PD and gravity compensation, nominal",
        "steady state right; overshoot and coupling",
        Finding(_error(pd) < _ON_TARGET and _excess(pd) > 0.05, _words(pd)),
        "Fig A1.4",
    )
    yield statement_row(
        "A1.5",
        "PD, plant varied 30 %",
        "worse, with a steady-state error; stable",
        Finding(_error(pd_varied) > 0.1 and pd_varied.swing().max() < _AT_REST, _words(pd_varied)),
        "Fig A1.5",
    )
    yield statement_row(
        "A1.8",
        "state feedback by (A1.12), nominal",
        "significantly better than PD, still coupled",
        Finding(
            _distance(feedback) < _SIGNIFICANTLY * _distance(pd) and _excess(feedback) > 0.05,
            f"{_words(feedback)}; {_distance(feedback):.3f} rad rms from the reference, "
            f"PD {_distance(pd):.3f} rad",
        ),
        "Fig A1.8",
        "better, but only by a fifth, and joint 2 overshoots by more",
        in_kind=_SIGNIFICANTLY <= _distance(feedback) / _distance(pd) < 1.0
        and _excess(feedback) > 0.05,
    )
    yield statement_row(
        "A1.9",
        "state feedback, plant varied 30 %",
        "better than PD; stable",
        Finding(
            _error(feedback_varied) < _error(pd_varied)
            and feedback_varied.swing().max() < _AT_REST,
            _words(feedback_varied),
        ),
        "Fig A1.9",
    )


def _computed_torque_rows() -> Iterator[Row]:
    exact = _run(ComputedTorque, 0.0, _SETTLED)
    yield statement_row(
        "A1.11",
        "computed torque, nominal",
        "perfect: no overshoot, no coupling",
        Finding(
            _from_demand(exact) < _ON_TARGET, f"{_from_demand(exact):.1e} rad from the reference"
        ),
        "Fig A1.11",
    )
    swings = {
        share: float(_run(ComputedTorque, share, _SUSTAINED).swing()[1])
        for share in (VARIED, 0.25, 0.2)
    }
    said = ", ".join(f"{swing:.2g} rad at {100 * share:g} %" for share, swing in swings.items())
    yield statement_row(
        "A1.12-unstable",
        "computed torque, plant varied 30 %",
        "unstable",
        Finding(swings[VARIED] > 1.0, f"joint 2 swings at {_SUSTAINED:g} s: {said}"),
        "Fig A1.12",
    )
    yield statement_row(
        "A1.12-stable",
        "computed torque, plant varied 20 %",
        "stable below 20 %, worse than state feedback",
        Finding(
            swings[0.2] < _AT_REST
            and _error(_run(ComputedTorque, 0.2, _SUSTAINED))
            > _error(_run(StateFeedback, 0.2, _SETTLED)),
            _words(_run(ComputedTorque, 0.2, _SUSTAINED)),
        ),
        "section A1.3.3",
    )


def _adaptive_rows() -> Iterator[Row]:
    run = _run(VariableStructureAdaptive, VARIED, _SETTLED)
    longer = simulate_manipulator(VariableStructureAdaptive(), nominal().varied(VARIED))
    low, high = bounds()
    assert run.estimates is not None
    inside = bool((run.estimates >= low - 1e-9).all() and (run.estimates <= high + 1e-9).all())
    yield statement_row(
        "A1.14",
        "variable-structure adaptive control, plant varied 30 %, boundary layer 0.02 rad/s",
        "perfect: no overshoot, no coupling",
        Finding(
            _from_demand(run) < 0.02, f"{_words(run)}; lengths varied as well: {_words(longer)}"
        ),
        "Fig A1.14",
        "holds with the lengths known and the six adapted parameters off by 30 %; no parameter "
        "makes up for lengths that are off",
        in_kind=_error(longer) > 0.05,
    )
    shares = (run.estimates - low) / (high - low)
    crossings = _crossings(shares[run.time <= _SHOWN])
    moved = _drift(shares)
    holds = inside and crossings >= _SWITCHES and moved < _NO_DRIFT
    yield statement_row(
        "A1.15",
        "its parameters",
        "switch; no drift at rest",
        Finding(
            holds,
            f"each crosses the middle of its bounds at least {crossings} times in the first "
            f"{_SHOWN:g} s; at the end no mean moves by more than {100 * moved:.1g} % of the "
            "bounds from one tenth of the run to the next, though they go on switching",
        ),
        "Fig A1.15",
        "" if holds else "the bounds are left, or a parameter does not switch, or it drifts",
    )


def _crossings(shares: Array) -> int:
    """Return how often every parameter crosses the middle of its bounds at the least."""
    return int((np.diff((shares > 0.5).astype(int), axis=0) != 0).sum(axis=0).min())


def _drift(shares: Array) -> float:
    """Return by how much a mean over the last tenth is off that over the tenth before, at most."""
    tenth = len(shares) // 10
    means = [part.mean(axis=0) for part in (shares[-2 * tenth : -tenth], shares[-tenth:])]
    return float(np.abs(means[1] - means[0]).max())


def draw_joints(run: ManipulatorRun, ax: "Axes") -> "Axes":
    """Draw the angles of both joints and their references.

    Parameters
    ----------
    run : ManipulatorRun
        The run.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    for joint in range(2):
        ax.plot(run.time, run.angles[:, joint], color=f"C{joint}", label=f"joint {joint + 1}")
        ax.plot(run.time, run.demanded[:, joint], color=f"C{joint}", ls="--", lw=0.8)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("angle [rad]")
    ax.grid(alpha=0.25)
    return ax


def _responses() -> "Figure":
    """Figures A1.4, A1.5, A1.8, A1.9, A1.11, A1.12 and A1.14."""
    from matplotlib.figure import Figure

    titles: dict[type[Controller], str] = {
        ProportionalDerivative: "PD",
        StateFeedback: "state feedback",
        ComputedTorque: "computed torque",
        VariableStructureAdaptive: "adaptive",
    }
    figure = Figure(figsize=(11.0, 5.6), layout="constrained")
    axes = figure.subplots(2, 4, sharex=True, sharey="row")
    for column, (kind, title) in enumerate(titles.items()):
        for row, share in enumerate((0.0, VARIED)):
            lasting = _SUSTAINED if kind is ComputedTorque and share else _SETTLED
            ax = draw_joints(_run(kind, share, lasting), axes[row, column])
            ax.set_title(f"{title}, {'varied 30 %' if share else 'nominal'}", fontsize="medium")
            ax.set_xlim(0.0, 6.0)
            ax.label_outer()
    axes[0, 0].legend(fontsize="small", frameon=False)
    return figure


def _estimates() -> "Figure":
    """Figure A1.15."""
    from matplotlib.figure import Figure

    run = _run(VariableStructureAdaptive, VARIED, _SETTLED)
    assert run.estimates is not None
    names = ("m1 [kg]", "m2 [kg]", "J1 [kg m²]", "J2 [kg m²]", "k1 [N m s]", "k2 [N m s]")
    actual: Array = nominal().varied(VARIED).parameters
    figure = Figure(figsize=(11.0, 4.6), layout="constrained")
    for place, ax in enumerate(figure.subplots(2, 3, sharex=True).flat):
        shown = run.time <= _SHOWN
        ax.plot(run.time[shown], run.estimates[shown, place], lw=0.6)
        ax.axhline(actual[place], color="0.3", ls="--", lw=0.8)
        ax.set_ylabel(names[place])
        if place >= 3:
            ax.set_xlabel("time [s]")
        ax.grid(alpha=0.25)
    return figure
