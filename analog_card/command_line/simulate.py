"""``analog-card simulate``: a netlist through the simulator."""

import re
from collections.abc import Mapping
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
from analog_card.files import require_apart, write_whole
from analog_card.netlist_text import Netlist, nearest, read_netlist, spice_number
from analog_card.ngspice import Waveforms, run
from analog_card.quantities import to_si
from analog_card.waveform_files import (
    columns,
    plot_waveforms,
    require_form,
    write_waveforms,
)

# What an analysis is made of; --points has a default.
_OPTIONS: dict[str, tuple[str, ...]] = {
    "op": (),
    "dc": ("--from", "--to", "--step", "--source"),
    "ac": ("--from", "--to", "--points"),
    "tran": ("--to", "--step"),
    "noise": ("--from", "--to", "--points", "--source"),
}
_POINTS = 20


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
        if re.fullmatch(r"[-+]?[\d.]+([eE][-+]?\d+)?M(?![eE][gG])[A-Za-z]*", number):
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
@click.option("--points", type=int, help=f"Points per decade.  [default: {_POINTS}]")
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
    points: int | None,
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
    if plot is not None and analysis == "op":
        raise InputError("--plot: an operating point has no curve; write it with --out")
    netlist = read_netlist(_path(file))
    require_apart((path for path in (out, plot) if path is not None), netlist.files)
    options = {"--from": start, "--to": stop, "--step": step, "--points": points}
    wanted = _analysis(netlist, analysis, {**options, "--source": source}, nodes)
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
    netlist: Netlist, kind: str, options: Mapping[str, str | int | None], nodes: tuple[str, ...]
) -> Analysis:
    given = {option: value for option, value in options.items() if value is not None}
    own = kind == "op" or not given.keys() & {"--from", "--to", "--step"}
    _refuse_unused(kind, given, own)
    if kind == "noise" and len(nodes) > 1:
        raise InputError(f"--node: noise is computed at one node, not at {', '.join(nodes)}")
    if own:
        found = analysis_in(netlist, kind)
        if isinstance(found, Noise) and nodes:
            found = replace(found, node=nodes[0])
        if isinstance(found, Noise | SourceSweep) and "--source" in given:
            found = replace(found, source=str(given["--source"]))
        return found
    for option in (*_OPTIONS[kind], *["--node"] * (kind == "noise" and not nodes)):
        if option not in given and option != "--points":
            raise InputError(f"{option}: needed too, for --analysis {kind} with options")
    unit = {"dc": "", "tran": "s"}.get(kind, "Hz")
    first, last, every = (
        to_si(given.get(option, 0.0), unit, option) for option in ("--from", "--to", "--step")
    )
    source, points = str(given.get("--source")), int(given.get("--points", _POINTS))
    if kind == "dc":
        return SourceSweep(source, first, last, every)
    if kind == "tran":
        return Transient(last, every)
    if kind == "noise":
        return Noise(nodes[0], source, first, last, points)
    return FrequencySweep(first, last, points)


def _refuse_unused(kind: str, given: Mapping[str, str | int], own: bool) -> None:
    taken = _OPTIONS[kind]
    for option in given:
        if option not in taken:
            there = f"it takes {', '.join(taken)}" if taken else "it takes none such"
            raise InputError(f"{option}: not used by --analysis {kind}; {there}")
        if own and option == "--points":
            raise InputError(
                f"{option}: not used with the netlist's own .{kind} line; give --from and --to too"
            )


def _print(result: Waveforms, nodes: tuple[str, ...]) -> None:
    from rich.console import Console

    heads = ["value"] if result.axis is None else ["first", "least", "largest", "last"]
    rows = table(result.netlist.name, "node", "unit", *heads)
    for name, (unit, values) in columns(result, nodes).items():
        picked = [values[0], values.min(), values.max(), values[-1]]
        rows.add_row(name, unit, *(f"{value:.5g}" for value in picked[: len(heads)]))
    Console(markup=False).print(rows)


def _write_plot(result: Waveforms, plot: str, nodes: tuple[str, ...]) -> Path:
    from io import BytesIO

    from matplotlib.figure import Figure

    both = np.iscomplexobj(result[result.axis or next(iter(result.vectors))])
    spectrum = both and "onoise_spectrum" not in result.vectors
    figure = Figure(figsize=(9, 6), layout="constrained")
    axes = figure.subplots(2 if spectrum else 1, 1, sharex=True, squeeze=False).ravel().tolist()
    plot_waveforms(result, axes, nodes)
    figure.suptitle(result.netlist.name, parse_math=False)
    stream = BytesIO()
    figure.savefig(stream, format=Path(plot).suffix[1:], dpi=120)
    return write_whole(plot, stream.getvalue())
