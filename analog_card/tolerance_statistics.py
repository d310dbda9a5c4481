"""What many trials say about a figure: distribution-free bounds, yield, importance, corners."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from analog_card.errors import InputError

CONTENT, CONFIDENCE = 0.95, 0.95


@dataclass(frozen=True)
class Bounds:
    """Between which values a figure lies, whatever its distribution.

    Attributes
    ----------
    low, high : float
        Two order statistics of the trials.
    content : float
        Share of all cards between them, at least.
    confidence : float
        How sure that is; below the one asked for when there are too few trials.
    """

    low: float
    high: float
    content: float
    confidence: float


@dataclass(frozen=True)
class Yield:
    """Share of cards within limits.

    Attributes
    ----------
    share : float
        Of the trials.
    low, high : float
        Between these it lies for all cards, with 95 % confidence (Clopper and Pearson 1934).
    """

    share: float
    low: float
    high: float


def bounds(
    values: Sequence[float], content: float = CONTENT, confidence: float = CONFIDENCE
) -> Bounds:
    """Return distribution-free bounds of a figure.

    Parameters
    ----------
    values : sequence of float
        One for each trial.
    content : float, optional
        Share of all cards that is to lie between the bounds.
    confidence : float, optional
        How sure that is to be.

    Returns
    -------
    Bounds
        The innermost pair of order statistics that does it; the extremes when none does.

    Raises
    ------
    InputError
        With less than two values.

    Notes
    -----
    Wilks 1941: the share between the r-th value from below and from above of n is distributed as
    Beta(n - 2 r + 1, 2 r), whatever the distribution of the values.

    Examples
    --------
    >>> found = bounds(range(1000))
    >>> found.low, found.high, round(found.confidence, 3)
    (18, 981, 0.969)
    """
    from scipy.stats import beta

    ordered = sorted(values)
    count = len(ordered)
    if count < 2:
        raise InputError(f"{count} trials; bounds need at least two")
    ranks = np.arange(1, count // 2 + 1)
    sure = beta.sf(content, count - 2 * ranks + 1, 2 * ranks)
    rank = max(int(np.count_nonzero(sure >= confidence)), 1)
    return Bounds(ordered[rank - 1], ordered[count - rank], content, float(sure[rank - 1]))


def yield_within(
    trials: Sequence[Mapping[str, float]], limits: Mapping[str, tuple[float, float]]
) -> Yield:
    """Return the share of trials whose figures are all within their limits.

    Parameters
    ----------
    trials : sequence of mapping of str to float
        Figures by name. A figure that is not a number is not within any limit.
    limits : mapping of str to tuple of float
        Lowest and highest value allowed, by figure.

    Raises
    ------
    InputError
        When there is no figure of a name.

    Examples
    --------
    >>> found = yield_within([{"x": 1.0}, {"x": 3.0}], {"x": (0.0, 2.0)})
    >>> found.share, round(found.low, 4), round(found.high, 4)
    (0.5, 0.0126, 0.9874)
    """
    from scipy.stats import binomtest

    for name in limits:
        if name not in trials[0]:
            raise InputError(f"limit of {name!r}: there is {', '.join(trials[0])}")
    good = sum(
        all(low <= trial[name] <= high for name, (low, high) in limits.items()) for trial in trials
    )
    interval = binomtest(good, len(trials)).proportion_ci(0.95, method="exact")
    return Yield(good / len(trials), float(interval.low), float(interval.high))


def importance(
    deviations: Sequence[Mapping[str, float]], figure: Sequence[float]
) -> dict[str, float]:
    """Return how much of a figure's spread each quantity accounts for, largest first.

    Parameters
    ----------
    deviations : sequence of mapping of str to float
        What was drawn in each trial.
    figure : sequence of float
        The figure in each trial; those that are not numbers are left out.

    Returns
    -------
    dict of str to float
        Squared rank correlation (Spearman 1904), which for independent quantities is the share of
        the variance of the ranks. Left out is what chance gives too: in one study out of twenty
        a quantity without any effect is in it.

    Notes
    -----
    Without effect the squared correlation is distributed as chi-squared with one degree of freedom
    over n - 1; the limit is its value for 5 % over the number of quantities (Bonferroni 1936).

    Examples
    --------
    >>> drawn = [{"a": x, "b": (x * 7) % 20} for x in range(20)]
    >>> importance(drawn, [2 * d["a"] for d in drawn])
    {'a': 1.0}
    """
    from scipy.stats import chi2, rankdata

    values = np.array(figure, float)
    usable = np.isfinite(values)
    names = list(deviations[0])
    table = np.array([[drawn[name] for name in names] for drawn in deviations])[usable]
    ranks = rankdata(table, axis=0) - (len(table) + 1) / 2
    wanted = rankdata(values[usable]) - (len(table) + 1) / 2
    scale = np.sqrt((ranks**2).sum(axis=0) * (wanted**2).sum())
    with np.errstate(invalid="ignore", divide="ignore"):
        shares = np.where(scale > 0, (ranks.T @ wanted / scale) ** 2, 0.0)
    chance = chi2.isf((1 - CONFIDENCE) / len(names), 1) / max(len(table) - 1, 1)
    order = [k for k in np.argsort(-shares, kind="stable") if shares[k] > chance]
    return {names[k]: round(float(shares[k]), 12) for k in order}


def corners(
    figures: Callable[[Sequence[Mapping[str, float]]], Sequence[Mapping[str, Any]]],
    extremes: Mapping[str, float],
    either: Mapping[str, float] = MappingProxyType({}),
) -> dict[str, tuple[float, float]]:
    """Return the worst cases of every figure, by corners that sensitivities sign.

    Parameters
    ----------
    figures : callable
        Takes a list of cards, each deviations by quantity, and returns the figures of each.
    extremes : mapping of str to float
        How far each quantity goes to either side.
    either : mapping of str to float, optional
        Quantities that change what others do, and where each stands while the sensitivities of the
        others are found: every corner is tried at both ends of each of them.

    Returns
    -------
    dict of str to tuple of float
        Lowest and highest value of each figure over all cards tried; a figure that no card gives is
        left out.

    Notes
    -----
    Each quantity alone goes to its upper end; the sign of the difference that it makes is that of
    its sensitivity. In the corner every quantity stands at the end that moves the figure the same
    way: exact for figures that are monotonic in each, a good guess for others.

    Examples
    --------
    >>> corners(lambda cards: [{"y": d["a"] - 2 * d["b"]} for d in cards], {"a": 1.0, "b": 1.0})
    {'y': (-3.0, 3.0)}
    """
    if not extremes:
        return {}
    middle = dict.fromkeys(extremes, 0.0)
    rest = middle | {name: value for name, value in either.items() if name in extremes}
    found = figures([rest, *({**rest, name: extreme} for name, extreme in extremes.items())])
    names = list(found[0])
    table = np.array([[each[name] for name in names] for each in found], float)
    signs = np.where(table[1:] < table[0], -1.0, 1.0)
    upper = [
        dict(zip(extremes, sign * np.array(list(extremes.values())), strict=True))
        for sign in signs.T
    ]
    lower = [{name: -value for name, value in card.items()} for card in upper]
    ends = [*lower, *upper]
    for name in either:
        ends += [{**card, name: -card[name]} for card in ends if name in card]
    # Many figures share a corner.
    distinct = {tuple(card.values()): card for card in ends}
    worst = figures([middle, *distinct.values()])
    tried = np.array([[each[name] for name in names] for each in [*found, *worst]], float)
    return {
        name: (float(np.nanmin(column)), float(np.nanmax(column)))
        for name, column in zip(names, tried.T, strict=True)
        if np.isfinite(column).any()
    }
