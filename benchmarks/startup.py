"""What a new process costs until it is of use, with compiled code kept from before."""

import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.results import Row

_FIRST_RESULT = "from pneuservo.simulation import simulate; simulate(time=[0.0, 0.1], command=1.0)"
# Name, arguments of the interpreter, committed and elsewhere [s].
_CASES = (
    ("new process to its first result", ("-c", _FIRST_RESULT), 1.5, 0.9),
    (
        "pneuservo --help",
        ("-c", "from pneuservo.command_line import main; main(['--help'])"),
        0.3,
        None,
    ),
)


def startup_rows(rounds: int) -> Iterator[Row]:
    """Yield CPU time of new processes; the wall clock is in the note."""
    for name, arguments, committed, elsewhere in _CASES:
        _process(arguments)
        took = np.array([_process(arguments) for _ in range(rounds)])
        yield Row(
            name,
            float(np.median(took[:, 0])),
            "s",
            committed,
            elsewhere,
            higher_is_better=False,
            spread=(float(took[:, 0].min()), float(took[:, 0].max())),
            note=f"wall clock {took[:, 1].min():.2f} s, load average {os.getloadavg()[0]:.1f}",
        )


def _process(arguments: tuple[str, ...]) -> tuple[float, float]:
    """Return CPU time and wall clock of a process [s]."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)  # noqa: S603
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, wall
