"""What each effect would change in recordings, and what of that a refit would not absorb."""

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.unknowns import values_in
from pneuservo.effects import Effect

_STEP = 1e-3
"""Share of a shape parameter's range by which it is moved to see what it does."""
_RUNAWAY = 1e9
_NOTHING = 1e-12
"""Share of a sum of squares that is its rounding."""

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


def gained_beyond(
    base: Fit, variants: Sequence[Array], left: Sequence[Array], one_sided: bool = False
) -> float:
    """Return the most that a signature explains beyond what a refit absorbs.

    Parameters
    ----------
    base : Fit
        What it would be added to; its weights count.
    variants : sequence of (n, k) array
        One signature from several starts.
    left : sequence of (n + t,) array
        Weighted residuals beyond a refit, see `Fit.beyond_refit`: what is left of a recording, or
        of several copies of it.
    one_sided : bool, optional
        Whether a variant counts only where more of the effect is missing, not less than none.

    Returns
    -------
    float
        Largest drop of the sum of squares, of any variant and of any of what is left.

    Notes
    -----
    By products with the columns as they are: what a refit leaves of each is as large as all of
    them, and would have to be made and read.
    """
    together = base.counted(np.hstack(variants))
    ends = np.cumsum([variant.shape[1] for variant in variants])[:-1]
    absorbed, missed = base.absorbed.T[:, : base.samples] @ together, np.column_stack(left)
    toward = together.T @ missed[: base.samples] - absorbed.T @ (base.absorbed.T @ missed)
    split = (np.split(together, ends, axis=1), np.split(absorbed, ends, axis=1))
    most = 0.0
    for columns, inside, along in zip(*split, np.split(toward, ends), strict=True):
        whole = columns.T @ columns
        beyond = whole - inside.T @ inside
        kept = np.diag(beyond) > _NOTHING * np.diag(whole)
        if kept[0] or (kept.any() and not one_sided):
            drops, adds = _drops(beyond[np.ix_(kept, kept)], along[kept])
            most = max(most, float(np.max(drops[adds] if one_sided else drops, initial=0.0)))
    return most


def _drops(products: Array, along: Array) -> tuple[Array, Array]:
    """Return what columns explain of some residuals, and whether that takes more of the first.

    Parameters
    ----------
    products : (k, k) array
        Of the columns with each other.
    along : (k, m) array
        Of the columns with the residuals.
    """
    sizes = np.sqrt(np.diag(products))
    inverse = np.linalg.pinv(products / np.outer(sizes, sizes), rcond=_NOTHING, hermitian=True)
    alone = along / sizes[:, np.newaxis]
    steps = inverse @ alone
    return np.sum(alone * steps, axis=0), (along[0] > 0.0) | (steps[0] > 0.0)


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
