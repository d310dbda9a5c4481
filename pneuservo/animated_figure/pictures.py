"""Pictures of a figure: poses, courses over time, and an animation."""

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from analog_card.files import write_whole
from pneuservo.animated_figure.result import FigureRun
from pneuservo.errors import InputError

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ANIMATIONS = (".gif", ".mp4")
"""What an animation can be written as."""

PICTURES_PER_SECOND = 25
# The frame sways by parts of a millimetre; so much more is shown.
SWAY_SHOWN = 50.0


def draw_courses(run: FigureRun, ax: "Axes", *names: str) -> "Axes":
    """Draw the displacements of axes and their demands.

    Parameters
    ----------
    run : FigureRun
        The run.
    ax : matplotlib.axes.Axes
        Where to draw.
    *names : str
        Of axes; by default all.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    for place, name in enumerate(names or run.axes):
        each, color = run.axes[name], _colour(place)
        ax.plot(run.time, 1e3 * each["demand"], color=color, ls="--", lw=0.7)
        ax.plot(run.time, 1e3 * each["displacement"], color=color, lw=1.0, label=name)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("displacement of the rod [mm]")
    ax.grid(alpha=0.25)
    return ax


def draw_frame(run: FigureRun, ax: "Axes", label: str = "") -> "Axes":
    """Draw the acceleration of the frame.

    Parameters
    ----------
    run : FigureRun
        The run.
    ax : matplotlib.axes.Axes
        Where to draw.
    label : str, optional
        For a legend.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    ax.plot(run.time, run.frame_acceleration, lw=0.8, label=label)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("acceleration of the frame [m/s²]")
    ax.grid(alpha=0.25)
    return ax


def overview(run: FigureRun) -> "Figure":
    """Return a figure of the whole run: rods, valves and frame over time."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 8.0), layout="constrained")
    rods, valves, frame = figure.subplots(3, 1, sharex=True, height_ratios=(2, 1, 1))
    draw_courses(run, rods)
    if len(run.axes) > 1:
        rods.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small", frameon=False)
    for place, each in enumerate(run.axes.values()):
        valves.plot(run.time, each["valve_voltage"], color=_colour(place), lw=0.6)
    valves.set_ylabel("valve [V]")
    valves.grid(alpha=0.25)
    draw_frame(run, frame).set_ylabel("frame [m/s²]")
    rods.set_xlabel("")
    return figure


def write_animation(run: FigureRun, file: str | Path, rate: int = PICTURES_PER_SECOND) -> None:
    """Write the run as a moving stick figure, whole or not at all.

    Parameters
    ----------
    run : FigureRun
        The run.
    file : str or Path
        Ending in .gif, or in .mp4 where the program ffmpeg is installed.
    rate : int, optional
        Pictures per second of the run, which is shown as fast as it is.

    Raises
    ------
    InputError
        When the name ends in something else, or ffmpeg is missing for .mp4.
    """
    from matplotlib.animation import FFMpegWriter, FuncAnimation, PillowWriter

    suffix = require_animation(str(file))
    writer = (PillowWriter if suffix == ".gif" else FFMpegWriter)(fps=rate)
    figure, update = _stage(run)
    shown = np.searchsorted(run.time, np.arange(run.time[0], run.time[-1], 1.0 / rate))
    moving = FuncAnimation(figure, lambda k: update(int(shown[k])), frames=len(shown))
    # The library writes to a name of its own: the whole file then takes its place at once.
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / f"animation{suffix}"
        moving.save(made, writer=writer, dpi=80)
        write_whole(file, made.read_bytes())


def require_animation(file: str, option: str = "animation") -> str:
    """Return the ending of an animation's name that can be written here.

    Parameters
    ----------
    file : str
        Name of the file.
    option : str, optional
        What it was given to, for the message.

    Raises
    ------
    InputError
        When the name ends in something else, or ffmpeg is missing for .mp4.
    """
    suffix = Path(file).suffix.lower()
    if suffix not in ANIMATIONS:
        raise InputError(f"{option} {file}: an animation ends in one of: {', '.join(ANIMATIONS)}")
    if suffix == ".mp4":
        from matplotlib.animation import FFMpegWriter

        if not FFMpegWriter.isAvailable():
            raise InputError(
                f"{option} {file}: .mp4 needs the program ffmpeg, which is not installed; install "
                "it, or write a .gif"
            )
    return suffix


def draw_pose(run: FigureRun, ax: "Axes", moment: float) -> "Axes":
    """Draw where the members are at a moment, the sway of the frame enlarged.

    Parameters
    ----------
    run : FigureRun
        The run.
    ax : matplotlib.axes.Axes
        Where to draw.
    moment : float
        [s].

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    k = min(int(np.searchsorted(run.time, moment)), len(run.time) - 1)
    update = _draw_members(run, ax)
    update(k)
    return ax


def _colour(place: int) -> tuple[float, float, float]:
    """Return the colour of an axis by its place: ten full colours, then a light one of each."""
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb

    shades = [to_rgb(shade) for shade in colormaps["tab20"](range(20))]
    return (shades[0::2] + shades[1::2])[place % len(shades)]


def _draw_members(run: FigureRun, ax: "Axes") -> Callable[[int], list["Artist"]]:
    """Draw the members and return a function that moves them to a sample."""
    places = run.joints()
    shift = (SWAY_SHOWN - 1.0) * run.frame_displacement
    across, up = places[..., 0] + shift[:, None, None], places[..., 1]
    reach = 1.1 * max(float(np.abs(across).max()), 0.15)
    ax.set_xlim(-reach, reach)
    ax.set_ylim(min(1.1 * float(up.min()), -0.1), 1.1 * max(float(up.max()), 0.1))
    ax.set_aspect("equal")
    ax.set_xlabel("across [m]")
    ax.set_ylabel("upwards [m]")
    ax.plot([-0.12, 0.12], [0.0, 0.0], color="0.75", lw=6.0, solid_capstyle="butt")
    (frame,) = ax.plot([], [], color="0.3", lw=6.0, solid_capstyle="butt")
    members = [
        ax.plot([], [], "o-", color=_colour(k), lw=4.0, ms=5.0, label=name)[0]
        for k, name in enumerate(run.axes)
    ]
    text = ax.set_title("", fontsize="small")

    def update(k: int) -> list["Artist"]:
        sway = SWAY_SHOWN * run.frame_displacement[k]
        frame.set_data([sway - 0.12, sway + 0.12], [0.0, 0.0])
        for place, member in enumerate(members):
            member.set_data(across[k, place], up[k, place])
        text.set_text(f"{run.time[k]:.2f} s, sway of the frame x {SWAY_SHOWN:g}")
        return [frame, *members, text]

    return update


def _stage(run: FigureRun) -> tuple["Figure", Callable[[int], list["Artist"]]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    ax = figure.subplots()
    update = _draw_members(run, ax)
    if len(run.axes) <= 7:
        ax.legend(loc="lower right", fontsize="x-small", frameon=False)
    return figure, update
