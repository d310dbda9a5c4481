"""``pneuservo tune``: potentiometer settings that are best in the worst rig of a set."""

import json
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import Count, Quantity, progress
from pneuservo.command_line.baseline_rig import warn_left_out, warn_of_transducer
from pneuservo.command_line.campaign_options import (
    hand_out,
    options_of_place,
    place_of,
    read_given,
    require_one_place,
    require_settings_kept,
)

if TYPE_CHECKING:
    from pneuservo.tuning.run import RobustTuning

# What is written into the folder of --out.
_FILES, _PICTURE = ("front.csv", "tuning.json", "card.toml"), "front.svg"
# Rows of the front that are printed; all of it is in the folder and in the JSON.
_MOST_ROWS = 15
# Figures in the table, so that it fits into 80 columns.
_SHORT = {
    "settling_time": "settles",
    "chatter": "chatter",
    "control_effort": "effort",
    "overshoot": "beyond",
    "steady_state_error": "error",
}

_EPILOG = """\b
Examples:
  pneuservo tune --out out/tune
  pneuservo tune --vary "supply.pressure=6.5, 7.7 bar" --vary "load.mass=1.8, 6.8, 11.8 kg"
    --overshoot 5% --jobs 2 --out out/tune
  pneuservo tune rigs.toml --cluster tcp://node1:8786 --out out/tune
\b
The set of rigs, in a file as of pneuservo campaign:
  demand = "15,24,6,15 mm"
  [vary]
  "supply.pressure" = "6.5, 7.7 bar"
  "load.mass" = "1.8, 6.8, 11.8 kg"
"""


@click.command("tune", epilog=_EPILOG)
@click.argument("file", required=False)
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=VALUES",
    help="A parameter of the rig or a part of the card (soldered.…) and its values in the set, as "
    "for pneuservo campaign; may be repeated.  [default: the corners of supply pressure, load and "
    "capacitors]",
)
@click.option("--trials", type=int, help="Drawn at each point of the grid of the set.")
@click.option("--rig", help="A built-in rig or a rig file.  [default: single-axis]")
@click.option("--demand", metavar="LIST|RECORDING", help="[default: 15,24,6,15 mm]")
@click.option("--hold", type=Quantity("s", 0.0), help="Time at each set point.  [default: 0.5 s]")
@click.option("--rate", type=Quantity("Hz", 0.0), help="Samples per second.  [default: 2 kHz]")
@click.option("--design", metavar="FILE", help="The card; default the recommended.")
@click.option(
    "--overshoot",
    type=Quantity("", 0.0),
    default="2 %",
    show_default=True,
    help="Most that is allowed in any rig.",
)
@click.option(
    "--error",
    type=Quantity("m", 0.0),
    default="0.1 mm",
    show_default=True,
    help="Largest steady-state error allowed in any rig.",
)
@click.option("--population", type=int, default=40, show_default=True, help="Tried at a time.")
@click.option("--generations", type=int, default=30, show_default=True, help="How many times.")
@click.option(
    "--check",
    type=Count(min=0),
    default=100,
    show_default=True,
    help="Drawn rigs and cards in which the outcome is simulated.",
)
@click.option("--seed", type=Count(min=0), help="Of the search and of what is drawn.  [default: 0]")
@options_of_place
@click.option(
    "--out",
    metavar="FOLDER",
    help="Keep everything in FOLDER, with front.csv, tuning.json, front.svg and card.toml; a "
    "stopped tuning goes on.",
)
@click.option("--plot", metavar="FILE", help="Draw the front: .svg, .png or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    file: str | None,
    vary: tuple[str, ...],
    overshoot: float,
    error: float,
    population: int,
    generations: int,
    check: int,
    jobs: int | None,
    cluster: str | None,
    out: str | None,
    plot: str | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Find settings of P1 to P4 that are best in the worst rig of a stated set.

    Best is a front: settling time against chatter and control effort, each as it is in the worst
    rig. One point of it is recommended, with what keeps it from being better, confirmed by single
    runs and checked in drawn rigs with drawn cards. The same command goes on after a stop. Exit
    status 3 when no settings keep the limits in every rig.
    """
    from pneuservo.report.picture_files import require_picture
    from pneuservo.tuning.problem import tuning_problem
    from pneuservo.tuning.run import run_tuning
    from pneuservo.tuning.search import Search

    require_picture("--plot", plot)
    require_one_place(cluster, jobs)
    settings = read_given(file, vary, given)
    require_settings_kept((*_FILES, _PICTURE), out, file, settings)
    where = "--vary" if file is None else f"{file} [vary]"
    problem = tuning_problem(settings, overshoot, error, where)
    if problem.left_out:
        warn_left_out(str(settings["rig"]), problem.left_out)
    warn_of_transducer(problem.design, problem.campaign.rig)
    plan = Search(population, generations, problem.campaign.seed)
    with (
        progress(len(plan) + check) as step,
        place_of(cluster, jobs) as (pool, processes),
    ):
        found = run_tuning(problem, plan, check, out, processes, step, pool)
    _report(found, out, plot, as_json)


def _report(found: "RobustTuning", out: str | None, plot: str | None, as_json: bool) -> None:
    from analog_card.design_file import design_to_toml
    from pneuservo.tuning.picture import tuning_figure
    from pneuservo.tuning.summary import summary

    report = summary(found)
    contents = (
        found.table().to_csv(index=False),
        json.dumps(report, indent=2) + "\n",
        design_to_toml(found.design),
    )
    hand_out(
        report,
        dict(zip(_FILES, contents, strict=True)),
        _PICTURE,
        lambda: tuning_figure(found),
        lambda: _print(found, report),
        out,
        plot,
        as_json,
    )


def _print(found: "RobustTuning", report: dict[str, Any]) -> None:
    from rich.console import Console

    from pneuservo.campaign.summary import shown_unit
    from pneuservo.tuning.problem import OBJECTIVES
    from pneuservo.tuning.summary import shown_figure

    console = Console(highlight=False, markup=False)

    def say(text: str) -> None:
        console.print(text, soft_wrap=True)

    say(
        f"{report['title']}: {len(report['rigs'])} rigs, {report['tried']} settings tried, "
        f"{report['feasible']} within the limits, {len(report['front'])} on the front"
    )
    _print_front(console, found)
    chosen = report["recommended"]
    pots = ", ".join(
        f"{name} {setting:.3f} ({chosen['ohm'][name] / 1e3:.3g} kohm)"
        for name, setting in chosen["settings"].items()
    )
    say(f"recommended: {pots}")
    for bound in chosen["binds"]:
        say(f"  {_bound_words(bound, found)}")
    for name in OBJECTIVES:
        one, other = (
            _number(shown_figure(name, each.figures[name]))
            for each in (found.chosen, found.located)
        )
        if one != other:
            say(f"  {_words(name)} by single runs {other}, side by side {one} {shown_unit(name)}")
    if found.trials:
        say(f"checked in {len(found.trials)} drawn rigs with drawn cards:")
        _print_check(console, found)


def _print_front(console: Any, found: "RobustTuning") -> None:
    import numpy as np
    from rich.table import Table

    from pneuservo.campaign.summary import shown_unit
    from pneuservo.tuning.problem import LIMITED, OBJECTIVES, POTENTIOMETERS
    from pneuservo.tuning.summary import shown_figure

    names = (*OBJECTIVES, *LIMITED)
    heads = [f"{_SHORT[name]}\n{shown_unit(name)}" for name in names]
    title = "the front, each figure in the worst rig of the set"
    table = Table(
        *("", *POTENTIOMETERS, *heads),
        box=None,
        padding=(0, 2, 0, 0),
        title=title,
        title_justify="left",
    )
    last = len(found.front) - 1
    rows = {*np.linspace(0, last, min(last + 1, _MOST_ROWS)).round().astype(int), found.choice}
    for index in sorted(rows):
        each = found.front[index]
        settings = [f"{setting:.3f}" for setting in each.settings]
        figures = [_number(shown_figure(name, each.figures[name])) for name in names]
        table.add_row("*" if index == found.choice else "", *settings, *figures)
    console.print(table)
    if len(rows) <= last:
        console.print(f"and {last + 1 - len(rows)} more: see --out or --json")


def _print_check(console: Any, found: "RobustTuning") -> None:
    from rich.table import Table

    from pneuservo.campaign.summary import shown_unit
    from pneuservo.tuning.summary import shown_figure

    table = Table("figure", "median", "highest", "worst of the set or limit", "within")
    for each in found.judged:
        numbers = [
            _number(shown_figure(each.figure, value))
            for value in (each.median, each.highest, each.limit)
        ]
        head = f"{_words(each.figure)}, {shown_unit(each.figure)}"
        table.add_row(head, *numbers, f"{each.within} of {each.trials}")
    console.print(table)


def _bound_words(bound: dict[str, Any], found: "RobustTuning") -> str:
    from pneuservo.campaign.summary import shown_unit, values_in_words
    from pneuservo.tuning.summary import shown_figure

    name = bound["figure"]
    if bound["kind"] == "end of travel":
        return f"{name} is at the end of its travel"
    size = f"{shown_figure(name, bound['value']):.3g} {shown_unit(name)}"
    rig = values_in_words(bound["values"], found.problem.campaign.axes)
    says = "is worst" if bound["kind"] == "worst" else "is near its limit"
    return f"{_words(name)} {says}, {size}, with {rig}"


def _number(value: float) -> str:
    """Return a figure to a thousandth of its unit at most."""
    return f"{round(value, 3) + 0.0:.3g}"


def _words(name: str) -> str:
    return name.replace("_", " ")
