"""Chapter 7 of the thesis, design of the sliding surface: its results and statements."""

from pathlib import Path

from pneuservo.rigs import Rig, load_rig
from pneuservo.thesis.chapter_7_pictures import draw_all
from pneuservo.thesis.chapter_7_reachability import reachability_rows
from pneuservo.thesis.chapter_7_surface import surface_rows
from pneuservo.thesis.rows import Row


def rows(rig: Rig | None = None) -> list[Row]:
    """Return the stated results of chapter 7 beside ours.

    Parameters
    ----------
    rig : Rig, optional
        For the non-linear simulations with the printed parameters, instead of the built-in one.
    """
    used = load_rig("single-axis") if rig is None else rig
    return [*surface_rows(used), *reachability_rows()]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of chapter 7 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    return draw_all(folder)
