"""Chapter 8 of the thesis, limit cycles: tables 8.1 to 8.10 recomputed."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from pneuservo.limit_cycle.comparison import by_describing_function, by_linear_simulation, measured
from pneuservo.limit_cycle.cycle import Cycle
from pneuservo.limit_cycle.locking import locking
from pneuservo.rigs import Rig
from pneuservo.thesis.chapter_8_loops import (
    Plants,
    StatedLoop,
    plants,
    printed_plants,
    stated_loops,
)
from pneuservo.thesis.chapter_8_pictures import draw_all
from pneuservo.thesis.chapter_8_sampled import sampled_rows
from pneuservo.thesis.chapter_8_statements import statement_rows
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED
from pneuservo.thesis.rows import REPRODUCED, Row, number_row

# How long the non-linear plant is followed [s].
_FOLLOWED = 0.8
_METHODS = {
    "nyquist": "Nyquist",
    "linear": "simulation of the linear model",
    "nonlinear": "simulation of the non-linear model",
}
_UNITS = {
    "frequency": "Hz",
    "amplitude": "m/s²",
    "high": "m/s²",
    "low": "m/s²",
    "range": "m/s²",
}
_QUANTITIES = {
    "frequency": "frequency",
    "amplitude": "amplitude of the surface",
    "high": "highest value of the surface",
    "low": "lowest value of the surface",
    "range": "range of the surface",
}
# The same behaviour with another figure, where none of ours is further off [-].
_IN_KIND_WITHIN = 0.15


def rows(rig: Rig | None = None) -> list[Row]:
    """Return the tables and the statements of chapter 8 beside ours.

    Parameters
    ----------
    rig : Rig, optional
        For the non-linear simulation with the printed parameters, instead of the built-in one.
    """
    sets = {PRINTED: _printed(rig), RECONCILED: plants(RECONCILED)}
    table = [row for loop in stated_loops() for row in _loop_rows(loop, sets)]
    return [*table, *statement_rows(sets), *sampled_rows(sets)]


def pictures(folder: Path, rig: Rig | None = None) -> list[Path]:
    """Draw the figures of chapter 8 into a folder and return their files.

    Parameters
    ----------
    folder : Path
        Where to; it has to exist.
    rig : Rig, optional
        As for `rows`.
    """
    return draw_all(folder, _printed(rig))


def _printed(rig: Rig | None) -> Plants:
    return plants(PRINTED) if rig is None else printed_plants(rig)


def _loop_rows(stated: StatedLoop, sets: Mapping[str, Plants]) -> Iterator[Row]:
    for method, quantities in stated.stated.items():
        ours = {kind: figures(method, stated, plant) for kind, plant in sets.items()}
        for quantity, value in _compared(method, stated, quantities).items():
            printed, reconciled = ours[PRINTED][quantity], ours[RECONCILED][quantity]
            nearest = min(abs(printed - value), abs(reconciled - value))
            row = number_row(
                f"{stated.id}-{method}-{quantity}",
                f"{stated.title}: {_QUANTITIES[quantity]}, {_METHODS[method]}",
                _UNITS[quantity],
                value,
                printed,
                reconciled,
                stated.source,
                stated.reasons.get(method, ""),
                in_kind=nearest <= _IN_KIND_WITHIN * abs(value),
            )
            # Said once where all is well: a method's remark stands at its frequency.
            said = row.verdict != REPRODUCED or quantity == "frequency"
            yield row if said else replace(row, reason="")


def _compared(
    method: str, stated: StatedLoop, quantities: Mapping[str, float]
) -> Mapping[str, float]:
    """Return the quantities that say something of the loop.

    How a digital loop round the linear plant splits its range into extremes is decided by the
    start alone, which is not stated: only the range is compared.
    """
    if "high" not in quantities:
        return quantities
    whole = {**quantities, "range": quantities["high"] - quantities["low"]}
    if method == "linear" and stated.signals.sampled:
        return {key: whole[key] for key in ("frequency", "range")}
    return whole


@cache
def figures(method: str, stated: StatedLoop, plant: Plants) -> Mapping[str, float]:
    """Return frequency, amplitude and extremes of a loop by one method.

    Parameters
    ----------
    method : str
        ``nyquist``, ``linear`` or ``nonlinear``.
    stated : StatedLoop
        The loop.
    plant : Plants
        Its parameters.

    Notes
    -----
    A digital loop round the linear plant locks to whole samples, to how many the start decides:
    its figures are means over 25 starts.
    """
    loop = plant.loop(stated)
    if method == "linear" and stated.signals.sampled:
        found = locking(loop)
        high, low = float(np.mean(found.high)), float(np.mean(found.low))
        return _figures(Cycle(float(np.mean(found.frequency)), high, low, True, 0.0))
    if method == "nyquist":
        finding = by_describing_function(loop)
    elif method == "linear":
        finding = by_linear_simulation(loop)
    else:
        finding = measured(plant.simulate(loop, _FOLLOWED))
    return _figures(finding.cycle)


def _figures(cycle: Cycle | None) -> Mapping[str, float]:
    if cycle is None:
        return dict.fromkeys(_UNITS, float("nan"))
    return {
        "frequency": cycle.frequency,
        "amplitude": cycle.amplitude,
        "high": cycle.high,
        "low": cycle.low,
        "range": cycle.high - cycle.low,
    }
