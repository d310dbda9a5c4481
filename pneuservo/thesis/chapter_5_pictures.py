"""The figures of chapter 5 of the thesis, redrawn."""

import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.linear import (
    advanced_servo,
    conventional_servo,
    equal_areas,
    table_5_2,
    without_valve,
)
from pneuservo.linear.characteristics import over_stroke, ultimate_gain
from pneuservo.report.picture_files import write_pictures
from pneuservo.state_feedback import linear_step
from pneuservo.thesis.chapter_5_responses import TIME, three_models
from pneuservo.thesis.chapter_5_tables import servo_of, stated, tuned
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FREQUENCY = np.geomspace(1.0, 100.0, 300)
_WAYS = {True: "extending", False: "retracting"}
_COLOURS = {True: "C0", False: "C1"}


def draw_all(folder: Path) -> list[Path]:
    """Draw every figure into a folder and return the files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    figures = {
        "chapter-5-bode": _bode(),
        "chapter-5-stroke": _stroke(),
        "chapter-5-gains": _gains(),
        "chapter-5-linear-steps": _linear_steps(),
        "chapter-5-three-models": _three_models(),
    }
    return write_pictures(figures, folder)


def _new(columns: int, rows: int = 1) -> tuple["Figure", list["Axes"]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.6 * columns, 2.9 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def _bode() -> "Figure":
    figure, (conventional, advanced, directions) = _new(3)
    data = table_5_2()
    for k, x in enumerate(stated()["positions"], 1):
        for ax, servo in (
            (conventional, conventional_servo(data, x, extending=False)),
            (advanced, advanced_servo(data, x, extending=False)),
        ):
            _magnitude(ax, without_valve(servo).response(_FREQUENCY), f"position {k}")
    for way, label in _WAYS.items():
        servo = without_valve(advanced_servo(data, stated()["positions"][0], way))
        _magnitude(directions, servo.response(_FREQUENCY), label, _COLOURS[way])
    conventional.set_title("5.3: conventional, retracting")
    advanced.set_title("5.7: advanced, retracting")
    directions.set_title("5.8: advanced, position 1")
    return figure


def _magnitude(ax: "Axes", response: np.ndarray, label: str, colour: str | None = None) -> None:
    ax.semilogx(_FREQUENCY, 20 * np.log10(np.abs(response)), label=label, color=colour)
    ax.set_xlabel("frequency [Hz]")
    ax.set_ylabel("|X/U| [dB re 1 m/V]")
    ax.grid(alpha=0.3)
    ax.legend(fontsize="x-small")


def _stroke() -> "Figure":
    figure, (frequency, damping, gain) = _new(3)
    data, sensitivity = table_5_2(), stated()["sensitivity"]
    table = over_stroke(data)
    x = 1e3 * table.displacement
    old = [without_valve(conventional_servo(data, float(at))) for at in table.displacement]
    frequency.plot(x, table.natural_frequency / (2 * math.pi), label="advanced")
    frequency.plot(x, [math.sqrt(s.a1) / (2 * math.pi) for s in old], "--", label="conventional")
    damping.plot(x, table.damping_ratio, label="advanced")
    damping.plot(x, [s.a2 / (2 * math.sqrt(s.a1)) for s in old], "--", label="conventional")
    higher = over_stroke(servo_of(RECONCILED))
    for way, label in _WAYS.items():
        for source, style, words in ((table, "-", "6.5 bar"), (higher, ":", "7.04 bar")):
            values = source.gain_extending if way else source.gain_retracting
            line = f"{label}, {words}"
            gain.plot(x, values / sensitivity, style, color=_COLOURS[way], label=line)
    gain.plot(
        x,
        [ultimate_gain(s) / sensitivity for s in old],
        "--",
        color="C2",
        label="conventional, extending",
    )
    frequency.set_title("5.5, 5.9: natural frequency")
    frequency.set_ylabel("[Hz]")
    damping.set_title("5.5, 5.9: damping ratio")
    damping.set_ylabel("[-]")
    gain.set_title("5.6, 5.10: ultimate gain")
    gain.set_ylabel("[V/V]")
    for ax in (frequency, damping, gain):
        ax.set_xlabel("displacement [mm]")
        ax.grid(alpha=0.3)
        ax.legend(fontsize="x-small")
    return figure


def _gains() -> "Figure":
    figure, axes = _new(3)
    data, pole = table_5_2(), parameter_set(PRINTED, 5)["third_pole"]
    positions = np.linspace(0.0, data.stroke, 61)
    names = {"gain": "Kp [V/V]", "velocity_gain": "Kv [s]", "acceleration_gain": "Ka [s²]"}
    for ax, (attribute, label) in zip(axes, names.items(), strict=True):
        for way, direction in _WAYS.items():
            values = [getattr(tuned(data, float(x), way, pole), attribute) for x in positions]
            ax.plot(1e3 * positions, values, color=_COLOURS[way], label=direction)
        ax.set_xlabel("displacement [mm]")
        ax.set_ylabel(label)
        ax.set_title(f"5.13: {label.split()[0]}")
        ax.grid(alpha=0.3)
        ax.legend(fontsize="x-small")
    return figure


def _linear_steps() -> "Figure":
    figure, axes = _new(3, 2)
    data, sensitivity, positions = table_5_2(), stated()["sensitivity"], stated()["positions"]
    equal = equal_areas(data)
    poles = parameter_set(PRINTED, 5)
    for k, x in enumerate(positions):
        controller = tuned(equal, x, True, poles["third_pole_equal_areas"])
        for number, at in enumerate(positions, 1):
            servo = without_valve(advanced_servo(equal, at, True))
            axes[k].plot(
                TIME,
                linear_step(servo, controller, sensitivity, TIME),
                label=f"at position {number}",
            )
        axes[k].set_title(f"5.14 to 5.16: equal areas, gains of position {k + 1}", fontsize="small")
    middle = positions[1]
    for ax, (tuned_for, direction) in zip(
        axes[3:5], ((False, "retraction"), (True, "extension")), strict=True
    ):
        controller = tuned(data, middle, tuned_for, poles["third_pole"])
        for way, label in _WAYS.items():
            servo = without_valve(advanced_servo(data, middle, way))
            response = linear_step(servo, controller, sensitivity, TIME)
            ax.plot(TIME, response, color=_COLOURS[way], label=label)
        ax.set_ylim(-1.0, 3.0)
        ax.set_title(f"5.17 to 5.20: {direction} gains, position 2", fontsize="small")
    axes[5].remove()
    for ax in axes[:5]:
        ax.set_xlabel("time [s]")
        ax.set_ylabel("share of the step [-]")
        ax.grid(alpha=0.3)
        ax.legend(fontsize="x-small")
    return figure


def _three_models() -> "Figure":
    figure, axes = _new(2)
    low, middle = stated()["positions"][:2]
    for ax, (origin, target) in zip(axes, ((low, middle), (middle, low)), strict=True):
        for label, response in three_models(origin, target).items():
            ax.plot(TIME, 1e3 * (origin + (target - origin) * response), lw=1.0, label=label)
        ax.axhline(1e3 * target, color="0.5", lw=0.8)
        ax.set_ylim(0.0, 30.0)
        ax.set_xlabel("time [s]")
        ax.set_ylabel("displacement [mm]")
        ax.set_title("5.24: " + ("outwards" if target > origin else "inwards"))
        ax.grid(alpha=0.3)
        ax.legend(fontsize="x-small")
    return figure
