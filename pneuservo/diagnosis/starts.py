"""Where a fit begins."""

from collections.abc import Iterable, Iterator, Sequence
from enum import Enum

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.problem import Problem, begun_at, problems_of


class Begin(Enum):
    """From where a fit near a similar one may begin."""

    ANYWHERE = "wherever it leaves the least"
    ALONE = "with all else where it was, and the size of what is new as if that were linear"
    """Where a new effect is far from linear, what makes up for it does so at another size."""
    NOMINAL = "at the nominal parameters"
    """Parameters that have gone far astray for want of an effect hold a fit where they are."""
    IN_NOISE = "the same, and all that is missed counts in noise"
    """What is missed slowly counts for little, and a fit may miss one channel for another."""


_SMALL = 0.1
"""Share of its first size with which an effect begins that seems to be none."""
_RUNAWAY = 1e6


def best_start(
    model: Model,
    cases: Sequence[Case],
    hypothesis: Hypothesis,
    near: Fit | None,
    begin: Begin = Begin.ANYWHERE,
) -> Problem:
    """Return the problem of a fit, begun where it leaves the least.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.
    near : Fit or None
        A fit of a similar hypothesis to start from.
    begin : Begin, optional
        From where, if there is such a fit.
    """
    starts = problems_of(model, cases, hypothesis)
    if near is None or begin in (Begin.NOMINAL, Begin.IN_NOISE):
        return least_of(starts)
    # The parameters may have gone astray for want of the effect: their nominal values as well.
    moved = _distinct([begun_at(start, near.shared, near.own) for start in starts])
    if not model.steady:
        return least_of([*starts, *moved])
    if begin is Begin.ALONE:
        sized = [found for start in moved for found in _sized(start, near, hypothesis, alone=True)]
        if sized:
            return least_of([*sized, *_balanced(moved[0], near, hypothesis)])
    return least_of(_near_enough(_beside_found(starts, near), moved, near, hypothesis))


def _near_enough(
    nominal: Sequence[Problem], moved: Sequence[Problem], near: Fit, hypothesis: Hypothesis
) -> Iterator[Problem]:
    """Yield starts near enough for a fit that keeps its sensitivities.

    Sized ones are worked out from the run of the one before.
    """
    yield from nominal
    for start in moved:
        yield start
        yield from _sized(start, near, hypothesis, alone=False)
    yield from _balanced(moved[0], near, hypothesis)


def _beside_found(starts: Sequence[Problem], near: Fit) -> list[Problem]:
    """Return starts at nominal parameters, the effects of a similar fit as they were found.

    Of three effects all combinations of starts would be a hundred runs and more.
    """
    found = {key: value for key, value in near.shared.items() if ":" in key}
    return _distinct([begun_at(start, found, [{}] * len(start.own)) for start in starts])


def _distinct(starts: Sequence[Problem]) -> list[Problem]:
    """Return starts without those that are as another is: what was found has one value, not many.

    Parameters
    ----------
    starts : sequence of Problem
        They differ only in where they begin.
    """
    begun: dict[tuple[float, ...], Problem] = {}
    for start in starts:
        begun.setdefault(tuple(np.asarray(start.begin).tolist()), start)
    return list(begun.values())


def least_of(starts: Iterable[Problem]) -> Problem:
    """Return the problem that leaves the least where it begins.

    Parameters
    ----------
    starts : iterable of Problem
        They differ only in where they begin.
    """
    with np.errstate(all="ignore"):
        costs, begun = zip(*((_cost(start), start) for start in starts), strict=True)
    best: Problem = begun[int(np.argsort(np.nan_to_num(costs, nan=np.inf))[0])]
    return best


def _cost(start: Problem) -> float:
    return float(np.sum(np.concatenate(start.residuals(start.first)) ** 2))


def _sized(start: Problem, near: Fit, hypothesis: Hypothesis, alone: bool) -> list[Problem]:
    """Return starts with the size of a new effect, and all else, as they would be if linear.

    Most of the way to a size that is too large may still be too large: shorter ways are returned
    as well.
    """
    added = hypothesis.effects - near.hypothesis.effects
    sizes = {
        e.key(e.parameters[0].name): e.parameters[0] for e in start.model.effects if e.id in added
    }
    place = next((i for i, u in enumerate(start.shared) if u.key in sizes), None)
    if place is None:
        return []
    begin, unknown = np.asarray(start.begin), start.shared[place]
    change = _change(start, near, begin)
    beyond = near.beyond_refit(change)
    share = float(beyond @ near.left) / max(float(beyond @ beyond), 1e-300)
    if unknown.low >= 0.0:
        share = max(share, _SMALL)
    inverse = sizes[unknown.key].inverse

    def size(share: float) -> float:
        whole = begin[place] / share if inverse else share * begin[place]
        return float(np.clip(whole, unknown.low, unknown.high))

    share = begin[place] / size(share) if inverse else size(share) / begin[place]
    whole = np.concatenate([change, np.zeros(len(near.distance))])
    found = []
    for way in (share, _SMALL * share):
        step = np.zeros_like(near.vector)
        if not alone:
            step = np.linalg.lstsq(near.sensitivity, way * whole - near.left, rcond=None)[0]
        sized = begun_at(start, *near.moved(step))
        np.asarray(sized.begin)[place] = size(way)
        found.append(sized)
    return found


def _balanced(start: Problem, near: Fit, hypothesis: Hypothesis) -> list[Problem]:
    """Return the start of an effect of several sizes of either sign, if all of it were linear.

    Scaled by one of them, as `_sized` does it, the others would begin where they may be far off.
    """
    added = hypothesis.effects - near.hypothesis.effects
    parameters = {
        effect.key(p.name): p
        for effect in start.model.effects
        if effect.id in added
        for p in effect.parameters
    }
    if len(parameters) < 2 or any(p.low >= 0.0 or p.neutral for p in parameters.values()):
        return []
    places = [i for i, unknown in enumerate(start.shared) if unknown.key in parameters]
    nothing = np.asarray(start.begin).copy()
    nothing[places] = 0.0
    columns = []
    for place in places:
        alone = nothing.copy()
        alone[place] = start.units[place]
        columns.append(np.concatenate([_change(start, near, alone), np.zeros(len(near.distance))]))
    matrix = np.column_stack([near.sensitivity, -np.column_stack(columns)])
    solution = np.linalg.lstsq(matrix, -near.left, rcond=None)[0]
    others = near.sensitivity.shape[1]
    balanced = begun_at(start, *near.moved(solution[:others]))
    low, high = start.bounds
    for place, size in zip(places, solution[others:], strict=True):
        within = np.clip(size, low[place], high[place])
        np.asarray(balanced.begin)[place] = within * start.units[place]
    return [balanced]


def _change(start: Problem, near: Fit, values: Array) -> Array:
    """Return what values in place of those of a similar fit change, in its weights."""
    with np.errstate(all="ignore"):
        there = near.weigh(start.residuals(values / start.units))
    return np.clip(np.nan_to_num(near.weighted - there), -_RUNAWAY, _RUNAWAY)
