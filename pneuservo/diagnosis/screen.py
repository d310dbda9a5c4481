"""Which candidates are worth a fit: those whose signature the residual contains."""

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.diagnosis.fit import Fit, orthonormal
from pneuservo.diagnosis.judge import LEAST_DISTANCE, LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.problem import residuals_of, values_in, values_in_each
from pneuservo.effects import Effect

WORTH_FITTING = 6
"""So many effects are fitted at each step; where there are no more, all of them."""
PARAMETERS_WORTH_FITTING = 2
"""So many parameters are loosened at each step, each for the price of a few simulations."""
LEAST_PROMISE = LEAST_GAIN / 3.0
"""Gain that an effect's signature has to promise: in 150 fits of development cases no effect gained
more than 2.8 times what it had promised."""
SMOOTH = 0.1
"""A misfit worth fewer than this share of its samples is looked into without any promise."""
IMITATIONS = 3
"""Recordings without effect that are made to see what the method itself pretends."""
_STEP = 1e-3
"""Share of a shape parameter's range by which it is moved to see what it does."""
_RUNAWAY = 1e9

Signatures = Mapping[str, Sequence[Array]]
"""Effect id to what it changes in all residuals, one array of columns per combination of starts."""


def signatures_of(model: Model, cases: Sequence[Case], base: Fit) -> dict[str, list[Array]]:
    """Return what each effect of a rig changes in the residuals.

    Parameters
    ----------
    model, cases
        What is fitted to what.
    base : Fit
        The fitted baseline.

    Returns
    -------
    dict of str to list of (n, k) array
        Per combination of an effect's starts: the change at the start, and by a step of each
        further parameter [unit of the cases].
    """
    return {effect.id: _signatures(model, cases, base, effect) for effect in model.effects}


def promising(
    base: Fit, signatures: Signatures, names: Sequence[str], keep: Sequence[str] = ()
) -> list[str]:
    """Return the candidates that a fit is worth trying with, in the order given.

    Parameters
    ----------
    base : Fit
        What they would be added to.
    signatures : mapping
        From `signatures_of`.
    names : sequence of str
        Candidates: effect ids and ``param.`` ids.
    keep : sequence of str, optional
        Candidates that are returned in any case.

    Returns
    -------
    list of str
        At most `WORTH_FITTING`, and those to keep; none that promises too little to earn its place.

    Notes
    -----
    A projected score test: the gain that a candidate's signature promises once what the fitted
    parameters absorb, within their tolerances, is taken out of it. Half of them are the best in
    the weights of the fit, the others in those of the noise alone, in which a channel that an
    effect has made to look noisy counts fully.
    """
    as_fitted = _scores(base, base.row_scale(), signatures, names)
    as_noise = _scores(base, np.ones(base.samples), signatures, names)
    worth = sorted(
        (n for n in names if max(as_fitted[n], as_noise[n]) > _least_promise(n, base)),
        key=as_fitted.__getitem__,
        reverse=True,
    )
    parameters = [name for name in worth if name.startswith("param.")]
    effects = [name for name in worth if not name.startswith("param.")]
    best = {*effects[: WORTH_FITTING // 2], *keep}
    for name in sorted(effects, key=as_noise.__getitem__, reverse=True):
        if len(best) >= WORTH_FITTING + len(keep):
            break
        best.add(name)
    best.update(parameters[:PARAMETERS_WORTH_FITTING])
    return [name for name in names if name in best]


def _least_promise(name: str, base: Fit) -> float:
    for channel, worth in base.effective.items():
        # So few independent samples promise nothing, whatever they hide.
        if worth < SMOOTH * base.samples_of(channel):
            return 0.0
    return LEAST_DISTANCE / 2.0 if name.startswith("param.") else LEAST_PROMISE


def _scores(
    base: Fit, scale: Array, signatures: Signatures, names: Sequence[str]
) -> dict[str, float]:
    basis = orthonormal(_rescaled(base, scale))
    left = np.concatenate([np.concatenate(base.residuals) / scale, base.distance])
    left = left - basis @ (basis.T @ left)
    score = {}
    for name in names:
        if name in signatures:
            score[name] = _gain(_spans(base, scale, signatures[name], basis), left)
        else:
            score[name] = _loosened_score(base, name, basis, left)
    return score


def _rescaled(base: Fit, scale: Array) -> Array:
    """Return the sensitivity of a fit with its residuals counted in other units."""
    sensitivity = base.sensitivity.copy()
    sensitivity[: base.samples] *= (base.row_scale() / scale)[:, np.newaxis]
    return sensitivity


@dataclass(frozen=True)
class Visibility:
    """How an effect would show, and how much of it the method pretends.

    Parameters
    ----------
    length : float
        Of its signature at the start's size, in standard deviations of the residuals.
    distinct : float
        Of the part that no refit of the baseline absorbs.
    pretended : float
        Largest drop of the sum of squares it seems to bring to recordings without any effect.
    """

    length: float
    distinct: float
    pretended: float


def visibilities(
    base: Fit, signatures: Signatures, imitations: Sequence[Array]
) -> dict[str, Visibility]:
    """Return how each effect would show in some recordings.

    Parameters
    ----------
    base : Fit
        The fitted baseline.
    signatures : mapping
        From `signatures_of`.
    imitations : sequence of (n,) array
        From `imitated_residuals`.

    Returns
    -------
    dict of str to Visibility
        By effect id.

    Notes
    -----
    What smoothing and sampling make of a perfect model is no physics. It is the same, by and
    large, in every recording that the baseline makes on the same path, so that a few tell its
    size.
    """
    basis, scale = base.absorbed, base.row_scale()
    imitations = [base.beyond_refit(left) for left in imitations]
    found = {}
    for name, variants in signatures.items():
        first = _weighted(base, scale, variants[0][:, :1])[:, 0]
        rest = first - basis @ (basis.T @ first)
        spans = _spans(base, scale, variants, basis)
        pretended = max((_gain(spans, left) for left in imitations), default=0.0)
        found[name] = Visibility(
            float(np.linalg.norm(first)), float(np.linalg.norm(rest)), pretended
        )
    return found


def gain_in(base: Fit, columns: Array, imitations: Sequence[Array]) -> float:
    """Return what some changes seem to explain of recordings that hold nothing of the kind.

    Parameters
    ----------
    base : Fit
        The model that the recordings were made by.
    columns : (n, k) array
        Weighted changes.
    imitations : sequence of (n,) array
        From `imitated_residuals`.
    """
    span = orthonormal(base.beyond_refit(columns))
    left = [base.beyond_refit(copy) for copy in imitations]
    return max((float(np.sum((span.T @ copy) ** 2)) for copy in left), default=0.0)


def imitated_residuals(
    model: Model, cases: Sequence[Case], base: Fit, seed: int = 0
) -> list[Array]:
    """Return what a fit leaves of recordings that its own rig has made.

    Parameters
    ----------
    model, cases, base
        What was fitted to what.
    seed : int, optional
        Seed of their noise.

    Returns
    -------
    list of (n,) array
        Weighted residuals.
    """
    values = values_in_each(cases, cases[0], base.shared, base.own)
    found = []
    for draw in range(IMITATIONS):
        copies = model.imitate(cases, values, np.random.default_rng((seed, draw)))
        left = residuals_of(model, copies, values)
        found.append(base.weigh([np.nan_to_num(part) for part in left]))
    return found


def _signatures(model: Model, cases: Sequence[Case], base: Fit, effect: Effect) -> list[Array]:
    found = []
    for starts in itertools.product(*(p.starts for p in effect.parameters)):
        values = {effect.key(p.name): s for p, s in zip(effect.parameters, starts, strict=True)}
        whole = _change(model, cases, base, values)
        columns = [whole]
        for parameter in effect.parameters[1:]:
            key = effect.key(parameter.name)
            step = _STEP * (parameter.high - parameter.low)
            step = step if values[key] + step <= parameter.high else -step
            columns.append(_change(model, cases, base, {**values, key: values[key] + step}) - whole)
        found.append(np.column_stack(columns))
    return found


def _change(model: Model, cases: Sequence[Case], base: Fit, values: dict[str, float]) -> Array:
    parts = []
    for case, own in zip(cases, base.own, strict=True):
        known = values_in(case, cases[0], base.shared, own)
        with np.errstate(all="ignore"):
            change = model.predict(case, known | values) - model.predict(case, known)
        parts.append(np.clip(np.nan_to_num(change[case.usable]), -_RUNAWAY, _RUNAWAY))
    return np.concatenate(parts)


def _weighted(base: Fit, scale: Array, columns: Array) -> Array:
    """Return columns counted in the spread of the residuals; tolerated values stay as they are."""
    rows = np.zeros((len(base.distance), columns.shape[1]))
    return np.vstack([columns / scale[:, np.newaxis], rows])


def _spans(base: Fit, scale: Array, variants: Sequence[Array], basis: Array) -> list[Array]:
    """Return orthonormal bases of what of each signature a refit does not absorb."""
    spans = []
    for variant in variants:
        columns = _weighted(base, scale, variant)
        rest = columns - basis @ (basis.T @ columns)
        whole = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
        kept = np.linalg.norm(rest, axis=0) > 1e-6 * whole
        if kept.any():
            spans.append(orthonormal(rest[:, kept]))
    return spans


def _gain(spans: Sequence[Array], left: Array) -> float:
    """Return the largest drop of a sum of squares that one of several spans gives."""
    return max((float(np.sum((span.T @ left) ** 2)) for span in spans), default=0.0)


def _loosened_score(base: Fit, name: str, basis: Array, left: Array) -> float:
    """Return what forgetting the tolerance of a parameter would gain: one row less to fit."""
    key = name.removeprefix("param.")
    if key not in base.tolerated:
        return 0.0
    row = base.samples + base.tolerated.index(key)
    leverage = float(np.sum(basis[row] ** 2))
    return float(left[row] ** 2) / max(1.0 - leverage, 1e-9)
