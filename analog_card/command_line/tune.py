"""``analog-card tune``: the settings of the potentiometers."""

import json
import math
from collections.abc import Mapping

import click

from analog_card.command_line.options import DESIGN, JSON, examples, keep_design, table
from analog_card.console import Quantity
from analog_card.design_file import design_to_toml, load_design
from analog_card.errors import InputError
from analog_card.files import write_whole
from analog_card.plain_json import plain_json
from analog_card.quantities import as_text
from analog_card.reach import sensitivities
from analog_card.tuning import Tuning, read_settings, with_transducer_gain
from analog_card.tuning import tune as find_settings


@click.command(
    "tune",
    epilog=examples(
        "tune --settling-time 0.07 --damping 1 --boundary-layer 5 --level 5",
        "tune --settling-time 100ms --boundary-layer '8000 mm/s2' --out my-card.toml",
    ),
)
@click.option(
    "--settling-time",
    type=Quantity("s", minimum=0.0),
    help="Settling time of the sliding motion, 4/(damping x natural frequency).",
)
@click.option(
    "--damping",
    type=Quantity("", minimum=0.0),
    help="Damping ratio of the sliding motion, up to 1.  [default: 1]",
)
@click.option(
    "--boundary-layer",
    type=Quantity("m/s**2", minimum=0.0),
    help="Width of the boundary layer in m/s2. The thesis prints 5000 and means mm/s2: 5 here.  "
    "[default: 5]",
)
@click.option(
    "--level",
    type=Quantity("V", minimum=0.0),
    help="Largest output voltage.  [default: 5]",
)
@click.option(
    "--transducer-scale",
    type=Quantity("V/m", minimum=0.0),
    help="Volts of the transducer for each metre.  [default: the design's]",
)
@click.option(
    "--turns",
    type=Quantity("", minimum=0.0),
    default=10.0,
    show_default=True,
    help="Turns of each potentiometer from end to end.",
)
@click.option(
    "--from",
    "turned_file",
    metavar="FILE",
    help="The other way: what the settings of this design file achieve.",
)
@DESIGN
@click.option("--out", metavar="FILE", help="Write the design with its new settings to FILE.")
@JSON
def command(
    settling_time: float | None,
    transducer_scale: float | None,
    turns: float,
    turned_file: str | None,
    design_file: str | None,
    out: str | None,
    as_json: bool,
    **goals: float | None,
) -> None:
    """Find the settings of potentiometers P1 to P4, or what given settings achieve.

    Numbers may carry a unit, as in 70ms or '5000 mm/s2'. Without --out the design file with the
    new settings follows the table.
    """
    given = {name: value for name, value in goals.items() if value is not None}
    keep_design(design_file, out)
    if turned_file is not None:
        _refuse({"settling_time": settling_time, "design": design_file, "out": out, **given})
        design = with_transducer_gain(load_design(turned_file), transducer_scale)
        tuning = read_settings(design)
    elif settling_time is None:
        raise InputError(
            "Missing option '--settling-time': say what is wanted, or with --from FILE what is"
        )
    else:
        design = load_design(design_file)
        tuning = find_settings(
            settling_time, **given, design=design, transducer_gain=transducer_scale
        )
    text = design_to_toml(tuning.design)
    if out is not None:
        write_whole(out, text)
    if as_json:
        click.echo(json.dumps(plain_json(tuning.to_dict(turns)), indent=2))
        return
    _print_tuning(tuning, turns)
    _print_limits(tuning)
    if turned_file is None:
        click.echo(f"\nwritten: {out}" if out is not None else f"\n{text}", nl=out is not None)


def _refuse(options: Mapping[str, object]) -> None:
    for name, value in options.items():
        if value is not None:
            raise InputError(
                f"--{name.replace('_', '-')} is not used with --from, which reads settings; "
                "leave one of them out"
            )


def _print_tuning(tuning: Tuning, turns: float) -> None:
    from rich.console import Console

    achieved = tuning.achieved
    goals = (
        f"c1 = {achieved['c1']:.5g} 1/s2",
        f"c2 = {achieved['c2']:.5g} 1/s",
        f"{achieved['boundary_layer']:.4g} m/s2",
        f"{achieved['level']:.4g} V",
    )
    rows = table(
        tuning.design.title, "", "sets", "to", "travel", "resistance", "a turn", "% for each %"
    )
    found = sensitivities(tuning.design, turns)
    for item, goal, does in zip(tuning.potentiometers, goals, found, strict=True):
        rows.add_row(
            item.name,
            item.setting.replace("_", " "),
            goal,
            f"{100 * item.fraction:.1f} %",
            as_text(item.resistance, "ohm", 3),
            f"{does.per_turn:+.3g} {does.unit}",
            f"{does.relative:.2f}",
        )
    Console(markup=False).print(rows)
    click.echo(f"settling time {tuning.settling_time:.4g} s, damping {tuning.damping:.4g}")


def _print_limits(tuning: Tuning) -> None:
    from rich.console import Console

    rows = table("What this card reaches", "quantity", "because of", "from", "to", "wanted", "")
    for limit in tuning.limits:
        rows.add_row(
            f"{limit.quantity}, {limit.unit}",
            limit.reason,
            f"{limit.lowest:.3g}",
            f"{limit.highest:.4g}" if math.isfinite(limit.highest) else "",
            f"{limit.wanted:.4g}",
            "ok" if limit.holds else "BEYOND",
        )
    Console(markup=False).print(rows)
