"""What a campaign says, in few numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import pandas as pd

from analog_card.quantities import unit_factor
from analog_card.tolerance_statistics import importance
from pneuservo.campaign.axes import Axis, Grid
from pneuservo.campaign.metrics import METRICS
from pneuservo.campaign.run import Outcome

# Units in which people read metrics, by SI unit.
_SHOWN = {"s": "ms", "m": "mm", "": "%"}
# A rank correlation of fewer samples, or of a spread of rounding errors, says nothing.
_LEAST_SAMPLES, _LEAST_SPREAD = 8, 1e-9


@dataclass(frozen=True)
class Spread:
    """What the samples say about one metric.

    Attributes
    ----------
    metric, unit : str
        What it is.
    mean, deviation : float or None
        Of the samples that have it; None without one, or with only one [unit].
    lowest, median, highest : float or None
        [unit].
    lowest_sample, highest_sample : int or None
        Which samples these are.
    without : int
        Samples that do not have it.
    important : dict of str to float
        Which axes account for it and for what share, by squared rank correlation.
    """

    metric: str
    unit: str
    mean: float | None
    deviation: float | None
    lowest: float | None
    median: float | None
    highest: float | None
    lowest_sample: int | None
    highest_sample: int | None
    without: int
    important: dict[str, float]


def spreads(outcome: Outcome) -> list[Spread]:
    """Return what the samples say about each metric.

    Parameters
    ----------
    outcome : Outcome
        Of a campaign.

    Returns
    -------
    list of Spread
        In the order of the campaign's metrics.
    """
    table = outcome.table()
    varying = [axis.name for axis in outcome.campaign.varying]
    return [_spread(table, metric, varying) for metric in outcome.campaign.metrics]


def grid_means(outcome: Outcome) -> pd.DataFrame:
    """Return the mean of each metric at each point of the grid.

    Parameters
    ----------
    outcome : Outcome
        Of a campaign.

    Returns
    -------
    pandas.DataFrame
        Indexed by the values of the grid's axes that vary, in SI; empty without such an axis. A
        mean is over the samples that have the metric.
    """
    names = [axis.name for axis in outcome.campaign.varying if isinstance(axis, Grid)]
    if not names:
        return pd.DataFrame()
    table = outcome.table()
    return table.groupby(names)[list(outcome.campaign.metrics)].mean()


def grid_without(outcome: Outcome) -> pd.DataFrame:
    """Return how many samples do not have each metric at each point of the grid.

    Parameters
    ----------
    outcome : Outcome
        Of a campaign.

    Returns
    -------
    pandas.DataFrame
        As from `grid_means`, whose means leave these samples out.
    """
    means = grid_means(outcome)
    if means.empty:
        return means
    names, metrics = list(means.index.names), list(means.columns)
    lacking = outcome.table().set_index(names)[metrics].isna()
    return lacking.groupby(names).sum()


def summary(outcome: Outcome) -> dict[str, Any]:
    """Return a campaign and what it says as plain values, for JSON."""
    campaign = outcome.campaign
    means = grid_means(outcome).reset_index().to_dict("records")
    without = grid_without(outcome).to_dict("records")
    errors = [sample["error"] for sample in outcome.samples if sample["error"] is not None]
    return {
        "title": campaign.title,
        "rig": campaign.rig.name,
        "controller": campaign.controller,
        "duration": float(campaign.time[-1] - campaign.time[0]),
        "seed": campaign.seed,
        "trials": campaign.trials,
        "samples": len(campaign),
        "failed": len(errors),
        "first_error": errors[0] if errors else None,
        "axes": [{"kind": type(axis).__name__.lower(), **asdict(axis)} for axis in campaign.axes],
        "metrics": [asdict(spread) for spread in spreads(outcome)],
        "grid": [
            {**_plain(row), "without": {str(key): int(count) for key, count in lacking.items()}}
            for row, lacking in zip(means, without, strict=True)
        ],
    }


def shown_unit(metric: str) -> str:
    """Return the unit in which people read a metric.

    Examples
    --------
    >>> shown_unit("settling_time")
    'ms'
    """
    return _SHOWN.get(METRICS[metric], METRICS[metric])


def shown(values: Any, shown_in: str, unit: str) -> Any:
    """Return values in the unit in which people read them.

    Parameters
    ----------
    values : float or array
        [unit].
    shown_in, unit : str
        The unit wanted, and the SI unit of the values.

    Examples
    --------
    >>> round(shown(650000.0, "bar", "Pa"), 9)
    6.5
    """
    scale, offset = unit_factor(shown_in, unit)
    return (values - offset) / scale


def shown_axis(axis: Axis, values: Any) -> Any:
    """Return values of an axis in the unit that it was given in."""
    return shown(values, axis.shown, axis.unit)


def values_in_words(values: Mapping[str, float], axes: Sequence[Axis]) -> str:
    """Return the values of a sample in the units that they were given in.

    Parameters
    ----------
    values : mapping of str to float
        In SI by name.
    axes : sequence of Grid or Random
        Of the campaign.

    Examples
    --------
    >>> axes = (Grid("supply.pressure", "Pa", "bar", (6.5e5, 7.7e5)),)
    >>> values_in_words({"supply.pressure": 6.5e5}, axes)
    'supply.pressure 6.5 bar'
    """
    return ", ".join(
        f"{axis.name} {shown_axis(axis, values[axis.name]):.4g} {axis.shown}".rstrip()
        for axis in axes
    )


def _spread(table: pd.DataFrame, metric: str, varying: list[str]) -> Spread:
    found = table[metric].dropna()
    many = len(found) > 1
    important: dict[str, float] = {}
    differs = bool(np.ptp(found) > _LEAST_SPREAD * np.max(np.abs(found))) if many else False
    if len(found) >= _LEAST_SAMPLES and varying and differs:
        drawn = [{str(key): value for key, value in row.items()} for row in _rows(table, varying)]
        important = importance(drawn, table[metric].tolist())
    return Spread(
        metric=metric,
        unit=METRICS[metric],
        mean=float(found.mean()) if len(found) else None,
        deviation=float(found.std()) if many else None,
        lowest=float(found.min()) if len(found) else None,
        median=float(found.median()) if len(found) else None,
        highest=float(found.max()) if len(found) else None,
        lowest_sample=int(found.idxmin()) if len(found) else None,
        highest_sample=int(found.idxmax()) if len(found) else None,
        without=len(table) - len(found),
        important=important,
    )


def _rows(table: pd.DataFrame, names: list[str]) -> list[dict[Any, Any]]:
    return table[names].to_dict("records")


def _plain(row: Mapping[Any, Any]) -> dict[str, float | None]:
    return {str(key): float(value) if np.isfinite(value) else None for key, value in row.items()}
