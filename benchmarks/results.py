"""What a benchmark gives: named rows, as a table and as JSON."""

import json
import os
import platform
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

import llvmlite.binding
import numba
import numpy
import scipy
from rich.table import Table

from analog_card.files import write_whole

RESULTS = Path(__file__).parent / "results.json"


@dataclass(frozen=True)
class Row:
    """One measured figure.

    Parameters
    ----------
    name : str
        What is measured.
    value : float
        Measured here.
    unit : str
        ``x`` for a ratio.
    committed, elsewhere : float, optional
        What the project commits to, and what an independent study of the same architecture
        measured on a Zen 5 machine with two processors.
    higher_is_better : bool, optional
        Whether the commitment is a floor or a ceiling.
    spread : tuple of float, optional
        Lowest and highest of the rounds.
    error_um : float, optional
        Largest error of the displacement in the runs that were timed [um].
    note : str, optional
        Settings, and what else belongs to the figure.
    """

    name: str
    value: float
    unit: str
    committed: float | None = None
    elsewhere: float | None = None
    higher_is_better: bool = True
    spread: tuple[float, float] | None = None
    error_um: float | None = None
    note: str = ""

    @property
    def kept(self) -> bool | None:
        """Return whether the commitment is kept; None without one."""
        if self.committed is None:
            return None
        if self.higher_is_better:
            return bool(self.value >= self.committed)
        return bool(self.value <= self.committed)


def table_of(rows: Iterable[Row]) -> Table:
    """Return the rows for people."""
    table = Table("figure", "here", "range", "committed", "elsewhere", "kept", "error um", "note")
    for row in rows:
        bound = ">=" if row.higher_is_better else "<="
        table.add_row(
            row.name,
            f"{row.value:.4g} {row.unit}",
            "" if row.spread is None else f"{row.spread[0]:.3g} to {row.spread[1]:.3g}",
            "" if row.committed is None else f"{bound} {row.committed:g}",
            "" if row.elsewhere is None else f"{row.elsewhere:g}",
            {None: "", True: "yes", False: "NO"}[row.kept],
            "" if row.error_um is None else f"{row.error_um:.2g}",
            row.note,
        )
    return table


def machine() -> dict[str, object]:
    """Return what the figures were measured on."""
    return {
        "processor": llvmlite.binding.get_host_cpu_name(),
        "processors": os.cpu_count(),
        "load_average": round(os.getloadavg()[0], 1),
        "system": platform.platform(),
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
    }


def write_results(rows: Iterable[Row], path: Path) -> None:
    """Write the rows as JSON."""
    document = {
        "how": "CPU time of the process, medians of rounds in which the contenders take turns, "
        "unless a row says wall clock; compare ratios between machines, not milliseconds",
        "machine": machine(),
        "rows": [{**asdict(row), "kept": row.kept} for row in rows],
    }
    write_whole(path, json.dumps(document, indent=2).encode() + b"\n")
