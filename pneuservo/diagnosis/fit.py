"""Output-error fits: the whole model is simulated and compared with what was measured."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pneuservo.diagnosis.models import Case, Model, Unknown
from pneuservo.diagnosis.models.model import Array, Values
from pneuservo.diagnosis.noise import effective_samples
from pneuservo.errors import FitError

_DIFFERENCE_STEP = 1e-6
_MOST_EVALUATIONS = 60
_INTERVAL = 1.96
"""Half width of a 95 % interval, in standard deviations."""


@dataclass(frozen=True)
class Hypothesis:
    """What a fit is allowed to change.

    Parameters
    ----------
    effects : frozenset of str
        Effects of the catalogue that are switched on.
    loosened : frozenset of str
        Rig parameters that may leave their tolerance.
    """

    effects: frozenset[str] = frozenset()
    loosened: frozenset[str] = frozenset()

    def adding(self, candidate: str) -> "Hypothesis":
        """Return this hypothesis and one more; ``param.X`` loosens the rig parameter X."""
        if candidate.startswith("param."):
            return Hypothesis(self.effects, self.loosened | {candidate.removeprefix("param.")})
        return Hypothesis(self.effects | {candidate}, self.loosened)

    def without(self, candidate: str) -> "Hypothesis":
        """Return this hypothesis less one."""
        return Hypothesis(
            self.effects - {candidate}, self.loosened - {candidate.removeprefix("param.")}
        )

    @property
    def members(self) -> tuple[str, ...]:
        """Return what this hypothesis adds to the baseline, in a fixed order."""
        return (*sorted(self.effects), *sorted(f"param.{key}" for key in self.loosened))


@dataclass(frozen=True)
class Fit:
    """A hypothesis fitted to recordings.

    Parameters
    ----------
    hypothesis : Hypothesis
        What was allowed to change.
    shared : mapping of str to float
        Fitted values that hold for every recording.
    intervals : mapping of str to (low, high)
        95 % intervals of the shared values.
    own : sequence of mapping
        Fitted values of each recording alone.
    residuals : sequence of array
        Measured minus modelled, usable samples only [SI].
    rms : float
        Root mean square of all residuals together [SI].
    samples, effective : float
        Number of samples, and what they are worth after serial correlation.
    unknowns : int
        How many numbers were fitted.
    penalty : float
        Squared distance of tolerated parameters from their nominal values, in tolerances.
    """

    hypothesis: Hypothesis
    shared: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    own: tuple[dict[str, float], ...]
    residuals: tuple[Array, ...]
    rms: float
    samples: int
    effective: float
    unknowns: int
    penalty: float
    jacobian: Array = field(repr=False)
    """Sensitivity of all residuals to the shared and own values, in scaled units."""

    def evidence(self, effective: float) -> float:
        """Return the Bayesian information criterion: lower is better, 10 is decisive."""
        return (
            effective * float(np.log(self.rms**2))
            + self.unknowns * float(np.log(effective))
            + self.penalty
        )


@dataclass
class _Problem:
    """The vector of unknowns and the residuals they leave."""

    model: Model
    cases: Sequence[Case]
    shared: list[Unknown]
    own: list[list[Unknown]]
    begin: Array | None = None
    scale: float = 1.0
    jacobian: Array | None = None

    def __post_init__(self) -> None:
        self.unknowns = [*self.shared, *itertools.chain.from_iterable(self.own)]
        self.units = np.array([_typical_size(u) for u in self.unknowns])
        self.start = np.array([u.start for u in self.unknowns])
        tolerated = [i for i, u in enumerate(self.unknowns) if u.sigma is not None]
        self.tolerated = np.array(tolerated, dtype=int)
        self.sigma = np.array([self.unknowns[i].sigma for i in tolerated], dtype=float)
        if self.begin is None:
            self.begin = self.start

    @property
    def bounds(self) -> tuple[Array, Array]:
        low = np.array([u.low for u in self.unknowns])
        high = np.array([u.high for u in self.unknowns])
        return low / self.units, high / self.units

    def values(self, vector: Array) -> list[dict[str, float]]:
        """Return the values of each case."""
        numbers = (vector * self.units).tolist()
        common = {u.key: number for u, number in zip(self.shared, numbers, strict=False)}
        offset, values = len(self.shared), []
        for case, own in zip(self.cases, self.own, strict=True):
            mine = numbers[offset : offset + len(own)]
            known = case.rig.effect_values | common
            values.append(known | {u.key: x for u, x in zip(own, mine, strict=True)})
            offset += len(own)
        return values

    def residuals(self, vector: Array) -> list[Array]:
        """Return measured minus modelled for each case, usable samples only."""
        return [
            (case.measured - self.model.predict(case, values))[case.usable]
            for case, values in zip(self.cases, self.values(vector), strict=True)
        ]

    def distance(self, vector: Array) -> Array:
        """Return how far tolerated values are from nominal, in tolerances."""
        moved = (vector * self.units)[self.tolerated] - self.start[self.tolerated]
        distance: Array = moved / self.sigma
        return distance

    def cost_vector(self, vector: Array) -> Array:
        """Return everything the optimiser squares and sums."""
        residual = np.concatenate(self.residuals(vector)) / self.scale
        bounded = np.nan_to_num(residual, nan=1e9, posinf=1e9, neginf=-1e9)
        return np.concatenate([bounded, self.distance(vector)])


def _typical_size(unknown: Unknown) -> float:
    if unknown.start:
        return abs(unknown.start)
    if unknown.sigma:
        return unknown.sigma
    span = unknown.high - unknown.low
    return span / 100.0 if np.isfinite(span) else 1.0


def shared_unknowns(model: Model, case: Case, hypothesis: Hypothesis) -> list[list[Unknown]]:
    """Return the unknowns that all recordings share, once per start worth trying."""
    baseline = []
    guess: dict[str, float] = getattr(model, "first_guess", lambda case: {})(case)
    for key in model.fitted:
        parameter = case.rig.parameters[key]
        known = parameter.tolerance and not parameter.free and key not in hypothesis.loosened
        start = guess.get(key, parameter.value) if parameter.free else parameter.value
        # Signs are part of what is known; only zero-centred values may change theirs.
        low = 0.0 if parameter.value > 0.0 and start > 0.0 else -np.inf
        sigma = parameter.tolerance if known else None
        baseline.append(Unknown(key, start, low, np.inf, sigma, parameter.unit))
    variants = []
    for effect in model.effects:
        if effect.id in hypothesis.effects:
            choices = itertools.product(*(p.starts for p in effect.parameters))
            variants.append(
                [
                    [
                        Unknown(effect.key(p.name), start, p.low, p.high, None, p.unit)
                        for p, start in zip(effect.parameters, choice, strict=True)
                    ]
                    for choice in choices
                ]
            )
    return [[*baseline, *itertools.chain(*choice)] for choice in itertools.product(*variants)]


def fit(
    model: Model,
    cases: Sequence[Case],
    hypothesis: Hypothesis,
    near: Fit | None = None,
    fixed: Values | None = None,
) -> Fit:
    """Fit a hypothesis to recordings by simulating them.

    Parameters
    ----------
    model : Model
        The rig's model.
    cases : sequence of Case
        Prepared recordings of one rig.
    hypothesis : Hypothesis
        What may change.
    near : Fit, optional
        A fit of a similar hypothesis to start from.
    fixed : mapping of str to float, optional
        Values of all shared unknowns; only each recording's own are then fitted.

    Returns
    -------
    Fit
        The best fit found.

    Raises
    ------
    FitError
        When no start leads to a finite fit.

    Notes
    -----
    Weighted least squares. A residual counts as ``effective`` independent samples of its own
    root mean square, so that a misfit of the model cannot overrule what is known of a parameter
    by sheer number of samples.
    """
    problems = _problems(model, cases, hypothesis, near, fixed)
    best = _best_start(problems)
    if fixed is not None and not best.unknowns:
        return _summary(model, hypothesis, best, np.empty(0), fixed)
    vector = np.asarray(best.begin) / best.units
    # Twice: the weights, and with them the intervals, follow from the misfit that is left.
    for _ in range(2):
        residuals = best.residuals(vector)
        effective = sum(effective_samples(r) for r in residuals)
        size = sum(len(r) for r in residuals)
        rms = float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))
        best.scale = max(rms, 1e-300) * float(np.sqrt(size / effective))
        vector = _solve(best, vector, hypothesis)
    return _summary(model, hypothesis, best, vector, fixed)


def _problems(
    model: Model,
    cases: Sequence[Case],
    hypothesis: Hypothesis,
    near: Fit | None,
    fixed: Values | None,
) -> list[_Problem]:
    own_variants = [
        model.nuisances(case, hypothesis.effects | set(case.rig.effects)) for case in cases
    ]
    most = max(len(variants) for variants in own_variants)
    own_choices = [[v[min(i, len(v) - 1)] for v in own_variants] for i in range(most)]
    if fixed is not None:
        bound = [_Fixed(model, dict(fixed))]
        return [_Problem(m, cases, [], own) for m in bound for own in own_choices]
    shared_choices = shared_unknowns(model, cases[0], hypothesis)
    problems = [_Problem(model, cases, s, o) for s in shared_choices for o in own_choices]
    if near is None:
        return problems
    return [*problems, *(_moved(problem, near) for problem in problems)]


class _Fixed(Model):
    """A model with its shared values held."""

    def __init__(self, model: Model, values: dict[str, float]):
        self._model, self._values = model, values

    def predict(self, case: Case, values: Values) -> Array:
        return self._model.predict(case, self._values | dict(values))


def _moved(problem: _Problem, near: Fit) -> _Problem:
    """Return the problem started from another fit, where that has the same unknowns."""
    known = [near.shared, *near.own]
    blocks = [problem.shared, *problem.own]
    begin: list[float] = []
    for values, block in zip(known, blocks, strict=True):
        begin += [values.get(unknown.key, unknown.start) for unknown in block]
    return replace(problem, begin=np.array(begin))


def _best_start(problems: list[_Problem]) -> _Problem:
    """Return the problem whose start leaves the least."""

    def cost(problem: _Problem) -> float:
        begin = np.asarray(problem.begin) / problem.units
        return float(np.sum(np.concatenate(problem.residuals(begin)) ** 2))

    with np.errstate(all="ignore"):
        costs = [cost(problem) for problem in problems]
    order = np.argsort(np.nan_to_num(costs, nan=np.inf))
    return problems[int(order[0])]


def _solve(problem: _Problem, vector: Array, hypothesis: Hypothesis) -> Array:
    from scipy.optimize import least_squares

    low, high = problem.bounds
    begin = np.clip(vector, low, high)
    with np.errstate(all="ignore"):
        found: Any = least_squares(
            problem.cost_vector,
            begin,
            bounds=(low, high),
            x_scale="jac",
            diff_step=_DIFFERENCE_STEP,
            max_nfev=_MOST_EVALUATIONS,
        )
    if not np.isfinite(found.cost) or found.cost > 1e17:
        tried = ", ".join(hypothesis.members) or "the baseline"
        raise FitError(
            f"the fit of {tried} did not reach finite values from any of its starts; "
            "check units and signs of the recording's channels"
        )
    solution: Array = found.x
    problem.jacobian = found.jac
    return solution


def _summary(
    model: Model, hypothesis: Hypothesis, problem: _Problem, vector: Array, fixed: Values | None
) -> Fit:
    residuals = problem.residuals(vector)
    everything = np.concatenate(residuals)
    jacobian = problem.jacobian if problem.jacobian is not None else np.zeros((len(everything), 0))
    spread = np.sqrt(np.clip(np.diag(np.linalg.pinv(jacobian.T @ jacobian)), 0.0, None))
    intervals = {}
    for i, unknown in enumerate(problem.shared):
        value, half = vector[i] * problem.units[i], _INTERVAL * spread[i] * problem.units[i]
        intervals[unknown.key] = (
            float(max(value - half, unknown.low)),
            float(min(value + half, unknown.high)),
        )
    values = problem.values(vector)
    keys = [{u.key for u in own} for own in problem.own]
    shared = {u.key: values[0][u.key] for u in problem.shared} if fixed is None else dict(fixed)
    return Fit(
        hypothesis,
        shared,
        intervals,
        tuple({k: v[k] for k in own} for v, own in zip(values, keys, strict=True)),
        tuple(residuals),
        float(np.sqrt(np.mean(everything**2))),
        len(everything),
        float(sum(effective_samples(r) for r in residuals)),
        len(problem.unknowns),
        float(np.sum(problem.distance(vector) ** 2)),
        jacobian[: len(everything)],
    )
