"""Which chapters of the thesis are recomputed, and how to recompute them."""

import importlib
import inspect
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

from threadpoolctl import threadpool_limits

from pneuservo.errors import InputError
from pneuservo.rigs import Rig
from pneuservo.thesis.rows import Row

# Every chapter module has rows() and pictures(folder).
CHAPTERS = (4, 5, 6, 7, 8, 9)


@dataclass(frozen=True)
class Chapter:
    """A recomputed chapter.

    Attributes
    ----------
    number : int
        Of the chapter.
    title : str
        What it is about, from the first line of its module.
    rows : tuple of Row
        What is stated, beside ours.
    pictures : tuple of Path
        Drawn figures.
    """

    number: int
    title: str
    rows: tuple[Row, ...]
    pictures: tuple[Path, ...]


def recompute(
    numbers: Sequence[int] = CHAPTERS,
    folder: Path | None = None,
    rig: Rig | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda _: None,
) -> list[Chapter]:
    """Recompute chapters of the thesis.

    Parameters
    ----------
    numbers : sequence of int, optional
        Of the chapters; each is taken once, in order.
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
        By number.

    Raises
    ------
    InputError
        When a number is not that of a chapter that is recomputed.
    """
    wanted = sorted(set(numbers))
    for number in wanted:
        if number not in CHAPTERS:
            known = ", ".join(str(chapter) for chapter in CHAPTERS)
            raise InputError(f"chapter {number} is not recomputed; there are: {known}")
    if jobs <= 1 or len(wanted) <= 1:
        found = []
        for number in wanted:
            step(f"chapter {number}")
            found.append(_recompute(number, folder, rig))
        return found
    done: dict[int, Chapter] = {}
    with ProcessPoolExecutor(min(jobs, len(wanted))) as pool:
        running = {pool.submit(_recompute, number, folder, rig): number for number in wanted}
        for future in as_completed(running):
            done[running[future]] = future.result()
            step(f"chapter {running[future]} done")
    return [done[number] for number in wanted]


def _recompute(number: int, folder: Path | None, rig: Rig | None) -> Chapter:
    module = importlib.import_module(f"pneuservo.thesis.chapter_{number}")
    # Chapters of linear models have no use for another plant.
    takes_rig = "rig" in inspect.signature(module.rows).parameters
    with threadpool_limits(limits=1, user_api="blas"):
        rows = module.rows(rig) if takes_rig and rig is not None else module.rows()
        pictures = module.pictures(folder) if folder is not None else []
    title = (module.__doc__ or "").split("\n")[0].rstrip(".")
    title = title.removeprefix(f"Chapter {number} of the thesis").lstrip(":, ")
    return Chapter(number, title, tuple(rows), tuple(pictures))
