"""Rows put together: the tables of a valve and the areas of its flow paths."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from analog_card.processes import processes
from pneuservo.arrays import Array
from pneuservo.calibration.table_row import TableRow, fit_row
from pneuservo.calibration.transient import LEAK, Transient
from pneuservo.errors import InputError
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.plant.valve import discharge_grid
from pneuservo.rigs import FlowPathTable, Rig, load_valve_tables

# The maker's rated flow, 2 SCFM at 100 psi absolute, gives 0.80 with the area of table 4.1.
RATED_COEFFICIENT = 0.8
_BREAK_POINTS = 5
# A first step of the curve so far below the second is no leak of its own.
_LATE = 0.6


@dataclass(frozen=True)
class FlowArea:
    """Area of a flow path at full opening.

    Parameters
    ----------
    value, low, high : float
        With its 95 % interval [m^2].
    reference : float
        Discharge coefficient of choked flow at full opening that was taken for it [-].
    """

    value: float
    low: float
    high: float
    reference: float


@dataclass(frozen=True)
class Calibration:
    """What charging and discharging a dead volume says of a valve or of a leak.

    Parameters
    ----------
    rows : tuple of TableRow
        One per recording.
    """

    rows: tuple[TableRow, ...]

    @property
    def of_paths(self) -> dict[str, tuple[TableRow, ...]]:
        """Return the rows of each flow path of a valve, by rising command."""
        return {
            path: tuple(
                sorted((r for r in self.rows if r.path == path), key=lambda row: row.command)
            )
            for path in FLOW_PATHS
            if any(row.path == path for row in self.rows)
        }

    def areas(
        self, reference: Mapping[str, float] | float = RATED_COEFFICIENT
    ) -> dict[str, FlowArea]:
        """Return the area of each path that was recorded at full opening.

        Parameters
        ----------
        reference : float or mapping of str to float, optional
            Discharge coefficient of choked flow at full opening, of all paths or by path [-].

        Returns
        -------
        dict of str to FlowArea
            By path.

        Notes
        -----
        Pressure tells the product of coefficient and area only; the area is that product over the
        reference.
        """
        found = {}
        for path, rows in self.of_paths.items():
            row = rows[-1]
            if row.command < row.transient.rig["valve.full_voltage"] or not row.visible.any():
                continue
            value = reference[path] if isinstance(reference, Mapping) else reference
            first = int(np.argmax(row.visible))
            area = row.transient.area / value
            centre, half = row.coefficient[first], row.half_width[first]
            found[path] = FlowArea(
                float(centre * area), float((centre - half) * area), float((centre + half) * area),
                value,
            )  # fmt: skip
        return found

    def tables(self, rig: Rig) -> dict[str, FlowPathTable]:
        """Return the tables of the valve, those of paths not recorded as the rig has them.

        Parameters
        ----------
        rig : Rig
            The rig whose valve it is.

        Returns
        -------
        dict of str to FlowPathTable
            For all four paths.

        Raises
        ------
        InputError
            When a command was recorded twice, or is none that a table can hold.
        """
        tables = dict(load_valve_tables(rig.valve))
        for path, rows in self.of_paths.items():
            commands = [round(row.command, 6) for row in rows]
            twice = {command for command in commands if commands.count(command) > 1}
            if twice:
                raise InputError(
                    f"path {path} was recorded more than once at {min(twice):g} V; a table holds "
                    "one row per command. Leave all but one recording out"
                )
            five = [_five(row) for row in rows]
            tables[path] = FlowPathTable(
                np.array(commands),
                np.array([points for points, _ in five]),
                np.array([values for _, values in five]),
            )
        discharge_grid(tables)
        return tables


def _five(row: TableRow) -> tuple[Array, Array]:
    """Return a row with five break points; further ones in between change nothing."""
    points = list(row.pressure_ratio)
    while len(points) < _BREAK_POINTS:
        wide = int(np.argmax(np.diff(points)))
        points.insert(wide + 1, round(0.5 * (points[wide] + points[wide + 1]), 2))
    found = np.array(points)
    return found, row.at(found)


def calibrate(
    transients: Sequence[Transient],
    polytropic_index: float | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda name: None,
) -> Calibration:
    """Find the coefficients of many transients.

    Parameters
    ----------
    transients : sequence of Transient
        Charges, discharges and leaks.
    polytropic_index : float, optional
        As in `pneuservo.calibration.table_row.fit_row` [-].
    jobs : int, optional
        Processes; the answer does not depend on it.
    step : callable, optional
        Told the name of each transient that is done.

    Returns
    -------
    Calibration
        One row per transient, in their order.
    """
    fit = partial(fit_row, polytropic_index=polytropic_index)
    if jobs <= 1 or len(transients) <= 1:
        rows = []
        for transient in transients:
            step(transient.name)
            rows.append(fit(transient))
        return Calibration(tuple(rows))
    with processes(min(jobs, len(transients)), start="fork") as pool:
        rows = []
        for row in pool.map(fit, transients):
            step(row.transient.name)
            rows.append(row)
    return Calibration(tuple(rows))


def valve_document(tables: Mapping[str, FlowPathTable], source: str) -> dict[str, Any]:
    """Return tables in the form of a valve file.

    Parameters
    ----------
    tables : mapping of str to FlowPathTable
        By flow path.
    source : str
        Where they come from.
    """
    return {
        "path": {
            path: {
                "source": source,
                "command_volts": table.command.round(6).tolist(),
                "pressure_ratio": table.pressure_ratio.round(6).tolist(),
                "discharge_coefficient": table.discharge_coefficient.round(5).tolist(),
            }
            for path, table in tables.items()
        }
    }


def cannot_tell_apart(rows: Sequence[TableRow]) -> list[str]:
    """Return what these recordings leave undecided, in sentences.

    Parameters
    ----------
    rows : sequence of TableRow
        What was found.
    """
    sentences = []
    if any(row.path != LEAK for row in rows):
        sentences.append(
            "Pressure alone cannot tell discharge coefficient, area, volume, polytropic index and "
            "temperature apart: only n R sqrt(T) Cd A/V is found, and the rest is taken as known. "
            "A weighed volume and a chamber filled with steel wool (n = 1) would."
        )
    if any(row.path == LEAK for row in rows):
        sentences.append(
            "Pressure alone cannot tell the area of a leak from the volume it empties, nor from "
            "the polytropic index: only n A/V is found. A measured volume would, and n is 1 where "
            "the loss takes far longer than the gas needs to reach wall temperature."
        )
    for row in rows:
        first = np.abs(row.curve.coefficient[:2])
        if row.path == LEAK and len(first) > 1 and first[0] < _LATE * first[1]:
            sentences.append(
                f"{row.transient.name}: at first it flows much less than a little later, as of a "
                "volume that was held for a while. Cut that part off with --window START:"
            )
        hidden = row.pressure_ratio[~row.visible]
        hidden = hidden[hidden > 0.0]
        if len(hidden):
            lowest, highest = row.curve.pressure_ratio.min(), row.curve.pressure_ratio.max()
            sentences.append(
                f"{row.transient.name}: the flow runs from pressure ratio {lowest:.2f} to "
                f"{highest:.2f}, so that the coefficient at "
                f"{', '.join(f'{value:.2f}' for value in hidden)} is not decided."
            )
    return sentences
