"""``pneuservo rigs``: the rigs that are built in, and a rig file to begin one's own with."""

import json
from dataclasses import asdict
from typing import Any

import click

from analog_card.files import write_whole
from analog_card.plain_json import plain_json
from pneuservo.errors import InputError

EXAMPLES = """\b
Examples:
  pneuservo rigs
  pneuservo rigs single-axis --out mine.toml
  pneuservo rigs dead-volume --json
"""


@click.command("rigs", epilog=EXAMPLES)
@click.argument("name", required=False)
@click.option("--out", metavar="FILE", help="Write the file of rig NAME here, to be changed.")
@click.option("--json", "as_json", is_flag=True, help="Print all as JSON in SI, nothing else.")
def command(name: str | None, out: str | None, as_json: bool) -> None:
    """List the built-in rigs, or print the file of rig NAME.

    A rig file of your own needs its kind and what differs from the built-in rig of that kind;
    every command takes it as --rig, a sidecar as [recording] rig.
    """
    from pneuservo.rigs import built_in_text, load_rig

    if name is None and out is not None:
        raise InputError("--out writes the file of one rig: name it before, such as single-axis")
    if name is None:
        rigs = _built_in_rigs()
        if as_json:
            click.echo(json.dumps(rigs, indent=2))
        else:
            _print_all(rigs)
        return
    text = built_in_text(name)
    if out is not None:
        write_whole(out, text)
    if as_json:
        parameters = {key: asdict(one) for key, one in load_rig(name).parameters.items()}
        click.echo(json.dumps(plain_json(parameters), indent=2))
    elif out is None:
        click.echo(text, nl=False)
    else:
        click.echo(f"written: {out}")


def _built_in_rigs() -> list[dict[str, Any]]:
    from pneuservo.diagnosis.models import required_channels
    from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, load_rig

    rigs = [(name, load_rig(name)) for name in (*BUILT_IN_RIGS, *VARIANTS)]
    return [
        {
            "name": name,
            "kind": rig.kind,
            "title": rig.title,
            "diagnosis_needs": required_channels(rig.kind),
        }
        for name, rig in rigs
    ]


def _print_all(rigs: list[dict[str, Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("rig", "kind", "what it is", "a diagnosis needs")
    for rig in rigs:
        needs = rig["diagnosis_needs"]
        named = "(not diagnosed)" if needs is None else ", ".join(needs)
        table.add_row(rig["name"], rig["kind"], rig["title"], named)
    Console(markup=False).print(table)
