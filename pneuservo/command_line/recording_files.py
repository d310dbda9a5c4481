"""Recordings named on a command line: what was worked around is said, and a window is cut out."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import click

from analog_card.console import warn
from analog_card.errors import InputError as QuantityError
from analog_card.files import require_apart
from analog_card.quantities import to_si
from pneuservo.errors import InputError
from pneuservo.recordings import Recording, read_recording
from pneuservo.recordings.time_checks import FEWEST_SAMPLES
from pneuservo.rigs import Rig, load_rig
from pneuservo.rigs.rig_file import files_beside


class Window(click.ParamType):
    """A stretch of time, ``START:END``, either side optional."""

    name = "START:END"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        """Return start and end in seconds."""
        if isinstance(value, tuple):
            return value
        start, separator, end = str(value).partition(":")
        if not separator:
            self.fail(f"{value!r} has no colon; write for example 1.5:4 or 82s:", param, ctx)
        try:
            window = (
                to_si(start, "s", "start") if start.strip() else float("-inf"),
                to_si(end, "s", "end") if end.strip() else float("inf"),
            )
        except QuantityError as problem:
            self.fail(str(problem), param, ctx)
        if window[0] >= window[1]:
            self.fail(f"{value!r} ends before it starts", param, ctx)
        return window


def read(path: str, rig: str | None, window: tuple[float, float] | None = None) -> Recording:
    """Read a recording, say on stderr what was worked around, and cut the window out of it.

    Parameters
    ----------
    path : str
        The data file.
    rig : str, optional
        Rig name or rig file, in place of the one that the recording names.
    window : tuple of float, optional
        Start and end of what is used [s]; all of it by default.

    Returns
    -------
    Recording
        The part that lies in the window.

    Raises
    ------
    InputError
        When the file cannot be used, or too little of it lies in the window.
    """
    recording = read_recording(path, rig)
    for message in recording.warnings:
        warn(f"{path}: {message}")
    if window is None:
        return recording
    cut = recording.slice(*window)
    if len(cut) < FEWEST_SAMPLES:
        first, last = recording.time[0], recording.time[-1]
        raise InputError(
            f"{path}: {len(cut)} samples lie in the window {window[0]:g}:{window[1]:g} s, at "
            f"least {FEWEST_SAMPLES} are needed; the recording runs from {first:g} to {last:g} s"
        )
    return cut


def require_room_for_valve(rig: Rig, folder: Path, names: Sequence[str]) -> None:
    """Refuse to write the valve file of a rig over another file.

    Parameters
    ----------
    rig : Rig
        Its valve file, if it has one, is written beside its copy.
    folder : Path
        Where to.
    names : sequence of str
        What else is written there.

    Raises
    ------
    InputError
        When there is another file of that name, or one of that name is written.
    """
    before = {_valve_of(folder / name) for name in names if name.endswith(".toml")}
    for name, text in files_beside(rig).items():
        there = folder / name
        # The copy that an earlier run has put there is renewed as all else is.
        another = there.is_file() and name not in before and there.read_text("utf-8") != text
        if name in names or another:
            raise InputError(
                f"{there}: the valve file of {rig.name} would take its place; choose another folder"
            )


def _valve_of(path: Path) -> str:
    """Return the name of the valve file of a rig file; nothing where there is none."""
    try:
        return Path(load_rig(path).valve).name
    except InputError:
        return ""


def require_unread(
    outputs: Iterable[Path], recordings: Sequence[Recording], *files: str | Path | None
) -> None:
    """Refuse to write over recordings, what they refer to, or other files that were given.

    Parameters
    ----------
    outputs : iterable of Path
        Files that are going to be written.
    recordings : sequence of Recording
        What was read.
    *files : str, Path or None
        Other options that may name a file.

    Raises
    ------
    InputError
        When a file is among both.
    """
    others = [name for name in files if name is not None]
    require_apart(outputs, [*(file for entry in recordings for file in entry.files), *others])
