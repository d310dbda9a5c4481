"""The process in which ngspice runs, started and spoken to by `analog_card.ngspice`.

ngspice keeps its state in global variables, cannot be loaded twice, and after some mistakes in a
netlist "awaits to be detached" or crashes. In a process of its own it can be replaced.

A request is a line of JSON on standard input: ``{"lines": [...], "title": "run 1", "changes":
["alter r1 = 2"], "command": "tran ...", "keep": false}``. A circuit that is kept serves requests
without lines until one of them fails.
A reply on standard output is a line of JSON; when it has ``names``, the values follow as bytes:
``points`` numbers of ``type`` for each name.
"""

import contextlib
import json
import logging
import os
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable
from typing import Any, BinaryIO

import numpy as np
from PySpice.Spice.NgSpice.Shared import NgSpiceShared

from analog_card.errors import SimulationError
from analog_card.library import ngspice_library
from analog_card.ngspice_words import is_chatter, is_failure

# How often to look whether the program that started this one is still there [s].
_WATCH = 0.5


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

    def analyse(self, request: dict[str, Any]) -> dict[str, np.ndarray]:
        """Load a netlist if there is one, change values, run one analysis, return its vectors.

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
        keep = False
        try:
            if "lines" in request:
                self._do(lambda: self.load_circuit("\n".join(request["lines"])))
            for change in request["changes"]:
                self._do(lambda change=change: self.exec_command(change))  # type: ignore[misc]
            self._do(lambda: self.exec_command(request["command"]))
            self._require_results_of(request["title"])
            self._require_solution()
            plot = self.plot(None, self._results())
            keep = request["keep"]
            return {name: np.asarray(vector.to_waveform()) for name, vector in plot.items()}
        finally:
            failed = [line for line in self._printed if is_failure(line)]
            told = [line for line in self._complained if line and not is_chatter(line)]
            self.words = list(dict.fromkeys([*told, *failed]))
            self._forget("destroy all", *([] if keep else ["remcirc"]))

    def _do(self, step: Callable[[], Any]) -> None:
        try:
            step()
        except NameError as problem:
            # A return code that is not zero: nothing works in this process from here on.
            raise DetachedError(str(problem)) from problem
        if any(is_failure(line) for line in (*self._complained, *self._printed)):
            raise SimulationError("ngspice reports a failure")

    def _require_solution(self) -> None:
        # With contradictory sources ngspice's last resort, a run of the circuit in time, still
        # "finishes successfully", at values that mean nothing.
        said = " ".join(self._complained).lower()
        if "singular matrix" in said and "transient op finished" in said:
            raise SimulationError("ngspice found no operating point")

    def _results(self) -> str:
        # A noise analysis leaves two plots: the spectrum, then its integral.
        last = str(self.last_plot)
        if not last.startswith("noise"):
            return last
        plots = [name for name in self.plot_names if name.startswith("noise")]
        return min(plots, key=lambda name: int(name.removeprefix("noise")))

    def _require_results_of(self, title: str) -> None:
        # After a netlist that did not load, ngspice would simulate the one before it.
        self.exec_command("echo $curplottitle")
        if not self._printed or self._printed[-1].lower() != title.lower():
            raise SimulationError("ngspice gave no results for this netlist")

    def _forget(self, *commands: str) -> None:
        # Both are needed: without them each run leaves its circuit behind, up to 0.8 MB a time.
        with contextlib.suppress(NameError):
            for command in commands:
                self.exec_command(command)


def answer(instance: Instance, request: dict[str, Any], reply: BinaryIO) -> bool:
    """Run one request, write the reply, and return whether this process is still of use."""
    usable, values = True, b""
    try:
        vectors = instance.analyse(request)
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
    """Answer requests until standard input ends, then remove the folder this ran in."""
    # ngspice prints where it likes: keep the reply stream for replies alone.
    reply = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    Instance._logger.addHandler(logging.NullHandler())
    Instance._logger.propagate = False
    # A .spiceinit in the current or the home folder is a script that ngspice runs at its start,
    # shell commands included: go where there is none.
    os.environ["HOME"] = empty_folder
    os.chdir(empty_folder)
    _end_with_parent(empty_folder)
    try:
        serve(reply)
    finally:
        # A worker of a process pool ends without its exit handlers: nobody else would do it.
        shutil.rmtree(empty_folder, ignore_errors=True)


def _end_with_parent(folder: str) -> None:
    """Have this process end when the program that started it has, also while ngspice computes."""
    # A termination of the whole group ends that program, and this one by it, tidily.
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    parent = os.getppid()

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(_WATCH)
        shutil.rmtree(folder, ignore_errors=True)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def serve(reply: BinaryIO) -> None:
    """Start ngspice and answer requests until standard input ends or it is of no more use."""
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
