"""Intervals by profile likelihood: how far a value can go while all others make up for it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.problem import Problem, problems_of
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.intervals import INTERVAL

RISE = INTERVAL**2
"""Rise of the weighted sum of squares at the ends of a 95 % interval (chi-square, one value)."""
_NEARLY = 0.05
"""Share of that rise within which an end is known well enough."""
_MOST_TRIALS = 6
_CHORDS = 2
"""Times that the other values follow, with the sensitivities of the solution."""


def with_profiles(
    model: Model,
    cases: Sequence[Case],
    found: Fit,
    keys: Sequence[str],
    rise: float = RISE,
) -> Fit:
    """Return a fit with the intervals of some shared values from their profile likelihood.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    found : Fit
        The fit.
    keys : sequence of str
        Shared values whose intervals are wanted.
    rise : float, optional
        Of the weighted sum of squares at the ends of an interval.

    Returns
    -------
    Fit
        The same fit, other intervals.

    Notes
    -----
    Where a model bends, the interval from its curvature at the solution is too narrow on one side
    and too wide on the other (Venzon and Moolgavkar 1988). An end that lies beyond a hard limit is
    the limit.
    """
    if not keys:
        return found
    problem = problems_of(model, cases, found.hypothesis)[0]
    problem.scale = found.scale
    values = [found.shared, *found.own]
    blocks = [problem.shared, *problem.own]
    solution = np.array([v[u.key] for v, block in zip(values, blocks, strict=True) for u in block])
    vector = solution / problem.units
    profile = _Profile(problem, vector, found.sensitivity * (problem.units / found.units), rise)
    place = {unknown.key: i for i, unknown in enumerate(problem.shared)}
    asked = [(place[key], sign) for key in keys for sign in (-1.0, 1.0)]
    ends = iter(side_by_side(lambda each: profile.end(*each), asked))
    intervals = dict(found.intervals)
    for key, one, other in zip(keys, ends, ends, strict=True):
        low, high = sorted(end * float(problem.units[place[key]]) for end in (one, other))
        intervals[key] = low, high
    return replace(found, intervals=intervals)


class _Profile:
    def __init__(self, problem: Problem, vector: Array, jacobian: Array, wanted: float):
        self._problem, self._vector, self._jacobian = problem, vector, jacobian
        self._wanted = wanted
        self._lowest = float(np.sum(problem.cost_vector(vector) ** 2))
        # Products of the tall matrix, made once: its singular values cost as much as a simulation.
        self._products = jacobian.T @ jacobian
        self._sigma = np.sqrt(np.clip(np.diag(_inverse(self._products)), 0.0, None))

    def end(self, column: int, sign: float) -> float:
        """Return the end of the interval of one unknown, in units of the problem."""
        low, high = (bound[column] for bound in self._problem.bounds)
        centre, limit = self._vector[column], high if sign > 0.0 else low
        # Of what nothing shows, all that is possible is as likely.
        reach = sign * float(np.sqrt(self._wanted)) * (self._sigma[column] or high - low)
        inside, outside = 0.0, np.inf
        for _ in range(_MOST_TRIALS):
            if sign * (centre + reach - limit) > 0.0:
                reach = limit - centre
            rise = self._rise(column, centre + reach)
            if abs(rise - self._wanted) < _NEARLY * self._wanted or (
                reach == limit - centre and rise < self._wanted
            ):
                break
            if rise < self._wanted:
                inside = abs(reach)
            else:
                outside = abs(reach)
            # The rise grows with the square of the distance, as long as the model hardly bends.
            wanted = abs(reach) * float(np.sqrt(self._wanted / max(rise, 1e-2 * self._wanted)))
            if not inside < wanted < outside:
                wanted = 0.5 * (inside + outside) if np.isfinite(outside) else 2.0 * inside
            reach = sign * wanted
        return float(centre + reach)

    def _rise(self, column: int, value: float) -> float:
        """Return how much worse the fit is with one unknown held and the others following."""
        vector = self._vector.copy()
        others = np.arange(len(vector)) != column
        vector[column] = value
        follow = _inverse(self._products[np.ix_(others, others)])
        low, high = self._problem.bounds
        lowest = np.inf
        for _ in range(_CHORDS + 1):
            with np.errstate(all="ignore"):
                left = self._problem.cost_vector(vector)
            cost = float(np.sum(left**2))
            if not cost < lowest:
                break
            lowest = cost
            step = follow @ (self._jacobian.T @ left)[others]
            vector[others] = np.clip(vector[others] - step, low[others], high[others])
        return max(lowest - self._lowest, 0.0)


def _inverse(products: Array) -> Array:
    """Return the inverse of products of columns, each column counted in its own length."""
    lengths = np.sqrt(np.diag(products))
    scale = np.divide(1.0, lengths, out=np.zeros_like(lengths), where=lengths > 0.0)
    scaled = np.linalg.pinv(products * np.outer(scale, scale), rcond=1e-14, hermitian=True)
    return np.asarray(scaled * np.outer(scale, scale))
