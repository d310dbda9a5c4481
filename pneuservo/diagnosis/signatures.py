"""What each effect would change in recordings, and what of that a refit would not absorb."""

import itertools
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pneuservo.diagnosis.fit import Fit, orthonormal
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.unknowns import values_in
from pneuservo.effects import Effect

_STEP = 1e-3
"""Share of a shape parameter's range by which it is moved to see what it does."""
_RUNAWAY = 1e9

Signatures = Mapping[str, Sequence[Array]]
"""Effect id to what it changes in all residuals, one array of columns per combination of starts."""


def signatures_of(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    effects: Sequence[Effect] | None = None,
) -> dict[str, list[Array]]:
    """Return what each effect of a rig changes in the residuals.

    Parameters
    ----------
    model, cases
        What is fitted to what.
    base : Fit
        The fitted baseline.
    effects : sequence of Effect, optional
        Those that are asked for; without them all of the model.

    Returns
    -------
    dict of str to list of (n, k) array
        Per combination of an effect's starts: the change at the start, and by a step of each
        further parameter [unit of the cases].
    """
    effects = model.effects if effects is None else effects
    found = side_by_side(lambda effect: _signatures(model, cases, base, effect), effects)
    return {effect.id: variants for effect, variants in zip(effects, found, strict=True)}


def spans_beyond(
    base: Fit, variants: Sequence[Array], counts: Callable[[Array], bool] | None = None
) -> list[Array]:
    """Return orthonormal bases of what of a signature a refit does not absorb.

    Parameters
    ----------
    base : Fit
        What it would be added to; its weights count.
    variants : sequence of (n, k) array
        One signature from several starts.
    counts : callable, optional
        Takes what a refit leaves of a variant, and returns whether the variant is to be counted.
    """
    spans = []
    # All at once: what a refit absorbs is far larger than any of them, and would be read for each.
    together = base.counted(np.hstack(variants))
    ends = np.cumsum([variant.shape[1] for variant in variants])[:-1]
    split = (np.split(each, ends, axis=1) for each in (together, base.beyond_refit(together)))
    for columns, rest in zip(*split, strict=True):
        if counts is not None and not counts(rest):
            continue
        whole = np.maximum(np.linalg.norm(columns, axis=0), 1e-30)
        kept = np.linalg.norm(rest, axis=0) > 1e-6 * whole
        if kept.any():
            spans.append(orthonormal(rest[:, kept]))
    return spans


def most_gained(spans: Sequence[Array], left: Array) -> float:
    """Return the largest drop of a sum of squares that one of several spans gives.

    Parameters
    ----------
    spans : sequence of (n, k) array
        Orthonormal.
    left : (n,) array
        What is to be explained.
    """
    return max((float(np.sum((span.T @ left) ** 2)) for span in spans), default=0.0)


def _signatures(model: Model, cases: Sequence[Case], base: Fit, effect: Effect) -> list[Array]:
    found = []
    for starts in itertools.product(*model.starts(effect, cases).values()):
        values = {effect.key(p.name): s for p, s in zip(effect.parameters, starts, strict=True)}
        whole = change_by(model, cases, base, values)
        columns = [whole]
        for parameter in effect.parameters[1:]:
            key = effect.key(parameter.name)
            step = _STEP * (parameter.high - parameter.low)
            step = step if values[key] + step <= parameter.high else -step
            columns.append(
                change_by(model, cases, base, {**values, key: values[key] + step}) - whole
            )
        found.append(np.column_stack(columns))
    return found


def change_by(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    values: Mapping[str, float],
    most: float = _RUNAWAY,
) -> Array:
    """Return what other values change in the residuals of all cases, usable samples only.

    Parameters
    ----------
    model, cases, base
        What was fitted to what.
    values : mapping of str to float
        In place of those of the fit, or beside them.
    most : float, optional
        Largest change of a sample [unit of the cases].

    Notes
    -----
    An effect of absurd size may run away; its direction is all that is asked for.
    """
    parts = []
    for case, own in zip(cases, base.own, strict=True):
        known = values_in(case, cases[0], base.shared, own)
        with np.errstate(all="ignore"):
            change = model.predict(case, {**known, **values}) - model.predict(case, known)
        parts.append(np.clip(np.nan_to_num(change[case.usable]), -most, most))
    return np.concatenate(parts)
