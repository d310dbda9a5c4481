"""The picture of a tuning: its front, and the settings along it."""

from typing import TYPE_CHECKING, Any

import numpy as np

from pneuservo.campaign.summary import shown_unit
from pneuservo.tuning.evaluation import RESOLUTION, Worst
from pneuservo.tuning.problem import POTENTIOMETERS
from pneuservo.tuning.run import RobustTuning
from pneuservo.tuning.summary import shown_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RESOLVED = RESOLUTION["chatter"]
_ALONG, _AGAINST = "settling_time", ("control_effort", "chatter")


def draw_front(ax: "Axes", found: RobustTuning, figure: str) -> "Axes":
    """Draw a figure of the front against its settling time, each in the worst rig of the set.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    found : RobustTuning
        What was found.
    figure : str
        One of the objectives.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled; what else was tried within the limits is drawn too.
    """
    rest = [each for each in found.tried if each.feasible(found.problem)]
    layers: list[tuple[list[Worst], dict[str, Any], str]] = [
        (rest, {"color": "0.8", "s": 6}, "tried, within the limits"),
        (found.front, {"color": "C0", "s": 14}, "front"),
        ([found.chosen], {"color": "C3", "s": 110, "marker": "*"}, "recommended"),
    ]
    for several, style, label in layers:
        x, y = (
            [shown_figure(name, each.figures[name]) for each in several]
            for name in (_ALONG, figure)
        )
        ax.scatter(x, y, label=label, **style)
    if figure == "chatter":
        # From what the valve's dead band swallows to the whole of its range.
        ax.set_yscale("symlog", linthresh=_RESOLVED)
        ax.set_ylim(bottom=0.0)
    ax.set_ylabel(f"{figure.replace('_', ' ')} [{shown_unit(figure)}]")
    ax.grid(alpha=0.3)
    return ax


def draw_settings(ax: "Axes", found: RobustTuning) -> "Axes":
    """Draw the settings of the front against its settling time.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    found : RobustTuning
        What was found.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    x = [shown_figure(_ALONG, each.figures[_ALONG]) for each in found.front]
    settings = np.array([each.settings for each in found.front])
    for name, values in zip(POTENTIOMETERS, settings.T, strict=True):
        ax.plot(x, values, ".", label=name)
    ax.set_ylim(0.0, 1.0)
    ax.set_ylabel("fraction of travel")
    ax.grid(alpha=0.3)
    return ax


def tuning_figure(found: RobustTuning) -> "Figure":
    """Return a figure of the front and of the settings along it.

    Parameters
    ----------
    found : RobustTuning
        What was found.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; save it with its ``savefig``.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 8.0), layout="constrained")
    panels = figure.subplots(len(_AGAINST) + 1, 1, sharex=True)
    for ax, name in zip(panels, _AGAINST, strict=False):
        draw_front(ax, found, name)
    draw_settings(panels[-1], found)
    panels[0].legend(fontsize="small")
    panels[-1].legend(fontsize="small", ncols=4)
    times = [shown_figure(_ALONG, each.figures[_ALONG]) for each in found.front]
    # What is slower than the whole front is of no interest.
    margin = 0.05 * (max(times) - min(times)) + 1.0
    panels[-1].set_xlim(min(times) - margin, max(times) + margin)
    panels[-1].set_xlabel(f"settling time in the worst rig [{shown_unit(_ALONG)}]")
    return figure
