"""The pictures of a calibration."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pneuservo.calibration.heat_transfer import ApparentCoefficient
from pneuservo.calibration.table_row import TableRow
from pneuservo.calibration.transient import LEAK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PATH_NAMES = {
    "s_a": "supply to a",
    "b_e": "b to exhaust",
    "s_b": "supply to b",
    "a_e": "a to exhaust",
    LEAK: "leak",
}
# The pressure moves at first only: further on a curve is one line.
_MOST_POINTS = 400


def _shades(count: int) -> list[tuple[float, float, float, float]]:
    import matplotlib

    return list(matplotlib.colormaps["viridis"](np.linspace(0.0, 0.85, count)))


def draw_coefficients(ax: "Axes", rows: Sequence[TableRow]) -> "Axes":
    """Draw the discharge coefficients of one path over pressure ratio.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    rows : sequence of TableRow
        Of one path.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    leak = rows[0].path == LEAK
    scale = 1e6 if leak else 1.0
    for row, colour in zip(rows, _shades(len(rows)), strict=True):
        label = row.transient.name if leak else f"{row.command:g} V"
        curve = row.curve
        ax.plot(curve.pressure_ratio, scale * curve.coefficient, ".", ms=3, color=colour, alpha=0.5)
        seen = row.visible
        ends = (float(curve.pressure_ratio.min()), float(curve.pressure_ratio.max()))
        ratio = np.union1d(row.pressure_ratio[seen], ends)
        ratio = ratio[(ratio >= ends[0]) & (ratio <= ends[1])]
        ax.plot(ratio, scale * row.at(ratio), color=colour, label=label)
        ax.errorbar(
            row.pressure_ratio[seen],
            scale * row.coefficient[seen],
            scale * row.half_width[seen],
            fmt="o",
            ms=3,
            capsize=2,
            color=colour,
        )
    ax.set_xlabel("downstream over upstream pressure [-]")
    ax.set_ylabel("effective area [mm²]" if leak else "discharge coefficient [-]")
    ax.set_title(PATH_NAMES[rows[0].path])
    ax.set_ylim(bottom=0.0)
    ax.legend(fontsize="small", ncols=2)
    return ax


def draw_transients(ax: "Axes", rows: Sequence[TableRow]) -> "Axes":
    """Draw measured and modelled pressures over time.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    rows : sequence of TableRow
        Of one path.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    # Openings differ fifty-fold, and so do the durations.
    logarithmic = len(rows) > 1
    for row, colour in zip(rows, _shades(len(rows)), strict=True):
        transient = row.transient
        every = max(1, len(transient.time) // _MOST_POINTS)
        first = 1 if logarithmic else 0
        ax.plot(
            transient.time[first::every],
            1e-5 * transient.pressure[first::every],
            ".",
            ms=2,
            color="0.6",
            label="measured" if row is rows[0] else None,
        )
        label = "modelled" if transient.path == LEAK else f"{row.command:g} V"
        ax.plot(
            row.time[first::every], 1e-5 * row.modelled[first::every], color=colour, label=label
        )
    if logarithmic:
        ax.set_xscale("log")
    ax.set_xlabel("time [s]")
    ax.set_ylabel("absolute pressure [bar]")
    ax.set_title(PATH_NAMES[rows[0].path])
    ax.legend(fontsize="small", ncols=2)
    return ax


def draw_apparent_coefficients(ax: "Axes", study: Sequence[ApparentCoefficient]) -> "Axes":
    """Draw what (4.34) finds over the true coefficient, when the gas exchanges heat.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    study : sequence of ApparentCoefficient
        From `pneuservo.calibration.heat_transfer.heat_transfer_study`.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    openings = sorted({entry.opening for entry in study}, reverse=True)
    colours = dict(zip(openings, _shades(len(openings)), strict=True))
    for entry in study:
        style = "-" if entry.path.startswith("s_") else "--"
        what = "charge" if style == "-" else "discharge"
        ax.plot(
            entry.pressure_ratio,
            entry.ratio,
            style,
            color=colours[entry.opening],
            label=f"{what}, {entry.opening:.0%} open, {entry.duration:.2g} s",
        )
    ax.axhline(1.0, color="0.5", lw=0.8)
    ax.set_xlabel("downstream over upstream pressure [-]")
    ax.set_ylabel("coefficient found over true one [-]")
    ax.set_ylim(bottom=0.0)
    ax.legend(fontsize="small", ncols=2)
    return ax
