"""What commands share that run a loop many times: what varies, where it runs, what it gives."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from analog_card.console import Count
from analog_card.files import require_apart, write_files
from pneuservo.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PLACE = (
    click.option(
        "--jobs",
        type=Count(min=1),
        help="Processes to run in; the numbers do not depend on it.  [default: 1]",
    ),
    click.option("--cluster", metavar="ADDRESS", help="Run on the workers of a dask scheduler."),
)


def options_of_place(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that say where it runs, ``--jobs`` and ``--cluster``.

    Parameters
    ----------
    command : callable
        Takes ``jobs`` and ``cluster``.
    """
    for option in reversed(_PLACE):
        command = option(command)
    return command


def read_given(file: str | None, vary: Sequence[str], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a campaign file, with options in place of or beside what it says.

    Parameters
    ----------
    file : str or None
        A campaign file.
    vary : sequence of str
        Axes as options give them, ``NAME=VALUES``.
    given : mapping of str to anything
        The other options by their keys in a campaign file; None and nothing are not given.

    Raises
    ------
    InputError
        When the file cannot be used, or an axis has no name.
    """
    from pneuservo.campaign.plan_file import read_settings

    settings = read_settings(file) if file is not None else {}
    settings |= {key: value for key, value in given.items() if value not in (None, ())}
    settings["vary"] = {**settings.get("vary", {}), **dict(map(_axis, vary))}
    return settings


def require_settings_kept(
    outputs: Sequence[str], out: str | None, file: str | None, settings: Mapping[str, Any]
) -> None:
    """Refuse a folder in which a run would write over what it reads.

    Parameters
    ----------
    outputs : sequence of str
        Names of the files that are going to be written into the folder.
    out : str or None
        The folder.
    file : str or None
        A campaign file.
    settings : mapping of str to anything
        From `read_given`.

    Raises
    ------
    InputError
        When the campaign file, or a rig, design or recording that it or an option names, is one of
        them.
    """
    if out is None:
        return
    named = [file, *(settings.get(key) for key in ("rig", "design", "demand"))]
    inputs = [Path(name) for name in named if name]
    # A recording has its sidecar beside it.
    inputs += [path.with_suffix(".toml") for path in inputs if path.suffix]
    require_apart([Path(out) / name for name in outputs], inputs)


def require_one_place(address: str | None, jobs: int | None) -> None:
    """Refuse a cluster and processes of this computer at once.

    Raises
    ------
    InputError
        When both are given.
    """
    if address is not None and jobs is not None:
        raise InputError("--cluster and --jobs exclude each other: the cluster has its own workers")


@contextmanager
def place_of(address: str | None, jobs: int | None) -> Iterator[tuple[Executor | None, int]]:
    """Yield the pool to run in, None for processes of this computer, and how many it has.

    Parameters
    ----------
    address : str or None
        Of a cluster.
    jobs : int or None
        Processes of this computer.

    Raises
    ------
    InputError
        When nothing answers at the address.
    """
    if address is None:
        yield None, jobs or 1
        return
    from pneuservo.campaign.cluster import cluster

    with cluster(address) as place:
        yield place


def hand_out(
    report: Mapping[str, Any],
    files: Mapping[str, str],
    picture: str,
    draw: Callable[[], "Figure"],
    say: Callable[[], None],
    out: str | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Write the files and pictures of a run and print its report.

    Parameters
    ----------
    report : mapping
        For ``--json``.
    files : mapping of str to str
        What goes into the folder of ``--out``, by name.
    picture : str
        Name of the picture in that folder.
    draw, say : callable
        Draw the picture, and print the report for people.
    out, plot : str or None
        Folder, and file of a picture.
    as_json : bool
        Whether the report is printed as JSON and nothing else.
    """
    from pneuservo.report.picture_files import write_picture

    written = []
    pictures = [plot] if plot is not None else []
    if out is not None:
        written = [str(path) for path in write_files(Path(out), files)]
        pictures.insert(0, str(Path(out) / picture))
    if pictures:
        figure = draw()
        for name in pictures:
            write_picture(figure, name)
    if as_json:
        click.echo(json.dumps(report, indent=2))
        return
    say()
    for name in (*written, *pictures):
        click.echo(f"written: {name}")


def _axis(text: str) -> tuple[str, str]:
    name, equals, values = text.partition("=")
    if not equals:
        raise InputError(f'--vary {text!r}: write NAME=VALUES, such as "load.mass=1.8, 7 kg"')
    return name.strip(), values
