"""The least-squares problem behind a fit: unknowns, starts, bounds and residuals."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model, Unknown
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.unknowns import (
    baseline_unknowns,
    effect_unknowns,
    own_unknowns,
    values_in_each,
)


@dataclass
class Problem:
    """The vector of unknowns and the residuals they leave.

    Parameters
    ----------
    model : Model
        What is simulated.
    cases : sequence of Case
        What it is compared with.
    shared : list of Unknown
        Unknowns that hold for every recording.
    own : list of list of Unknown
        Unknowns of each recording alone.
    begin : (m,) array, optional
        Where the fit begins, where that is not the unknowns' start [SI].
    scale : mapping of str to float, optional
        What one residual counts as one standard deviation, by channel [unit of the channel].
    jacobian : (n, m) array, optional
        Sensitivities at the solution, once there is one.
    held : mapping of str to float, optional
        Shared values that are not fitted.
    reference : Case, optional
        The recording that the shared values are stated for; the first one where it is not given.
    """

    model: Model
    cases: Sequence[Case]
    shared: list[Unknown]
    own: list[list[Unknown]]
    begin: Array | None = None
    scale: Mapping[str, float] = field(default_factory=dict)
    jacobian: Array | None = None
    held: Values = field(default_factory=dict)
    reference: Case | None = None

    def __post_init__(self) -> None:
        self.unknowns = [*self.shared, *itertools.chain.from_iterable(self.own)]
        self.units = np.array([_typical_size(u) for u in self.unknowns])
        self.start = np.array([u.start for u in self.unknowns])
        tolerated = [i for i, u in enumerate(self.unknowns) if u.sigma is not None]
        self.tolerated = np.array(tolerated, dtype=int)
        self.sigma = np.array([self.unknowns[i].sigma for i in tolerated], dtype=float)
        if self.begin is None:
            self.begin = self.start
        self._rows: tuple[Mapping[str, float], Array] | None = None

    @property
    def first(self) -> Array:
        """Return where the fit begins, in units of the fit."""
        return np.asarray(self.begin) / self.units

    @property
    def keys(self) -> list[str]:
        """Return the name of each unknown, told apart by case where it is a case's own."""
        return column_names([u.key for u in self.shared], [[u.key for u in o] for o in self.own])

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the judged channel of each case."""
        return tuple(case.channel for case in self.cases)

    def resolution(self, channel: str) -> float:
        """Return the residual below which the fit of a channel is perfect [its unit]."""
        return max(case.resolution for case in self.cases if case.channel == channel)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Return the lowest and highest vector."""
        low = np.array([u.low for u in self.unknowns])
        high = np.array([u.high for u in self.unknowns])
        return low / self.units, high / self.units

    def own_values(self, vector: Array) -> list[dict[str, float]]:
        """Return each case's own values; in a joint model those of its recording's first case."""
        numbers = iter((vector * self.units).tolist()[len(self.shared) :])
        mine = [{u.key: next(numbers) for u in own} for own in self.own]
        return [mine[owner] for owner in self.owners]

    @property
    def owners(self) -> tuple[int, ...]:
        """Return the case whose own values each case has."""
        if not self.model.joint:
            return tuple(range(len(self.cases)))
        first: dict[int, int] = {}
        return tuple(first.setdefault(id(c.recording), i) for i, c in enumerate(self.cases))

    def values(self, vector: Array) -> list[dict[str, float]]:
        """Return the values of each case."""
        numbers = (vector * self.units).tolist()
        common = dict(self.held)
        common |= {u.key: number for u, number in zip(self.shared, numbers, strict=False)}
        return values_in_each(
            self.cases, self.reference or self.cases[0], common, self.own_values(vector)
        )

    def residuals(self, vector: Array) -> list[Array]:
        """Return measured minus modelled for each case, usable samples only."""
        return residuals_of(self.model, self.cases, self.values(vector))

    def row_scale(self) -> Array:
        """Return what each residual counts as one [unit of its case]."""
        # A fit asks thousands of times; what is given is replaced, never changed.
        if self._rows is None or self._rows[0] is not self.scale:
            parts = [
                np.full(int(np.count_nonzero(case.usable)), self.scale.get(case.channel, 1.0))
                for case in self.cases
            ]
            self._rows = self.scale, np.concatenate(parts)
        return self._rows[1]

    def solved(self, vector: Array) -> "Solved":
        """Return the sensitivities at the solution, for a fit that begins near it."""
        if self.jacobian is None:
            raise ValueError("the problem has not been solved")
        return Solved(self.keys, self.jacobian, vector, self.units, self.row_scale())

    def distance(self, vector: Array) -> Array:
        """Return how far tolerated values are from nominal, in tolerances."""
        moved = (vector * self.units)[self.tolerated] - self.start[self.tolerated]
        distance: Array = moved / self.sigma
        return distance

    def cost_vector(self, vector: Array) -> Array:
        """Return everything the optimiser squares and sums."""
        residual = np.concatenate(self.residuals(vector)) / self.row_scale()
        if not np.isfinite(residual).all():
            residual = np.nan_to_num(residual, nan=1e9, posinf=1e9, neginf=-1e9)
        return np.concatenate([residual, self.distance(vector)])


@dataclass(frozen=True)
class Solved:
    """Sensitivities of a solved problem.

    Parameters
    ----------
    keys : sequence of str
        Name of each column.
    sensitivity : (n + t, m) array
        Of all weighted residuals and then of the distances of tolerated values.
    vector : (m,) array
        The solution, each unknown in its typical size.
    units : (m,) array
        These sizes [SI].
    rows : (n,) array
        What each residual counted as one.
    """

    keys: Sequence[str]
    sensitivity: Array
    vector: Array
    units: Array
    rows: Array

    def row_scale(self) -> Array:
        """Return what each residual counted as one."""
        return self.rows


def column_names(shared: Sequence[str], own: Sequence[Sequence[str]]) -> list[str]:
    """Return the names of shared unknowns and of those of each case, no two alike.

    Parameters
    ----------
    shared : sequence of str
        Keys that hold for every case.
    own : sequence of sequence of str
        Keys of each case alone.

    Examples
    --------
    >>> column_names(["load.mass"], [["zero"], [], ["zero"]])
    ['load.mass', 'zero of case 0', 'zero of case 2']
    """
    return [*shared, *(own_key(key, i) for i, keys in enumerate(own) for key in keys)]


def own_key(key: str, case: int) -> str:
    """Return the name of a value of one case, by the place of the case."""
    return f"{key} of case {case}"


def _typical_size(unknown: Unknown) -> float:
    if unknown.start:
        return abs(unknown.start)
    if unknown.sigma:
        return unknown.sigma
    span = unknown.high - unknown.low
    return span / 100.0 if np.isfinite(span) and span > 0.0 else 1.0


def residuals_of(model: Model, cases: Sequence[Case], values: Sequence[Values]) -> list[Array]:
    """Return measured minus modelled, usable samples only [unit of the cases].

    Parameters
    ----------
    model, cases
        What is simulated, and what it is compared with.
    values : sequence of mapping
        From `values_in_each`.
    """
    # What is judged of one recording is simulated at once, and kept.
    together: dict[int, list[int]] = {}
    for place, case in enumerate(cases):
        together.setdefault(id(case.recording), []).append(place)

    def left_at(places: Sequence[int]) -> list[Array]:
        return [
            (cases[i].measured - model.predict(cases[i], values[i]))[cases[i].usable]
            for i in places
        ]

    found = side_by_side(left_at, together.values())
    left = dict(zip(itertools.chain(*together.values()), itertools.chain(*found), strict=True))
    return [left[place] for place in range(len(cases))]


def problems_of(model: Model, cases: Sequence[Case], hypothesis: Hypothesis) -> list[Problem]:
    """Return the problem of fitting a hypothesis, once per start worth trying.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.

    Returns
    -------
    list of Problem
        They differ only in where they begin.
    """
    own = own_unknowns(model, cases, hypothesis, cases[0])
    baseline = baseline_unknowns(model, cases, hypothesis)
    return [
        Problem(model, cases, [*baseline, *effects], own)
        for effects in effect_unknowns(model, cases, hypothesis)
    ]


def problem_with(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis, shared: Values, reference: Case
) -> Problem:
    """Return the problem of fitting each recording's own values, the shared ones held.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.
    shared : mapping of str to float
        Values of all shared unknowns.
    reference : Case
        The recording that they are stated for.

    Returns
    -------
    Problem
        It has no shared unknowns.
    """
    own = own_unknowns(model, cases, hypothesis, reference)
    return Problem(model, cases, [], own, held=shared, reference=reference)


def begun_at(problem: Problem, shared: Values, own: Sequence[Values]) -> Problem:
    """Return the problem begun at other values, as far as they have the same unknowns.

    Parameters
    ----------
    problem : Problem
        With several cases' own unknowns.
    shared, own
        Values of a fit.
    """
    begin = [
        values.get(unknown.key, unknown.start)
        for values, block in zip([shared, *own], [problem.shared, *problem.own], strict=True)
        for unknown in block
    ]
    return replace(problem, begin=np.array(begin))
