"""What nothing in the catalogue explains: its shape, as a table over one recorded quantity."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.diagnosis.fit import INTERVAL, Fit, explained, rms
from pneuservo.diagnosis.judge import LEAST_GAIN, OVER_IMITATIONS
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array, Table
from pneuservo.diagnosis.problem import residuals_of, values_in_each

INSTEAD = 1.3
"""A table that explains so many times what the named effects do, in their place, leaves nothing of
the names."""
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
        rises = np.diff(smooth)
        size = float(np.ptp(smooth))
        if np.all(rises > -0.05 * size):
            return "growing"
        if np.all(rises < 0.05 * size):
            return "falling"
        place = int(np.argmax(np.abs(smooth - np.median(smooth))))
        kind = "a hump" if smooth[place] > np.median(smooth) else "a dip"
        return f"{kind} at {self.knots[place]:.3g} {self.table.unit_of_quantity}".rstrip()


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
    A cubic smoothing spline whose penalty generalised cross-validation chooses
    (`scipy.interpolate.make_smoothing_spline`; Wahba 1990).
    """
    from scipy.interpolate import make_smoothing_spline

    weights = 1.0 / np.maximum(spread, 1e-3 * max(float(np.max(np.abs(values))), 1e-300)) ** 2
    scale = float(knots[-1] - knots[0])
    spline = make_smoothing_spline((knots - knots[0]) / scale, values, weights / weights.max())
    return np.asarray(spline((knots - knots[0]) / scale))


def find_unexplained(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    baseline: Fit,
    chosen: Fit,
    copies: Callable[[Fit], Sequence[Array]],
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
        Takes a fit and returns what it leaves of recordings that its own rig has made, weighted.

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
    beside = _best(model, cases, tables, chosen, copies(chosen))
    if beside is None or not chosen.hypothesis.effects:
        return beside
    named = explained(baseline, chosen)
    if beside.gain < WORTH_SAYING * (beside.gain + named):
        return None
    instead = _best(model, cases, tables, baseline, copies(baseline))
    if instead is not None and instead.gain > INSTEAD * named:
        return replace(instead, instead=True)
    return replace(beside, named_gain=named)


def _best(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    base: Fit,
    copies: Sequence[Array],
) -> Unexplained | None:
    left = base.beyond_refit(base.weighted)
    imitations = [base.beyond_refit(copy) for copy in copies]
    best: tuple[float, Table, Array, Array] | None = None
    for table in tables:
        columns = base.beyond_refit(
            np.column_stack([_change(model, cases, base, table, k) for k in table.knots])
        )
        seen = np.linalg.norm(columns, axis=0) > 1e-6
        if not seen.any():
            continue
        span = np.linalg.qr(columns[:, seen])[0]
        gain = float(np.sum((span.T @ left) ** 2))
        pretended = max((float(np.sum((span.T @ copy) ** 2)) for copy in imitations), default=0.0)
        if gain <= max(LEAST_GAIN, OVER_IMITATIONS * pretended, best[0] if best else 0.0):
            continue
        steps = np.asarray(np.linalg.lstsq(columns, left, rcond=1e-6)[0], dtype=np.float64)
        if float(np.std(table.step * steps)) > table.least:
            best = gain, table, columns, steps
    return None if best is None else _fitted(model, cases, base, *best)


def _change(model: Model, cases: Sequence[Case], base: Fit, table: Table, knot: str) -> Array:
    """Return what a step of one knot changes in the weighted residuals."""
    there = {**base.shared, **table.values, knot: table.step}
    values = values_in_each(cases, cases[0], there, base.own)
    return base.weighted - base.weigh(residuals_of(model, cases, values))


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
