"""``analog-card schematic``: the circuit diagram of the card."""

from io import BytesIO
from pathlib import Path

import click

from analog_card.command_line.options import DESIGN, examples, keep_design
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.files import write_whole
from analog_card.schematic import draw_card

_FORMS = (".svg", ".pdf", ".png")


@click.command("schematic", epilog=examples("schematic --out card.svg", "schematic --out card.pdf"))
@DESIGN
@click.option("--out", metavar="FILE", required=True, help="Picture: .svg, .pdf or .png.")
def command(design_file: str | None, out: str) -> None:
    """Draw the card: one channel and the supplies, with values and settings."""
    if Path(out).suffix not in _FORMS:
        raise InputError(f"{out}: unknown form of picture; there is {', '.join(_FORMS)}")
    keep_design(design_file, out)
    from matplotlib.figure import Figure

    figure = Figure(figsize=(16, 12), layout="constrained")
    draw_card(load_design(design_file), figure.subplots())
    stream = BytesIO()
    figure.savefig(stream, format=Path(out).suffix[1:], dpi=110)
    click.echo(f"written: {write_whole(out, stream.getvalue())}")
