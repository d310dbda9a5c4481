"""``analog-card simulate``: a netlist through the simulator."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np

import netlists
from analog_card.analyses import (
    Analysis,
    FrequencySweep,
    Noise,
    SourceSweep,
    Transient,
    analysis_in,
)
from analog_card.command_line.options import examples, table
from analog_card.errors import InputError
from analog_card.files import write_whole
from analog_card.netlist_text import Netlist, nearest, read_netlist, spice_number
from analog_card.ngspice import Waveforms, run
from analog_card.quantities import to_si
from analog_card.waveform_files import (
    axis_of,
    columns,
    plot_waveforms,
    require_form,
    write_waveforms,
)


class Parameter(click.ParamType):
    """A value for a parameter of the netlist, ``NAME=VALUE`` with a number as SPICE writes it."""

    name = "NAME=VALUE"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, float]:
        """Return name and value."""
        if isinstance(value, tuple):
            return value
        name, equals, number = (part.strip() for part in str(value).partition("="))
        if not (name.isidentifier() and equals):
            self.fail(f"{value!r}; write for example resistance=22k", param, ctx)
        if re.fullmatch(r"[\d.]+M", number):
            self.fail(f"{value!r}: M is a thousandth in SPICE; write meg or m", param, ctx)
        try:
            return name, spice_number(number)
        except ValueError as problem:
            self.fail(f"{value!r}: {problem}; write for example {name}=22k", param, ctx)


@click.command(
    "simulate",
    epilog=examples(
        "simulate rc-low-pass --analysis ac --param resistance=2.2k --plot rc-low-pass.svg",
        "simulate card --analysis tran --to 50ms --step 50us --node control1 --out control.csv",
    ),
)
@click.argument("file")
@click.option(
    "--analysis",
    type=click.Choice(["op", "dc", "ac", "tran", "noise"]),
    required=True,
    help="What to compute. Without the options below: as the netlist's own line of that kind.",
)
@click.option(
    "--param", "parameters", type=Parameter(), multiple=True, help="Another value for a .param."
)
@click.option("--from", "start", metavar="VALUE", help="First frequency, or value of the source.")
@click.option("--to", "stop", metavar="VALUE", help="Last frequency, value or time.")
@click.option("--step", metavar="VALUE", help="Step of a dc sweep, longest step of a transient.")
@click.option("--points", type=int, default=20, show_default=True, help="Points per decade.")
@click.option("--source", metavar="NAME", help="Source to sweep, or that noise is referred to.")
@click.option("--node", "nodes", metavar="NAME", multiple=True, help="Node wanted; without it all.")
@click.option("--out", metavar="FILE", help="Write the values: .csv, .parquet or .h5.")
@click.option("--plot", metavar="FILE", help="Draw the curves: .svg, .png or .pdf.")
def command(
    file: str,
    analysis: str,
    parameters: tuple[tuple[str, float], ...],
    start: str | None,
    stop: str | None,
    step: str | None,
    points: int,
    source: str | None,
    nodes: tuple[str, ...],
    out: str | None,
    plot: str | None,
) -> None:
    """Simulate a netlist FILE, or one of the card's own by name, such as card or relay.

    A netlist of your own may hold a circuit and nothing else: commands, code models and
    includes from outside its folder are refused. Numbers may carry a unit, as in 20kHz or 50us.
    """
    if out is not None:
        require_form(Path(out))
    if plot is not None and Path(plot).suffix not in (".svg", ".png", ".pdf"):
        raise InputError(f"{plot}: unknown form of picture; there is .svg, .png, .pdf")
    netlist = read_netlist(_path(file))
    wanted = _analysis(netlist, analysis, (start, stop, step), points, source, nodes)
    if isinstance(wanted, Noise):
        nodes = ()
    result = run(netlist, wanted, dict(parameters))
    if out is None and plot is None:
        _print(result, nodes)
    if out is not None:
        click.echo(f"written: {write_waveforms(result, out, nodes)}")
    if plot is not None:
        click.echo(f"written: {_write_plot(result, plot, nodes)}")


def _path(file: str) -> Path:
    shipped = netlists.shipped()
    if Path(file).exists() or "." in file or "/" in file:
        return Path(file)
    if file not in shipped:
        raise InputError(
            f"{file}: neither a file nor a netlist of the card{nearest(file, shipped)}"
        )
    return shipped[file]


def _analysis(
    netlist: Netlist,
    kind: str,
    values: tuple[str | None, str | None, str | None],
    points: int,
    source: str | None,
    nodes: tuple[str, ...],
) -> Analysis:
    if kind == "op" or not any(value is not None for value in values):
        found = analysis_in(netlist, kind)
        if isinstance(found, Noise) and nodes:
            found = replace(found, node=nodes[0])
        if isinstance(found, Noise | SourceSweep) and source:
            found = replace(found, source=source)
        return found
    unit = {"dc": "", "tran": "s"}.get(kind, "Hz")
    start, stop, step = (
        None if text is None else to_si(text, unit, option)
        for text, option in zip(values, ("--from", "--to", "--step"), strict=True)
    )
    needed: dict[str, Any] = {"--to": stop}
    if kind == "tran":
        needed["--step"] = step
    else:
        needed["--from"] = start
    if kind == "dc":
        needed["--step"] = step
    if kind in ("dc", "noise"):
        needed["--source"] = source
    if kind == "noise":
        needed["--node"] = nodes[0] if nodes else None
    for option, value in needed.items():
        if value is None:
            raise InputError(f"{option}: needed too, for --analysis {kind} with options")
    first, last, every = (float(value or 0) for value in (start, stop, step))
    if kind == "dc":
        return SourceSweep(str(source), first, last, every)
    if kind == "tran":
        return Transient(last, every)
    if kind == "noise":
        return Noise(nodes[0], str(source), first, last, points)
    return FrequencySweep(first, last, points)


def _print(result: Waveforms, nodes: tuple[str, ...]) -> None:
    from rich.console import Console

    axis = axis_of(result)
    heads = ["value"] if axis is None else ["first", "least", "largest", "last"]
    rows = table(result.netlist.name, "node", "unit", *heads)
    for name, (unit, values) in columns(result, nodes).items():
        picked = [values[0], values.min(), values.max(), values[-1]]
        rows.add_row(name, unit, *(f"{value:.5g}" for value in picked[: len(heads)]))
    Console(markup=False).print(rows)


def _write_plot(result: Waveforms, plot: str, nodes: tuple[str, ...]) -> Path:
    from io import BytesIO

    from matplotlib.figure import Figure

    both = np.iscomplexobj(result[axis_of(result) or next(iter(result.vectors))])
    spectrum = both and "onoise_spectrum" not in result.vectors
    figure = Figure(figsize=(9, 6), layout="constrained")
    axes = figure.subplots(2 if spectrum else 1, 1, sharex=True, squeeze=False).ravel().tolist()
    plot_waveforms(result, axes, nodes)
    figure.suptitle(result.netlist.name, parse_math=False)
    stream = BytesIO()
    figure.savefig(stream, format=Path(plot).suffix[1:], dpi=120)
    return write_whole(plot, stream.getvalue())
