"""The command ``analog-card``."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import CommandGroup, Quantity, progress

if TYPE_CHECKING:
    from analog_card.tuning import Tuning
    from analog_card.verification import Verification

DESIGN = click.option(
    "--design",
    "design_file",
    metavar="FILE",
    help="Design file of the card; without it the recommended card.",
)
JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON and nothing else.")


def _examples(*commands: str) -> str:
    lines = "\n".join(f"  analog-card {command}" for command in commands)
    return f"\b\nExamples:\n{lines}"


@click.group(cls=CommandGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="pneuservo")
def main() -> None:
    """Tune, simulate and verify the analogue sliding-mode control card."""


@main.command(
    epilog=_examples(
        "tune --settling-time 0.07 --damping 1 --boundary-layer 5 --level 5",
        "tune --settling-time 100ms --boundary-layer '8000 mm/s2' --out my-card.toml",
    )
)
@click.option(
    "--settling-time",
    type=Quantity("s", minimum=0.0),
    required=True,
    help="Settling time of the sliding motion, 4/(damping x natural frequency).",
)
@click.option(
    "--damping",
    type=Quantity("", minimum=0.0),
    default=1.0,
    show_default=True,
    help="Damping ratio of the sliding motion, up to 1.",
)
@click.option(
    "--boundary-layer",
    type=Quantity("m/s**2", minimum=0.0),
    default=5.0,
    show_default=True,
    help="Width of the boundary layer in m/s2. The thesis prints 5000 and means mm/s2: 5 here.",
)
@click.option(
    "--level",
    type=Quantity("V", minimum=0.0),
    default=5.0,
    show_default=True,
    help="Largest output voltage.",
)
@DESIGN
@click.option("--out", metavar="FILE", help="Write the design with its new settings to FILE.")
@JSON
def tune(
    settling_time: float,
    damping: float,
    boundary_layer: float,
    level: float,
    design_file: str | None,
    out: str | None,
    as_json: bool,
) -> None:
    """Find the settings of potentiometers P1 to P4.

    Numbers may carry a unit, as in 70ms or '5000 mm/s2'. Without --out the design file with the
    new settings follows the table.
    """
    from analog_card.design_file import design_to_toml, load_design
    from analog_card.files import write_whole
    from analog_card.tuning import tune as find_settings

    design = load_design(design_file)
    tuning = find_settings(settling_time, damping, boundary_layer, level, design)
    text = design_to_toml(tuning.design)
    if out is not None:
        write_whole(out, text)
    if as_json:
        click.echo(json.dumps(tuning.to_dict(), indent=2))
        return
    _print_tuning(tuning)
    click.echo(f"\nwritten: {out}" if out is not None else f"\n{text}", nl=out is not None)


@main.command(epilog=_examples("verify", "verify --out out/verification --json"))
@DESIGN
@click.option("--out", metavar="FOLDER", help="Write verification.png and .json to FOLDER.")
@JSON
@click.pass_context
def verify(context: click.Context, design_file: str | None, out: str | None, as_json: bool) -> None:
    """Compare the netlist of the differentiators with the behavioural model.

    Exit status 1 when they differ by more than the limits.
    """
    from analog_card.design_file import load_design
    from analog_card.files import write_whole
    from analog_card.verification import verify as compare

    design = load_design(design_file)
    with progress(total=2) as step:
        result = compare(design, step)
    text = json.dumps(result.to_dict(), indent=2)
    if out is not None:
        write_whole(Path(out) / "verification.json", text + "\n")
        write_whole(Path(out) / "verification.png", _picture(result))
    if as_json:
        click.echo(text)
    else:
        _print_verification(result)
        if out is not None:
            click.echo(f"written: {Path(out) / 'verification.png'}")
    if not result.passed:
        context.exit(1)


@main.command(epilog=_examples("doctor", "doctor --json"))
@JSON
@click.pass_context
def doctor(context: click.Context, as_json: bool) -> None:
    """Say whether the circuit simulator works on this computer.

    Exit status 1 when it runs and gives wrong numbers.
    """
    from dataclasses import asdict

    from analog_card.doctor import examine

    found = examine()
    if as_json:
        click.echo(json.dumps({**asdict(found), "works": found.works}, indent=2))
    else:
        click.echo(f"Python {found.python}")
        click.echo(f"PySpice {found.pyspice}")
        click.echo(f"ngspice {found.ngspice}, {found.library}")
        click.echo(f"RC low pass at its corner: gain {found.gain:.6f}, 0.707107 expected")
        click.echo("ok" if found.works else "wrong: reinstall the ngspice library")
    if not found.works:
        context.exit(1)


def _table(title: str, *columns: str) -> Any:
    from rich.table import Table

    table = Table(title=title, title_justify="left")
    for number, column in enumerate(columns):
        table.add_column(column, justify="left" if number < 2 else "right")
    return table


def _print_tuning(tuning: "Tuning") -> None:
    from rich.console import Console

    from analog_card.quantities import as_text

    weights = tuning.weights
    goals = (
        f"c1 = {weights.displacement:.5g} 1/s2",
        f"c2 = {weights.velocity:.5g} 1/s",
        f"{weights.boundary_layer:.4g} m/s2",
        f"{weights.level:.4g} V",
    )
    table = _table(tuning.design.title, "", "sets", "to", "travel", "resistance")
    for item, goal in zip(tuning.potentiometers, goals, strict=True):
        table.add_row(
            item.name,
            item.setting.replace("_", " "),
            goal,
            f"{100 * item.fraction:.1f} %",
            as_text(item.resistance, "ohm", 3),
        )
    Console().print(table)


def _print_verification(result: "Verification") -> None:
    from rich.console import Console

    table = _table(
        "Netlist against behavioural model", "tap", "quantity", "band", "worst", "limit", ""
    )
    for item in result.deviations:
        table.add_row(
            item.tap,
            item.quantity,
            item.band,
            f"{item.worst:.2g} {item.unit}",
            "" if item.limit is None else f"{item.limit:g}",
            "" if item.limit is None else ("pass" if item.passed else "FAIL"),
        )
    Console().print(table)


def _picture(result: "Verification") -> bytes:
    from io import BytesIO

    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 8), layout="constrained")
    result.plot(figure.subplots(2, 2).ravel())
    figure.suptitle(f"Netlist against behavioural model: {result.design.title}")
    stream = BytesIO()
    figure.savefig(stream, format="png", dpi=100)
    return stream.getvalue()
