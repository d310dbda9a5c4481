"""Output-error fits: the whole model is simulated and compared with what was measured."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, explained, rms
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import DECISIVE
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.problem import Problem, begun_at, problem_with, problems_of
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.starts import Begin, best_start, least_of
from pneuservo.diagnosis.steady import Known, SteadySensitivity
from pneuservo.errors import FitError
from pneuservo.intervals import INTERVAL
from pneuservo.noise import effective_samples

_DIFFERENCE_STEP = 1e-6
_MOST_EVALUATIONS = 30
_STOPPED_SHORT = 0
"""A reflective trust region that has made all its evaluations creeps along the valley of two values
that look alike, and a dogleg ends the fit in three more: an asymmetry beside a load cell's zero was
left at 65 instead of 38. From the beginning it would lead closed volumes astray."""
_CLOSE, _ENOUGH = 1e-6, 1e-5
"""Relative drop of the sum of squares below which a fit ends, and one from kept sensitivities."""
_FEW_EVALUATIONS = 15
_MOST_PASSES = 8
_MOST_POLISHED, _WORTH_GOING_ON = 4, 0.01
"""A fit is carried on so often where each time gains this share of what was left."""
_BEYOND = (-2.0, -1.0, 1.0, 2.0)
"""Tolerances by which a parameter is moved to look beyond a ridge ..."""
_WORTH_LOOKING = 1.05
"""... where a channel of a recording is left at so many times its noise, which is known to 5 %."""
_SETTLED = 0.03
"""Relative change of the weights below which they have settled."""


def fit(
    model: Model,
    cases: Sequence[Case],
    hypothesis: Hypothesis,
    near: Fit | None = None,
    fixed: Values | None = None,
    reference: Case | None = None,
    begin: Begin = Begin.ANYWHERE,
    elsewhere: Fit | None = None,
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
    begin : Begin, optional
        From where, if there is such a fit.
    elsewhere : Fit, optional
        Of the hypothesis to the same recordings, read in another way: where it has ended is one
        more start.

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
        best = best_start(model, cases, hypothesis, near, begin)
        if elsewhere is not None:
            best = least_of([best, _begun_where_ended(best, elsewhere)])
    else:
        best = problem_with(model, cases, hypothesis, fixed, reference or cases[0])
        if not best.unknowns:
            return _summary(hypothesis, best, np.empty(0), fixed)
    if near is None and fixed is None:
        return _fitted_anew(best, hypothesis)
    if begin is Begin.IN_NOISE:
        # Weights that followed from what is missed would lead it astray again.
        best.scale = dict.fromkeys(best.channels, 1.0)
        vector = _solve(best, best.first, hypothesis, None)
        return _summary(hypothesis, best, vector, fixed).in_weights(_scales(best, vector))
    vector = _settled(best, best.first, hypothesis, near)
    return _summary(hypothesis, best, vector, fixed)


def at_nominal(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return what a hypothesis leaves at nominal parameters, in the weights of its fit.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    found : Fit
        From `fit`.
    """
    problem = _problem_of(model, cases, found)
    problem.jacobian = SteadySensitivity(problem, None)(problem.first)
    return _summary(found.hypothesis, problem, problem.first, None)


def _problem_of(model: Model, cases: Sequence[Case], found: Fit) -> Problem:
    """Return the problem that a fit has solved, begun anew in the weights of the fit."""
    return replace(problems_of(model, cases, found.hypothesis)[0], scale=found.scale)


def refitted(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return the fit of a baseline to the recordings it was fitted to, read in another way.

    Parameters
    ----------
    model : Model
        The rig's model.
    cases : sequence of Case
        The recordings as they are read now.
    found : Fit
        Of the baseline; nothing but its values is taken over, as a start.
    """
    start = problems_of(model, cases, found.hypothesis)[0]
    return _fitted_anew(least_of([start, _begun_where_ended(start, found)]), found.hypothesis)


def _begun_where_ended(start: Problem, found: Fit) -> Problem:
    """Return a problem begun where a fit to the same recordings, read otherwise, has ended."""
    count = len(start.cases)
    own = found.own if len(found.own) == count else [{}] * count
    return begun_at(start, found.shared, own)


def _fitted_anew(problem: Problem, hypothesis: Hypothesis) -> Fit:
    """Return a fit with sensitivities of its own."""
    vector = _settled(problem, problem.first, hypothesis, None)
    return _summary(hypothesis, problem, vector, None)


def _settled(problem: Problem, vector: Array, hypothesis: Hypothesis, near: Fit | None) -> Array:
    """Return the solution with the weights that follow from the misfit that it leaves."""
    steady, known = problem.model.steady, None
    less_free = near if near and steady and near.hypothesis.is_part_of(hypothesis) else None
    for passed in range(_MOST_PASSES if steady else 2):
        before, problem.scale = problem.scale, _scales(problem, vector)
        if less_free is not None and not passed:
            # What a start misses must not pass for noise where less freedom did not miss it.
            first = less_free.scale
            problem.scale = {c: min(s, first.get(c, s)) for c, s in problem.scale.items()}
        if before and all(abs(before[c] / s - 1.0) < _SETTLED for c, s in problem.scale.items()):
            break
        vector = _solve(problem, vector, hypothesis, near if known is None else known)
        if passed or near is not None:
            # By now the vector is near the solution: no sensitivity has to be worked out again.
            known = problem.solved(vector)
        if less_free is not None and _hopeless(problem, vector, less_free):
            break
    return vector


def beyond_ridges(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return a fit, or the one beyond a ridge of the sum of squares where that leaves less.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    found : Fit
        From `fit`.

    Notes
    -----
    Each parameter whose ridges the model knows is moved by some tolerances to either side, all
    others follow as they would if they were linear, and the fit goes on from there with the
    sensitivities that it has: halfway to where it leaves less it may leave more.
    """
    if not model.ridges:
        return found
    worst = max(rms([r]) for c, r in zip(cases, found.residuals, strict=True) if c.recorded)
    if worst < _WORTH_LOOKING:
        return found
    problem = begun_at(_problem_of(model, cases, found), found.shared, found.own)
    here = problem.first

    def beyond(move: tuple[int, float]) -> tuple[float, Array]:
        place, away = move
        moved, others = here.copy(), np.arange(len(here)) != place
        moved[place] += away
        moved = np.clip(moved, *problem.bounds)
        left = problem.cost_vector(moved)
        moved[others] += np.linalg.lstsq(found.sensitivity[:, others], -left, rcond=None)[0]
        vector = _solve(replace(problem), moved, found.hypothesis, found)
        return float(np.sum(problem.cost_vector(vector) ** 2)), vector

    moves = [
        (int(place), away * sigma / problem.units[place])
        for place, sigma in zip(problem.tolerated, problem.sigma, strict=True)
        if problem.keys[place] in model.ridges
        for away in _BEYOND
    ]
    if not moves:
        return found
    _, least = min(side_by_side(beyond, moves), key=lambda side: side[0])
    # With weights of its own: by those that are there it might count as settled already.
    begun = replace(problem, begin=least * problem.units, scale={})
    again = _fitted_anew(begun, found.hypothesis)
    return again if explained(found, again) > DECISIVE else found


def polished(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return a fit carried to its end with sensitivities of its own.

    Parameters
    ----------
    model, cases
        What was fitted to what.
    found : Fit
        From `fit`; where sensitivities were kept from a similar fit it may have stopped on a ridge
        along which two values make up for each other.

    Notes
    -----
    A dogleg that meets a bound is cut short there, though the gradient leads away from it, and ends
    as if nothing were to be gained: a leak whose share of laminar flow had come to 1 beside a heat
    transfer stayed there, 24 below what it explains at 0.5, and a leak of another law was named.
    Where a value lies at its bound a reflective trust region goes on from it.

    A spool whose motor is too weak, in a loop that chatters, had 24,100 after one round and 33,200
    of 99,800 after two, where a slew had 25,900.
    """
    for _ in range(_MOST_POLISHED):
        before, found = found, _counted_anew(_further(model, cases, found))
        if explained(before, found) < _WORTH_GOING_ON * float(np.sum(before.left**2)):
            break
    return found


def _counted_anew(found: Fit) -> Fit:
    """Return a fit in whose weights nothing that it no longer misses counts as noise."""
    scale = channel_scales(found.channels, found.residuals, found.finest)
    return found.in_weights({c: min(size, scale[c]) for c, size in found.scale.items()})


def _further(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return a fit carried on, by as many evaluations as a fit may take."""
    problem = begun_at(_problem_of(model, cases, found), found.shared, found.own)
    vector = _solve(problem, problem.first, found.hypothesis, None)
    low, high = problem.bounds
    if np.any((vector <= low) | (vector >= high)):
        inside = replace(problem)
        other = _solve(inside, vector, found.hypothesis, None, method="trf")
        if np.sum(inside.cost_vector(other) ** 2) < np.sum(problem.cost_vector(vector) ** 2):
            problem, vector = inside, other
    return _summary(found.hypothesis, problem, vector, None)


def _hopeless(problem: Problem, vector: Array, near: Fit) -> bool:
    """Return whether more freedom has led to a worse fit: no other weights will mend that."""
    row_scale = problem.row_scale()
    before = np.concatenate([np.concatenate(near.residuals) / row_scale, near.distance])
    return float(np.sum(problem.cost_vector(vector) ** 2)) > float(np.sum(before**2))


def _scales(problem: Problem, vector: Array) -> dict[str, float]:
    finest = {channel: problem.resolution(channel) for channel in problem.channels}
    return channel_scales(problem.channels, problem.residuals(vector), finest)


def channel_scales(
    channels: Sequence[str], residuals: Sequence[Array], finest: Mapping[str, float]
) -> dict[str, float]:
    """Return what one residual of each channel counts as one standard deviation.

    Parameters
    ----------
    channels : sequence of str
        Channel of each residual.
    residuals : sequence of array
        Measured minus modelled.
    finest : mapping of str to float
        Residual below which the fit of a channel is perfect.
    """
    scales = {}
    for channel in dict.fromkeys(channels):
        parts = [r for r, c in zip(residuals, channels, strict=True) if c == channel]
        size, worth = sum(len(r) for r in parts), sum(effective_samples(r) for r in parts)
        scales[channel] = max(rms(parts), finest[channel]) * float(np.sqrt(size / worth))
    return scales


def _solve(
    problem: Problem,
    vector: Array,
    hypothesis: Hypothesis,
    known: Known | None,
    method: str = "dogbox",
) -> Array:
    from scipy.optimize import least_squares

    low, high = problem.bounds
    begin = np.clip(vector, low, high)
    how: dict[str, Any] = {
        "diff_step": _DIFFERENCE_STEP,
        "ftol": _CLOSE,
        "max_nfev": _MOST_EVALUATIONS,
    }
    if problem.model.steady:
        how = {
            "jac": SteadySensitivity(problem, known),
            "ftol": _ENOUGH,
            "max_nfev": _FEW_EVALUATIONS,
            # A reflective trust region creeps where a size begins near its lower bound.
            "method": method,
        }
    with np.errstate(all="ignore"):
        how |= {"bounds": (low, high), "x_scale": "jac"}
        found: Any = least_squares(problem.cost_vector, begin, **how)
        if found.status == _STOPPED_SHORT and not problem.model.steady:
            further = least_squares(problem.cost_vector, found.x, **how, method="dogbox")
            found = min(found, further, key=lambda each: each.cost)
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
    half = INTERVAL * np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    # Of what nothing shows all that is possible is as likely.
    half[~jacobian.any(axis=0) & np.isfinite(np.subtract(*problem.bounds))] = np.inf
    bounds = [
        (float(max(x - h, u.low)), float(min(x + h, u.high)))
        for x, h, u in zip(vector * problem.units, half, problem.shared, strict=False)
    ]
    values = problem.values(vector)
    intervals = {u.key: ends for u, ends in zip(problem.shared, bounds, strict=True)}
    shared = {u.key: values[0][u.key] for u in problem.shared} if fixed is None else dict(fixed)
    return Fit(
        hypothesis=hypothesis,
        shared=shared,
        intervals=intervals,
        own=tuple(problem.own_values(vector)),
        channels=problem.channels,
        residuals=tuple(residuals),
        rms=max(rms(residuals), min(finest.values())),
        samples=len(everything),
        effective=effective,
        finest=finest,
        known=frozenset(case.channel for case in problem.cases if not case.recorded),
        unknowns=len(problem.unknowns),
        penalty=float(np.sum(problem.distance(vector) ** 2)),
        scale=problem.scale or dict.fromkeys(effective, 1.0),
        keys=tuple(problem.keys),
        units=problem.units,
        bounds=problem.bounds,
        vector=vector,
        owners=problem.owners,
        tolerated=tuple(problem.unknowns[i].key for i in problem.tolerated),
        distance=problem.distance(vector),
        sensitivity=jacobian,
        covariance=covariance,
    )
