"""The pictures of an identification."""

from typing import TYPE_CHECKING

import numpy as np

from pneuservo.identification.result import Identification

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# For people: a scale and the unit to print, by channel.
_DISPLAY = {
    "displacement": (1e3, "mm"),
    "pressure_a": (1e-5, "bar"),
    "pressure_b": (1e-5, "bar"),
    "force": (1.0, "N"),
}
_MEASURED, _MODELLED = "0.3", "#1f6fb4"


def draw_fit(ax: "Axes", found: Identification, channel: str) -> "Axes":
    """Draw a measured channel and the model of it over time.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    found : Identification
        What was found.
    channel : str
        One of its residuals.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    scale, unit = _DISPLAY[channel]
    model, residual = found.modelled[channel] * scale, found.residual[channel] * scale
    # Several recordings follow one another.
    order = np.arange(len(model)) * float(np.median(np.diff(found.time)))
    ax.plot(order, model + residual, color=_MEASURED, lw=1.6, label="measured")
    ax.plot(order, model, color=_MODELLED, lw=0.9, label="modelled")
    name = "net force of the pressures" if channel == "force" else channel.replace("_", " ")
    ax.set_xlabel("time [s]")
    ax.set_ylabel(f"{name} [{unit}]")
    ax.legend(loc="upper right", fontsize="small")
    return ax


def draw_autocorrelation(ax: "Axes", found: Identification) -> "Axes":
    """Draw the autocorrelation of every residual, with the band of white noise.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    found : Identification
        What was found.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    for name, judged in found.whiteness.items():
        lags = np.arange(1, len(judged.autocorrelation) + 1)
        ax.plot(lags, judged.autocorrelation, "o-", ms=3, label=name.replace("_", " "))
        ax.axhspan(-judged.band, judged.band, color="#bbbbbb", alpha=0.3)
    ax.set_ylim(-1.0, 1.0)
    ax.set_xlabel("lag [samples]")
    ax.set_ylabel("autocorrelation of the residual [-]")
    ax.legend(fontsize="small", title="grey: 95 % band of white noise", title_fontsize="small")
    return ax


def draw_estimates(
    ax: "Axes", found: dict[str, Identification], parameter: str, true: float | None = None
) -> "Axes":
    """Draw one value as several identifications found it, with intervals.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    found : dict of str to Identification
        By label.
    parameter : str
        Which value.
    true : float, optional
        A line to compare with [SI].

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    places = np.arange(len(found))
    values = [entry.values[parameter] for entry in found.values()]
    half = np.nan_to_num([value.half_width for value in values])
    ax.errorbar([v.value for v in values], places, xerr=half, fmt="o", capsize=3, color=_MODELLED)
    if true is not None:
        ax.axvline(true, color="0.5", lw=0.8)
    ax.set_yticks(places, list(found))
    ax.set_xlabel(f"{parameter} [{values[0].unit}]")
    return ax
