"""``analog-card trade-off``: break frequency against noise and switching frequency."""

import json
from io import BytesIO
from pathlib import Path

import click

from analog_card.command_line.options import DESIGN, JSON, examples, keep_design, table
from analog_card.console import Quantity, progress
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.files import write_whole
from analog_card.trade_off import (
    BREAK_FREQUENCIES,
    TRANSDUCER_BAND,
    TRANSDUCER_NOISE,
    TradeOff,
    trade_off,
)

_FORMS = (".svg", ".pdf", ".png")


@click.command(
    "trade-off",
    epilog=examples(
        "trade-off --plot trade-off.svg", "trade-off --transducer-noise '10 uV' --json"
    ),
)
@DESIGN
@click.option(
    "--transducer-noise",
    type=Quantity("V"),
    default=TRANSDUCER_NOISE,
    show_default=True,
    help="Noise of the transducer, rms in V.",
)
@click.option(
    "--transducer-band",
    type=Quantity("Hz", 0.0),
    default=TRANSDUCER_BAND,
    show_default=True,
    help="Up to where it is white, in Hz.",
)
@click.option("--plot", metavar="FILE", help="Draw it: .svg, .pdf or .png.")
@JSON
def command(
    design_file: str | None,
    transducer_noise: float,
    transducer_band: float,
    plot: str | None,
    as_json: bool,
) -> None:
    """Weigh the break frequency of the differentiators: noise against switching frequency."""
    if plot is not None and Path(plot).suffix not in _FORMS:
        raise InputError(f"{plot}: unknown form of picture; there is {', '.join(_FORMS)}")
    keep_design(design_file, plot)
    design = load_design(design_file)
    with progress(total=len(BREAK_FREQUENCIES)) as step:
        found = trade_off(
            design,
            transducer_noise=transducer_noise,
            transducer_band=transducer_band,
            step=step,
        )
    if plot is not None:
        write_whole(plot, _picture(found, design.title, Path(plot).suffix[1:]))
    if as_json:
        click.echo(json.dumps(found.to_dict(), indent=2))
        return
    _print(found)
    if plot is not None:
        click.echo(f"written: {plot}")


def _print(found: TradeOff) -> None:
    from rich.console import Console

    rows = table(
        "Break frequency against noise and switching",
        "",
        "break",
        "noise of the card",
        "with the transducer",
        "ideal relay",
        "op-amp as relay",
    )
    for name, point in [*(("", point) for point in found.points), ("this card", found.nominal)]:
        rows.add_row(
            name,
            f"{point.break_frequency:.0f} Hz",
            f"{point.own_noise:.3g} m/s2",
            f"{point.total_noise:.3g} m/s2",
            f"{point.switching_frequency:.0f} Hz",
            f"{point.circuit_switching_frequency:.0f} Hz",
        )
    Console(markup=False).print(rows)
    click.echo(
        f"A 12-bit converter sees chattering in the displacement below "
        f"{found.detectable_frequency:.0f} Hz."
    )


def _picture(found: TradeOff, title: str, form: str) -> bytes:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.5, 8), layout="constrained")
    found.plot(figure.subplots(2, 1, sharex=True))
    heading = f"What the break frequency costs and gives\n{title}"
    figure.suptitle(heading, fontsize="medium", parse_math=False)
    stream = BytesIO()
    figure.savefig(stream, format=form, dpi=110)
    return stream.getvalue()
