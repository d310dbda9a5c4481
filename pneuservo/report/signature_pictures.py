"""Pictures of signatures, and the page of a whole catalogue."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analog_card.files import write_whole
from pneuservo.arrays import Array
from pneuservo.effects import Effect
from pneuservo.recordings import CHANNELS
from pneuservo.report.picture_files import write_picture
from pneuservo.report.signature_runs import runs_of
from pneuservo.report.signatures import Signature, signature_of
from pneuservo.report.svg import BASELINE, GUILTY, MEASURED, REPAIRED
from pneuservo.report.words import quantity
from pneuservo.rigs import load_rig
from pneuservo.thinning import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_RUN = {"m": ("mm", 1e3), "Pa": ("bar", 1e-5)}
_CHANGE = {"m": ("µm", 1e6), "Pa": ("kPa", 1e-3), "V": ("mV", 1e3)}
_PUSHING = ("piston", "load", "endstop")
"""Blocks that act by a force, which the pressures have to make up for."""
_PANEL = 1.7
"""Height of a panel [in]."""


def signature_figure(signature: Signature) -> "Figure":
    """Return the picture of a signature: the run, faint, and below it what the effect changes.

    Parameters
    ----------
    signature : Signature
        The two runs.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window; write it with `pneuservo.report.picture_files.write_picture`.
    """
    from matplotlib.figure import Figure

    panels = _panels(signature)
    figure = Figure(figsize=(7.5, _PANEL * (len(panels) + 1) + 0.5), layout="constrained")
    axes = figure.subplots(len(panels) + 1, 1, sharex=True)
    draw_run(signature, axes[0])
    for ax, (label, unit, curves) in zip(axes[1:], panels, strict=True):
        draw_change(signature.time, label, unit, curves, ax)
    for ax in axes:
        ax.label_outer()
    units = {p.name: p.unit for p in signature.effect.parameters}
    shape = ", ".join(f"{n} = {quantity(v, units[n])}" for n, v in signature.values.items())
    figure.suptitle(f"{signature.effect.id}: {shape}", fontsize="medium", wrap=True)
    return figure


def draw_run(signature: Signature, ax: "Axes") -> "Axes":
    """Draw the run itself, with the effect and without, in the channel that tells most.

    Parameters
    ----------
    signature : Signature
        The two runs.
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    channel = _leading(signature)
    unit, factor = _RUN.get(CHANNELS[channel].unit, (CHANNELS[channel].unit, 1.0))
    for run, colour, label in (
        (signature.without, MEASURED, "without"),
        (signature.present, GUILTY, "with the effect"),
    ):
        time, samples = thinned(signature.time, factor * run[channel])
        ax.plot(time, samples, color=colour, alpha=0.45, lw=1.2, label=label)
    return _labelled(ax, f"{_words(channel)}\n[{unit}]")


def draw_change(time: Array, label: str, unit: str, curves: dict[str, Array], ax: "Axes") -> "Axes":
    """Draw what an effect changes in one kind of quantity.

    Parameters
    ----------
    time : (n,) array
        [s].
    label, unit : str
        The quantity and its SI unit.
    curves : dict of str to (n,) array
        What changes by how much, with effect minus without [SI].
    ax : matplotlib.axes.Axes
        Where to draw.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, labelled.
    """
    shown, factor = _CHANGE.get(unit, (unit, 1.0))
    for (name, change), colour in zip(curves.items(), (REPAIRED, BASELINE), strict=False):
        ax.plot(*thinned(time, factor * change), color=colour, lw=1.0, label=name)
    return _labelled(ax, f"{label}\nchanges [{shown}]")


def write_catalogue(
    kind: str,
    effects: Iterable[Effect],
    folder: Path,
    progress: Callable[[str], None] = lambda step: None,
) -> list[Path]:
    """Write a picture of every effect's signature, and ``index.html`` that shows them all.

    Parameters
    ----------
    kind : str
        Kind of rig.
    effects : iterable of Effect
        What it can show.
    folder : Path
        Where to; made if need be.
    progress : callable, optional
        Told which effect is being drawn.

    Returns
    -------
    list of Path
        The files, the page last.
    """
    runs, effects, files = runs_of(kind), tuple(effects), []
    folder.mkdir(parents=True, exist_ok=True)
    for effect in effects:
        progress(effect.id)
        files.append(folder / picture_name(effect))
        write_picture(signature_figure(signature_of(effect, kind, runs)), files[-1])
    write_whole(folder / "index.html", catalogue_page(kind, effects))
    return [*files, folder / "index.html"]


def picture_name(effect: Effect) -> str:
    """Return the name of the file that shows an effect on the page of its catalogue."""
    return f"{effect.id}.svg"


def catalogue_page(kind: str, effects: Iterable[Effect]) -> str:
    """Return the page that shows the effects of a kind of rig, with their pictures beside it.

    Parameters
    ----------
    kind : str
        Kind of rig.
    effects : iterable of Effect
        What it can show.

    Returns
    -------
    str
        HTML; its pictures are the files by `picture_name` in the same folder.
    """
    from pneuservo.report.page import render

    shown = [(effect, picture_name(effect)) for effect in effects]
    return render("catalogue_page.html", rig=load_rig(kind), effects=shown)


def _panels(signature: Signature) -> list[tuple[str, str, dict[str, Array]]]:
    """Return label, SI unit and curves of each panel; what does not change has none."""
    if "displacement" not in signature.without:
        return [
            (_words(channel), CHANNELS[channel].unit, {_words(channel): signature.change(channel)})
            for channel in signature.without
            if np.any(signature.change(channel))
        ]
    moved, side_a, side_b = (
        signature.change(channel) for channel in ("displacement", "pressure_a", "pressure_b")
    )
    panels = [
        ("displacement", "m", {"displacement": moved}),
        ("pressures", "Pa", {"pressure a": side_a, "pressure b": side_b}),
    ]
    if signature.effect.block in _PUSHING:
        rig = load_rig("single-axis")
        push = rig["piston.area_a"] * side_a - rig["piston.area_b"] * side_b
        panels.append(("force of the pressures", "N", {"force of the pressures": push}))
    return panels


def _leading(signature: Signature) -> str:
    """Return the channel in which the run is shown: the motion, or what changes most."""
    if "displacement" in signature.without:
        return "displacement"
    return max(signature.without, key=lambda name: float(np.ptp(signature.change(name))))


def _words(channel: str) -> str:
    return channel.replace("_", " ")


def _labelled(ax: "Axes", label: str) -> "Axes":
    ax.set_ylabel(label)
    ax.set_xlabel("time [s]")
    ax.grid(alpha=0.3)
    if len(ax.lines) > 1:
        ax.legend(
            fontsize="small",
            frameon=False,
            ncols=2,
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            borderaxespad=0.0,
        )
    return ax
