"""Figures 9.20 to 9.22: two single-axis controllers on the coupled axes of the figure's arm."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from analog_card.tuning import tune
from pneuservo.animated_figure import FigureRun, load_figure, simulate_figure
from pneuservo.animated_figure.demand import waving
from pneuservo.animated_figure.pictures import draw_frame, draw_pose
from pneuservo.controllers import AnalogueCard, ContinuousController, StateFeedback
from pneuservo.thesis.rows import Row
from pneuservo.thesis.statements import Finding, statement_row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The settling time of chapter 9's card, and how the arm is moved: the thesis does not say.
_SETTLING_TIME = 0.07
_DURATION, _FREQUENCY, _AMPLITUDE = 2.2, 1.0, 0.25
# Once the start has died out, for a whole period [s].
_STEADY = 1.2
# "Almost eliminated": to less than this share.
_ALMOST = 0.2
_OTHER = {"shoulder": "elbow", "elbow": "shoulder"}
_CARD, _FEEDBACK = "card", "state feedback"


def _controllers() -> Mapping[str, ContinuousController]:
    return {_CARD: AnalogueCard(tune(_SETTLING_TIME).figures), _FEEDBACK: StateFeedback()}


@cache
def _run(
    controller: str, moved: tuple[str, ...], axes: tuple[str, ...] = tuple(_OTHER)
) -> FigureRun:
    figure = load_figure("arm").only(*axes)
    time = np.linspace(0.0, _DURATION, round(1e3 * _DURATION) + 1)
    return simulate_figure(
        figure,
        time=time,
        controller=_controllers()[controller],
        demands=waving(figure, time, _FREQUENCY, _AMPLITUDE, moved),
    )


def _ripple(controller: str, held: str) -> float:
    """Return how far an axis that is held is moved by the other one, steadily [m]."""
    run = _run(controller, (_OTHER[held],))
    return float(np.ptp(run.axes[held]["displacement"][run.time >= _STEADY]))


def arm_rows() -> Iterator[Row]:
    """Return what section 9.3.6.2 states of the arm, beside ours."""
    for number, held in enumerate(_OTHER, start=1):
        card, feedback = (_ripple(name, held) for name in (_CARD, _FEEDBACK))
        yield statement_row(
            f"9.21-ripple-{number}",
            f"arm: ripple of the held {held} while the {_OTHER[held]} swings at 1 Hz",
            "of state feedback almost eliminated by the card",
            Finding(
                card < _ALMOST * feedback,
                f"card {1e3 * card:.3f} mm, state feedback {1e3 * feedback:.3f} mm",
            ),
            "Figs 9.21, 9.22",
        )
    both = tuple(_OTHER)
    card, feedback = (_run(name, both).frame_vibration(_STEADY) for name in (_CARD, _FEEDBACK))
    yield statement_row(
        "9.21-vibration",
        "arm: acceleration of the frame, rms, both axes swinging at 1 Hz",
        "vibrations of the figure greatly reduced by the card",
        Finding(
            card < 0.5 * feedback,
            f"card {1e3 * card:.1f} mm/s², state feedback {1e3 * feedback:.1f} mm/s²",
        ),
        "section 9.3.6.2",
    )
    whole, alone = _tracking(both), _tracking(("shoulder",))
    yield statement_row(
        "9.21-omitted",
        "arm: error of the shoulder under the same card, with and without the forearm",
        "members can be added or omitted without changing a controller",
        Finding(
            abs(whole - alone) < 0.05 * whole,
            f"rms error {1e3 * whole:.3f} mm with, {1e3 * alone:.3f} mm without it",
        ),
        "section 9.3.6.2",
    )


def _tracking(axes: tuple[str, ...]) -> float:
    """Return the error of the swinging shoulder in an arm of some axes, root mean square [m]."""
    run = _run(_CARD, axes, axes)
    shoulder, steady = run.axes["shoulder"], run.time >= _STEADY
    error = (shoulder["demand"] - shoulder["displacement"])[steady]
    return float(np.sqrt(np.mean(error**2)))


def arm_figure() -> "Figure":
    """Return figures 9.20 to 9.22: the arm, the ripple of a held axis, and the frame."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 6.0), layout="constrained")
    grid = figure.subplots(2, 3, width_ratios=(1.0, 2.0, 2.0))
    place = grid[0, 0].get_gridspec()[:, 0]
    for ax in grid[:, 0]:
        ax.remove()
    draw_pose(_run(_CARD, tuple(_OTHER)), figure.add_subplot(place), 1.3)
    for ax, held in zip(grid[:, 1], _OTHER, strict=True):
        for controller in (_FEEDBACK, _CARD):
            run = _run(controller, (_OTHER[held],))
            off = run.axes[held]["displacement"] - run.axes[held]["demand"]
            ax.plot(run.time, 1e3 * off, lw=0.9, label=controller)
        ax.set_title(f"{held} held, {_OTHER[held]} swings", fontsize="medium")
        ax.set_ylabel("ripple of the rod [mm]")
        ax.grid(alpha=0.25)
    grid[0, 1].legend(fontsize="small", frameon=False)
    for controller in (_FEEDBACK, _CARD):
        run = _run(controller, tuple(_OTHER))
        grid[0, 2].plot(
            run.time, 1e3 * run.axes["shoulder"]["displacement"], lw=0.9, label=controller
        )
        draw_frame(run, grid[1, 2], controller)
    each = _run(_CARD, tuple(_OTHER)).axes["shoulder"]
    grid[0, 2].plot(each.time, 1e3 * each["demand"], "--", color="0.4", lw=0.8, label="demand")
    grid[0, 2].set_title("both swing: shoulder", fontsize="medium")
    grid[0, 2].set_ylabel("displacement of the rod [mm]")
    grid[0, 2].legend(fontsize="small", frameon=False)
    grid[0, 2].grid(alpha=0.25)
    grid[1, 2].set_title("both swing: frame", fontsize="medium")
    for ax in (grid[0, 1], grid[1, 1], grid[0, 2]):
        ax.set_xlabel("time [s]")
    return figure
