"""``make bench``: what the simulation costs, as named figures with their errors beside them.

Ratios are what to compare between machines; milliseconds are not. CPU time is what is measured
unless a row says wall clock, so that other work on the machine changes little.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from benchmarks import circuit_loop
from benchmarks.batches import gradient_rows, monte_carlo_rows, scaling_rows
from benchmarks.diagnosis import diagnosis_rows
from benchmarks.results import RESULTS, Row, table_of, write_results
from benchmarks.single_runs import single_rows
from benchmarks.startup import startup_rows


def all_rows(
    duration: float = 1.0, runs: int = 1000, rounds: int = 7, foreign_rounds: int = 3
) -> Iterator[Row]:
    """Yield every figure.

    Parameters
    ----------
    duration : float
        Simulated time of a run [s].
    runs : int
        Of the Monte Carlo study.
    rounds, foreign_rounds : int
        Repetitions, and those in which scipy takes part.
    """
    yield from single_rows(duration, foreign_rounds)
    yield from monte_carlo_rows(runs, duration, rounds)
    yield from gradient_rows(duration, rounds)
    yield from startup_rows(rounds)
    yield from scaling_rows(duration, rounds)
    yield from diagnosis_rows()


def main(path: Path = RESULTS) -> None:
    """Print the table and write it."""
    console = Console(width=200 if not sys.stdout.isatty() else None)
    rows = list(all_rows())
    console.print(table_of(rows))
    write_results(rows, path)
    console.print(circuit_loop.compare())
    console.print(f"written: {path}")


if __name__ == "__main__":
    main()
