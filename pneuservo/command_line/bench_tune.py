"""``pneuservo bench-tune``: P1 and P2 against the ideal response, then P3 until all is quiet."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
import numpy as np

from analog_card.console import Quantity, progress, warn
from analog_card.design_file import design_to_toml, load_design
from analog_card.files import write_whole
from analog_card.plain_json import plain_json
from analog_card.tuning import read_settings
from pneuservo.bench_tuning import BenchTuning, bench_tune
from pneuservo.command_line.baseline_rig import baseline_rig, warn_of_transducer
from pneuservo.command_line.recording_files import read, require_unread
from pneuservo.controllers import SlidingMode
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.simulation.replay import initial_state

# Without a recording: the thesis' step, after a moment at rest.
_REST, _STEP, _HOLD, _RATE = 0.015, 0.024, 0.4, 2000.0
_BEFORE = 0.02

EXAMPLES = """\b
Examples:
  pneuservo bench-tune --settling-time 70ms --out tuned.toml
  pneuservo bench-tune --settling-time 80ms --json
"""


@click.command("bench-tune", epilog=EXAMPLES)
@click.option("--design", metavar="FILE", help="The card as it is now; default the recommended.")
@click.option(
    "--recording",
    metavar="FILE",
    help="Its step response, with demand and displacement.  [default: simulated, 15 to 24 mm]",
)
@click.option(
    "--settling-time",
    type=Quantity("s", 0.0),
    default=0.07,
    show_default=True,
    help="Of the ideal digital controller, in s.",
)
@click.option(
    "--damping", type=Quantity("", 0.0), default=1.0, show_default=True, help="Of the same."
)
@click.option("--rig", help="A rig of kind single-axis.  [default: as recorded, or single-axis]")
@click.option("--out", metavar="FILE", help="Write the design with its new settings.")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    design: str | None,
    recording: str | None,
    settling_time: float,
    damping: float,
    rig: str | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Tune a card as on the bench: by its step response against the ideal digital one.

    P1 and P2 are turned until the response lies on the ideal one; then P3 widens the boundary
    layer until no limit cycle is left and the overshoot is at most 2 %.
    """
    card = load_design(design)
    source = None if recording is None else read(recording, rig)
    if out is not None:
        require_unread([Path(out)], [] if source is None else [source], design, rig)
    ideal = SlidingMode(settling_time, damping)
    with progress() as step:
        if source is None:
            time = np.arange(0.0, _BEFORE + _HOLD, 1.0 / _RATE)
            demand = np.where(time < _BEFORE, _REST, _STEP)
            used = baseline_rig(rig or "single-axis")
            warn_of_transducer(card, used)
            found = bench_tune(card, ideal, time, demand, rig=used, step=step)
        else:
            found = _from_recording(source, card, ideal, rig, step)
    if out is not None:
        write_whole(out, design_to_toml(found.design))
    report = _report(found, out)
    if as_json:
        click.echo(json.dumps(plain_json(report), indent=2))
    else:
        _print(report)


def _from_recording(
    source: Recording, card: Any, ideal: SlidingMode, rig: str | None, step: Any
) -> Any:
    for channel in ("demand", "displacement"):
        if channel not in source:
            raise InputError(
                f"{source.source}: there is no channel {channel}; there are: "
                f"{', '.join(source.channels)}"
            )
    used = baseline_rig(rig or source.rig).with_conditions(source.conditions)
    warn_of_transducer(card, used)
    start = initial_state(source, used, warn)
    return bench_tune(
        card,
        ideal,
        source.time,
        source["demand"],
        recorded=source["displacement"],
        rig=used,
        initial=start,
        step=step,
    )


def _report(found: BenchTuning, out: str | None) -> dict[str, Any]:
    tuning = read_settings(found.design)
    return {
        "settings": {
            item.name: {"fraction": item.fraction, "ohm": item.resistance}
            for item in tuning.potentiometers
        },
        "achieved": tuning.achieved,
        "difference": {"before": found.match.before, "after": found.match.after},
        "boundary_layers": [{"width": width, "quiet": quiet} for width, quiet in found.tried],
        "response": asdict(found.response),
        "criterion": "no limit cycle, overshoot at most 2 %",
        "out": out,
    }


def _print(report: dict[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    table = Table("", "travel", "resistance")
    for name, setting in report["settings"].items():
        table.add_row(name, f"{100 * setting['fraction']:.1f} %", f"{setting['ohm']:.0f} ohm")
    console.print(table)
    difference = report["difference"]
    console.print(
        f"difference from the ideal response: {1e6 * difference['before']:.0f} um rms before, "
        f"{1e6 * difference['after']:.0f} um after P1 and P2",
        soft_wrap=True,
    )
    console.print(
        f"boundary layer {report['achieved']['boundary_layer']:.3g} m/s2, the narrowest with "
        f"{report['criterion']}; overshoot {100 * report['response']['overshoot']:.1f} %",
        soft_wrap=True,
    )
    if report["out"]:
        console.print(f"written: {report['out']}", soft_wrap=True)
