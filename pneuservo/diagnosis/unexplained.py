"""What nothing in the catalogue explains: its shape, as a table over one recorded quantity."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.diagnosis.fit import Fit, rms
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array, Table, Values
from pneuservo.diagnosis.problem import values_in
from pneuservo.diagnosis.screen import imitated_residuals, projected

ENOUGH_GAIN = 100.0
"""A table has to lower the weighted sum of squares by as much as an effect has to ..."""
OVER_IMITATIONS = 8.0
"""... and by so many times what it lowers that of recordings without anything unexplained."""
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
            half = 1.96 * float(sigma)
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
    model: Model, cases: Sequence[Case], baseline: Fit, chosen: Fit, seed: int
) -> Unexplained | None:
    """Return the table that explains what a model leaves, where it earns its place.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    baseline, chosen : Fit
        The re-fitted baseline, and the model with everything that was named.
    seed : int
        Seed of the noise of the imitations.

    Returns
    -------
    Unexplained or None
        None when what is left could be noise, or the model has no tables.

    Notes
    -----
    Every table is simulated knot by knot, what the fitted parameters absorb is taken out, and the
    knots are fitted together: a projected score test with one degree of freedom per knot, held
    against imitations of the recordings like any named effect.
    """
    beside = _best(model, cases, chosen, seed)
    if not chosen.hypothesis.effects:
        return beside
    named = _gain_between(baseline, chosen)
    instead = _best(model, cases, baseline, seed)
    if instead is not None and instead.gain > INSTEAD * named:
        return replace(instead, instead=True)
    if beside is None or beside.gain < WORTH_SAYING * (beside.gain + named):
        return None
    return replace(beside, named_gain=named)


def _gain_between(before: Fit, after: Fit) -> float:
    first, second = (after.weigh(found.residuals) for found in (before, after))
    return float(np.sum(first**2) - np.sum(second**2))


def _best(model: Model, cases: Sequence[Case], base: Fit, seed: int) -> Unexplained | None:
    left = projected(base, base.weigh(base.residuals)[:, np.newaxis])[:, 0]
    imitations = [
        projected(base, copy[:, np.newaxis])[:, 0]
        for copy in imitated_residuals(model, cases, base, seed)
    ]
    best: tuple[float, Table, Array] | None = None
    for table in model.tables(cases):
        raw = np.column_stack([_change(model, cases, base, table, k) for k in table.knots])
        columns = projected(base, raw / base.row_scale()[:, np.newaxis])
        seen = np.linalg.norm(columns, axis=0) > 1e-6
        if not seen.any():
            continue
        span = np.linalg.qr(columns[:, seen])[0]
        gain = float(np.sum((span.T @ left) ** 2))
        pretended = max((float(np.sum((span.T @ copy) ** 2)) for copy in imitations), default=0.0)
        enough = gain > max(ENOUGH_GAIN, OVER_IMITATIONS * pretended)
        heights = table.step * np.linalg.lstsq(columns, left, rcond=1e-6)[0]
        enough = enough and float(np.std(heights)) > table.least
        if enough and (best is None or gain > best[0]):
            best = gain, table, columns
    if best is None:
        return None
    return _fitted(model, cases, base, left, *best)


def _change(model: Model, cases: Sequence[Case], base: Fit, table: Table, knot: str) -> Array:
    """Return what a step of one knot changes in the residuals [unit of the cases]."""
    there = {**base.shared, **table.values, knot: table.step}
    before, after = (
        np.concatenate(_parts(model, cases, shared, base.own)) for shared in (base.shared, there)
    )
    change: Array = before - after
    return change


def _parts(
    model: Model, cases: Sequence[Case], shared: Values, own: Sequence[Values]
) -> list[Array]:
    return [
        (case.measured - model.predict(case, values_in(case, cases[0], shared, mine)))[case.usable]
        for case, mine in zip(cases, own, strict=True)
    ]


def _fitted(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    left: Array,
    gain: float,
    table: Table,
    columns: Array,
) -> Unexplained:
    """Return the table with its knots fitted together with what the parameters do about it."""
    steps = np.linalg.lstsq(columns, left, rcond=1e-6)[0]
    # Of the shape alone: what all knots have in common the parameters may take up.
    shape = np.eye(len(steps)) - 1.0 / len(steps)
    covariance = shape @ np.linalg.pinv(columns.T @ columns) @ shape
    spread = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    heights = dict(zip(table.knots, (steps * table.step).tolist(), strict=True))
    shared = {**base.shared, **table.values, **heights}
    own = list(base.own)
    residuals = _parts(model, cases, shared, own)
    # What the parameters had made up for they no longer have to.
    undone = np.concatenate([base.weigh(residuals), base.distance])
    parameters, more = base.moved(np.linalg.lstsq(base.sensitivity, -undone, rcond=None)[0])
    moved = {**shared, **parameters}
    closer = _parts(model, cases, moved, more)
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
