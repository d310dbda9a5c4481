"""``analog-card verify``: netlist against behavioural equivalent."""

import json
from dataclasses import fields
from pathlib import Path

import click

from analog_card.behaviour import Imperfections
from analog_card.command_line.options import DESIGN, JSON, examples, keep_design, table
from analog_card.console import progress
from analog_card.design_file import load_design
from analog_card.files import write_whole
from analog_card.verification import Verification
from analog_card.verification import verify as compare
from analog_card.verification_plot import picture

# The frequency response and each transient.
_STEPS = 6


@click.command("verify", epilog=examples("verify", "verify --out out/verification --json"))
@DESIGN
@click.option(
    "--without",
    multiple=True,
    type=click.Choice([item.name.replace("_", "-") for item in fields(Imperfections)]),
    help="Leave an imperfection out of the model, to see what it is worth; may be repeated.",
)
@click.option("--out", metavar="FOLDER", help="Write verification.png and .json to FOLDER.")
@JSON
@click.pass_context
def command(
    context: click.Context,
    design_file: str | None,
    without: tuple[str, ...],
    out: str | None,
    as_json: bool,
) -> None:
    """Compare the netlist of a channel with its behavioural equivalent.

    Frequency response of every stage; sine, triangle, step, overload and relay over time. Exit
    status 1 when they differ by more than the limits.
    """
    numbers, drawing = (Path(out or "", f"verification.{form}") for form in ("json", "png"))
    if out is not None:
        keep_design(design_file, numbers, drawing)
    design = load_design(design_file)
    model = Imperfections().without(*(name.replace("-", "_") for name in without))
    with progress(total=_STEPS) as step:
        result = compare(design, step, model)
    text = json.dumps(result.to_dict(), indent=2)
    if out is not None:
        write_whole(numbers, text + "\n")
        write_whole(drawing, picture(result))
    if as_json:
        click.echo(text)
    else:
        _print_verification(result)
        if out is not None:
            click.echo(f"written: {drawing}")
    if not result.passed:
        context.exit(1)


def _print_verification(result: Verification) -> None:
    from rich.console import Console

    rows = table(
        "Netlist against behavioural model", "stage", "quantity", "band", "worst", "limit", ""
    )
    for item in result.deviations:
        verdict = "pass" if item.passed else "FAIL"
        if item.play:
            verdict += f", edges ±{item.play * 1e6:g} µs; without {item.without_play:.2g} %"
        rows.add_row(
            item.stage,
            item.quantity,
            item.band,
            f"{item.worst:.2g} {item.unit}",
            f"{item.limit:g}",
            verdict,
        )
    Console(markup=False).print(rows)
    if any(item.play for item in result.deviations):
        click.echo(
            "Edges: behind the boundary-layer amplifier both sides switch over 30 V in some 3 us. "
            "Where the table says so\nan edge counts as the same when it comes that much earlier "
            "or later; at the same times the deviation is the larger figure."
        )
