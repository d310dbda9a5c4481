"""Files that a sidecar points to: only beside the recording, never elsewhere."""

import os
from pathlib import Path

from pneuservo.errors import InputError


def inside_folder(text: str, folder: Path, where: str) -> Path:
    """Return the path of a file that a sidecar names.

    Parameters
    ----------
    text : str
        The path as written, relative to the recording's folder.
    folder : Path
        The recording's folder.
    where : str
        File and key, for the message.

    Returns
    -------
    Path
        The absolute path, links resolved.

    Raises
    ------
    InputError
        When the path is absolute, leaves the folder (links included), or is not a file.
    """
    folder = Path(os.path.realpath(folder))
    if "\0" in text:
        raise InputError(f"{where}: {text!r} is not a path; name a file in {folder}")
    target = Path(os.path.realpath(folder / text))
    if Path(text).is_absolute() or not target.is_relative_to(folder):
        raise InputError(
            f"{where}: {text!r} leaves the recording's folder {folder}; "
            "copy the file into that folder and name it there"
        )
    if not target.is_file():
        raise InputError(f"{where}: there is no file {text!r} in {folder}")
    return target
