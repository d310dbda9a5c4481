"""``pneuservo catalogue``: the physics that the diagnosis can name."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import progress, writing
from pneuservo.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pneuservo.effects import Effect

EXAMPLES = """\b
Examples:
  pneuservo catalogue
  pneuservo catalogue friction.stribeck --plot stribeck.svg
  pneuservo catalogue --pictures catalogue
  pneuservo catalogue --rig analogue-card --json
"""


@click.command("catalogue", epilog=EXAMPLES)
@click.argument("effect", required=False)
@click.option(
    "--rig",
    default="single-axis",
    show_default=True,
    help="A built-in rig, or a rig file, whose kind's effects are listed.",
)
@click.option("--plot", metavar="FILE", help="Draw what EFFECT changes: .svg, .png or .pdf.")
@click.option(
    "--pictures",
    metavar="FOLDER",
    help="Draw what each effect changes: EFFECT.svg, and index.html that shows them all.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the entries as JSON, nothing else.")
def command(
    effect: str | None, rig: str, plot: str | None, pictures: str | None, as_json: bool
) -> None:
    """List the effects that the diagnosis of a rig can name, or all about one of them.

    An effect with every parameter at its neutral value is the baseline. Each can be switched on in
    a rig file, under [effects]. Its picture, its signature, is a short run of the rig with and
    without it.
    """
    from pneuservo.effects import effect_by_id, effects_of
    from pneuservo.rigs import load_rig

    _require_options(effect, plot, pictures)
    rig = load_rig(rig).kind
    entries = effects_of(rig) if effect is None else (effect_by_id(effect, rig),)
    if plot is not None:
        _draw_one(entries[0], rig, plot)
    if pictures is not None:
        _draw_all(entries, rig, pictures)
    if as_json:
        click.echo(json.dumps([_plain(entry) for entry in entries], indent=2))
        return
    if effect is None:
        _print_all(entries, rig)
    else:
        _print_one(entries[0])
    for written in (plot, pictures and str(Path(pictures) / "index.html")):
        if written is not None:
            click.echo(f"written: {written}")


def _require_options(effect: str | None, plot: str | None, pictures: str | None) -> None:
    from pneuservo.report.picture_files import require_picture

    if plot is not None and effect is None:
        raise InputError(
            "--plot draws one effect: name it before, such as friction.stribeck; "
            "--pictures FOLDER draws all of them"
        )
    if pictures is not None and effect is not None:
        raise InputError(f"--pictures draws all effects; for {effect} alone give --plot FILE")
    require_picture("--plot", plot)


def _draw_one(effect: "Effect", rig: str, plot: str) -> None:
    from pneuservo.report.picture_files import write_picture
    from pneuservo.report.signature_pictures import signature_figure
    from pneuservo.report.signatures import signature_of

    with progress() as step:
        step(effect.id)
        figure = signature_figure(signature_of(effect, rig))
        with writing("--plot", plot):
            write_picture(figure, plot)


def _draw_all(effects: "Sequence[Effect]", rig: str, folder: str) -> None:
    from pneuservo.report.signature_pictures import write_catalogue

    with progress(len(effects)) as step, writing("--pictures", folder):
        write_catalogue(rig, effects, Path(folder), step)


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
    Console(markup=False).print(table)


def _print_one(entry: Any) -> None:
    from rich.console import Console
    from rich.table import Table

    click.echo(f"{entry.id} ({entry.block})\n{entry.statement}\n{entry.equation}")
    table = Table("parameter", "unit", "neutral", "from", "to", "meaning")
    for p in entry.parameters:
        figures = (f"{value:g}" for value in (p.neutral, p.low, p.high))
        table.add_row(p.name, p.unit or "-", *figures, p.meaning)
    Console(markup=False).print(table)
    click.echo(f"source: {entry.source}\nto see it: {entry.experiment}")
