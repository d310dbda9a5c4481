"""A table fitted to what a model leaves, knot by knot, together with what the parameters do."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, explained, rms
from pneuservo.diagnosis.fitting import channel_scales
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Table, Values
from pneuservo.diagnosis.problem import residuals_of
from pneuservo.diagnosis.unknowns import values_in_each
from pneuservo.intervals import INTERVAL

PLAIN = 0.05
"""What a bend between knots, and what all have in common, counts, in what a knot shows: knots of
which nothing shows are laid on a straight line, others hardly move."""
_MOST_PASSES = 8
_HARDLY_MORE = 0.02
"""Share of what a table explains that another pass has to add."""
_SHARES = (1.0, 0.5, 0.2)
"""Of a step, where all of it may be too much."""

Steps = Array
"""What every knot has in units of the table's step: one row, or one for each recording."""


def coarse_shapes(knots: int) -> Array:
    """Return shapes with every other knot only, straight between them, one per row.

    Parameters
    ----------
    knots : int
        How many there are.
    """
    every = np.arange(knots)
    return np.array([np.clip(1.0 - 0.5 * np.abs(every - k), 0.0, None) for k in every[::2]])


def of_channels(cases: Sequence[Case], found: Fit) -> Fit:
    """Return a fit of what was recorded alone.

    What follows from it, such as what friction can hold, has no slope where it holds: it would
    keep knots, and all that follows them, at the edge of that.

    Parameters
    ----------
    cases, found
        What was fitted to what.
    """
    residuals = _recorded(cases, found.residuals)
    counts = [np.full(len(r), c.recorded) for c, r in zip(cases, residuals, strict=True)]
    sensitivity = found.sensitivity.copy()
    sensitivity[: found.samples][~np.concatenate(counts)] = 0.0
    judged = rms([r for r, case in zip(residuals, cases, strict=True) if case.recorded])
    return replace(found, residuals=tuple(residuals), rms=judged, sensitivity=sensitivity)


def without_table(found: Fit, table: Table) -> Fit:
    """Return a fit without the values of a table that stands in it; what it leaves stays.

    Parameters
    ----------
    found : Fit
        From `Tabulated.fitted`.
    table : Table
        That stands in it.
    """
    keys = {*table.values, *table.knots}
    shared, *own = (
        {key: value for key, value in values.items() if key not in keys}
        for values in (found.shared, *found.own)
    )
    return replace(found, shared=shared, own=tuple(own))


@dataclass(frozen=True)
class Tabulated:
    """A table, and the recordings that it may explain something of.

    Parameters
    ----------
    model, cases
        What is fitted to what.
    table : Table
        What is tabulated.
    reference : Case
        The recording that shared values are stated for.
    """

    model: Model
    cases: Sequence[Case]
    table: Table
    reference: Case

    @cached_property
    def _parts(self) -> list[int]:
        """Return which of its tables each case has."""
        first: dict[int, int] = {}
        return [
            first.setdefault(id(case.recording), len(first)) if self.table.own else 0
            for case in self.cases
        ]

    @property
    def flat(self) -> Steps:
        """Return tables that have nothing at any knot."""
        return np.zeros((max(self._parts) + 1, len(self.table.knots)))

    def changes(self, base: Fit, shapes: Array | None = None, steps: Steps | None = None) -> Array:
        """Return what a step of each of some shapes changes in the residuals [unit of the cases].

        Parameters
        ----------
        base : Fit
            What it is tabulated beside.
        shapes : (m, k) array, optional
            Heights of all knots, in steps; without them every knot alone.
        steps : (p, k) array, optional
            Those that it has taken already.

        Returns
        -------
        (n, p m) array
            Those of the first row of steps first: where every recording has a table of its own,
            each of them in one recording alone.
        """
        taken = self.flat if steps is None else steps
        changes = []
        for shape in np.eye(len(self.table.knots)) if shapes is None else shapes:
            left = self._left(*self._with_heights(base, taken + shape))
            changes.append(
                [before - after for before, after in zip(base.residuals, left, strict=True)]
            )
        return np.column_stack(
            [
                np.concatenate(
                    [
                        change if mine == part else np.zeros_like(change)
                        for change, mine in zip(each, self._parts, strict=True)
                    ]
                )
                for part in range(len(taken))
                for each in changes
            ]
        )

    def fitted(self, base: Fit, columns: Array) -> tuple[Fit, Steps, Array]:
        """Return a fit with the table in it, together with what the parameters do about it.

        Parameters
        ----------
        base : Fit
            What it is tabulated beside.
        columns : (n, p k) array
            What every knot changes.

        Returns
        -------
        found : Fit
            With the table; its intervals are those without, see `beside_table`.
        steps : (p, k) array
            What it has at its knots.
        columns : (n, p k) array
            What every knot changes there.

        Notes
        -----
        The misfit that it removes had passed for noise: what it leaves is the measure from then on,
        and it goes on for as long as it explains more.
        """
        found, steps, gain = base, self.flat, 0.0
        for _ in range(_MOST_PASSES):
            closer, moved = self._further(found, steps, columns)
            more = explained(base, closer)
            if more < gain * (1.0 + _HARDLY_MORE) or explained(found, closer, found) <= 0.0:
                break
            found, steps, gain = closer, moved, more
            columns = self.changes(found, steps=steps)
        return found, steps, columns

    def _with_heights(
        self, base: Fit, steps: Steps
    ) -> tuple[dict[str, float], tuple[dict[str, float], ...]]:
        """Return the shared and own values of a fit with the table beside them.

        Of tables of recordings of their own the shared values hold the one that varies most.
        """
        table = self.table
        rows = [dict(zip(table.knots, row, strict=True)) for row in (table.step * steps).tolist()]
        shared = {**base.shared, **table.values, **rows[varies_most(steps)]}
        if not table.own:
            return shared, base.own
        own = ({**mine, **rows[part]} for mine, part in zip(base.own, self._parts, strict=True))
        return shared, tuple(own)

    def _left(self, shared: Values, own: Sequence[Values]) -> list[Array]:
        values = values_in_each(self.cases, self.reference, shared, own)
        return _recorded(self.cases, residuals_of(self.model, self.cases, values))

    def _further(self, base: Fit, steps: Steps, columns: Array) -> tuple[Fit, Steps]:
        """Return a fit whose table has gone on from some steps, and the steps that it has taken.

        The parameters move to where they suit the table, all of the way or so far as it gets
        better.
        """
        whole = _steps(base, columns, steps)
        undone = base.weighted - base.counted(columns @ whole)
        follow = np.linalg.lstsq(
            base.sensitivity, -np.concatenate([undone, base.distance]), rcond=None
        )[0]
        tried: list[tuple[float, Fit, Steps]] = []
        for share in _SHARES:
            taken = steps + share * whole.reshape(steps.shape)
            moved = base.stepped(share * follow)
            shared, own = self._with_heights(moved, taken)
            residuals = self._left(shared, own)
            cost = float(np.sum(base.weigh(residuals) ** 2)) + moved.penalty
            found = replace(
                moved,
                shared=shared,
                own=own,
                residuals=tuple(residuals),
                rms=max(rms(residuals), min(base.finest.values())),
            )
            if tried and cost > tried[-1][0]:
                break
            tried.append((cost, found, taken))
        _, found, taken = min(tried, key=lambda each: each[0])
        scale = channel_scales(found.channels, found.residuals, found.finest)
        return found.in_weights(scale), taken


def varies_most(steps: Steps) -> int:
    """Return the row whose table varies most.

    Parameters
    ----------
    steps : (p, k) array
        What every table has at its knots.
    """
    return int(np.argmax(np.std(steps, axis=1)))


def spread_of_shape(base: Fit, columns: Array, parts: int) -> Array:
    """Return how well every knot is known, but for what all have in common [steps].

    Parameters
    ----------
    base : Fit
        In whose weights.
    columns : (n, p k) array
        What every knot changes.
    parts : int
        So many tables.

    Returns
    -------
    (p, k) array
        Standard deviations.
    """
    rest, plain = _rows(base, columns, parts)
    knots = columns.shape[1] // parts
    # Of the shape alone: what all knots have in common the parameters may take up.
    shape = np.kron(np.eye(parts), np.eye(knots) - 1.0 / knots)
    covariance = shape @ np.linalg.pinv(rest.T @ rest + plain.T @ plain) @ shape
    spread: Array = np.sqrt(np.clip(np.diag(covariance), 0.0, None)).reshape(parts, knots)
    return spread


def beside_table(base: Fit, found: Fit, columns: Array, parts: int) -> Fit:
    """Return a fit with the intervals of its values that are right beside a table.

    None is narrower than without the table: those of sizes allow for the forms of laws.

    Parameters
    ----------
    base, found : Fit
        Without and with the table, see `Tabulated.fitted`.
    columns : (n, p k) array
        What every knot changes.
    parts : int
        So many tables.

    Returns
    -------
    Fit
        With the table, other intervals and another covariance.
    """
    _, plain = _rows(found, columns, parts)
    values, knots = len(found.keys), columns.shape[1]
    rows = np.zeros((len(found.sensitivity) + len(plain), values + knots))
    rows[: len(found.sensitivity), :values] = found.sensitivity
    rows[: found.samples, values:] = found.counted(columns)
    rows[len(found.sensitivity) :, values:] = plain
    spread = np.linalg.pinv(rows.T @ rows)[:values, :values]
    covariance = spread * np.outer(found.units, found.units)
    half = INTERVAL * np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    ends = [bound * found.units for bound in found.bounds]
    intervals = dict(found.intervals)
    for key, lowest, highest, much in zip(found.keys, *ends, half, strict=True):
        if key in base.intervals:
            value, (low, high) = found.shared[key], base.intervals[key]
            below = max(much, base.shared[key] - low)
            above = max(much, high - base.shared[key])
            intervals[key] = float(max(value - below, lowest)), float(min(value + above, highest))
    return replace(found, intervals=intervals, covariance=covariance)


def _recorded(cases: Sequence[Case], residuals: Sequence[Array]) -> list[Array]:
    return [r if c.recorded else np.zeros_like(r) for c, r in zip(cases, residuals, strict=True)]


def _rows(base: Fit, columns: Array, parts: int) -> tuple[Array, Array]:
    """Return what the knots change beyond a refit, and what keeps them plain.

    Where nothing shows they run straight, and what they have in common is left to the parameters.
    """
    rest = base.beyond_refit(base.counted(columns))
    knots = rest.shape[1] // parts
    each = np.vstack([np.diff(np.eye(knots), 2, axis=0), np.full(knots, knots**-0.5)])
    plain = np.kron(np.eye(parts), each)
    return rest, plain * PLAIN * float(np.median(np.linalg.norm(rest, axis=0)))


def _steps(base: Fit, columns: Array, taken: Steps) -> Array:
    """Return the steps of the knots that explain most beyond a refit, after some taken already."""
    rest, plain = _rows(base, columns, len(taken))
    left = np.concatenate([base.unabsorbed, -plain @ taken.ravel()])
    return np.asarray(np.linalg.lstsq(np.vstack([rest, plain]), left, rcond=1e-6)[0])
