"""Which chapters of the thesis are recomputed, and how to recompute them."""

import importlib
import inspect
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path

from threadpoolctl import threadpool_limits

from analog_card.processes import processes
from pneuservo.errors import InputError
from pneuservo.rigs import Rig
from pneuservo.thesis.rows import Row

# Every chapter module has rows() and pictures(folder); where a rig is simulated they take one too.
CHAPTERS: tuple[int | str, ...] = (4, 5, 6, 7, 8, 9, "A1")


@dataclass(frozen=True)
class Chapter:
    """A recomputed chapter.

    Attributes
    ----------
    number : int or str
        Of the chapter; of an appendix as printed, such as ``"A1"``.
    title : str
        What it is about, from the first line of its module.
    rows : tuple of Row
        What is stated, beside ours.
    pictures : tuple of Path
        Drawn figures.
    rig : str, optional
        Title of the rig that took the place of the built-in one; empty where none did.
    """

    number: int | str
    title: str
    rows: tuple[Row, ...]
    pictures: tuple[Path, ...]
    rig: str = ""

    @property
    def name(self) -> str:
        """Return what the thesis calls it, such as ``Chapter 9`` or ``Appendix A1``."""
        return _name(self.number)


def recompute(
    numbers: Sequence[int | str] = CHAPTERS,
    folder: Path | None = None,
    rig: Rig | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda _: None,
) -> list[Chapter]:
    """Recompute chapters of the thesis.

    Parameters
    ----------
    numbers : sequence of int or str, optional
        Of `CHAPTERS`; each is taken once, in order.
    folder : Path, optional
        Where the pictures go; it has to exist. Without it none are drawn.
    rig : Rig, optional
        For the non-linear simulations with the printed parameters, instead of the built-in
        single axis.
    jobs : int, optional
        Chapters recomputed at the same time; the result is the same.
    step : callable, optional
        Told what is computed next, or in parallel what is done.

    Returns
    -------
    list of Chapter
        In the order of `CHAPTERS`.

    Raises
    ------
    InputError
        When a number is not that of a chapter that is recomputed.
    """
    require_chapters(numbers)
    wanted = [number for number in CHAPTERS if number in numbers]
    if jobs <= 1 or len(wanted) <= 1:
        found = []
        for number in wanted:
            step(_name(number).lower())
            found.append(_recompute(number, folder, rig))
        return found
    done: dict[int | str, Chapter] = {}
    with processes(min(jobs, len(wanted)), start="fork") as pool:
        running = {pool.submit(_recompute, number, folder, rig): number for number in wanted}
        for future in as_completed(running):
            done[running[future]] = future.result()
            step(f"{_name(running[future]).lower()} done")
    return [done[number] for number in wanted]


def require_chapters(numbers: Sequence[int | str]) -> None:
    """Refuse a chapter that is not recomputed.

    Parameters
    ----------
    numbers : sequence of int or str
        As `recompute` takes them.

    Raises
    ------
    InputError
        When one is none of `CHAPTERS`.
    """
    for number in numbers:
        if number not in CHAPTERS:
            known = ", ".join(str(chapter) for chapter in CHAPTERS)
            raise InputError(f"chapter {number} is not recomputed; there are: {known}")


def _name(number: int | str) -> str:
    return f"Chapter {number}" if isinstance(number, int) else f"Appendix {number}"


def _recompute(number: int | str, folder: Path | None, rig: Rig | None) -> Chapter:
    file = _name(number).lower().replace(" ", "_")
    module = importlib.import_module(f"pneuservo.thesis.{file}")
    with threadpool_limits(limits=1, user_api="blas"):
        rows = module.rows(**_taken(module.rows, rig))
        pictures = (
            module.pictures(folder, **_taken(module.pictures, rig)) if folder is not None else []
        )
    title = (module.__doc__ or "").split("\n")[0].rstrip(".")
    title = title.removeprefix(f"{_name(number)} of the thesis").lstrip(":, ")
    used = _taken(module.rows, rig).get("rig")
    return Chapter(number, title, tuple(rows), tuple(pictures), used.title if used else "")


def _taken(function: Callable[..., object], rig: Rig | None) -> dict[str, Rig]:
    """Return the rig for a function that takes one: linear models have no use for another plant."""
    takes = rig is not None and "rig" in inspect.signature(function).parameters
    return {"rig": rig} if takes and rig is not None else {}
