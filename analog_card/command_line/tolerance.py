"""``analog-card tolerance``: what tolerances do to the card in open loop."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from analog_card.behaviour_elements import figure_name, offset_name
from analog_card.command_line.options import DESIGN, JSON, examples, keep_design, table
from analog_card.command_line.tolerance_options import tolerance_options, with_tolerances
from analog_card.console import Count, progress
from analog_card.design import AMPLIFIER_FIGURES, AMPLIFIERS
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.plain_json import plain_json
from analog_card.quantities import as_text, to_si
from analog_card.tolerance_figures import FIGURES
from analog_card.tolerance_statistics import CONFIDENCE
from analog_card.tolerance_study import Study, study_card

REPORT = "tolerance.json"
"""What a study is written to, in its folder."""
# Written as they are; the others take prefixes.
_PLAIN_UNITS = ("1/s2", "1/s", "m/s2", "V s/m", "V s2/m", "degree", "Hz")


def study_options(function: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that every tolerance study takes."""
    options = [
        click.option("--seed", type=Count(min=0), default=0, show_default=True),
        click.option(
            "--jobs",
            type=Count(min=1),
            default=1,
            show_default=True,
            help="Processes to run in; the numbers do not depend on it.",
        ),
        click.option(
            "--limit",
            "limit",
            multiple=True,
            metavar="FIGURE=LOW..HIGH",
            help="Limits for the yield, such as rest_error=-0.3mm..0.3mm; repeatable.",
        ),
        click.option(
            "--out",
            metavar="FOLDER",
            help="Keep trials and tolerance.json in FOLDER; a stopped study goes on.",
        ),
    ]
    function = tolerance_options(function)
    for option in reversed([*options, DESIGN, JSON]):
        function = option(function)
    return function


@click.command(
    "tolerance",
    epilog=examples(
        "tolerance --trials 200 --netlist-trials 10",
        "tolerance --trials 100 --netlist-trials 0 --resistor 0.001 "
        "--limit rest_error=-0.3mm..0.3mm --json",
    ),
)
@click.option(
    "--trials",
    type=Count(min=2),
    default=1000,
    show_default=True,
    help="Cards computed by behaviour.",
)
@click.option(
    "--netlist-trials",
    type=Count(min=0),
    default=200,
    show_default=True,
    help="How many of them are run as netlists too.",
)
@study_options
def command(
    trials: int,
    netlist_trials: int,
    seed: int,
    jobs: int,
    limit: tuple[str, ...],
    out: str | None,
    design_file: str | None,
    as_json: bool,
    **tolerances: float | None,
) -> None:
    """Study what tolerances of parts, op-amps and temperature do to the card.

    Monte Carlo by behaviour and by netlist over the same cards, worst cases by corners, and which
    part matters most. Tolerances are those of the design file; options replace them. In closed
    loop: pneuservo tolerance.
    """
    if out is not None:
        keep_design(design_file, Path(out) / REPORT)
    with progress(total=trials + netlist_trials) as step:
        study = study_card(
            with_tolerances(load_design(design_file), tolerances),
            trials,
            netlist_trials,
            seed,
            parsed_limits(limit, FIGURES),
            out,
            jobs,
            step,
        )
    report(study, out, as_json)


def parsed_limits(texts: tuple[str, ...], units: dict[str, str]) -> dict[str, tuple[float, float]]:
    """Return limits by figure from texts such as ``rest_error=-0.3mm..0.3mm``.

    Raises
    ------
    InputError
        When one is not of this form or of no figure.
    """
    found = {}
    for text in texts:
        name, _, both = text.partition("=")
        low, dots, high = both.partition("..")
        if not dots:
            raise InputError(f"--limit {text!r}: write FIGURE=LOW..HIGH")
        if name not in units:
            raise InputError(f"--limit {text!r}: the figures are {', '.join(units)}")
        what = f"--limit {name}"
        found[name] = to_si(low, units[name], what), to_si(high, units[name], what)
    return found


def report(study: Study, out: str | None, as_json: bool) -> None:
    """Print a study and write it."""
    from analog_card.files import write_whole

    text = json.dumps(plain_json(study.to_dict()), indent=2)
    if out is not None:
        write_whole(Path(out) / REPORT, text + "\n")
    if as_json:
        click.echo(text)
        return
    _print(study)
    if out is not None:
        click.echo(f"written: {Path(out) / REPORT}")


def _print(study: Study) -> None:
    from rich.console import Console

    console = Console(markup=False)
    rows = table(
        f"{len(study.trials)} cards, {len(study.netlist_trials)} of them as netlists too",
        "figure",
        "nominal",
        "95 % of cards",
        "worst case",
        "no number",
    )
    for item in study.spreads:
        rows.add_row(
            item.figure.replace("_", " "),
            _text(item.nominal, item.unit),
            _between(item.low, item.high, item.unit),
            _between(item.corner_low, item.corner_high, item.unit),
            f"{item.failed} of {len(study.trials)}" if item.failed else "",
        )
    console.print(rows)
    rows = table("What matters most, share of the spread", "figure", "", "netlist differs by")
    for item in study.spreads:
        rows.add_row(
            item.figure.replace("_", " "),
            "\n".join(f"{share:4.0%}  {_readable(name)}" for name, share in item.important.items()),
            "" if item.difference is None else _text(item.difference, item.unit),
        )
    console.print(rows)
    if study.spreads[0].confidence < CONFIDENCE:
        console.print(
            f"Few trials: bounds with {study.spreads[0].confidence:.0%} confidence only; what "
            "matters most is named only where it cannot be chance."
        )
    if study.cards_within is not None:
        within = study.cards_within
        console.print(
            f"within the limits: {within.share:.1%} of the trials, "
            f"{within.low:.1%} to {within.high:.1%} of all cards"
        )


def _readable(name: str) -> str:
    for amplifier in AMPLIFIERS:
        if name == offset_name(amplifier):
            return f"{amplifier} offset".replace("_", " ")
        for figure in AMPLIFIER_FIGURES:
            if name == figure_name(amplifier, figure):
                return f"{amplifier} {figure}".replace("_", " ")
    return name


def _between(low: float | None, high: float | None, unit: str) -> str:
    if low is None or high is None or math.isnan(low):
        return ""
    return f"{_text(low, unit)} to {_text(high, unit)}"


def _text(value: float, unit: str) -> str:
    if unit in _PLAIN_UNITS:
        return f"{value:.4g} {unit}"
    return as_text(value, unit, 3)
