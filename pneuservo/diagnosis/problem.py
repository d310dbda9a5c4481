"""The least-squares problem behind a fit: unknowns, starts, bounds and residuals."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model, Unknown
from pneuservo.diagnosis.models.model import Array, Values
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.rigs import Parameter

_LEAST_SHARE = 1e-3
"""Share of where it starts that a positive parameter keeps: nothing divides by nothing."""
_ANEW = "error of "
"""How the name of a recording's own error of a parameter begins, where that was measured anew."""


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


def values_in(case: Case, first: Case, shared: Values, own: Values) -> dict[str, float]:
    """Return the values that a model takes for one recording.

    Parameters
    ----------
    case : Case
        The recording.
    first : Case
        The one that the shared values are stated for.
    shared, own : mapping of str to float
        Fitted values of all recordings and of this one.

    Notes
    -----
    Where a parameter was measured anew for a recording, 5 kg added for example, a fit that
    corrects it does so by the same factor everywhere, but for the error of that measurement, which
    is the recording's own: 5 kg are weighed better than what they are added to. A zero, or what may
    as well be one, is corrected by as much everywhere.
    """
    here, mine = dict(shared), dict(own)
    before, now = first.rig.parameters, case.rig.parameters
    measured_anew = any(key.startswith(_ANEW) for key in own)
    for key in shared:
        if key not in now:
            continue
        nominal, reference = now[key].value, before[key].value
        error = mine.pop(_ANEW + key, 0.0) if measured_anew else 0.0
        if _is_a_zero(before[key]):
            here[key] += nominal - reference + error
        elif nominal != reference:
            here[key] *= (1.0 + error) * nominal / reference
    return {**case.rig.effect_values, **here, **mine}


def _is_a_zero(parameter: Parameter) -> bool:
    """Return whether a value is no larger than what it is known by."""
    return abs(parameter.value) <= parameter.tolerance


def values_in_each(
    cases: Sequence[Case], first: Case, shared: Values, own: Sequence[Values]
) -> list[dict[str, float]]:
    """Return the values that a model takes for each of several recordings.

    Parameters
    ----------
    cases : sequence of Case
        The recordings.
    first, shared, own
        As for `values_in`, the last one per recording.
    """
    return [values_in(case, first, shared, mine) for case, mine in zip(cases, own, strict=True)]


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
    own = _own_unknowns(model, cases, hypothesis, cases[0])
    baseline = _baseline_unknowns(model, cases, hypothesis)
    return [
        Problem(model, cases, [*baseline, *effects], own)
        for effects in _effect_unknowns(model, cases, hypothesis)
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
    own = _own_unknowns(model, cases, hypothesis, reference)
    return Problem(model, cases, [], own, held=shared, reference=reference)


def _own_unknowns(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis, reference: Case
) -> list[list[Unknown]]:
    """Return the unknowns of each case; in a joint model a recording's stand with its first."""
    seen: set[int] = set()
    found = []
    for case in cases:
        own = model.nuisances(case, hypothesis.effects | set(case.rig.effects))
        if not model.joint or id(case.recording) not in seen:
            own += _measured_anew(model, case, reference)
        seen.add(id(case.recording))
        found.append(own)
    return found


def _measured_anew(model: Model, case: Case, reference: Case) -> list[Unknown]:
    """Return the errors of parameters that were measured anew, each as well as the first time."""
    found = []
    for key in model.fitted(case):
        before, now = reference.rig.parameters[key], case.rig[key]
        if not before.tolerance or before.free or before.value == now:
            continue
        if _is_a_zero(before):
            error = Unknown(_ANEW + key, 0.0, -np.inf, np.inf, before.tolerance, before.unit)
            found.append(error)
        else:
            sigma = before.tolerance / abs(before.value)
            found.append(Unknown(_ANEW + key, 0.0, _LEAST_SHARE - 1.0, np.inf, sigma))
    return found


def _baseline_unknowns(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis
) -> list[Unknown]:
    found = []
    case = cases[0]
    guess = model.first_guess(case)
    for key in model.fitted_to(cases):
        parameter = case.rig.parameters[key]
        known = parameter.tolerance and not parameter.free and key not in hypothesis.loosened
        start = guess.get(key, parameter.value) if parameter.free else parameter.value
        # Signs are part of what is known; only zero-centred values may change theirs.
        low = _LEAST_SHARE * start if parameter.value > 0.0 and start > 0.0 else -np.inf
        sigma = parameter.tolerance if known else None
        found.append(Unknown(key, start, low, np.inf, sigma, parameter.unit))
    return found


def _effect_unknowns(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis
) -> list[list[Unknown]]:
    """Return the unknowns of the effects, once per combination of their starts."""
    switched = [effect for effect in model.effects if effect.id in hypothesis.effects]
    parameters = [(effect.key(p.name), p) for effect in switched for p in effect.parameters]
    tried = [starts for effect in switched for starts in model.starts(effect, cases).values()]
    return [
        [
            Unknown(key, start, p.low, p.high, None, p.unit)
            for (key, p), start in zip(parameters, starts, strict=True)
        ]
        for starts in itertools.product(*tried)
    ]


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
