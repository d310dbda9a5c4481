"""Chapter 5 of the thesis, linear models and state feedback: its tables and statements."""

from pathlib import Path

from pneuservo.rigs import Rig, load_rig
from pneuservo.thesis.chapter_5_pictures import draw_all
from pneuservo.thesis.chapter_5_responses import response_rows
from pneuservo.thesis.chapter_5_statements import statement_rows
from pneuservo.thesis.chapter_5_tables import table_rows
from pneuservo.thesis.rows import Row


def rows(rig: Rig | None = None) -> list[Row]:
    """Return tables 5.3 to 5.5 and the statements of chapter 5 beside ours.

    Parameters
    ----------
    rig : Rig, optional
        For the non-linear simulations with the printed parameters, instead of the built-in one.
    """
    used = load_rig("single-axis") if rig is None else rig
    return [*table_rows(), *statement_rows(), *response_rows(used)]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of chapter 5 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to.
    """
    return draw_all(folder)
