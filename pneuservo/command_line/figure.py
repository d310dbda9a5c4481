"""``pneuservo figure``: move an animated figure, and see what its axes do to each other."""

import dataclasses
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import Quantity, progress, warn, writing
from pneuservo.command_line.baseline_rig import warn_of_transducer
from pneuservo.command_line.unused_options import refuse_unused

if TYPE_CHECKING:
    from pneuservo.animated_figure import AnimatedFigure, FigureRun

# What an axis of a figure can be controlled by: what becomes a compiled law.
CONTROLLERS = ("analogue-card", "state-feedback", "sliding-mode", "proportional")
MOTIONS = ("wave", "steps")

EXAMPLES = """\b
Examples:
  pneuservo figure --animation figure.gif
  pneuservo figure --figure arm --controller state-feedback --moved elbow
  pneuservo figure --figure fourteen-axes --without left-hip,right-hip --plot run.svg --json
"""


@click.command("figure", epilog=EXAMPLES)
@click.option(
    "--figure",
    "name",
    default="seven-axes",
    show_default=True,
    help="arm, seven-axes, fourteen-axes, or a figure file.",
)
@click.option("--axes", metavar="LIST", help="Only these axes and what they stand on.")
@click.option("--without", metavar="LIST", help="Not these axes, nor what they carry.")
@click.option(
    "--controller",
    type=click.Choice(CONTROLLERS),
    default=CONTROLLERS[0],
    show_default=True,
    help="Of every axis, all with the same settings.",
)
@click.option(
    "--settling-time", type=Quantity("s"), help="Of the sliding surface.  [default: 70 ms]"
)
@click.option("--boundary-layer", type=Quantity("m/s**2"), help="[default: 5 m/s**2]")
@click.option("--gain", type=Quantity(""), help="Of the displacement, in V/V.")
@click.option("--velocity-gain", type=Quantity("s"), help="Of the velocity.")
@click.option("--acceleration-gain", type=Quantity("s**2"), help="Of the acceleration.")
@click.option(
    "--motion",
    type=click.Choice(MOTIONS),
    default=MOTIONS[0],
    show_default=True,
    help="All axes swing, or one after another steps.",
)
@click.option("--moved", metavar="LIST", help="Only these axes swing; the others are held.")
@click.option(
    "--frequency", type=Quantity("Hz", 0.0), default="1 Hz", show_default=True, help="Of a wave."
)
@click.option(
    "--hold", type=Quantity("s", 0.0), default="0.5 s", show_default=True, help="Between two steps."
)
@click.option(
    "--amplitude",
    type=Quantity(""),
    default="25 %",
    show_default=True,
    help="As a share of each stroke.",
)
@click.option("--duration", type=Quantity("s", 0.0), default="3 s", show_default=True)
@click.option(
    "--rate",
    type=Quantity("Hz", 0.0),
    default="1 kHz",
    show_default=True,
    help="Samples per second.",
)
@click.option("--out", metavar="FOLDER", help="Write a recording of each axis: AXIS.csv.")
@click.option("--plot", metavar="FILE", help="Draw the run: .svg, .png or .pdf.")
@click.option(
    "--animation", metavar="FILE", help="Write a moving picture: .gif, or .mp4 with ffmpeg."
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    name: str,
    axes: str | None,
    without: str | None,
    controller: str,
    motion: str,
    moved: str | None,
    frequency: float,
    hold: float,
    amplitude: float,
    duration: float,
    rate: float,
    out: str | None,
    plot: str | None,
    animation: str | None,
    as_json: bool,
    **shape: float | None,
) -> None:
    """Simulate an animated figure: pneumatic axes coupled through its members and its frame.

    No controller knows of another. Axes can be added and left out; nothing is tuned anew.
    """
    from pneuservo.animated_figure import simulate_figure
    from pneuservo.animated_figure.demand import sampled_time, stepping, waving
    from pneuservo.animated_figure.pictures import overview, require_animation, write_animation
    from pneuservo.loop_controller import loop_controller
    from pneuservo.report.picture_files import require_picture, write_picture

    require_picture("--plot", plot)
    if animation is not None:
        require_animation(animation, "--animation")
    if motion != "wave":
        refuse_unused({"moved": moved}, f"--motion {motion}")
    figure = _figure(name, axes, without)
    for axis, effects in figure.left_out.items():
        warn(f"{axis}: left out of the run: {', '.join(effects)}")
    if out is not None:
        with writing("--out", out):
            _require_files(figure, Path(out))
    given = {key: value for key, value in shape.items() if value is not None}
    loop = loop_controller(controller, given)
    controlled = loop.controller
    for moved_axis in figure.axes.values():
        warn_of_transducer(loop.design, moved_axis.rig)
    time = sampled_time(duration, rate)
    if motion == "wave":
        chosen = _names(moved) if moved is not None else None
        demands = waving(figure, time, frequency, amplitude, chosen)
    else:
        demands = stepping(figure, time, hold, amplitude)
    with progress() as step:
        step(f"{len(figure.axes)} axes over {duration:g} s")
        run = simulate_figure(figure, time=time, controller=controlled, demands=demands)
        if animation is not None:
            step("drawing")
            with writing("--animation", animation):
                write_animation(run, animation)
    if out is not None:
        with writing("--out", out):
            _write_axes(run, Path(out))
    if plot is not None:
        with writing("--plot", plot):
            write_picture(overview(run), plot)
    report = _report(run, controller, {"out": out, "plot": plot, "animation": animation})
    if as_json:
        click.echo(json.dumps(report, indent=2))
    else:
        _print(report)


def _names(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(",") if part.strip())


def _figure(name: str, axes: str | None, without: str | None) -> "AnimatedFigure":
    from pneuservo.animated_figure import load_figure

    figure = load_figure(name)
    if axes is not None:
        figure = figure.only(*_names(axes))
    if without is not None:
        figure = figure.without(*_names(without))
    return figure


def _require_files(figure: "AnimatedFigure", folder: Path) -> None:
    """Refuse a folder in which the recording of one axis cannot be written."""
    from pneuservo.recordings.writer import require_recording_file

    for name in figure.axes:
        require_recording_file(_recording(folder, name))


def _write_axes(run: "FigureRun", folder: Path) -> None:
    from pneuservo.recordings import write_recording

    folder.mkdir(parents=True, exist_ok=True)
    for name, axis in run.axes.items():
        write_recording(axis.to_recording(name), _recording(folder, name))


def _recording(folder: Path, axis: str) -> Path:
    return folder / f"{axis}.csv"


def _report(run: "FigureRun", controller: str, files: dict[str, str | None]) -> dict[str, Any]:
    import numpy as np

    axes = {}
    for name, axis in run.axes.items():
        ripple = run.ripple(name)
        axes[name] = {
            "error_rms": float(np.sqrt(np.mean((axis["demand"] - axis["displacement"]) ** 2))),
            "force_peak": float(np.abs(axis["force"]).max()) if "force" in axis else 0.0,
            "valve_voltage_rms": float(np.sqrt(np.mean(axis["valve_voltage"] ** 2))),
            "ripple": dataclasses.asdict(ripple) if ripple is not None else None,
        }
    return {
        "figure": run.figure.name,
        "controller": controller,
        "duration": float(run.time[-1] - run.time[0]),
        "axes": axes,
        "frame": {
            "acceleration_rms": run.frame_vibration(),
            "displacement_peak": float(np.abs(run.frame_displacement).max()),
        },
        "left_out": {name: list(effects) for name, effects in run.figure.left_out.items()},
        **files,
    }


def _print(report: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    table = Table("axis", "error rms", "largest force at the rod", "moved by others")
    for name, axis in report["axes"].items():
        ripple = axis["ripple"]
        table.add_row(
            name,
            f"{1e3 * axis['error_rms']:.3f} mm",
            f"{axis['force_peak']:.1f} N",
            f"{1e3 * ripple['peak_to_peak']:.3f} mm" if ripple else "",
        )
    console.print(table)
    frame = report["frame"]
    console.print(
        f"frame: {frame['acceleration_rms']:.3g} m/s² rms, sways up to "
        f"{1e3 * frame['displacement_peak']:.3g} mm",
        soft_wrap=True,
    )
    for key in ("out", "plot", "animation"):
        if report[key]:
            console.print(f"written: {report[key]}", soft_wrap=True)
