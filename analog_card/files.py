"""Writing files whole or not at all."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a file so that a reader sees the old content or the new, never a part.

    Parameters
    ----------
    path : str or Path
        Where to write; missing parent folders are made.
    content : str or bytes
        What to write; text is encoded as UTF-8.

    Returns
    -------
    Path
        The path written.

    Raises
    ------
    OSError
        When the folder cannot be written to.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> write_whole(folder + "/deep/note.txt", "done").read_text()
    'done'
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    data = content.encode("utf-8") if isinstance(content, str) else content
    descriptor, scratch = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
        os.chmod(scratch, 0o666 & ~_umask())
        os.replace(scratch, path)
    except BaseException:
        Path(scratch).unlink(missing_ok=True)
        raise
    return path


def write_files(folder: str | Path, contents: Mapping[str, str | bytes]) -> list[Path]:
    """Write several files into a folder, each whole; all of them are made before the first is.

    Parameters
    ----------
    folder : str or Path
        Where to write; made when missing.
    contents : mapping of str to str or bytes
        Name in the folder to what to write.

    Returns
    -------
    list of Path
        The paths written.

    Raises
    ------
    OSError
        When the folder cannot be written to.
    """
    return [write_whole(Path(folder) / name, content) for name, content in contents.items()]


def _umask() -> int:
    # The mask can only be read by setting it.
    mask = os.umask(0)
    os.umask(mask)
    return mask
