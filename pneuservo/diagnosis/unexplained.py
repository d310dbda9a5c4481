"""What nothing in the catalogue explains: its shape, as a table over one recorded quantity."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.diagnosis.fit import INTERVAL, Fit, explained, rms
from pneuservo.diagnosis.judge import OVER_IMITATIONS
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array, Table
from pneuservo.diagnosis.problem import residuals_of, values_in_each
from pneuservo.diagnosis.side_by_side import side_by_side

LEAST_GAIN = 900.0
"""Drop of the weighted sum of squares that a table has to bring: a table has more freedom than an
effect; in two of 18 pairs of quiet recordings without any effect the best reached 232 and 700."""
INSTEAD = 1.3
"""A table that explains so many times what the named effects do, in their place, leaves nothing of
the names."""
TURN = 0.2
"""Share of its size that a curve has to go back to count as turning."""
WORTH_SAYING = 0.1
"""Beside a named effect a table has to explain this share of all that is explained."""


@dataclass(frozen=True)
class Unexplained:
    """What has no name, as a table.

    Parameters
    ----------
    table : Table
        What is tabulated over what.
    knots, values : (k,) array
        Quantity at the knots, and what the table has there, SI.
    spread : (k,) array
        Standard deviations of the values, but for what all have in common.
    gain : float
        Drop of the weighted sum of squares.
    named_gain : float
        The same of the named effects that stand beside it; 0 without any.
    fit : Fit
        The chosen model with the table in it.
    instead : bool
        Whether it explains the recordings better than what had been named.
    """

    table: Table
    knots: Array
    values: Array
    spread: Array = field(repr=False)
    gain: float
    named_gain: float
    fit: Fit = field(repr=False)
    instead: bool = False

    @property
    def share(self) -> float:
        """Return its share of all that is explained."""
        return self.gain / (self.gain + self.named_gain)

    @property
    def shape(self) -> str:
        """Return what depends on what, and how, in words."""
        return f"{self.table.what} that depends on {self.table.quantity} ({self.form})"

    @property
    def parameters(self) -> dict[str, dict[str, float | str]]:
        """Return the table as the answer lists it: its ends, and every knot with its interval."""
        found: dict[str, dict[str, float | str]] = {}
        for key, value in self.table.values.items():
            unit = self.table.unit_of_quantity if key in (self.table.low, self.table.high) else ""
            found[_name(key)] = {"value": value, "unit": unit, "low": value, "high": value}
        for key, value, sigma in zip(self.table.knots, self.values, self.spread, strict=True):
            half = INTERVAL * float(sigma)
            found[_name(key)] = {
                "value": float(value),
                "unit": self.table.unit,
                "low": float(value) - half,
                "high": float(value) + half,
            }
        return found

    @property
    def form(self) -> str:
        """Return the smoothed shape in words."""
        smooth = smoothed(self.knots, self.values, self.spread)
        turns = _turns(smooth)
        if not turns:
            return "growing" if smooth[-1] > smooth[0] else "falling"
        if len(turns) > 1:
            return f"up and down, {len(turns)} turns"
        place = turns[0]
        kind = "a hump" if smooth[place] > smooth[0] else "a dip"
        return f"{kind} at {self.knots[place]:.3g} {self.table.unit_of_quantity}".rstrip()


def _turns(smooth: Array) -> list[int]:
    """Return where a curve turns and goes back by a good part of its size."""
    from scipy.signal import find_peaks

    prominence = TURN * float(np.ptp(smooth))
    found = [find_peaks(sign * smooth, prominence=prominence)[0] for sign in (1.0, -1.0)]
    return sorted(int(place) for places in found for place in places)


def _name(key: str) -> str:
    return key.partition(":")[2]


def smoothed(knots: Array, values: Array, spread: Array) -> Array:
    """Return values at knots without what their spread makes of them.

    Parameters
    ----------
    knots, values, spread : (k,) array
        Strictly increasing knots, values and their standard deviations.

    Notes
    -----
    The smoothest cubic spline that misses the values by no more than their spread
    (`scipy.interpolate.UnivariateSpline`; Reinsch 1967).
    """
    from scipy.interpolate import UnivariateSpline

    sigma = np.maximum(spread, 1e-3 * max(float(np.max(np.abs(values))), 1e-300))
    share = (knots - knots[0]) / float(knots[-1] - knots[0])
    return np.asarray(UnivariateSpline(share, values, 1.0 / sigma, s=len(knots))(share))


def find_unexplained(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    baseline: Fit,
    chosen: Fit,
    copies: Callable[[Fit], Sequence[Array]],
    jobs: int = 1,
) -> Unexplained | None:
    """Return the table that explains what a model leaves, where it earns its place.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    tables : sequence of Table
        What may be tabulated over what.
    baseline, chosen : Fit
        The re-fitted baseline, and the model with everything that was named.
    copies : callable
        Takes a fit and returns what it leaves of recordings that its own rig has made, beyond a
        refit.
    jobs : int, optional
        So many tables at a time.

    Returns
    -------
    Unexplained or None
        None when what is left could be noise.

    Notes
    -----
    Every table is simulated knot by knot, what the fitted parameters absorb is taken out, and the
    knots are fitted together: a projected score test with one degree of freedom per knot, held
    against imitations of the recordings like any named effect. Only where something is left beside
    the names a table may do better in their place.
    """
    beside = _best(model, cases, tables, chosen, copies(chosen), jobs)
    if beside is None or not chosen.hypothesis.effects:
        return beside
    named = explained(baseline, chosen)
    if beside.gain < WORTH_SAYING * (beside.gain + named):
        return None
    instead = _best(model, cases, tables, baseline, copies(baseline), jobs)
    if instead is not None and instead.gain > INSTEAD * named:
        return replace(instead, instead=True)
    return replace(beside, named_gain=named)


def _best(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    base: Fit,
    copies: Sequence[Array],
    jobs: int,
) -> Unexplained | None:
    left = base.beyond_refit(base.weighted)
    best: tuple[float, Table, Array, Array] | None = None
    changes = side_by_side(lambda table: _changes(model, cases, base, table), tables, jobs)
    for table, columns in zip(tables, changes, strict=True):
        seen = np.linalg.norm(columns, axis=0) > 1e-6
        if not seen.any():
            continue
        span = np.linalg.qr(columns[:, seen])[0]
        gain = float(np.sum((span.T @ left) ** 2))
        pretended = max((float(np.sum((span.T @ copy) ** 2)) for copy in copies), default=0.0)
        if gain <= max(LEAST_GAIN, OVER_IMITATIONS * pretended, best[0] if best else 0.0):
            continue
        steps = np.asarray(np.linalg.lstsq(columns, left, rcond=1e-6)[0], dtype=np.float64)
        if float(np.std(table.step * steps)) > table.least:
            best = gain, table, columns, steps
    return None if best is None else _fitted(model, cases, base, *best)


def _changes(model: Model, cases: Sequence[Case], base: Fit, table: Table) -> Array:
    """Return what a step of each knot changes in the weighted residuals beyond a refit."""
    changes, here = [], base.weighted
    for knot in table.knots:
        there = {**base.shared, **table.values, knot: table.step}
        values = values_in_each(cases, cases[0], there, base.own)
        changes.append(here - base.weigh(residuals_of(model, cases, values)))
    return base.beyond_refit(np.column_stack(changes))


def _fitted(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    gain: float,
    table: Table,
    columns: Array,
    steps: Array,
) -> Unexplained:
    """Return the table with its knots fitted together with what the parameters do about it."""
    # Of the shape alone: what all knots have in common the parameters may take up.
    shape = np.eye(len(steps)) - 1.0 / len(steps)
    covariance = shape @ np.linalg.pinv(columns.T @ columns) @ shape
    spread = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    heights = dict(zip(table.knots, (steps * table.step).tolist(), strict=True))
    shared = {**base.shared, **table.values, **heights}
    own = list(base.own)
    residuals = residuals_of(model, cases, values_in_each(cases, cases[0], shared, own))
    # What the parameters had made up for they no longer have to.
    undone = np.concatenate([base.weigh(residuals), base.distance])
    parameters, more = base.moved(np.linalg.lstsq(base.sensitivity, -undone, rcond=None)[0])
    moved = {**shared, **parameters}
    closer = residuals_of(model, cases, values_in_each(cases, cases[0], moved, more))
    if np.sum(base.weigh(closer) ** 2) < np.sum(base.weigh(residuals) ** 2):
        shared, own, residuals = moved, more, closer
    found = replace(
        base,
        shared=shared,
        own=tuple(own),
        residuals=tuple(residuals),
        rms=max(rms(residuals), *base.finest.values()),
    )
    low, high = (table.values[key] for key in (table.low, table.high))
    knots = np.linspace(low, high, len(table.knots))
    values = np.array(list(heights.values()))
    return Unexplained(table, knots, values, spread * table.step, gain, 0.0, found)
