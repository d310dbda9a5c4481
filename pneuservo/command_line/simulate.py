"""``pneuservo simulate``: replay a recording's command, or close a loop."""

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import numpy as np

from analog_card.behaviour import Imperfections
from analog_card.console import Count, Quantity, warn, writing
from analog_card.plain_json import plain_json
from pneuservo.command_line.baseline_rig import warn_of_transducer, without_effects
from pneuservo.command_line.recording_files import read
from pneuservo.command_line.unused_options import refuse_unused
from pneuservo.controllers import CONTROLLERS, controller_settings
from pneuservo.errors import InputError
from pneuservo.loop_controller import (
    CARDS,
    UNITS,
    LoopController,
    loop_controller,
    written,
)
from pneuservo.recordings import CHANNELS, Recording, write_recording
from pneuservo.recordings.writer import require_recording_file
from pneuservo.report.picture_files import require_picture, write_picture
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import Simulation, replay, step_demand
from pneuservo.simulation.demand import HOLD, RATE, names_recording, set_points
from pneuservo.simulation.inputs import require_kind
from pneuservo.simulation.phase_plane import require_surface
from pneuservo.simulation.replay import initial_state

EXAMPLES = """\b
Examples:
  pneuservo simulate --controller sliding-mode --demand "15,24,6,15 mm" --out loop.csv
  pneuservo simulate --controller analogue-card --card behaviour --demand "15,24 mm"
  pneuservo simulate --controller hybrid-sliding-mode --sampling-time 2ms --demand "15,24 mm"
  pneuservo simulate --replay loop.csv --out replayed.csv
"""


@click.command("simulate", epilog=EXAMPLES)
@click.option("--rig", help="A built-in rig or a rig file.  [default: as recorded, or single-axis]")
@click.option("--replay", "replayed", metavar="RECORDING", help="Replay its valve_voltage.")
@click.option("--port", type=click.Choice(["a", "b"]), help="Where a test volume is connected.")
@click.option("--controller", metavar="NAME", help=f"Close the loop: {', '.join(CONTROLLERS)}.")
@click.option("--demand", metavar="LIST|RECORDING", help='Set points, such as "15,24,6,15 mm".')
@click.option("--hold", type=Quantity("s", 0.0), help="Time at each set point.  [default: 0.5 s]")
@click.option("--rate", type=Quantity("Hz", 0.0), help="Samples per second.  [default: 1 kHz]")
@click.option(
    "--settling-time",
    type=Quantity(UNITS["settling_time"]),
    help="Of the surface.  [default: 70 ms]",
)
@click.option("--damping", type=Quantity(UNITS["damping"]), help="Of the surface.  [default: 1]")
@click.option(
    "--boundary-layer",
    type=Quantity(UNITS["boundary_layer"]),
    help="0 is a relay.  [default: 5 m/s**2]",
)
@click.option("--level", type=Quantity(UNITS["level"]), help="Largest output.  [default: 5 V]")
@click.option("--gain", type=Quantity(UNITS["gain"]), help="Of the displacement, in V/V.")
@click.option("--velocity-gain", type=Quantity(UNITS["velocity_gain"]), help="Of the velocity.")
@click.option(
    "--acceleration-gain", type=Quantity(UNITS["acceleration_gain"]), help="Of the acceleration."
)
@click.option(
    "--sampling-time",
    type=Quantity(UNITS["sampling_time"]),
    help="Of a controller on a computer.  [default: 1 ms]",
)
@click.option(
    "--accelerometer/--no-accelerometer",
    default=None,
    help="Whether a controller on a computer has one, or takes differences.",
)
@click.option(
    "--reaching-share",
    type=Quantity(UNITS["reaching_share"]),
    help="Of the switching function, taken away in each sample.  [default: 0.2]",
)
@click.option(
    "--design",
    metavar="FILE",
    help="Design of the card; where nothing is asked for it stays turned as it says.",
)
@click.option(
    "--card",
    type=click.Choice(CARDS),
    help="What the card is simulated by: its nominal figures, its behaviour with every "
    "imperfection, or its circuit in ngspice.  [default: figures]",
)
@click.option(
    "--without",
    multiple=True,
    type=click.Choice([item.name.replace("_", "-") for item in dataclasses.fields(Imperfections)]),
    help="Leave an imperfection out of the card's behaviour; may be repeated.",
)
@click.option(
    "--seed",
    type=Count(min=0),
    default=0,
    help="Of the noise that the rig's transducers or converters have.  [default: 0]",
)
@click.option("--out", metavar="FILE", help="Write all channels: .csv, .parquet or .h5.")
@click.option("--plot", metavar="FILE", help="Draw the run: .svg, .png or .pdf.")
@click.option(
    "--phase-plane",
    metavar="FILE",
    help="Draw the phase plane with sliding surface and boundary layer: .svg, .png or .pdf.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    rig: str | None,
    replayed: str | None,
    port: str | None,
    controller: str | None,
    demand: str | None,
    hold: float | None,
    rate: float | None,
    out: str | None,
    plot: str | None,
    phase_plane: str | None,
    as_json: bool,
    without: tuple[str, ...],
    seed: int,
    **shape: Any,
) -> None:
    """Simulate a rig: replay the command of a recording, or close a loop.

    A replay starts from the recording's first sample and holds each sample of the command until
    the next. A closed loop starts at rest at the first set point.
    """
    given = {name: value for name, value in shape.items() if value is not None}
    if without:
        given["without"] = tuple(name.replace("-", "_") for name in without)
    require_picture("--plot", plot)
    require_picture("--phase-plane", phase_plane)
    if out is not None:
        require_recording_file(out)
    source: Recording | None = None
    loop: LoopController | None = None
    if replayed is not None and controller is not None:
        raise InputError(
            "--replay and --controller exclude each other: a replayed command leaves nothing to "
            "control. For the set points of a recording use --controller with --demand RECORDING"
        )
    if replayed is not None:
        refuse_unused(
            {"demand": demand, "hold": hold, "rate": rate, "phase_plane": phase_plane, **given},
            "a replay",
        )
        source = read(replayed, rig)
        result = _replay(source, rig, port, seed)
    elif controller is not None:
        refuse_unused({"port": port}, "a closed loop")
        loop = loop_controller(controller, given)
        if phase_plane is not None:
            require_surface(loop.controller)
        result, source = _closed_loop(loop, rig, demand, hold, rate, seed)
    else:
        raise InputError(
            f"say what to simulate: --replay RECORDING, or --controller with one of: "
            f"{', '.join(CONTROLLERS)}"
        )
    files = {"out": out, "plot": plot, "phase_plane": phase_plane}
    _write(result, source, loop, files)
    report = _report(result, source, files)
    if as_json:
        click.echo(json.dumps(plain_json(report), indent=2))
    else:
        _print(report)


def _replay(source: Recording, rig_name: str | None, port: str | None, seed: int) -> Simulation:
    rig = load_rig(rig_name or source.rig)
    if rig.kind == "single-axis" or (rig.kind == "dead-volume" and not rig.effects):
        return replay(source, rig, port, warn, seed)
    from pneuservo.diagnosis.replay import replay_model

    refuse_unused({"port": port}, f"a replay on rig {rig.name}")
    return replay_model(source, rig)


def _closed_loop(
    loop: LoopController,
    rig_name: str | None,
    demand: str | None,
    hold: float | None,
    rate: float | None,
    seed: int,
) -> tuple[Simulation, Recording | None]:
    if demand is None:
        raise InputError('a closed loop needs --demand, such as --demand "15,24,6,15 mm"')
    if not names_recording(demand):
        rig = _rig_of_loop(loop, rig_name or "single-axis")
        values = set_points(demand, rig["piston.stroke"], "--demand")
        time, samples = step_demand(values, hold or HOLD, rate or RATE)
        return loop.run(rig, time, samples, seed=seed), None
    refuse_unused({"hold": hold, "rate": rate}, "a recorded demand")
    source = read(demand, rig_name)
    if "demand" not in source:
        raise InputError(
            f"{demand}: there is no channel demand; there are: {', '.join(source.channels)}"
        )
    rig = _rig_of_loop(loop, rig_name or source.rig).with_conditions(source.conditions)
    start = initial_state(source, rig, warn)
    return loop.run(rig, source.time, source["demand"], start, seed), source


def _rig_of_loop(loop: LoopController, name: str) -> Rig:
    """Return a rig as a controller can drive it, and warn of a card made for another."""
    rig = require_kind(name, "single-axis", effects=True)
    warn_of_transducer(loop.design, rig)
    return without_effects(rig, name) if loop.drives_baseline_only else rig


def _write(
    result: Simulation,
    source: Recording | None,
    loop: LoopController | None,
    files: Mapping[str, str | None],
) -> None:
    if files["out"] is not None:
        recording = result.to_recording(Path(files["out"]).stem)
        # So that the recording that was read is never written over.
        read_from = source.source if source is not None else None
        title = loop.title if loop else recording.title
        with writing("--out", files["out"]):
            write_recording(
                dataclasses.replace(recording, source=read_from, title=title), files["out"]
            )
    for option, draw in (("plot", result.figure), ("phase_plane", result.phase_plane)):
        file = files[option]
        if file is not None:
            with writing(written(option), file):
                write_picture(draw(), file)


def _report(
    result: Simulation,
    source: Recording | None,
    files: Mapping[str, str | None],
) -> dict[str, Any]:
    controller = result.controller
    report: dict[str, Any] = {
        "rig": result.rig.name,
        "controller": None,
        "samples": len(result),
        "duration": float(result.time[-1] - result.time[0]),
        **files,
    }
    if controller is not None:
        report["controller"] = {"kind": controller.kind, **controller_settings(controller)}
        report["steps"] = [dataclasses.asdict(step) for step in result.step_responses()]
        report["steady_state_error"] = result.steady_state_error()
        cycle = result.limit_cycle()
        report["limit_cycle"] = dataclasses.asdict(cycle) if cycle else None
    if source is not None:
        report["difference"] = {
            name: {
                "rms": float(np.sqrt(np.nanmean((source[name] - result[name]) ** 2))),
                "unit": CHANNELS[name].unit,
            }
            for name in result.channels
            if name in source
            and name not in ("demand", "valve_voltage" if controller is None else "demand")
        }
    return report


def _print(report: Mapping[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    console.print(f"{report['samples']} samples over {report['duration']:.4g} s", soft_wrap=True)
    if report.get("steps"):
        table = Table("step at", "to", "rise", "settling", "overshoot", "error at the end")
        for step in report["steps"]:
            table.add_row(
                f"{step['start']:.3g} s",
                f"{step['target'] * 1e3:.4g} mm",
                _milliseconds(step["rise_time"]),
                _milliseconds(step["settling_time"]),
                _percent(step["overshoot"]),
                f"{step['steady_state_error'] * 1e3:.4f} mm",
            )
        console.print(table)
    if report["controller"] is not None:
        cycle = report["limit_cycle"]
        text = f"{cycle['frequency']:.1f} Hz" if cycle else "none"
        console.print(f"limit cycle at the last set point: {text}", soft_wrap=True)
    if report.get("difference"):
        table = Table("channel", "rms difference from the recording")
        for name, entry in report["difference"].items():
            table.add_row(name, f"{entry['rms']:.3g} {entry['unit']}".strip())
        console.print(table)
    for key in ("out", "plot", "phase_plane"):
        if report[key]:
            console.print(f"written: {report[key]}", soft_wrap=True)


def _milliseconds(seconds: float) -> str:
    return "not reached" if math.isnan(seconds) else f"{seconds * 1e3:.0f} ms"


def _percent(share: float) -> str:
    return "no answer" if math.isnan(share) else f"{share * 100:.1f} %"
