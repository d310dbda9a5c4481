"""``analog-card opamp``: the op-amp's netlist against its data sheet."""

import json
from dataclasses import asdict

import click

from analog_card.command_line.options import DESIGN, JSON, examples, table
from analog_card.design_file import load_design
from analog_card.opamp_bench import Figure, measure_opamp
from analog_card.plain_json import plain_json
from analog_card.quantities import as_text


@click.command("opamp", epilog=examples("opamp", "opamp --json"))
@DESIGN
@JSON
@click.pass_context
def command(context: click.Context, design_file: str | None, as_json: bool) -> None:
    """Measure each figure of the CA3140's data sheet on its netlist.

    Exit status 1 when one differs by more than 5 % without a known reason.
    """
    figures = measure_opamp(load_design(design_file).soldered.operational_amplifier)
    passed = all(figure.passed for figure in figures)
    if as_json:
        rows = [
            {**asdict(figure), "deviation_per_cent": figure.deviation, "passed": figure.passed}
            for figure in figures
        ]
        click.echo(json.dumps(plain_json({"passed": passed, "figures": rows}), indent=2))
    else:
        _print(figures)
    if not passed:
        context.exit(1)


def _print(figures: tuple[Figure, ...]) -> None:
    from rich.console import Console

    rows = table("CA3140: data sheet and netlist", "figure", "", "data sheet", "measured", "off")
    reasons = [figure for figure in figures if figure.passed and not figure.within]
    for figure in figures:
        note = f"[{reasons.index(figure) + 1}]" if figure in reasons else ""
        rows.add_row(
            figure.name,
            "pass" if figure.within else note or "FAIL",
            as_text(figure.data_sheet, figure.unit, 3),
            as_text(figure.measured, figure.unit, 4),
            f"{figure.deviation:.1f} %",
        )
    console = Console(markup=False)
    console.print(rows)
    for number, figure in enumerate(reasons, 1):
        console.print(f"[{number}] {figure.name}: {figure.why}")
