"""``pneuservo simulate``: replay a recording's command, or close a loop."""

import dataclasses
import io
import json
import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
import numpy as np

from analog_card.console import Quantity
from analog_card.files import write_whole
from analog_card.quantities import to_si
from pneuservo.controllers import CONTROLLERS, AnalogueCard, Controller
from pneuservo.errors import InputError
from pneuservo.naming import nearest
from pneuservo.recordings import CHANNELS, Recording, read_recording, write_recording
from pneuservo.rigs import Rig, load_rig
from pneuservo.simulation import Simulation, replay, simulate, step_demand
from pneuservo.simulation.inputs import require_kind
from pneuservo.simulation.replay import initial_state

_HOLD, _RATE = 0.5, 1000.0
_RECORDING_SUFFIXES = (".csv", ".parquet", ".h5", ".hdf5", ".mat", ".tdms")
_PICTURE_SUFFIXES = (".png", ".svg", ".pdf")
_NUMBER = re.compile(r"[-+]?[.\d]+([eE][-+]?\d+)?")
# Options that shape a controller, and the controllers that take them.
_TUNING = ("settling_time", "damping", "boundary_layer", "level")
_TAKEN = {
    "sliding-mode": _TUNING,
    "proportional": ("gain", "level"),
    "state-feedback": ("gain", "velocity_gain", "acceleration_gain", "level"),
    "analogue-card": (*_TUNING, "design"),
}

EXAMPLES = """\b
Examples:
  pneuservo simulate --controller sliding-mode --demand "15,24,6,15 mm" --out loop.csv
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
@click.option("--settling-time", type=Quantity("s"), help="Of the surface.  [default: 70 ms]")
@click.option("--damping", type=Quantity(""), help="Of the surface.  [default: 1]")
@click.option(
    "--boundary-layer", type=Quantity("m/s**2"), help="0 is a relay.  [default: 5 m/s**2]"
)
@click.option("--level", type=Quantity("V"), help="Largest output.  [default: 5 V]")
@click.option("--gain", type=Quantity(""), help="Of the displacement, in V/V.")
@click.option("--velocity-gain", type=Quantity("s"), help="Of the velocity.")
@click.option("--acceleration-gain", type=Quantity("s**2"), help="Of the acceleration.")
@click.option("--design", metavar="FILE", help="Design of the card; turned as it says, or tuned.")
@click.option("--out", metavar="FILE", help="Write all channels: .csv, .parquet or .h5.")
@click.option("--plot", metavar="FILE", help="Draw the run: .svg, .png or .pdf.")
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
    as_json: bool,
    **shape: Any,
) -> None:
    """Simulate a rig: replay the command of a recording, or close a loop.

    A replay starts from the recording's first sample and holds each sample of the command until
    the next. A closed loop starts at rest at the first set point.
    """
    given = {name: value for name, value in shape.items() if value is not None}
    _require_picture(plot)
    source: Recording | None = None
    if replayed is not None and controller is not None:
        raise InputError(
            "--replay and --controller exclude each other: a replayed command leaves nothing to "
            "control. For the set points of a recording use --controller with --demand RECORDING"
        )
    if replayed is not None:
        _refuse({"demand": demand, "hold": hold, "rate": rate, **given}, "a replay")
        source = _read(replayed, rig)
        result = _replay(source, rig, port)
    elif controller is not None:
        _refuse({"port": port}, "a closed loop")
        law = _controller(controller, given)
        result, source = _closed_loop(law, rig, demand, hold, rate)
    else:
        raise InputError(
            f"say what to simulate: --replay RECORDING, or --controller with one of: "
            f"{', '.join(CONTROLLERS)}"
        )
    _write(result, source, out, plot)
    report = _report(result, source, out, plot)
    if as_json:
        click.echo(json.dumps(_finite(report), indent=2))
    else:
        _print(report)


def _replay(source: Recording, rig_name: str | None, port: str | None) -> Simulation:
    rig = load_rig(rig_name or source.rig)
    if rig.kind == "single-axis" or (rig.kind == "dead-volume" and not rig.effects):
        return replay(source, rig, port, _warn)
    from pneuservo.diagnosis.replay import replay_model

    _refuse({"port": port}, f"a replay on rig {rig.name}")
    return replay_model(source, rig)


def _closed_loop(
    controller: Controller,
    rig_name: str | None,
    demand: str | None,
    hold: float | None,
    rate: float | None,
) -> tuple[Simulation, Recording | None]:
    if demand is None:
        raise InputError('a closed loop needs --demand, such as --demand "15,24,6,15 mm"')
    if Path(demand).suffix.lower() not in _RECORDING_SUFFIXES:
        rig = require_kind(rig_name or "single-axis", "single-axis")
        values = _set_points(demand, rig)
        time, samples = step_demand(values, hold or _HOLD, rate or _RATE)
        return simulate(rig, time=time, controller=controller, demand=samples), None
    _refuse({"hold": hold, "rate": rate}, "a recorded demand")
    source = _read(demand, rig_name)
    if "demand" not in source:
        raise InputError(
            f"{demand}: there is no channel demand; there are: {', '.join(source.channels)}"
        )
    rig = require_kind(rig_name or source.rig, "single-axis").with_conditions(source.conditions)
    start = initial_state(source, rig, _warn)
    result = simulate(
        rig, time=source.time, controller=controller, demand=source["demand"], initial=start
    )
    return result, source


def _controller(name: str, given: Mapping[str, Any]) -> Controller:
    if name not in CONTROLLERS:
        raise InputError(
            f"controller {name!r} is not known; there are: {', '.join(CONTROLLERS)}"
            f"{nearest(name, CONTROLLERS)}"
        )
    for option in given:
        if option not in _TAKEN[name]:
            raise InputError(
                f"{_option(option)} is not an option of the controller {name}; "
                f"it takes: {', '.join(map(_option, _TAKEN[name]))}"
            )
    if name == AnalogueCard.kind:
        return _card(given)
    make: Any = CONTROLLERS[name]
    made: Controller = make(**given)
    return made


def _card(given: Mapping[str, Any]) -> AnalogueCard:
    from analog_card.design_file import load_design
    from analog_card.figures import card_figures
    from analog_card.tuning import tune

    design = load_design(given.get("design"))
    wanted = {name: given[name] for name in _TUNING if name in given}
    if not wanted:
        return AnalogueCard(card_figures(design))
    relay = wanted.get("boundary_layer") == 0.0
    if relay:
        del wanted["boundary_layer"]
    figures = tune(**{"settling_time": 0.07, **wanted, "design": design}).figures
    if relay:
        # The feedback of the boundary-layer amplifier is opened.
        figures = dataclasses.replace(figures, output_gain=math.inf)
    return AnalogueCard(figures)


def _set_points(text: str, rig: Rig) -> list[float]:
    """Return set points [m]; one without a unit has the unit of the last."""
    parts = [part.strip() for part in text.split(",")]
    units = [_NUMBER.sub("", part, count=1).strip() for part in parts]
    stroke = rig["piston.stroke"]
    values = []
    for part, unit in zip(parts, units, strict=True):
        quantity = part if unit or not part else f"{part} {units[-1] or 'm'}"
        value = to_si(quantity, "m", "--demand")
        if not 0.0 <= value <= stroke:
            raise InputError(
                f"--demand: {quantity} is outside the stroke, 0 to {stroke * 1e3:g} mm; "
                'give the unit once or with each, such as "15,24,6,15 mm"'
            )
        values.append(value)
    return values


def _read(path: str, rig: str | None) -> Recording:
    recording = read_recording(path, rig)
    for message in recording.warnings:
        _warn(f"{path}: {message}")
    return recording


def _write(result: Simulation, source: Recording | None, out: str | None, plot: str | None) -> None:
    if out is not None:
        recording = result.to_recording(Path(out).stem)
        # So that the recording that was read is never written over.
        read_from = source.source if source is not None else None
        with _named("--out", out):
            write_recording(dataclasses.replace(recording, source=read_from), out)
    if plot is not None:
        picture = io.BytesIO()
        result.figure().savefig(picture, format=Path(plot).suffix[1:].lower(), dpi=150)
        with _named("--plot", plot):
            write_whole(plot, picture.getvalue())


@contextmanager
def _named(option: str, path: str) -> Iterator[None]:
    try:
        yield
    except OSError as problem:
        raise InputError(
            f"{option} {path}: cannot be written: {problem.strerror}; choose another folder"
        ) from problem


def _report(
    result: Simulation, source: Recording | None, out: str | None, plot: str | None
) -> dict[str, Any]:
    controller = result.controller
    report: dict[str, Any] = {
        "rig": result.rig.name,
        "controller": None,
        "samples": len(result),
        "duration": float(result.time[-1] - result.time[0]),
        "out": out,
        "plot": plot,
    }
    if controller is not None:
        report["controller"] = {"kind": controller.kind, **dataclasses.asdict(controller)}
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

    console = Console(highlight=False)
    console.print(f"{report['samples']} samples over {report['duration']:.4g} s", soft_wrap=True)
    if report.get("steps"):
        table = Table("step at", "to", "rise", "settling", "overshoot", "error at the end")
        for step in report["steps"]:
            table.add_row(
                f"{step['start']:.3g} s",
                f"{step['target'] * 1e3:.4g} mm",
                _milliseconds(step["rise_time"]),
                _milliseconds(step["settling_time"]),
                f"{step['overshoot'] * 100:.1f} %",
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
    for key in ("out", "plot"):
        if report[key]:
            console.print(f"written: {report[key]}", soft_wrap=True, markup=False)


def _milliseconds(seconds: float) -> str:
    return "not reached" if math.isnan(seconds) else f"{seconds * 1e3:.0f} ms"


def _finite(value: Any) -> Any:
    """Return the same with None for what JSON has no number for."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _refuse(options: Mapping[str, Any], what: str) -> None:
    for name, value in options.items():
        if value is not None:
            raise InputError(f"{_option(name)} is not used by {what}; leave it out")


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _require_picture(plot: str | None) -> None:
    if plot is not None and Path(plot).suffix.lower() not in _PICTURE_SUFFIXES:
        raise InputError(f"--plot {plot}: a picture ends in one of: {', '.join(_PICTURE_SUFFIXES)}")


def _warn(message: str) -> None:
    click.echo(f"Warning: {message}", err=True)
