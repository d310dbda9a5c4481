"""Pictures of a run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from pneuservo.errors import InputError
from pneuservo.recordings import CHANNELS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pneuservo.simulation.result import Simulation

# SI unit to the unit people read, and the factor from one to the other.
_SHOWN = {"m": ("mm", 1e3), "Pa": ("bar", 1e-5), "m/s**2": ("m/s²", 1.0)}
_PANELS = (
    ("demand", "displacement"),
    ("dead_volume_pressure",),
    ("velocity",),
    ("pressure_a", "pressure_b"),
    ("valve_voltage",),
)
_QUANTITY = {"m": "displacement", "Pa": "absolute pressure", "V": "voltage", "m/s": "velocity"}


def draw_channels(simulation: "Simulation", ax: "Axes", channels: Sequence[str] = ()) -> "Axes":
    """Draw channels of one unit over time.

    Parameters
    ----------
    simulation : Simulation
        The run.
    ax : matplotlib.axes.Axes
        Where to draw.
    channels : sequence of str, optional
        Names of channels; by default demand and displacement, as far as there are.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.

    Raises
    ------
    InputError
        When the run lacks a channel, or the channels have different units.
    """
    names = list(channels) or [name for name in _PANELS[0] if name in simulation]
    names = names or [list(simulation.channels)[-1]]
    for name in names:
        if name not in simulation:
            raise InputError(
                f"the run has no channel {name!r}; it has: {', '.join(simulation.channels)}"
            )
    units = {CHANNELS[name].unit for name in names}
    if len(units) > 1:
        raise InputError(f"{', '.join(names)} have different units and need axes of their own")
    unit = units.pop()
    shown, factor = _SHOWN.get(unit, (unit, 1.0))
    for name in names:
        # A held set point changes at once.
        held = name == "demand"
        ax.plot(
            simulation.time,
            factor * simulation[name],
            label=name.replace("_", " "),
            lw=1.0,
            color="0.5" if held else None,
            drawstyle="steps-post" if held else "default",
        )
    quantity = _QUANTITY.get(unit, names[0].replace("_", " "))
    ax.set_ylabel(f"{quantity} [{shown}]" if shown else quantity)
    ax.set_xlabel("time [s]")
    ax.grid(alpha=0.3)
    if len(names) > 1:
        ax.legend(loc="best", fontsize="small", frameon=False)
    return ax


def overview(simulation: "Simulation") -> "Figure":
    """Return a figure of a whole run, one panel per kind of quantity.

    Parameters
    ----------
    simulation : Simulation
        The run.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; save it with its ``savefig``.
    """
    from matplotlib.figure import Figure

    panels = [[name for name in panel if name in simulation] for panel in _PANELS]
    panels = [panel for panel in panels if panel]
    figure = Figure(figsize=(8.0, 2.0 * len(panels) + 0.6), layout="constrained")
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for ax, panel in zip(axes, panels, strict=True):
        draw_channels(simulation, ax, panel)
        ax.label_outer()
    return figure
