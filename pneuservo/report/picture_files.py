"""Figures written to files."""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from analog_card.files import write_whole
from pneuservo.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUFFIXES = (".png", ".svg", ".pdf")


def require_picture(option: str, file: str | None) -> None:
    """Refuse a name that does not say which form of picture it is.

    Parameters
    ----------
    option : str
        What it was given to, for the message.
    file : str or None
        None is no picture, and accepted.

    Raises
    ------
    InputError
        When the name ends in anything but .svg, .png or .pdf.
    """
    if file is not None and Path(file).suffix.lower() not in SUFFIXES:
        raise InputError(f"{option} {file}: a picture ends in one of: {', '.join(SUFFIXES)}")


def write_picture(figure: "Figure", file: str | Path) -> None:
    """Write a figure, whole or not at all, in the form that the name ends in.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure.
    file : str or Path
        Ending in .svg, .png or .pdf.
    """
    import matplotlib

    stream = io.BytesIO()
    form = Path(file).suffix[1:].lower()
    # The same figure is the same file: no date, no random names, text as text.
    metadata = {"Date": None, "Creator": None} if form == "svg" else None
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "pneuservo"}):
        figure.savefig(stream, format=form, dpi=150, metadata=metadata)
    write_whole(file, stream.getvalue())


def write_pictures(figures: Mapping[str, "Figure"], folder: Path) -> list[Path]:
    """Write figures into a folder as SVG and return the files.

    Parameters
    ----------
    figures : mapping of str to matplotlib.figure.Figure
        Name of each file without its ending, and the figure.
    folder : Path
        Where to; it has to exist.
    """
    files = [folder / f"{name}.svg" for name in figures]
    for file, figure in zip(files, figures.values(), strict=True):
        write_picture(figure, file)
    return files
