"""``pneuservo diagnose``: where and why a simulation differs from recordings."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from analog_card.console import Count, progress, writing
from analog_card.files import require_writable, write_files
from pneuservo.command_line.recording_files import (
    Window,
    read,
    require_room_for_valve,
    require_unread,
)
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig


class _ManyValidated(click.Command):
    """Lets one ``--validate`` take all the files up to the next option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        spread: list[str] = []
        collecting, nameless = False, False
        for word in args:
            option, _, first = word.partition("=")
            if word.startswith("-") and nameless:
                break
            if option == "--validate":
                collecting, nameless = True, not first
                spread += ["--validate", first] if first else []
                continue
            collecting = collecting and not word.startswith("-")
            nameless = False
            spread += ["--validate", word] if collecting else [word]
        if nameless:
            raise click.BadOptionUsage(
                "--validate", "--validate names no recording; name one, or leave it out", ctx
            )
        return super().parse_args(ctx, spread)


_EPILOG = """\b
Examples:
  pneuservo diagnose out/demo/example/leaking-volume.csv --out out/diagnosis
  pneuservo diagnose out/demo/example/leaking-volume.csv --json
"""


@click.command("diagnose", cls=_ManyValidated, epilog=_EPILOG)
@click.argument("recordings", nargs=-1, required=True, metavar="REC [REC ...]")
@click.option(
    "--validate",
    multiple=True,
    metavar="REC [REC ...]",
    help="Recordings to hold back: nothing shared is fitted to them.",
)
@click.option("--rig", help="Rig name or rig file, in place of the one the recordings name.")
@click.option("--window", type=Window(), help="Use only this stretch of the recordings [s].")
@click.option(
    "--validate-window",
    type=Window(),
    help="Use only this stretch of the recordings held back [s].",
)
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path("out/diagnosis"),
    show_default=True,
    help="Folder for the answer.",
)
@click.option(
    "--seed",
    type=Count(min=0),
    default=0,
    show_default=True,
    help="Seed of the noise chance is judged by.",
)
@click.option(
    "--jobs",
    type=Count(min=1),
    help="Fits at a time; the answer does not depend on it.  [default: one per processor]",
)
@click.option(
    "--without",
    multiple=True,
    metavar="PART",
    help="Leave a part of a servo's diagnosis out, to see what it is good for: stick-mask, "
    "nuisances, imitations, unnamed.",
)
@click.option("--json", "as_json", is_flag=True, help="Print diagnosis.json and nothing else.")
def command(
    recordings: tuple[str, ...],
    validate: tuple[str, ...],
    rig: str | None,
    window: tuple[float, float] | None,
    validate_window: tuple[float, float] | None,
    out: Path,
    seed: int,
    jobs: int | None,
    without: tuple[str, ...],
    as_json: bool,
) -> None:
    """Say where and why the simulation of a rig differs from recordings of it.

    Writes diagnosis.json, report.html and model.toml, the repaired rig. Exit status: 0 with an
    answer, whatever it is; 2 for unusable input; 3 when a fit failed.
    """
    from pneuservo.diagnosis import diagnose
    from pneuservo.report.answer_files import NAMES
    from pneuservo.simulation.trials import processors

    with progress() as step:
        step("reading the recordings")
        used = [read(path, rig, window) for path in recordings]
        held_back = [read(path, rig, validate_window) for path in validate]
        require_unread([out / name for name in NAMES], [*used, *held_back])
        require_room_for_valve(load_rig(rig or used[0].rig), out, [*NAMES, "report.html"])
        _require_apart(used, held_back)
        with writing("--out", out):
            require_writable(out)
        found = diagnose(used, held_back, rig, step, seed, without, jobs or processors())
        step("writing the report")
        with writing("--out", out):
            answer = write_answer(found, out)
    if as_json:
        click.echo(json.dumps(answer, indent=2))
        return
    from pneuservo.report.sessions import between_sessions_in_words
    from pneuservo.report.words import headline, not_judged_in_words

    if answer.get("partial"):
        click.echo("interrupted: this answer is made of what had been fitted until then")
    click.echo(f"{answer['verdict']}: {headline(answer)}")
    for sentence in (*not_judged_in_words(answer), *between_sessions_in_words(answer)):
        click.echo(sentence)
    click.echo(f"report: {out / 'report.html'}")


def _require_apart(used: Sequence[Recording], held_back: Sequence[Recording]) -> None:
    """Refuse samples that would count twice, or be held back and used as well."""
    seen: dict[Path, list[Recording]] = {}
    for recording in (*used, *held_back):
        if recording.source is None:
            continue
        same = seen.setdefault(recording.source.resolve(), [])
        for other in same:
            if recording.time[0] <= other.time[-1] and other.time[0] <= recording.time[-1]:
                raise InputError(
                    f"{recording.source} was given twice; leave it out once, or use different "
                    "stretches of it with --window and --validate-window"
                )
        same.append(recording)


def write_answer(found: Any, folder: Path) -> dict[str, Any]:
    """Write a diagnosis into a folder and return its document.

    Parameters
    ----------
    found : Diagnosis
        What was found.
    folder : Path
        Where ``diagnosis.json``, ``report.html`` and ``model.toml`` go.

    Returns
    -------
    dict
        The content of ``diagnosis.json``.
    """
    from pneuservo.diagnosis import document
    from pneuservo.report.answer_files import answer_files
    from pneuservo.report.page import diagnosis_page

    answer = document(found)
    write_files(
        folder, {**answer_files(found, answer), "report.html": diagnosis_page(found, answer)}
    )
    return answer
