"""Chapter 9 of the thesis, implementation: converters, digital, hybrid and analogue control."""

from pathlib import Path

from pneuservo.report.picture_files import write_pictures
from pneuservo.thesis.chapter_9_arm import arm_figure, arm_rows
from pneuservo.thesis.chapter_9_detectability import detectability_figure, detectability_rows
from pneuservo.thesis.chapter_9_frequency import frequency_rows
from pneuservo.thesis.chapter_9_pictures import figures
from pneuservo.thesis.chapter_9_robustness import robustness_rows
from pneuservo.thesis.chapter_9_steps import step_rows
from pneuservo.thesis.rows import Row


def rows() -> list[Row]:
    """Return what chapter 9 states, beside ours."""
    return [
        *detectability_rows(),
        *step_rows(),
        *robustness_rows(),
        *arm_rows(),
        *frequency_rows(),
    ]


def pictures(folder: Path) -> list[Path]:
    """Draw the figures of chapter 9 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    """
    return write_pictures(
        {
            "chapter-9-detectability": detectability_figure(),
            **figures(),
            "chapter-9-arm": arm_figure(),
        },
        folder,
    )
