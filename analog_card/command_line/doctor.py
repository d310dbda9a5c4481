"""``analog-card doctor``: whether the simulator works here."""

import json
from dataclasses import asdict

import click

from analog_card.command_line.options import JSON, examples
from analog_card.doctor import examine


@click.command("doctor", epilog=examples("doctor", "doctor --json"))
@JSON
@click.pass_context
def command(context: click.Context, as_json: bool) -> None:
    """Say whether the circuit simulator works on this computer.

    Exit status 1 when it runs and gives wrong numbers.
    """
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
