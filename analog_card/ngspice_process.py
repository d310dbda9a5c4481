"""The process in which ngspice runs, started and spoken to by `analog_card.ngspice`.

ngspice keeps its state in global variables, cannot be loaded twice, and after some mistakes in a
netlist "awaits to be detached" or crashes. In a process of its own it can be replaced.

A request is a line of JSON on standard input: ``{"lines": [...], "command": "tran ..."}``.
A reply on standard output is a line of JSON; when it has ``names``, the values follow as bytes:
``points`` numbers of ``type`` for each name.
"""

import contextlib
import json
import logging
import os
import re
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np
from PySpice.Spice.NgSpice.Shared import NgSpiceShared

from analog_card.errors import SimulationError
from analog_card.library import ngspice_library

# How ngspice begins a line about something that failed. Notes, warnings and the steps of the
# search for an operating point are not failures, nor is a node that has "error" in its name.
_FAILURE = re.compile(
    r"(error:|error on line|pterror|fatal\b|doanalyses:|.*simulation\(s\) aborted|undefined par"
    r"|cannot compute|could not find|.*unknown subckt|.*awaits to be detached)",
    re.IGNORECASE,
)
_CHATTER = re.compile(
    r"note:|trying gmin|supplies reduced|using sparse|reference value"
    r"|warning: .*(gmin|source step)",
    re.IGNORECASE,
)


class DetachedError(Exception):
    """Ngspice has given up; this process is of no more use."""


class Instance(NgSpiceShared):
    """PySpice's instance with a judgement of its own on what ngspice says.

    PySpice 1.5 takes every line on standard error for a failure, also the notes that a
    successful search for the operating point leaves there, and any line with "error" in it.
    """

    _logger = logging.getLogger(__name__)

    def __init__(self) -> None:
        self._printed: list[str] = []
        self._complained: list[str] = []
        self.words: list[str] = []
        type(self).LIBRARY_PATH = ngspice_library()
        super().__init__()

    def send_char(self, message: str, ngspice_id: Any) -> int:
        """Keep a line that ngspice said; take back PySpice's verdict on it."""
        self._error_in_stdout = self._error_in_stderr = False
        stream, _, line = str(message).partition(" ")
        (self._complained if stream == "stderr" else self._printed).append(line.strip())
        return 0

    def analyse(self, lines: list[str], command: str) -> dict[str, np.ndarray]:
        """Load a netlist, run one analysis and return all its vectors by name.

        What ngspice complained about, without its chatter, is in `words` afterwards.

        Raises
        ------
        SimulationError
            When ngspice complained, in its own words.
        DetachedError
            When ngspice cannot be used any more.
        """
        self._printed.clear()
        self._complained.clear()
        try:
            self._do(lambda: self.load_circuit("\n".join(lines)))
            self._do(lambda: self.exec_command(command))
            self._require_results_of(lines[0])
            plot = self.plot(None, self.last_plot)
            return {name: np.asarray(vector.to_waveform()) for name, vector in plot.items()}
        finally:
            failed = [line for line in self._printed if _FAILURE.match(line)]
            told = [line for line in self._complained if line and not _CHATTER.match(line)]
            self.words = list(dict.fromkeys([*told, *failed]))
            self._forget()

    def _do(self, step: Callable[[], Any]) -> None:
        try:
            step()
        except NameError as problem:
            # A return code that is not zero: nothing works in this process from here on.
            raise DetachedError(str(problem)) from problem
        if any(_FAILURE.match(line) for line in (*self._complained, *self._printed)):
            raise SimulationError("ngspice reports a failure")

    def _require_results_of(self, title: str) -> None:
        # After a netlist that did not load, ngspice would simulate the one before it.
        self.exec_command("echo $curplottitle")
        if not self._printed or self._printed[-1].lower() != title.lower():
            raise SimulationError("ngspice gave no results for this netlist")

    def _forget(self) -> None:
        # Both are needed: without them each run leaves its circuit behind, up to 0.8 MB a time.
        with contextlib.suppress(NameError):
            self.exec_command("destroy all")
            self.exec_command("remcirc")


def answer(instance: Instance, request: dict[str, Any], reply: BinaryIO) -> bool:
    """Run one request, write the reply, and return whether this process is still of use."""
    usable, values = True, b""
    try:
        vectors = instance.analyse(request["lines"], request["command"])
        table = np.array(list(vectors.values()))
        header: dict[str, Any] = {"names": list(vectors), "points": table.shape[1]}
        header["type"] = table.dtype.str
        values = table.tobytes()
    except (SimulationError, DetachedError) as problem:
        usable = isinstance(problem, SimulationError)
        header = {"failure": str(problem), "usable": usable}
    send(reply, {**header, "words": instance.words}, values)
    return usable


def send(reply: BinaryIO, header: dict[str, Any], values: bytes = b"") -> None:
    """Write one reply."""
    reply.write(json.dumps(header).encode() + b"\n" + values)
    reply.flush()


def main(empty_folder: str) -> None:
    """Answer requests until standard input ends."""
    # ngspice prints where it likes: keep the reply stream for replies alone.
    reply = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    Instance._logger.addHandler(logging.NullHandler())
    Instance._logger.propagate = False
    # A .spiceinit in the current or the home folder is a script that ngspice runs at its start,
    # shell commands included: go where there is none.
    os.environ["HOME"] = empty_folder
    os.chdir(empty_folder)
    try:
        instance = Instance()
    except Exception as problem:  # the parent process has to hear of anything at all
        send(reply, {"failure": str(problem)})
        return
    send(reply, {"version": instance.ngspice_version})
    for line in sys.stdin.buffer:
        if not answer(instance, json.loads(line), reply):
            return


if __name__ == "__main__":
    main(sys.argv[1])
