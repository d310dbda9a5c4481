"""Asking the diagnosis, as a user does: by its command line, one process per case."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from analog_card.files import write_whole
from pneuservo.errors import InputError

_CALL = "from pneuservo.command_line import main; main()"
LONGEST = 1800.0
"""After this the diagnosis is taken to hang [s]."""
_HANGS = 124
"""Its exit status then, as of timeout(1)."""
_STOPPED = {-signal.SIGINT, -signal.SIGTERM, -signal.SIGHUP, -signal.SIGKILL}


@dataclass(frozen=True)
class Answer:
    """What the diagnosis said of one case.

    Parameters
    ----------
    document : dict or None
        diagnosis.json; None when there is none.
    seconds : float
        How long it took, start of the process included [s].
    status : int
        Exit status; 124 when it did not end in time, negative when a signal ended it.
    message : str
        The end of what it wrote to standard error.
    program : str, optional
        Digest of the program that was asked.
    """

    document: dict[str, Any] | None
    seconds: float
    status: int
    message: str
    program: str = ""

    @property
    def interrupted(self) -> bool:
        """Return whether somebody stopped it before it was done: that says nothing of it."""
        partial = self.document is not None and bool(self.document.get("partial"))
        return partial or self.status in _STOPPED


def ask(used: Sequence[Path], held_back: Sequence[Path], folder: Path, without: str = "") -> Answer:
    """Return the diagnosis of some recordings.

    Parameters
    ----------
    used, held_back : sequence of Path
        Recordings; they name their rig file.
    folder : Path
        Where its files go.
    without : str, optional
        A part of the diagnosis that is left out, as ``pneuservo diagnose --without`` names it.

    Returns
    -------
    Answer
        Whatever happened.
    """
    words = [sys.executable, "-c", _CALL, "diagnose", *map(str, used)]
    if held_back:
        words += ["--validate", *map(str, held_back)]
    if without:
        words += ["--without", without]
    # One diagnosis per processor: its own threads would only wait for each other.
    words += ["--jobs", "1", "--out", str(folder), "--json"]
    surroundings = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    start = time.monotonic()
    try:
        done = subprocess.run(  # noqa: S603 - the interpreter that runs this, and file names
            words, capture_output=True, text=True, timeout=LONGEST, env=surroundings, check=False
        )
        status, said, message = done.returncode, done.stdout, done.stderr[-2000:]
    except subprocess.TimeoutExpired:
        status, said, message = _HANGS, "", f"no answer within {LONGEST:g} s"
    seconds = time.monotonic() - start
    document = None
    if status == 0:
        try:
            document = json.loads(said)
        except ValueError as problem:
            message = f"standard output is not one JSON document: {problem}"
    return Answer(document, seconds, status, message)


def keep_answer(answer: Answer, path: Path) -> None:
    """Write an answer, so that it is not asked for again."""
    write_whole(path, json.dumps(asdict(answer), indent=1) + "\n")


def kept_answer(path: Path) -> Answer | None:
    """Return an answer that was written earlier; None when there is none."""
    if not path.exists():
        return None
    try:
        return Answer(**json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as problem:
        raise InputError(
            f"{path}: is not a kept answer ({problem}); delete it, and it is asked for again"
        ) from problem
