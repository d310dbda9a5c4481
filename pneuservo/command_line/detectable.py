"""``pneuservo detectable``: which chattering a converter still sees."""

import json

import click

from analog_card.console import Count, Quantity
from pneuservo.command_line.baseline_rig import baseline_rig
from pneuservo.linear.detectability import DetectableFrequencies, detectable_frequencies
from pneuservo.linear.from_rig import servo_data

EXAMPLES = """\b
Examples:
  pneuservo detectable
  pneuservo detectable --threshold "3.98 um" --json
"""


@click.command("detectable", epilog=EXAMPLES)
@click.option("--rig", help="A rig of kind single-axis.  [default: table 5.2 of the thesis]")
@click.option("--bits", type=Count(4, 24), default=12, show_default=True, help="Of the converter.")
@click.option(
    "--threshold", type=Quantity("m", 0.0), help="Amplitude just seen.  [default: half a bit]"
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(rig: str | None, bits: int, threshold: float | None, as_json: bool) -> None:
    """Say up to which switching frequency a converter sees the chattering of the piston.

    Tables 9.1 and 9.2 of the thesis, which a threshold of 3.98 um reproduces within 1 %.
    """
    used = servo_data(baseline_rig(rig)) if rig is not None else None
    found = detectable_frequencies(used, threshold, bits)
    if as_json:
        click.echo(json.dumps(_report(found), indent=2))
    else:
        _print(found)


def _report(found: DetectableFrequencies) -> dict[str, object]:
    tables = {"without_valve": found.without_valve, "with_valve": found.with_valve}
    return {
        "threshold": found.threshold,
        "positions": list(found.positions),
        **{
            name: {direction: values.tolist() for direction, values in table.items()}
            for name, table in tables.items()
        },
    }


def _print(found: DetectableFrequencies) -> None:
    from rich.console import Console
    from rich.table import Table

    positions = [f"{1e3 * position:g} mm" for position in found.positions]
    table = Table("", "direction", *positions)
    for name, rows in (
        ("without the valve's dynamics", found.without_valve),
        ("with them", found.with_valve),
    ):
        for direction, values in rows.items():
            table.add_row(name, direction, *[f"{value:.0f} Hz" for value in values])
    console = Console(highlight=False, markup=False)
    console.print(table)
    console.print(f"amplitude just seen: {1e6 * found.threshold:.3f} um", soft_wrap=True)
