"""Writing files whole or not at all."""

import errno
import fcntl
import os
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from analog_card.errors import InputError


def write_whole(path: str | Path, content: str | bytes) -> Path:
    """Write a file so that a reader sees the old content or the new, never a part.

    Parameters
    ----------
    path : str or Path
        Where to write; missing parent folders are made. A link is followed; a device or a pipe is
        written to and stays what it is.
    content : str or bytes
        What to write; text is encoded as UTF-8.

    Returns
    -------
    Path
        The path written.

    Raises
    ------
    OSError
        When the folder cannot be written to, or the path is that of a folder or of a link that
        leads back to itself.

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
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OSError(errno.ELOOP, "is a link that leads back to itself; remove it", str(path))
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a folder; name a file in it", str(path))
    if target.exists() and not target.is_file():
        target.write_bytes(data)
        return path
    descriptor, scratch = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
        os.chmod(scratch, 0o666 & ~_umask())
        os.replace(scratch, target)
    except BaseException:
        Path(scratch).unlink(missing_ok=True)
        raise
    return path


def require_writable(folder: Path) -> None:
    """Try whether a folder can be made and written to, and leave nothing behind.

    Parameters
    ----------
    folder : Path
        It and its parents need not exist.

    Raises
    ------
    OSError
        When it cannot.
    """
    existing = next(parent for parent in (folder, *folder.absolute().parents) if parent.exists())
    with tempfile.TemporaryFile(dir=existing):
        pass


@contextmanager
def alone_in(folder: str | Path) -> Iterator[None]:
    """Keep other processes out of a folder, as far as they ask.

    Parameters
    ----------
    folder : str or Path
        Made when missing. It is free again when the process ends, however that happens.

    Raises
    ------
    InputError
        When another process is in it.
    OSError
        When it cannot be made.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    held = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as problem:
            raise InputError(
                f"{folder}: another run is at work in it; wait until it has ended, or name another "
                "folder"
            ) from problem
        yield
    finally:
        os.close(held)


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


def require_apart(outputs: Iterable[str | Path], inputs: Iterable[str | Path]) -> None:
    """Refuse to write over what is read.

    Parameters
    ----------
    outputs : iterable of str or Path
        Files that are going to be written.
    inputs : iterable of str or Path
        Files that are read.

    Raises
    ------
    InputError
        When one file is among both, by whatever path.

    Examples
    --------
    >>> require_apart(["out/card.toml"], ["card.toml"])
    >>> require_apart(["card.toml"], ["./card.toml"])
    Traceback (most recent call last):
    analog_card.errors.InputError: card.toml: is read, and nothing that is read is written over; ...
    """
    read = {Path(path).resolve() for path in inputs}
    for path in outputs:
        if Path(path).resolve() in read:
            raise InputError(
                f"{path}: is read, and nothing that is read is written over; choose another name"
            )


def _umask() -> int:
    # The mask can only be read by setting it.
    mask = os.umask(0)
    os.umask(mask)
    return mask
