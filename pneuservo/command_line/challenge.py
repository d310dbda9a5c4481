"""``pneuservo challenge``: the blind trial of the diagnosis."""

import json
from pathlib import Path

import click

from analog_card.console import Count, progress
from analog_card.files import alone_in, write_whole
from pneuservo.challenge.sizes import FULL, QUICK
from pneuservo.naming import require_known

_EPILOG = """\b
Examples:
  pneuservo challenge --quick --out out/challenge-quick
  pneuservo challenge --cases 200 --jobs 2 --out out/challenge
  pneuservo challenge --out out/challenge      (takes up a trial that was stopped)
"""


@click.command("challenge", epilog=_EPILOG)
@click.option("--cases", type=Count(min=1), help=f"How many cases; {FULL} in a new folder.")
@click.option("--quick", is_flag=True, help=f"A trial of {QUICK} cases.")
@click.option(
    "--seed", type=Count(min=0), help="Draws the cases; drawn by chance and stated without it."
)
@click.option(
    "--jobs", type=Count(min=1), default=2, show_default=True, help="Processes at a time."
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("out/challenge"),
    show_default=True,
    help="Folder of the trial; one that holds a trial is taken up again.",
)
@click.option(
    "--beside",
    type=click.Path(file_okay=False, exists=True, path_type=Path),
    multiple=True,
    help="Folder of a finished trial to report on the same page.",
)
@click.option(
    "--page",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Where the page goes; challenge.md in the folder of the trial without it.",
)
@click.option(
    "--without",
    multiple=True,
    metavar="PART",
    help="Diagnose also with this part left out (pneuservo diagnose --without PART).",
)
@click.option("--make-only", is_flag=True, help="Make and seal the cases, diagnose none.")
@click.option("--json", "as_json", is_flag=True, help="Print the score and nothing else.")
def command(
    cases: int | None,
    quick: bool,
    seed: int | None,
    jobs: int,
    out: Path,
    beside: tuple[Path, ...],
    page: Path | None,
    without: tuple[str, ...],
    make_only: bool,
    as_json: bool,
) -> None:
    """Conceal effects in made recordings, diagnose them blindly, and score the answers.

    Keys are sealed before the first diagnosis and opened after the last. A trial that was
    stopped is taken up where it was; its folder can be copied.
    """
    from pneuservo.challenge.trial import (
        diagnose_cases,
        judge_cases,
        make_cases,
        open_trial,
        summary,
    )
    from pneuservo.diagnosis import PARTS

    for part in without:
        require_known(part, PARTS, "--without")
    if quick and cases is not None:
        raise click.UsageError("--quick and --cases exclude each other")
    wanted = QUICK if quick else cases
    if wanted is None and not (out / "plan.json").exists():
        wanted = FULL
    others = [open_trial(folder, None, None) for folder in beside]
    with alone_in(out):
        trial = open_trial(out, wanted, seed)
        with progress((2 + len(without)) * trial.cases) as step:
            make_cases(trial, jobs, step)
            if make_only:
                made = f"{trial.cases} cases with seed {trial.seed}: {out / 'cases'}"
                click.echo(made, err=as_json)
                return
            for part in ("", *without):
                diagnose_cases(trial, jobs, step, part)
    judged = judge_cases(trial)
    found = summary(trial, judged)
    text = json.dumps(found, indent=2)
    write_whole(out / "score.json", text + "\n")
    from pneuservo.challenge.page import trial_page

    everything = [(trial, judged), *((other, judge_cases(other)) for other in others)]
    written = write_whole(page or out / "challenge.md", trial_page(everything))
    if as_json:
        click.echo(text)
        return
    _show(found["measures"])
    click.echo(f"seed {trial.seed}; page: {written}")


def _show(measures: list[dict]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("cases", "measure", "asked", "found", "of")
    for line in measures:
        if not line["count"]:
            continue
        asked = "" if line["asked"] is None else f"{line['asked']:.3g}"
        colour = {True: "green", False: "red", None: "default"}[line["met"]]
        table.add_row(
            line["group"],
            line["name"],
            asked,
            f"[{colour}]{line['value']:.3g}[/{colour}]",
            str(line["count"]),
        )
    Console().print(table)
