"""What nothing in the catalogue explains: its shape, as a table over one recorded quantity."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.judge import OVER_IMITATIONS
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Table
from pneuservo.diagnosis.problem import residuals_of
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import gained_beyond
from pneuservo.diagnosis.tabulated import (
    Tabulated,
    beside_table,
    coarse_shapes,
    of_channels,
    spread_of_shape,
    varies_most,
)
from pneuservo.diagnosis.unknowns import values_in_each
from pneuservo.intervals import INTERVAL

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
    found = _table_of(model, cases, tables, baseline, chosen, copies)
    if found is None:
        return None
    # It was fitted to what was recorded alone; what it leaves of all else is told, too.
    values = values_in_each(cases, cases[0], found.fit.shared, found.fit.own)
    left = tuple(residuals_of(model, cases, values))
    return replace(found, fit=replace(found.fit, residuals=left))


def _table_of(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    baseline: Fit,
    chosen: Fit,
    copies: Copies,
) -> Unexplained | None:
    """Return the table beside the names, or in their place, fitted to what was recorded alone."""
    baseline, chosen = (of_channels(cases, fit) for fit in (baseline, chosen))
    beside = _best(model, cases, tables, chosen, copies)
    names = len(chosen.hypothesis.effects)
    if not names:
        return beside
    # In the weights of the table's own gain: what it removes had passed for noise of the names.
    named = explained(baseline, chosen, None if beside is None else beside.fit)
    if beside is not None and beside.gain < WORTH_SAYING * (beside.gain + named):
        beside = None
    doubtful = names >= MANY_NAMES or _hardly_closer(baseline, chosen)
    # One more name is no reason to drop others.
    if doubtful or (beside is not None and not beside.table.form_of):
        instead = _best(model, cases, tables, baseline, copies)
        if instead is not None:
            enough = INSTEAD_OF_MANY if names >= MANY_NAMES else INSTEAD
            # In noise too: what a table does not follow would count for little in its own weights.
            weights = (instead.fit, instead.fit.in_noise)
            gains = [
                [explained(baseline, found, weighed) for found in (instead.fit, chosen)]
                for weighed in weights
            ]
            if all(by_table > enough * by_names for by_table, by_names in gains):
                return replace(instead, instead=True)
    return None if beside is None else replace(beside, named_gain=named)


def _hardly_closer(baseline: Fit, chosen: Fit) -> bool:
    """Return whether what is beyond noise is mostly still there; residuals count in noise."""
    before, after = (max(fit.rms**2 - 1.0, 0.0) for fit in (baseline, chosen))
    return after > HARDLY_CLOSER * before and after > LEAST_LEFT


def _best(
    model: Model,
    cases: Sequence[Case],
    tables: Sequence[Table],
    base: Fit,
    copies: Copies,
) -> Unexplained | None:
    """Return the table that explains most of what a fit leaves, of those that earn their place.

    They promise in the weights of the misfit that there is, and in those of noise: what is slow
    leaves so few independent samples that a supply which wanders promised 7 of the 3,600 that it
    explains.
    """
    sides = [(side, side.beyond_refit(side.weighted)) for side in (base, base.in_noise)]
    promise: list[tuple[float, Tabulated]] = []
    placed = [Tabulated(model, cases, table, cases[0]) for table in tables]
    roughly = side_by_side(
        lambda each: each.changes(base, coarse_shapes(len(each.table.knots))), placed
    )
    for each, columns in zip(placed, roughly, strict=True):
        promised = [gained_beyond(side, [columns], [left]) for side, left in sides]
        promise.append((max(promised), each))
    promise.sort(key=lambda each: each[0], reverse=True)
    worth_fitting = [
        each
        for gain, each in promise[:WORTH_FITTING]
        if gain > LEAST_PROMISE * each.table.least_gain
    ]
    changes = side_by_side(lambda each: each.changes(base), worth_fitting)
    fitted = [
        _fitted(each, base, columns, copies)
        for each, columns in zip(worth_fitting, changes, strict=True)
    ]
    worth = [found for found in fitted if found is not None]
    return max(worth, key=lambda found: found.gain, default=None)


def _fitted(tabulated: Tabulated, base: Fit, columns: Array, copies: Copies) -> Unexplained | None:
    """Return a table fitted together with what the parameters do about it, if it is worth it."""
    table = tabulated.table
    found, steps, moved = tabulated.fitted(base, columns)
    weighed, gain = base.in_weights(found.scale), explained(base, found)
    if gain <= table.least_gain:
        return None
    made = copies(weighed)
    pretended = gained_beyond(weighed, [columns], made) if made else 0.0
    if gain <= OVER_IMITATIONS * pretended:
        return None
    values = table.step * steps
    if float(np.max(np.std(values, axis=1))) <= table.least:
        return None
    if float(np.max(np.abs(values))) > table.largest:
        return None
    shown = varies_most(steps)
    spread = spread_of_shape(weighed, moved, len(steps))[shown]
    low, high = (table.values[key] for key in (table.low, table.high))
    knots = np.linspace(low, high, len(table.knots))
    found = beside_table(base, found, moved, len(steps))
    return Unexplained(table, knots, values[shown], spread * table.step, gain, 0.0, found)
