"""``pneuservo catalogue``: the physics that the diagnosis can name."""

import json
from typing import Any

import click

from pneuservo.rigs import BUILT_IN_RIGS

EXAMPLES = """\b
Examples:
  pneuservo catalogue
  pneuservo catalogue friction.stribeck
  pneuservo catalogue --rig analogue-card --json
"""


@click.command("catalogue", epilog=EXAMPLES)
@click.argument("effect", required=False)
@click.option(
    "--rig",
    type=click.Choice(BUILT_IN_RIGS),
    default="single-axis",
    show_default=True,
    help="The kind of rig whose effects are listed.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the entries as JSON, nothing else.")
def command(effect: str | None, rig: str, as_json: bool) -> None:
    """List the effects that the diagnosis of a rig can name, or all about one of them.

    An effect with every parameter at its neutral value is the baseline. Each can be switched on in
    a rig file, under [effects].
    """
    from pneuservo.effects import effect_by_id, effects_of

    entries = effects_of(rig) if effect is None else (effect_by_id(effect, rig),)
    if as_json:
        click.echo(json.dumps([_plain(entry) for entry in entries], indent=2))
    elif effect is None:
        _print_all(entries, rig)
    else:
        _print_one(entries[0])


def _plain(entry: Any) -> dict[str, Any]:
    return {
        "id": entry.id,
        "block": entry.block,
        "rigs": list(entry.rigs),
        "statement": entry.statement,
        "equation": entry.equation,
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "neutral": p.neutral,
                "low": p.low,
                "high": p.high,
                "meaning": p.meaning,
            }
            for p in entry.parameters
        ],
        "source": entry.source,
        "experiment": entry.experiment,
    }


def _print_all(entries: Any, rig: str) -> None:
    from rich.console import Console
    from rich.table import Table

    if not entries:
        click.echo(f"The catalogue has no effect for a rig of kind {rig}.")
        return
    table = Table("effect", "block", "what it is", title=f"{len(entries)} effects of a {rig}")
    for entry in entries:
        table.add_row(entry.id, entry.block, entry.statement.partition(";")[0])
    Console().print(table)


def _print_one(entry: Any) -> None:
    from rich.console import Console
    from rich.table import Table

    click.echo(f"{entry.id} ({entry.block})\n{entry.statement}\n{entry.equation}")
    table = Table("parameter", "unit", "neutral", "from", "to", "meaning")
    for p in entry.parameters:
        figures = (f"{value:g}" for value in (p.neutral, p.low, p.high))
        table.add_row(p.name, p.unit or "-", *figures, p.meaning)
    Console().print(table)
    click.echo(f"source: {entry.source}\nto see it: {entry.experiment}")
