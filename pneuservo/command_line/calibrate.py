"""``pneuservo calibrate``: a valve or a leak from the pressure of a dead volume."""

import json
from pathlib import Path
from typing import Any

import click
import tomli_w

from analog_card.console import Count, Quantity, progress, warn
from analog_card.files import write_whole
from pneuservo.command_line.recording_files import Window, read, require_unread
from pneuservo.errors import InputError

_EPILOG = """\b
Examples:
  pneuservo calibrate --simulate --out out/calibration
  pneuservo calibrate out/calibration/recordings/s_a-5V.csv --json
"""


@click.command("calibrate", epilog=_EPILOG)
@click.argument("recordings", nargs=-1, metavar="[REC ...]")
@click.option("--simulate", "simulated", is_flag=True, help="Simulate the experiment instead.")
@click.option("--rig", help="Rig name or rig file, in place of the one the recordings name.")
@click.option("--window", type=Window(), help="Use only this stretch of the recordings [s].")
@click.option(
    "--index",
    type=Quantity("", 0.0),
    help="Polytropic index assumed.  [default: the rig's; 1 for a leak]",
)
@click.option(
    "--reference",
    type=Quantity("", 0.0),
    default=0.8,
    show_default=True,
    help="Coefficient of choked flow at full opening that the areas are worked out with.",
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("out/calibration"),
    show_default=True,
    help="Folder for the answer.",
)
@click.option(
    "--seed", type=Count(min=0), default=0, show_default=True, help="Seed of simulated noise."
)
@click.option("--jobs", type=Count(1), default=1, show_default=True, help="Processes.")
@click.option("--json", "as_json", is_flag=True, help="Print calibration.json and nothing else.")
def command(
    recordings: tuple[str, ...],
    simulated: bool,
    rig: str | None,
    window: tuple[float, float] | None,
    index: float | None,
    reference: float,
    out: Path,
    seed: int,
    jobs: int,
    as_json: bool,
) -> None:
    """Find discharge coefficients and areas from charging or discharging a dead volume.

    Each recording holds one command, or none when a closed volume only leaks. Writes
    calibration.json, valve.toml (the tables of the valve, when there is one), coefficients.svg and
    transients.svg.
    """
    from pneuservo.calibration import calibrate, transient_of

    if simulated == bool(recordings):
        raise InputError("give recordings of a dead volume, or --simulate for simulated ones")
    with progress() as step:
        step("reading the recordings")
        used = _recordings(recordings, simulated, rig, window, seed, out)
        found = calibrate([transient_of(entry, rig) for entry in used], index, jobs, step)
        step("drawing")
        answer = _document(found, reference)
        answer["valve"] = _write(found, answer, out)
    if as_json:
        click.echo(json.dumps(answer, indent=2))
    else:
        _print(answer, out)


def _recordings(
    paths: tuple[str, ...],
    simulated: bool,
    rig: str | None,
    window: tuple[float, float] | None,
    seed: int,
    out: Path,
) -> Any:
    from pneuservo.rigs import load_rig

    answers = [out / "valve.toml", out / "calibration.json"]
    if simulated:
        from pneuservo.calibration.experiment import COMMANDS, simulate_transient
        from pneuservo.plant.flow_paths import FLOW_PATHS
        from pneuservo.recordings import write_recording

        name = rig or "dead-volume"
        require_unread(answers, [], name, load_rig(name).valve)
        for number, path in enumerate(FLOW_PATHS):
            for volts in COMMANDS:
                made = simulate_transient(
                    path, volts, rig=name, seed=[seed, number, int(10 * volts)]
                )
                write_recording(made, out / "recordings" / f"{made.name}.csv")
                yield made
        return
    for path in paths:
        recording = read(path, rig, window)
        require_unread(answers, [recording], load_rig(recording.rig).valve)
        yield recording


def _document(found: Any, reference: float) -> dict[str, Any]:
    from pneuservo.calibration.table import cannot_tell_apart
    from pneuservo.calibration.transient import LEAK
    from pneuservo.identification.whiteness import whiteness

    rows = []
    for row in found.rows:
        judged = whiteness(row.residual)
        leak = row.path == LEAK
        rows.append(
            {
                "recording": row.transient.name,
                "path": row.path,
                "command": None if leak else row.command,
                "polytropic_index": row.polytropic_index,
                "quantity": "effective area" if leak else "discharge coefficient",
                "unit": "m**2" if leak else "",
                "points": [
                    {
                        "pressure_ratio": float(ratio),
                        "value": float(value),
                        "low": max(float(value - half), 0.0) if seen else None,
                        "high": float(value + half) if seen else None,
                    }
                    for ratio, value, half, seen in zip(
                        row.pressure_ratio, row.coefficient, row.half_width, row.visible,
                        strict=True,
                    )
                ],
                "seen_from": float(row.curve.pressure_ratio.min()),
                "seen_to": float(row.curve.pressure_ratio.max()),
                "residual_rms": float((row.residual**2).mean() ** 0.5),
                "noise_rms": row.transient.noise_rms,
                "residual": {
                    "white": judged.white,
                    "probability": judged.probability,
                    "statement": judged.sentence(),
                },
            }
        )  # fmt: skip
    areas = {
        path: {"value": area.value, "low": area.low, "high": area.high, "unit": "m**2"}
        for path, area in found.areas(reference).items()
    }
    return {
        "schema": 1,
        "rows": rows,
        "areas": areas,
        "reference_coefficient": reference,
        "cannot_tell_apart": cannot_tell_apart(found.rows),
    }


def _write(found: Any, answer: dict[str, Any], out: Path) -> str | None:
    from pneuservo.calibration.pictures import draw_coefficients, draw_transients
    from pneuservo.calibration.table import valve_document
    from pneuservo.calibration.transient import LEAK
    from pneuservo.report.svg import draw

    groups = [list(rows) for rows in found.of_paths.values()]
    groups += [[row] for row in found.rows if row.path == LEAK]
    pictures = {}
    for name, paint in (("coefficients", draw_coefficients), ("transients", draw_transients)):

        def all_groups(axes: Any, paint: Any = paint) -> None:
            for ax, rows in zip(axes if isinstance(axes, list) else [axes], groups, strict=False):
                paint(ax, rows)

        columns = 1 if len(groups) == 1 else 2
        shape = (-(-len(groups) // columns), columns)
        size = (6.0 * columns, 4.0 * shape[0])
        pictures[name] = draw(all_groups, size=size, shape=shape)
    tables = None
    if found.of_paths:
        rig = found.rows[0].transient.rig
        try:
            tables = tomli_w.dumps(valve_document(found.tables(rig), "pneuservo calibrate"))
        except InputError as problem:
            warn(f"no valve.toml: {problem}")
    valve = None
    if tables is not None:
        valve = str(write_whole(out / "valve.toml", tables))
    for name, text in pictures.items():
        write_whole(out / f"{name}.svg", text)
    write_whole(out / "calibration.json", json.dumps({**answer, "valve": valve}, indent=2) + "\n")
    return valve


def _print(answer: dict[str, Any], out: Path) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)
    table = Table("recording", "path", "pressure ratio: value ± half of the 95 % interval", "rms")
    for row in answer["rows"]:
        scale = 1e6 if row["unit"] else 1.0
        points = [
            f"{p['pressure_ratio']:.2f}: {scale * p['value']:.3g}"
            + (
                " not decided"
                if p["high"] is None
                else f" ± {scale * (p['high'] - p['value']):.1g}"
            )
            for p in row["points"]
            if p["pressure_ratio"] > 0.0
        ]
        what = row["path"] + (" [mm²]" if row["unit"] else "")
        table.add_row(row["recording"], what, "; ".join(points), f"{row['residual_rms']:.0f} Pa")
    console.print(table)
    if answer["areas"]:
        areas = Table("path", "area at full opening")
        for path, area in answer["areas"].items():
            half = 0.5e6 * (area["high"] - area["low"])
            areas.add_row(path, f"{1e6 * area['value']:.4f} ± {half:.4f} mm²")
        console.print(areas)
    for sentence in answer["cannot_tell_apart"]:
        console.print(sentence, soft_wrap=True)
    console.print(f"written: {out}", soft_wrap=True)
