"""Tables 9.1 and 9.2 of the thesis: up to which frequency a converter sees the chattering."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from analog_card.linear_servo import LinearServo, converter_step
from pneuservo.linear import advanced_servo, table_5_2, without_valve
from pneuservo.linear.detectability import DetectableFrequencies, detectable_frequencies
from pneuservo.simulation.sampled_loop import ACCELERATION_RANGE
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set
from pneuservo.thesis.rows import Row, number_row

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Tables 9.1 and 9.2 [Hz]: at 1.5, 15 and 28.5 mm. The first entries of the rows of extension are
# unreadable; the ranges in the text, 163 to 233 Hz and 155 to 204 Hz, give them.
_STATED = {
    ("9.1", "extend"): (233.0, 176.0, 218.0),
    ("9.1", "retract"): (210.0, 163.0, 205.0),
    ("9.2", "extend"): (204.0, 165.0, 196.0),
    ("9.2", "retract"): (190.0, 155.0, 187.0),
}
_FROM_TEXT = "unreadable in the scan; from the range that the text states"
# Where the acceleration is looked at [Hz].
_ACCELERATION_FREQUENCY = 950.0


def detectability_rows() -> list[Row]:
    """Return tables 9.1 and 9.2 and what the text states of the converter, beside ours."""
    return [*_tables(), *_converter()]


def threshold() -> float:
    """Return the displacement amplitude just seen of the reconciled set, 0 dB at 1 m [m]."""
    decibel = parameter_set(RECONCILED, 9)["threshold_decibel"]
    return float(10.0 ** (decibel / 20.0))


def _tables() -> Iterator[Row]:
    bits = round(parameter_set(PRINTED, 9)["bits"])
    printed = detectable_frequencies(bits=bits)
    reconciled = detectable_frequencies(threshold=threshold())
    for (table, direction), stated in _STATED.items():
        ours = [_row(found, table)[direction] for found in (printed, reconciled)]
        for k, position in enumerate(printed.positions):
            at = f"{1e3 * position:g} mm"
            yield number_row(
                f"{table}-{direction}-{k + 1}",
                f"largest detectable switching frequency, {direction}ing at {at}, "
                + ("no valve" if table == "9.1" else "valve"),
                "Hz",
                stated[k],
                float(ours[0][k]),
                float(ours[1][k]),
                f"Table {table}",
                _FROM_TEXT if k == 0 and direction == "extend" else "",
                in_kind=True,
            )


def _row(found: DetectableFrequencies, table: str) -> dict[str, np.ndarray]:
    return dict(found.without_valve if table == "9.1" else found.with_valve)


def _converter() -> Iterator[Row]:
    bits = round(parameter_set(PRINTED, 9)["bits"])
    yield number_row(
        "9.1-half-bit",
        "half a bit of the displacement",
        "µm",
        3.662,
        1e6 * converter_step(table_5_2().stroke, bits),
        None,
        "equation (9.1)",
    )
    yield number_row(
        "9.2-half-bit",
        "half a bit of the acceleration",
        "m/s²",
        0.0394,
        converter_step(ACCELERATION_RANGE, bits),
        None,
        "equation (9.2)",
    )
    yield number_row(
        "9.3-acceleration",
        "amplitude of the acceleration switched at 950 Hz, extending at mid-stroke, valve",
        "m/s²",
        0.0400,
        _acceleration(_servos()["extending"], _ACCELERATION_FREQUENCY),
        None,
        "Figure 9.3",
    )


def _servos() -> dict[str, LinearServo]:
    """Return the linear models at mid-stroke with the chapter's valve, by direction."""
    values = parameter_set(PRINTED, 9)
    return {
        name: replace(
            advanced_servo(table_5_2(), 0.5 * table_5_2().stroke, way),
            valve_frequency=values["valve_frequency"],
            valve_damping=values["valve_damping"],
        )
        for name, way in (("extending", True), ("retracting", False))
    }


def _acceleration(servo: LinearServo, frequency: float) -> float:
    level = parameter_set(PRINTED, 9)["level"]
    w = 2.0 * math.pi * frequency
    return float(level * w * w * abs(servo.response(np.array([frequency]))[0]))


def detectability_figure() -> "Figure":
    """Return figures 9.1 to 9.3: what is seen of the chattering, over its frequency."""
    from matplotlib.figure import Figure

    data, level = table_5_2(), parameter_set(PRINTED, 9)["level"]
    f = np.geomspace(50.0, 1000.0, 200)
    figure = Figure(figsize=(11.0, 3.6), layout="constrained")
    axes = figure.subplots(1, 3)
    for ax, title in zip(axes, ("without valve", "with valve"), strict=False):
        for k, share in enumerate((0.05, 0.5, 0.95)):
            for way, style in ((True, "-"), (False, "--")):
                servo = advanced_servo(data, share * data.stroke, way)
                servo = servo if title == "with valve" else without_valve(servo)
                label = f"{1e3 * share * data.stroke:g} mm, " + ("extend" if way else "retract")
                amplitude = 1e6 * level * np.abs(servo.response(f))
                ax.loglog(f, amplitude, style, color=f"C{k}", lw=1.0, label=label)
        ax.axhline(1e6 * converter_step(data.stroke), color="0.3", lw=1.0)
        ax.annotate("half a bit", (55.0, 1.05e6 * converter_step(data.stroke)), fontsize="small")
        ax.set_title(title, fontsize="medium")
        ax.set_ylabel("amplitude of the displacement [µm]")
    axes[0].legend(loc="upper right", fontsize="x-small", frameon=False)
    for k, (name, servo) in enumerate(_servos().items()):
        amplitude = [_acceleration(servo, float(frequency)) for frequency in f]
        axes[2].loglog(f, amplitude, color=f"C{k}", lw=1.0, label=f"{name}, mid-stroke, valve")
    axes[2].axhline(converter_step(ACCELERATION_RANGE), color="0.3", lw=1.0)
    axes[2].annotate(
        "half a bit", (55.0, 1.1 * converter_step(ACCELERATION_RANGE)), fontsize="small"
    )
    axes[2].legend(loc="upper right", fontsize="small", frameon=False)
    axes[2].set_ylabel("amplitude of the acceleration [m/s²]")
    for ax in axes:
        ax.set_xlabel("switching frequency [Hz]")
        ax.grid(which="both", alpha=0.25)
    return figure
