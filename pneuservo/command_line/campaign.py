"""``pneuservo campaign``: a closed loop run many times, over grids and distributions."""

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import Count, Quantity, progress, warn
from pneuservo.command_line.campaign_options import (
    hand_out,
    options_of_place,
    place_of,
    read_given,
    require_one_place,
    require_settings_kept,
)

if TYPE_CHECKING:
    from pneuservo.campaign.run import Outcome

# What is written into the folder of --out.
_FILES, _PICTURE = ("samples.csv", "summary.json"), "metrics.svg"
# Points of the grid that are printed; all of them are in the folder and in the JSON.
_MOST_ROWS = 40

_EPILOG = """\b
Examples:
  pneuservo campaign --controller sliding-mode --demand "15,24 mm"
    --vary "supply.pressure=6.5:7.7 bar:5"
  pneuservo campaign --controller analogue-card --demand "15,24,6,15 mm" --trials 200 --jobs 2
    --vary "load.mass=normal(1.825 kg, 3 %)" --vary "piston.coulomb_friction=tolerance"
    --vary "soldered.velocity_differentiator.capacitance=tolerance" --out out/campaign
  pneuservo campaign campaign.toml --cluster tcp://node1:8786 --out out/campaign
\b
Campaign file:
  controller = "sliding-mode"
  demand = "15,24,6,15 mm"
  trials = 100
  [vary]
  "supply.pressure" = "6.5:7.7 bar:5"
  "load.mass" = "normal(1.825 kg, 3 %)"
"""


@click.command("campaign", epilog=_EPILOG)
@click.argument("file", required=False)
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=VALUES",
    help='A parameter and its values: a list, "LOW:HIGH UNIT:COUNT", "normal(MEAN, DEVIATION)", '
    '"uniform(LOW, HIGH)", "log_uniform(LOW, HIGH)" or "tolerance"; may be repeated. Names are '
    "those of rig files, of design files, controller.OPTION, effect:PARAMETER and element.NAME.",
)
@click.option("--trials", type=int, help="Drawn at each point of the grid.  [default: 100 or 1]")
@click.option("--seed", type=Count(min=0), help="Of what is drawn.  [default: 0]")
@click.option("--rig", help="A built-in rig or a rig file.  [default: single-axis]")
@click.option("--controller", metavar="NAME", help="As for pneuservo simulate.")
@click.option("--demand", metavar="LIST|RECORDING", help='Such as "15,24,6,15 mm".')
@click.option("--hold", type=Quantity("s", 0.0), help="Time at each set point.  [default: 0.5 s]")
@click.option("--rate", type=Quantity("Hz", 0.0), help="Samples per second.  [default: 1 kHz]")
@click.option("--design", metavar="FILE", help="Design of an analogue card.")
@click.option("--card", help="What a card is simulated by: figures, behaviour or circuit.")
@click.option("--without", multiple=True, help="An imperfection that the card is to lack.")
@click.option(
    "--metric",
    "metrics",
    multiple=True,
    help="What to measure; may be repeated.  [default: rise_time, settling_time, overshoot, "
    "steady_state_error, limit_cycle_frequency and limit_cycle_stroke; of a recorded demand "
    "largest_error and rms_error in place of the first four]",
)
@options_of_place
@click.option(
    "--out",
    metavar="FOLDER",
    help="Keep samples, summary.json and metrics.svg in FOLDER; a stopped campaign goes on.",
)
@click.option("--plot", metavar="FILE", help="Draw metrics over axes: .svg, .png or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON, nothing else.")
def command(
    file: str | None,
    vary: tuple[str, ...],
    jobs: int | None,
    cluster: str | None,
    out: str | None,
    plot: str | None,
    as_json: bool,
    **given: Any,
) -> None:
    """Run a closed loop many times, over grids and distributions of any of its numbers.

    The campaign is the one in FILE, with options in place of or beside what it says. Sample by
    sample it goes to the folder of --out as it comes; the same command goes on after a stop, and
    gives the same numbers in one process, in many, or on a cluster.
    """
    from pneuservo.campaign.plan_file import campaign_of
    from pneuservo.campaign.run import run_campaign
    from pneuservo.report.picture_files import require_picture

    require_picture("--plot", plot)
    require_one_place(cluster, jobs)
    settings = read_given(file, vary, given)
    require_settings_kept((*_FILES, _PICTURE), out, file, settings)
    campaign = campaign_of(settings, "--vary" if file is None else f"{file} [vary]", warn)
    with progress(len(campaign)) as step, place_of(cluster, jobs) as (pool, processes):
        outcome = run_campaign(campaign, out, processes, step, pool)
    _report(outcome, out, plot, as_json)


def _report(outcome: "Outcome", out: str | None, plot: str | None, as_json: bool) -> None:
    from pneuservo.campaign.picture import campaign_figure
    from pneuservo.campaign.summary import summary

    report = summary(outcome)
    contents = (outcome.table().to_csv(), json.dumps(report, indent=2) + "\n")
    hand_out(
        report,
        dict(zip(_FILES, contents, strict=True)),
        _PICTURE,
        lambda: campaign_figure(outcome),
        lambda: _print(outcome, report),
        out,
        plot,
        as_json,
    )


def _print(outcome: "Outcome", report: Mapping[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console(highlight=False, markup=False)

    def say(text: str) -> None:
        console.print(text, soft_wrap=True)

    say(f"{report['title']}: {report['samples']} samples of {report['duration']:.4g} s")
    if report["failed"]:
        say(f"{report['failed']} could not be simulated; the first: {report['first_error']}")
    columns = ("mean", "deviation", "lowest", "median", "highest")
    table = Table("metric", *columns, "without")
    for entry in report["metrics"]:
        metric = entry["metric"]
        numbers = [_shown_metric(metric, entry[name]) for name in columns]
        table.add_row(_head(metric), *numbers, str(entry["without"] or ""))
    console.print(table)
    for entry in report["metrics"]:
        if entry["important"]:
            shares = ", ".join(f"{k} ({100 * v:.0f} %)" for k, v in entry["important"].items())
            say(f"{_words(entry['metric'])} depends on {shares}")
    _print_grid(console, outcome)


def _print_grid(console: Any, outcome: "Outcome") -> None:
    from rich.table import Table

    from pneuservo.campaign.summary import grid_means, shown_axis

    means = grid_means(outcome)
    if means.empty:
        return
    axes = {axis.name: axis for axis in outcome.campaign.axes}
    names = [str(name) for name in means.index.names]
    metrics = [name for name in means.columns if means[name].notna().any()]
    heads = [f"{name}, {axes[name].shown}".rstrip(", ") for name in names]
    table = Table(title="means at the points of the grid", title_justify="left")
    for head in (*heads, *map(_head, metrics)):
        table.add_column(head, overflow="fold")
    rows = means.reset_index()
    for row in rows.head(_MOST_ROWS).to_dict("records"):
        cells = [f"{shown_axis(axes[name], row[name]):.4g}" for name in names]
        table.add_row(*cells, *(_shown_metric(name, row[name]) for name in metrics))
    console.print(table)
    if len(rows) > _MOST_ROWS:
        console.print(f"and {len(rows) - _MOST_ROWS} more points: see --out or --json")


def _words(metric: str) -> str:
    return metric.replace("_", " ")


def _head(metric: str) -> str:
    from pneuservo.campaign.summary import shown_unit

    return f"{_words(metric)}, {shown_unit(metric)}"


def _shown_metric(metric: str, value: float | None) -> str:
    """Return a metric in the unit in which people read it, to a tenth of a thousandth at most."""
    from pneuservo.campaign.metrics import METRICS
    from pneuservo.campaign.summary import shown, shown_unit

    if value is None or math.isnan(value):
        return ""
    return f"{round(shown(value, shown_unit(metric), METRICS[metric]), 4) + 0.0:.4g}"
