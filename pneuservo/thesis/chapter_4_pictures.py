"""The figures of chapter 4 of the thesis, redrawn."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.calibration.pictures import (
    PATH_NAMES,
    draw_apparent_coefficients,
    draw_coefficients,
)
from pneuservo.calibration.validation import Comparison, experiment_rig
from pneuservo.identification.pictures import draw_estimates
from pneuservo.plant.gas import gas_mass_flow, ideal_gas, mass_flow_coefficient
from pneuservo.report.picture_files import write_pictures
from pneuservo.thesis.chapter_4_motion import by_position_and_direction, synthetic
from pneuservo.thesis.chapter_4_stated import stated
from pneuservo.thesis.chapter_4_steps import StepRun, step_run
from pneuservo.thesis.chapter_4_valve import calibrated, heat_study, valve_comparisons
from pneuservo.thinning import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_TITLES = {
    "4.10": "4.10: calibrated (solid) and nominal 0.8 (dashed)",
    "4.12": "4.12: another valve (solid), model (dashed)",
    "4.13": "4.13: another day (solid), model (dashed)",
}
_OPENING_PER_VOLT = 0.2
_POINTS = 150


def draw_all(folder: Path) -> list[Path]:
    """Draw every figure into a folder and return the files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    figures = {
        "chapter-4-orifice": _orifice(),
        "chapter-4-coefficients": _coefficients(),
        "chapter-4-transients": _transients(),
        "chapter-4-identification": _identification(),
        "chapter-4-steps": _steps(),
    }
    return write_pictures(figures, folder)


def _new(columns: int, rows: int = 1) -> tuple["Figure", list["Axes"]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.4 * columns, 3.2 * rows), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def _orifice() -> "Figure":
    figure, (coefficient, charge, discharge) = _new(3)
    rig = experiment_rig()
    gas = ideal_gas(rig["temperature"], rig["gas.constant"], rig["gas.isentropic_exponent"])
    ratio = np.linspace(0.0, 1.0, 300)
    values = [mass_flow_coefficient(float(r), gas) for r in ratio]
    coefficient.plot(ratio, values)
    coefficient.set_xlabel("downstream over upstream pressure [-]")
    coefficient.set_ylabel("mass-flow coefficient [√K·s/m]")
    coefficient.set_title("4.3")
    supply, ambient, area = rig["supply.pressure"], rig["ambient.pressure"], 0.8e-6
    below, above = np.linspace(1.0, supply, 300), np.linspace(ambient, supply, 300)
    into = [gas_mass_flow(supply, float(p), area, 1.0, gas) for p in below]
    out = [gas_mass_flow(float(p), ambient, area, 1.0, gas) for p in above]
    charge.plot(1e-5 * below, 1e3 * np.array(into))
    charge.set_xlabel("downstream pressure [bar]")
    charge.set_title("4.4a: charging from a constant pressure")
    discharge.plot(1e-5 * above, 1e3 * np.array(out))
    discharge.set_xlabel("upstream pressure [bar]")
    discharge.set_title("4.4b: exhausting to the atmosphere")
    for ax in (charge, discharge):
        ax.set_ylabel("mass flow [g/s]")
    return figure


def _coefficients() -> "Figure":
    figure, axes = _new(2, 3)
    for ax, (path, rows) in zip(axes, calibrated().of_paths.items(), strict=False):
        draw_coefficients(ax, rows)
        ax.set_title(f"4.9: {PATH_NAMES[path]}")
    draw_apparent_coefficients(axes[4], heat_study())
    axes[4].set_title("n = 1.4 assumed, plain chamber")
    draw_apparent_coefficients(axes[5], heat_study(True))
    axes[5].set_title("n = 1 assumed, steel wool inside")
    for ax in axes[4:]:
        ax.legend(fontsize=6, ncols=2)
    return figure


def _transients() -> "Figure":
    figure, axes = _new(2, 3)
    for row, (number, comparisons) in enumerate(valve_comparisons().items()):
        for column, charging in enumerate((True, False)):
            ax = axes[2 * row + column]
            _compared(ax, [c for c in comparisons if c.path.startswith("s_") == charging])
            ax.set_title(_TITLES[number], fontsize="medium")
            if row == 0:
                ax.legend(fontsize=6)
    return figure


def _compared(ax: "Axes", comparisons: list[Comparison]) -> None:
    styles: dict[tuple[str, float], str] = {}
    for entry in comparisons:
        colour = styles.setdefault((entry.path, entry.command), f"C{len(styles)}")
        label = f"{PATH_NAMES[entry.path]}, {_OPENING_PER_VOLT * entry.command:.0%}"
        kept = np.unique(np.geomspace(1, len(entry.time) - 1, _POINTS).astype(int))
        time = entry.time[kept]
        ax.semilogx(time, 1e-5 * entry.measured[kept], color=colour, label=label)
        ax.semilogx(time, 1e-5 * entry.simulated[kept], "--", color=colour)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("absolute pressure [bar]")


def _identification() -> "Figure":
    names = list(stated()["evolution"])
    figure, axes = _new(3, 2)
    for ax, name in zip(axes[:3], names, strict=True):
        true = stated()["synthetic"]["parameters"][name]
        for method, found in synthetic().items():
            values = [entry.parameters[name] for entry in found]
            ax.plot(values, "o", ms=4, label=method)
        ax.axhline(true, color="0.5", lw=0.8)
        ax.set_xlabel("seed of the noise")
        ax.set_ylabel(f"{name} [{found[0].values[name].unit}]")
        ax.set_title("4.15: 500 points")
        ax.legend(fontsize="small")
    labelled = {f"{n}, {way}": found for (n, way), found in by_position_and_direction().items()}
    for ax, name in zip(axes[3:], names, strict=True):
        draw_estimates(ax, labelled, name, stated()["evolution"][name])
        ax.set_title("Table 4.6")
        if ax is not axes[3]:
            ax.set_yticklabels([])
    return figure


def _steps() -> "Figure":
    figure, axes = _new(2, 2)
    values = stated()["steps"]
    panels = (
        ("4.16: gain 1, calibrated", step_run(values["gain_low"])),
        ("4.17: gain 1, near the set point", step_run(values["gain_low"])),
        ("4.18: gain 3.4, calibrated", step_run(values["gain_high"])),
        ("4.18: gain 3.4, nominal coefficient 0.8", step_run(values["gain_high"], False)),
    )
    for ax, (title, run) in zip(axes, panels, strict=True):
        _run(ax, run)
        ax.set_title(title)
    axes[1].set_xlim(0.98, 1.5)
    axes[1].set_ylim(22.0, 25.0)
    return figure


def _run(ax: "Axes", run: StepRun) -> None:
    for name, colour in (("demand", "0.6"), ("displacement", "C0")):
        ax.plot(*thinned(run.run.time, 1e3 * run.run[name]), color=colour, lw=0.9, label=name)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("displacement [mm]")
    ax.legend(fontsize="small")
