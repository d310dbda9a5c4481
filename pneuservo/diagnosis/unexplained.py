"""What nothing in the catalogue explains: its shape, as a table over one recorded quantity."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.diagnosis.fit import INTERVAL, Fit, explained, rms
from pneuservo.diagnosis.fitting import channel_scales
from pneuservo.diagnosis.judge import OVER_IMITATIONS
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array, Table, Values
from pneuservo.diagnosis.problem import residuals_of, values_in_each
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import most_gained, spans_beyond

Copies = Callable[[Fit], Sequence[Array]]
"""Takes a fit and returns what it leaves of recordings that its own rig has made, beyond a refit,
in its weights."""

INSTEAD = 1.1
"""A table that explains so many times what the named effects do, in their place, leaves nothing of
the names."""
MANY_NAMES = 3
"""So many names may have shared among them what a single thing does that has none ..."""
INSTEAD_OF_MANY = 0.95
"""... and that are as many as that make way for a table that explains this share of what they do.
(Three that exhausts which ice up were called explained 6,540, and areas that drift 6,370.)"""
HARDLY_CLOSER = 0.5
"""Share of what is beyond noise that names may leave: where they leave more, something that has
none is tried in their place ..."""
LEAST_LEFT = 0.1
"""... if it is this share of the noise, whose size is known to 5 %."""
WORTH_FITTING = 3
"""So many tables, those that promise most, are fitted ..."""
LEAST_PROMISE = 0.2
"""... of those that promise this share of what they have to bring: a misfit counts as noise until
it is explained."""
PLAIN = 0.05
"""What a bend between knots, and what all have in common, counts, in what a knot shows: knots of
which nothing shows are laid on a straight line, others hardly move."""
_MOST_PASSES = 8
_HARDLY_MORE = 0.02
"""Share of what a table explains that another pass has to add."""
_SHARES = (1.0, 0.5, 0.2)
"""Of a step, where all of it may be too much."""
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
    copies: Copies,
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
        See `Copies`.
    jobs : int, optional
        So many tables at a time.

    Returns
    -------
    Unexplained or None
        None when what is left could be noise.

    Notes
    -----
    Every table is simulated with every other knot, what the fitted parameters absorb is taken out,
    and those that promise most are simulated knot by knot and fitted: with one degree of freedom
    per knot, held against imitations of the recordings like any named effect. Only where something
    is left beside the names, where there are many, or where they leave most of what is beyond
    noise, a table may do better in their place.
    """
    baseline, chosen = (_of_channels(cases, fit) for fit in (baseline, chosen))
    beside = _best(model, cases, tables, chosen, copies, jobs)
    names = len(chosen.hypothesis.effects)
    if not names:
        return beside
    named = explained(baseline, chosen)
    if beside is not None and beside.gain < WORTH_SAYING * (beside.gain + named):
        beside = None
    if beside is not None or names >= MANY_NAMES or _hardly_closer(baseline, chosen):
        instead = _best(model, cases, tables, baseline, copies, jobs)
        if instead is not None:
            by_names = explained(baseline, chosen, instead.fit)
            enough = INSTEAD_OF_MANY if names >= MANY_NAMES else INSTEAD
            if instead.gain > enough * by_names:
                return replace(instead, instead=True)
    return None if beside is None else replace(beside, named_gain=named)


def _hardly_closer(baseline: Fit, chosen: Fit) -> bool:
    """Return whether what is beyond noise is mostly still there; residuals count in noise."""
    before, after = (max(fit.rms**2 - 1.0, 0.0) for fit in (baseline, chosen))
    return after > HARDLY_CLOSER * before and after > LEAST_LEFT


def _of_channels(cases: Sequence[Case], fit: Fit) -> Fit:
    """Return a fit of what was recorded alone.

    What follows from it, such as what friction can hold, has no slope where it holds: it would
    keep knots, and all that follows them, at the edge of that.
    """
    residuals = _recorded(cases, fit.residuals)
    counts = [np.full(len(r), c.recorded) for c, r in zip(cases, residuals, strict=True)]
    sensitivity = fit.sensitivity.copy()
    sensitivity[: fit.samples][~np.concatenate(counts)] = 0.0
    judged = rms([r for r, case in zip(residuals, cases, strict=True) if case.recorded])
    return replace(fit, residuals=tuple(residuals), rms=judged, sensitivity=sensitivity)


def _recorded(cases: Sequence[Case], residuals: Sequence[Array]) -> list[Array]:
    return [r if c.recorded else np.zeros_like(r) for c, r in zip(cases, residuals, strict=True)]


def _left(model: Model, cases: Sequence[Case], values: Sequence[Values]) -> list[Array]:
    return _recorded(cases, residuals_of(model, cases, values))


def _best(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    base: Fit,
    copies: Copies,
    jobs: int,
) -> Unexplained | None:
    """Return the table that explains most of what a fit leaves, of those that earn their place."""
    left = base.beyond_refit(base.weighted)
    promise: list[tuple[float, Table]] = []
    roughly = side_by_side(
        lambda table: _changes(model, cases, base, table, _coarse(len(table.knots))), tables, jobs
    )
    for table, columns in zip(tables, roughly, strict=True):
        promise.append((most_gained(spans_beyond(base, [columns]), left), table))
    promise.sort(key=lambda each: each[0], reverse=True)
    worth_fitting = [
        table for gain, table in promise[:WORTH_FITTING] if gain > LEAST_PROMISE * table.least_gain
    ]
    changes = side_by_side(
        lambda table: _changes(model, cases, base, table, np.eye(len(table.knots))),
        worth_fitting,
        jobs,
    )
    fitted = [
        _fitted(model, cases, base, table, columns, copies)
        for table, columns in zip(worth_fitting, changes, strict=True)
    ]
    worth = [found for found in fitted if found is not None]
    return max(worth, key=lambda found: found.gain, default=None)


def _coarse(knots: int) -> Array:
    """Return shapes with every other knot only, straight between them, one per row."""
    every = np.arange(knots)
    return np.array([np.clip(1.0 - 0.5 * np.abs(every - k), 0.0, None) for k in every[::2]])


def _changes(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    table: Table,
    shapes: Array,
    steps: Array | float = 0.0,
) -> Array:
    """Return what a step of each of some shapes changes in the residuals [unit of the cases].

    Beside a table that has taken some steps already.
    """
    here = np.concatenate(base.residuals)
    changes = []
    for shape in shapes:
        heights = dict(zip(table.knots, (table.step * (steps + shape)).tolist(), strict=True))
        there = {**base.shared, **table.values, **heights}
        values = values_in_each(cases, cases[0], there, base.own)
        changes.append(here - np.concatenate(_left(model, cases, values)))
    return np.column_stack(changes)


def _fitted(
    model: Model, cases: Sequence[Case], base: Fit, table: Table, columns: Array, copies: Copies
) -> Unexplained | None:
    """Return a table fitted together with what the parameters do about it, if it is worth it.

    The misfit that it removes had passed for noise: what it leaves is the measure from then on, and
    it goes on for as long as it explains more.
    """
    found, steps, gain = base, np.zeros(len(table.knots)), 0.0
    first = columns
    for _ in range(_MOST_PASSES):
        closer, moved = _further(model, cases, found, table, steps, columns)
        more = explained(base, closer)
        if more < gain * (1.0 + _HARDLY_MORE) or explained(found, closer, found) <= 0.0:
            break
        found, steps, gain = closer, moved, more
        columns = _changes(model, cases, found, table, np.eye(len(steps)), steps)
    weighed = base.in_weights(found.scale)
    spans = spans_beyond(weighed, [first])
    pretended = max((most_gained(spans, copy) for copy in copies(weighed)), default=0.0)
    if gain <= max(table.least_gain, OVER_IMITATIONS * pretended):
        return None
    values = table.step * steps
    if float(np.std(values)) <= table.least or float(np.max(np.abs(values))) > table.largest:
        return None
    rest, plain = _rows(weighed, columns)
    # Of the shape alone: what all knots have in common the parameters may take up.
    shape = np.eye(len(steps)) - 1.0 / len(steps)
    covariance = shape @ np.linalg.pinv(rest.T @ rest + plain.T @ plain) @ shape
    spread = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    low, high = (table.values[key] for key in (table.low, table.high))
    knots = np.linspace(low, high, len(table.knots))
    return Unexplained(table, knots, values, spread * table.step, gain, 0.0, found)


def _rows(base: Fit, columns: Array) -> tuple[Array, Array]:
    """Return what the knots change beyond a refit, and what keeps them plain.

    Where nothing shows they run straight, and what they have in common is left to the parameters.
    """
    rest = base.beyond_refit(base.counted(columns))
    knots = rest.shape[1]
    plain = np.vstack([np.diff(np.eye(knots), 2, axis=0), np.full(knots, knots**-0.5)])
    return rest, plain * PLAIN * float(np.median(np.linalg.norm(rest, axis=0)))


def _steps(base: Fit, columns: Array, taken: Array) -> Array:
    """Return the steps of the knots that explain most beyond a refit, after some taken already."""
    rest, plain = _rows(base, columns)
    left = np.concatenate([base.unabsorbed, -plain @ taken])
    return np.asarray(np.linalg.lstsq(np.vstack([rest, plain]), left, rcond=1e-6)[0])


def _further(
    model: Model, cases: Sequence[Case], base: Fit, table: Table, steps: Array, columns: Array
) -> tuple[Fit, Array]:
    """Return a fit whose table has gone on from some steps, and the steps that it has taken.

    The parameters move to where they suit the table, all of the way or so far as it gets better.
    """
    whole = _steps(base, columns, steps)
    undone = base.weighted - base.counted(columns @ whole)
    follow = np.linalg.lstsq(
        base.sensitivity, -np.concatenate([undone, base.distance]), rcond=None
    )[0]
    tried: list[tuple[float, Fit, Array]] = []
    for share in _SHARES:
        taken = steps + share * whole
        heights = dict(zip(table.knots, (taken * table.step).tolist(), strict=True))
        moved = base.stepped(share * follow)
        shared = {**moved.shared, **table.values, **heights}
        values = values_in_each(cases, cases[0], shared, moved.own)
        residuals = _left(model, cases, values)
        cost = float(np.sum(base.weigh(residuals) ** 2)) + moved.penalty
        found = replace(
            moved,
            shared=shared,
            residuals=tuple(residuals),
            rms=max(rms(residuals), min(base.finest.values())),
        )
        if tried and cost > tried[-1][0]:
            break
        tried.append((cost, found, taken))
    _, found, taken = min(tried, key=lambda each: each[0])
    scale = channel_scales(found.channels, found.residuals, found.finest)
    return found.in_weights(scale), taken
