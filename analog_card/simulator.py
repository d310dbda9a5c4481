"""Keeping the process in which ngspice runs: starting it, asking it, replacing it."""

import atexit
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from typing import IO, Any

import numpy as np

from analog_card.errors import SimulationError


class Simulator:
    """The process of `analog_card.ngspice_process`, started when first needed.

    Safe to use from several threads: requests wait for one another.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._complaints: IO[bytes] | None = None
        self._empty_folder: str | None = None
        self._ready: dict[str, Any] = {}
        self._loads = 0

    @property
    def process_id(self) -> int | None:
        """The process, when there is one."""
        return self._process.pid if self._process else None

    def version(self) -> int:
        """Start ngspice if need be and return its version, 0 when it does not say.

        Raises
        ------
        SimulationError
            When it does not start.
        """
        with self._lock:
            self._start()
            return int(self._ready["version"] or 0)

    def ask(
        self,
        lines: list[str] | None,
        command: str,
        time_limit: float,
        changes: list[str] | None = None,
        keep: bool = False,
    ) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
        """Run one analysis of one netlist.

        Parameters
        ----------
        lines : list of str or None
            The netlist; its title is replaced. None for the circuit that the last request kept.
        command : str
            The analysis in ngspice's words.
        time_limit : float
            Longest wait for the answer [s].
        changes : list of str, optional
            Commands that change values of the circuit first.
        keep : bool, optional
            Whether the next request is for the same circuit.

        Returns
        -------
        header : dict
            ``words`` ngspice complained with; ``failure`` when it failed.
        vectors : dict of str to ndarray
            Values by ngspice's own names; empty after a failure.

        Raises
        ------
        SimulationError
            When the process does not start, dies or takes too long.
        """
        with self._lock:
            process = self._start()
            request: dict[str, Any] = {"changes": changes or [], "command": command, "keep": keep}
            if lines is not None:
                # A title of our own for each netlist proves that the results are of this one.
                self._loads += 1
                request["lines"] = [f"netlist {self._loads}", *lines[1:]]
            request["title"] = f"netlist {self._loads}"
            overdue = threading.Event()
            timer = threading.Timer(time_limit, _end, (process, overdue))
            timer.start()
            try:
                header, vectors = _exchange(process, request)
            except (OSError, ValueError) as problem:
                last_words = self._stop()
                if overdue.is_set():
                    raise SimulationError(
                        f"no result within {time_limit:g} s; shorten the analysis"
                    ) from problem
                raise SimulationError(
                    f"ngspice crashed. {last_words}".strip(), words=[last_words] * bool(last_words)
                ) from problem
            except BaseException:
                # Interrupted: the reply still to come must not be taken for the next one.
                self._stop()
                raise
            finally:
                timer.cancel()
            if not header.get("usable", True):
                self._stop()
            return header, vectors

    def close(self) -> None:
        """End the process."""
        with self._lock:
            self._stop()

    def forget(self) -> None:
        """Leave the process to the program this one was forked from."""
        self._lock = threading.Lock()
        self._process = self._complaints = self._empty_folder = None

    def _start(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        self._stop()
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115 - lives as long as the process
        self._empty_folder = tempfile.mkdtemp(prefix="analog-card-")
        package_root = str(Path(__file__).resolve().parents[1])
        search = os.pathsep.join(filter(None, [package_root, os.environ.get("PYTHONPATH")]))
        # -P: nothing is imported from the current folder, which may be anybody's.
        self._process = subprocess.Popen(  # noqa: S603 - our own interpreter, module and folder
            [sys.executable, "-P", "-m", "analog_card.ngspice_process", self._empty_folder],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            env={**os.environ, "PYTHONPATH": search},
        )
        assert self._process.stdout is not None
        first = self._process.stdout.readline()
        if not first:
            raise SimulationError(f"ngspice did not start. {self._stop()}".strip())
        self._ready = json.loads(first)
        if "failure" in self._ready:
            self._stop()
            raise SimulationError(self._ready["failure"])
        return self._process

    def _stop(self) -> str:
        """End the process and return the last line it left on standard error."""
        lines: list[str] = []
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            for stream in (self._process.stdin, self._process.stdout):
                with contextlib.suppress(OSError):
                    stream.close()  # type: ignore[union-attr]
            self._process = None
        if self._complaints is not None:
            self._complaints.seek(0)
            lines = self._complaints.read().decode(errors="replace").split("\n")
            self._complaints.close()
            self._complaints = None
        if self._empty_folder is not None:
            shutil.rmtree(self._empty_folder, ignore_errors=True)
            self._empty_folder = None
        return next((line.strip() for line in reversed(lines) if line.strip()), "")


def _exchange(
    process: subprocess.Popen[bytes], request: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(json.dumps(request).encode() + b"\n")
    process.stdin.flush()
    header = json.loads(process.stdout.readline())
    names = header.get("names", [])
    if not names:
        return header, {}
    kind = np.dtype(header["type"])
    size = len(names) * header["points"] * kind.itemsize
    table = np.frombuffer(process.stdout.read(size), kind).reshape(len(names), -1)
    return header, dict(zip(names, table, strict=True))


def _end(process: subprocess.Popen[bytes], overdue: threading.Event) -> None:
    overdue.set()
    process.kill()


SIMULATOR = Simulator()
atexit.register(SIMULATOR.close)
os.register_at_fork(after_in_child=SIMULATOR.forget)
