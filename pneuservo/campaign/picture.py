"""The picture of a campaign: every metric against every axis."""

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from pneuservo.campaign.axes import Axis, Grid
from pneuservo.campaign.metrics import METRICS
from pneuservo.campaign.run import Outcome
from pneuservo.campaign.summary import shown, shown_axis, shown_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# A grid with more values than this is not told apart by colour.
_MOST_COLOURS = 7
_WIDEST_NAME = 30


def draw_metric(ax: "Axes", outcome: Outcome, metric: str, axis: Axis) -> "Axes":
    """Draw a metric against an axis: every sample, and for a grid the line of means.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    outcome : Outcome
        Of a campaign.
    metric : str
        One of the campaign's.
    axis : Grid or Random
        One of the campaign's.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled; samples are coloured by another axis of the grid, if there is one.
        The mark of a mean is open where some samples do not have the metric.
    """
    table = outcome.table()
    other = _other(outcome, axis)
    groups = [(None, table)] if other is None else list(table.groupby(other.name))
    colours = _colours(len(groups))
    for (value, group), colour in zip(groups, colours, strict=True):
        label = None
        if other is not None:
            label = f"{float(shown_axis(other, value)):.4g} {other.shown}".strip()
        _draw_group(ax, group, metric, axis, colour, label)
    ax.set_xlabel(_labelled(_broken(axis.name), " ", axis.shown))
    ax.set_ylabel(_labelled(metric.replace("_", " "), "\n", shown_unit(metric)))
    ax.grid(alpha=0.3)
    return ax


def campaign_figure(outcome: Outcome) -> "Figure":
    """Return a figure of every metric that some sample has against every axis that varies.

    When no sample has any, every metric of the campaign has its panels, empty.

    Parameters
    ----------
    outcome : Outcome
        Of a campaign.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; save it with its ``savefig``.
    """
    from matplotlib.figure import Figure

    table = outcome.table()
    found = [name for name in outcome.campaign.metrics if table[name].notna().any()]
    # A figure without panels cannot be made, and the runs must not be lost to that.
    metrics = found or outcome.campaign.metrics
    varying = outcome.campaign.varying or outcome.campaign.axes
    size = (1.2 + 2.9 * len(varying), 0.8 + 1.7 * len(metrics))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(metrics), len(varying), sharex="col", sharey="row", squeeze=False)
    for row, metric in zip(panels, metrics, strict=True):
        for ax, axis in zip(row, varying, strict=True):
            draw_metric(ax, outcome, metric, axis)
            ax.label_outer()
    for ax, axis in zip(panels[0], varying, strict=True):
        other = _other(outcome, axis)
        if other is not None:
            # Above the column: inside it would lie on the samples.
            ax.legend(
                title=other.name,
                fontsize="x-small",
                title_fontsize="x-small",
                loc="lower center",
                bbox_to_anchor=(0.5, 1.0),
                ncols=3,
            )
    figure.align_ylabels()
    return figure


def _draw_group(
    ax: "Axes", group: pd.DataFrame, metric: str, axis: Axis, colour: str, label: str | None
) -> None:
    x = shown_axis(axis, group[axis.name].to_numpy(dtype=float))
    y = shown(group[metric].to_numpy(dtype=float), shown_unit(metric), METRICS[metric])
    if not isinstance(axis, Grid):
        ax.plot(x, y, ".", color=colour, label=label, markersize=4)
        return
    values = np.unique(x)
    usable = np.isfinite(y)
    means = [
        float(np.mean(y[(x == value) & usable])) if (usable & (x == value)).any() else np.nan
        for value in values
    ]
    ax.plot(values, means, ".-", color=colour, label=label, lw=1.0, markersize=4)
    # What is left of the samples need not be like those that dropped out.
    lacking = [bool((~usable & (x == value)).any()) for value in values]
    ax.plot(
        values[lacking],
        np.array(means)[lacking],
        "o",
        color=colour,
        markerfacecolor="white",
        markersize=5,
        zorder=3,
    )
    if len(x) > len(values):
        ax.plot(x, y, ".", color=colour, markersize=2, alpha=0.4)


def _other(outcome: Outcome, axis: Axis) -> Grid | None:
    """Return the axis whose values are told apart by colour."""
    for other in outcome.campaign.varying:
        few = isinstance(other, Grid) and len(other.values) <= _MOST_COLOURS
        if few and isinstance(other, Grid) and other.name != axis.name:
            return other
    return None


def _colours(count: int) -> list[str]:
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    if count == 1:
        return ["C0"]
    return [to_hex(colormaps["viridis"](0.9 * k / (count - 1))) for k in range(count)]


def _labelled(name: str, between: str, unit: str) -> str:
    return f"{name}{between}[{unit}]" if unit else name


def _broken(name: str) -> str:
    """Return a name on two lines if it is wider than a panel."""
    first, dot, last = name.rpartition(".")
    return f"{first}\n{dot}{last}" if len(name) > _WIDEST_NAME else name
