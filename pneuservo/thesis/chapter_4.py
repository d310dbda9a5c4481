"""Chapter 4 of the thesis, the non-linear model: calibration, identification, validation."""

from pathlib import Path

from pneuservo.thesis.rows import Row


def rows() -> list[Row]:
    """Return the tables and the statements of chapter 4 beside ours."""
    from pneuservo.thesis.chapter_4_motion import motion_rows
    from pneuservo.thesis.chapter_4_valve import valve_rows

    return [*valve_rows(), *motion_rows()]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of chapter 4 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    from pneuservo.thesis.chapter_4_pictures import draw_all

    return draw_all(folder)
