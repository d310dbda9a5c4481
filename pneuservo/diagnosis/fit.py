"""Output-error fits: the whole model is simulated and compared with what was measured."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array, Values
from pneuservo.diagnosis.noise import effective_samples
from pneuservo.diagnosis.problem import Problem, own_key, problem_with, problems_of
from pneuservo.diagnosis.steady import SteadySensitivity
from pneuservo.errors import FitError

_DIFFERENCE_STEP = 1e-6
_MOST_EVALUATIONS = 60
_ENOUGH = 1e-5
"""Relative drop of the sum of squares below which a fit from kept sensitivities ends."""
_FEW_EVALUATIONS = 15
_MOST_PASSES = 8
_SETTLED = 0.03
"""Relative change of the weights below which they have settled."""
_INTERVAL = 1.96
"""Half width of a 95 % interval, in standard deviations."""


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
    channels : sequence of str
        Channel of each residual.
    residuals : sequence of array
        Measured minus modelled, usable samples only [unit of the cases].
    rms : float
        Root mean square of all residuals together [unit of the cases].
    samples : int
        Number of samples.
    effective : mapping of str to float
        What the samples of each channel are worth after serial correlation.
    finest : mapping of str to float
        Residual below which the fit of a channel is perfect [unit of its cases].
    unknowns : int
        How many numbers were fitted.
    penalty : float
        Squared distance of tolerated parameters from their nominal values, in tolerances.
    """

    hypothesis: Hypothesis
    shared: dict[str, float]
    intervals: dict[str, tuple[float, float]]
    own: tuple[dict[str, float], ...]
    channels: tuple[str, ...]
    residuals: tuple[Array, ...]
    rms: float
    samples: int
    effective: Mapping[str, float]
    finest: Mapping[str, float]
    unknowns: int
    penalty: float
    scale: Mapping[str, float]
    """What one residual of each channel counts as one standard deviation."""
    keys: tuple[str, ...]
    """Name of each column of `sensitivity`."""
    units: Array = field(repr=False)
    """What one unit of each column is [SI]."""
    owners: tuple[int, ...]
    """Case whose own values each case has."""
    tolerated: tuple[str, ...]
    """Values that are known within a tolerance."""
    distance: Array = field(repr=False)
    """How far the tolerated values are from nominal, in tolerances."""
    sensitivity: Array = field(repr=False)
    """Of all weighted residuals and then of `distance` to all values, in units of the fit."""
    covariance: Array = field(repr=False)
    """Covariance of the shared and then all own values [SI]."""

    def interval_of(
        self, quantity: Callable[[Values, Values], float]
    ) -> tuple[float, float, float]:
        """Return a quantity that follows from the fitted values, and its 95 % interval.

        Parameters
        ----------
        quantity : callable
            Takes the shared values and the own values of the first recording.

        Returns
        -------
        value, low, high : float
            From the linearised spread of the fitted values.
        """
        keys = [*((0, key) for key in self.shared), *((1, key) for key in self.own[0])]
        values = (dict(self.shared), dict(self.own[0]))
        centre, slopes = quantity(*values), []
        for i, (group, key) in enumerate(keys):
            step = 1e-3 * float(np.sqrt(max(self.covariance[i, i], 0.0))) or 1e-12
            moved = tuple(
                {**v, key: v[key] + step} if g == group else v for g, v in enumerate(values)
            )
            slopes.append((quantity(*moved) - centre) / step)
        slope, size = np.array(slopes), len(keys)
        spread = max(0.0, float(slope @ self.covariance[:size, :size] @ slope))
        half = _INTERVAL * float(np.sqrt(spread))
        return centre, centre - half, centre + half

    def sensitivities(self, member: str) -> Array:
        """Return the columns of the Jacobian that belong to an effect or a ``param.`` id."""
        parameter = member.removeprefix("param.")
        columns = [
            i
            for i, key in enumerate(self.shared)
            if key == parameter or key.startswith(f"{member}:")
        ]
        return self.jacobian[:, columns]

    def moved(self, step: Array) -> tuple[dict[str, float], list[dict[str, float]]]:
        """Return the shared and own values after a step.

        Parameters
        ----------
        step : (m,) array
            In units of the fit, one number per column of `sensitivity`.
        """
        by_key = dict(zip(self.keys, (step * self.units).tolist(), strict=True))
        shared = {key: value + by_key.get(key, 0.0) for key, value in self.shared.items()}
        own = [
            {key: value + by_key.get(own_key(key, place), 0.0) for key, value in values.items()}
            for place, values in zip(self.owners, self.own, strict=True)
        ]
        return shared, own

    @property
    def jacobian(self) -> Array:
        """Return the sensitivity of the weighted residuals alone."""
        return self.sensitivity[: self.samples]

    @property
    def weighted(self) -> Array:
        """Return all residuals, each counted in the spread of its channel."""
        return self.weigh(self.residuals)

    def weigh(self, parts: Sequence[Array]) -> Array:
        """Return residuals or changes of them, each counted in the spread of its channel."""
        return np.concatenate(parts) / self.row_scale()

    def row_scale(self) -> Array:
        """Return what each residual counts as one."""
        return np.concatenate(
            [
                np.full(len(part), self.scale[c])
                for part, c in zip(self.residuals, self.channels, strict=True)
            ]
        )

    @property
    def all_effective(self) -> float:
        """Return what all samples together are worth."""
        return sum(self.effective.values())

    def rms_of(self, channel: str) -> float:
        """Return the root mean square of what one channel leaves [unit of its cases]."""
        parts = [r for r, c in zip(self.residuals, self.channels, strict=True) if c == channel]
        return max(rms(parts), self.finest[channel])

    def evidence(self, effective: Mapping[str, float]) -> float:
        """Return the Bayesian information criterion: lower is better, 10 is decisive.

        Parameters
        ----------
        effective : mapping of str to float
            What the samples of each channel are worth; the same for all that are compared.
        """
        misfit = sum(
            worth * float(np.log(self.rms_of(channel) ** 2)) for channel, worth in effective.items()
        )
        return misfit + self.unknowns * float(np.log(sum(effective.values()))) + self.penalty


def fit(
    model: Model,
    cases: Sequence[Case],
    hypothesis: Hypothesis,
    near: Fit | None = None,
    fixed: Values | None = None,
    reference: Case | None = None,
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
    reference : Case, optional
        The recording that `fixed` is stated for; the first one where it is not given.

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
    if fixed is None:
        best = _best_start(
            problems_of(model, cases, hypothesis, (near.shared, near.own) if near else None)
        )
    else:
        best = problem_with(model, cases, hypothesis, fixed, reference or cases[0])
        if not best.unknowns:
            return _summary(hypothesis, best, np.empty(0), fixed)
    vector = np.asarray(best.begin) / best.units
    # The weights, and with them the intervals, follow from the misfit that is left.
    for _ in range(_MOST_PASSES if model.steady else 2):
        before, best.scale = best.scale, _scales(best, vector)
        if before and all(abs(before[c] / s - 1.0) < _SETTLED for c, s in best.scale.items()):
            break
        vector = _solve(best, vector, hypothesis, near)
    return _summary(hypothesis, best, vector, fixed)


def rms(residuals: Sequence[Array]) -> float:
    """Return the root mean square of several residuals together.

    Parameters
    ----------
    residuals : sequence of array
        In one unit.
    """
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)))


def _scales(problem: Problem, vector: Array) -> dict[str, float]:
    """Return what one residual of each channel counts as one standard deviation."""
    residuals, scales = problem.residuals(vector), {}
    for channel in dict.fromkeys(problem.channels):
        parts = [r for r, c in zip(residuals, problem.channels, strict=True) if c == channel]
        size, worth = sum(len(r) for r in parts), sum(effective_samples(r) for r in parts)
        scales[channel] = max(rms(parts), problem.resolution(channel)) * float(
            np.sqrt(size / worth)
        )
    return scales


def _best_start(problems: list[Problem]) -> Problem:
    """Return the problem whose start leaves the least."""

    def cost(problem: Problem) -> float:
        begin = np.asarray(problem.begin) / problem.units
        return float(np.sum(np.concatenate(problem.residuals(begin)) ** 2))

    with np.errstate(all="ignore"):
        costs = [cost(problem) for problem in problems]
    order = np.argsort(np.nan_to_num(costs, nan=np.inf))
    return problems[int(order[0])]


def _solve(problem: Problem, vector: Array, hypothesis: Hypothesis, near: Fit | None) -> Array:
    from scipy.optimize import least_squares

    low, high = problem.bounds
    begin = np.clip(vector, low, high)
    how: dict[str, Any] = {"diff_step": _DIFFERENCE_STEP, "max_nfev": _MOST_EVALUATIONS}
    if problem.model.steady:
        how = {
            "jac": SteadySensitivity(problem, near),
            "ftol": _ENOUGH,
            "max_nfev": _FEW_EVALUATIONS,
        }
    with np.errstate(all="ignore"):
        found: Any = least_squares(
            problem.cost_vector, begin, bounds=(low, high), x_scale="jac", **how
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


def _summary(hypothesis: Hypothesis, problem: Problem, vector: Array, fixed: Values | None) -> Fit:
    residuals = problem.residuals(vector)
    everything = np.concatenate(residuals)
    effective: dict[str, float] = {}
    for channel, part in zip(problem.channels, residuals, strict=True):
        effective[channel] = effective.get(channel, 0.0) + effective_samples(part)
    finest = {channel: problem.resolution(channel) for channel in effective}
    jacobian = problem.jacobian
    if jacobian is None:
        jacobian = np.zeros((len(everything) + len(problem.tolerated), len(vector)))
    spread = np.linalg.pinv(jacobian.T @ jacobian) * np.outer(problem.units, problem.units)
    covariance = np.asarray(spread, dtype=np.float64)
    half = _INTERVAL * np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    bounds = [
        (float(max(x - h, u.low)), float(min(x + h, u.high)))
        for x, h, u in zip(vector * problem.units, half, problem.shared, strict=False)
    ]
    values = problem.values(vector)
    intervals = {u.key: ends for u, ends in zip(problem.shared, bounds, strict=True)}
    shared = {u.key: values[0][u.key] for u in problem.shared} if fixed is None else dict(fixed)
    return Fit(
        hypothesis,
        shared,
        intervals,
        tuple(problem.own_values(vector)),
        problem.channels,
        tuple(residuals),
        max(rms(residuals), *finest.values()),
        len(everything),
        effective,
        finest,
        len(problem.unknowns),
        float(np.sum(problem.distance(vector) ** 2)),
        problem.scale or dict.fromkeys(effective, 1.0),
        tuple(problem.keys),
        problem.units,
        problem.owners,
        tuple(problem.unknowns[i].key for i in problem.tolerated),
        problem.distance(vector),
        jacobian,
        covariance,
    )
