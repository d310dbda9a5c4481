"""``pneuservo thesis``: recompute the thesis' tables and stated results, and write the page."""

import json
from pathlib import Path
from typing import Any

import click

from analog_card.console import Count, progress, writing
from analog_card.files import write_whole

PAGE, PICTURES = "reproduction.md", "reproduction"
# Where the page of the whole thesis stands; no other page takes its place unless asked to.
WHOLE = "docs"

EXAMPLES = """\b
Examples:
  pneuservo thesis
  pneuservo thesis --chapter 8
  pneuservo thesis --json > rows.json
"""


@click.command("thesis", epilog=EXAMPLES)
@click.option(
    "--chapter",
    "chapters",
    multiple=True,
    metavar="NUMBER",
    help="Only this chapter; may be given again.  [default: all, 4 to 9 and appendix A1]",
)
@click.option(
    "--out",
    metavar="FOLDER",
    help=f"Folder for {PAGE} and, below it, {PICTURES}/ with the pictures.  [default: "
    f"{WHOLE}; with --chapter or --rig nothing is written]",
)
@click.option("--page/--no-page", default=True, help="Write the page and its pictures, or neither.")
@click.option(
    "--rig",
    help="A rig for the non-linear simulations of chapters 5, 7 and 8 with the printed parameters: "
    "5.21, 7.13, the remark of 7.12, and chapter 8 with its pictures.  [default: single-axis]",
)
@click.option(
    "--jobs",
    type=Count(1, 64),
    default=1,
    show_default=True,
    help="Chapters recomputed at the same time.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the results as JSON, nothing else.")
def command(
    chapters: tuple[str, ...],
    out: str | None,
    page: bool,
    rig: str | None,
    jobs: int,
    as_json: bool,
) -> None:
    """Recompute every table and stated result of the thesis that the package covers.

    Thesis value, ours with the printed and with the reconciled parameters, and a verdict.
    """
    from pneuservo.command_line.baseline_rig import baseline_rig
    from pneuservo.thesis.chapters import CHAPTERS, recompute, require_chapters
    from pneuservo.thesis.page import to_dict, write_reproduction

    used = baseline_rig(rig) if rig is not None else None
    given = tuple(int(name) if name.isdecimal() else name.upper() for name in chapters)
    numbers = given or CHAPTERS
    require_chapters(numbers)
    whole = used is None and set(numbers) == set(CHAPTERS)
    place = WHOLE if out is None and whole else out
    target = Path(place) / PAGE if page and place is not None else None
    folder = _picture_folder(target.parent) if target is not None else None
    with progress(len(set(numbers))) as step:
        found = recompute(numbers, folder, used, jobs, step)
    if target is not None:
        write_whole(target, write_reproduction(found, target))
    report = to_dict(found)
    if as_json:
        click.echo(json.dumps(report, indent=2))
    else:
        _print(found, str(target) if target is not None else None)


def _picture_folder(out: Path) -> Path:
    folder = out / PICTURES
    with writing("--out", out):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def _print(chapters: list[Any], written: str | None) -> None:
    from rich.console import Console
    from rich.table import Column, Table

    from pneuservo.thesis.page import VERDICTS, counts, percent, shown

    console = Console(highlight=False, markup=False)
    off = Table(
        Column("not reproduced", overflow="fold"), "thesis", "printed", "reconciled", "verdict"
    )
    for chapter in chapters:
        for row in chapter.rows:
            if row.verdict == VERDICTS[0]:
                continue
            ours = [
                f"{shown(value)} {percent(difference)}".strip()
                for value, difference in (
                    (row.printed, row.printed_difference),
                    (row.reconciled, row.reconciled_difference),
                )
            ]
            off.add_row(row.id, f"{shown(row.stated)} {row.unit}".strip(), *ours, row.verdict)
    if off.row_count:
        console.print(off)
    table = Table("chapter", *VERDICTS)
    for chapter in chapters:
        found = counts(chapter.rows)
        table.add_row(
            f"{chapter.number}: {chapter.title}", *[str(found[verdict]) for verdict in VERDICTS]
        )
    console.print(table)
    if written:
        console.print(f"written: {written}", soft_wrap=True)
