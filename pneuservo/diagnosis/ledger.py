"""What a search tried, step by step, and what could have been named instead."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Rival:
    """A hypothesis that stands in for a chosen effect, and its probability."""

    candidate: str
    probability: float
    information_criterion: float


def probabilities(criteria: Mapping[str, float], unit: float) -> dict[str, float]:
    """Return how probable each of some hypotheses is, by its weight among them.

    Parameters
    ----------
    criteria : mapping of str to float
        Information criterion of each.
    unit : float
        By how much criteria differ that are as good as each other; 1 where a law, if it is the
        right one, fits exactly.

    Returns
    -------
    dict of str to float
        exp(-criterion / (2 unit)), normalised.

    Examples
    --------
    >>> probabilities({"leak": 100.0, "lag": 102.0}, 1.0)["leak"]  # doctest: +ELLIPSIS
    0.731...
    >>> probabilities({"leak": 100.0, "lag": 102.0}, 10.0)["leak"]  # doctest: +ELLIPSIS
    0.524...
    """
    lowest = min(criteria.values())
    weight = {name: math.exp(-0.5 * (e - lowest) / unit) for name, e in criteria.items()}
    total = sum(weight.values())
    return {name: share / total for name, share in weight.items()}


@dataclass(frozen=True)
class Step:
    """One step of a search: what was tried, and what came of it.

    Parameters
    ----------
    base : tuple of str
        What was already accepted.
    candidate : str
        The best addition; for a replacement, what was put in the place of `replaced`.
    accepted : bool
        Whether it earned its place.
    replaced : str, optional
        The member that had to go.
    criterion_drop : float, optional
        By how much the information criterion fell.
    share : float, optional
        Share of what the baseline leaves unexplained.
    rms : mapping of str to float, optional
        What each candidate leaves [unit of the cases].
    why : str, optional
        Why the member had to go, where nothing took its place.
    """

    base: tuple[str, ...]
    candidate: str
    accepted: bool
    replaced: str = ""
    criterion_drop: float = 0.0
    share: float = 0.0
    rms: Mapping[str, float] = field(default_factory=dict)
    why: str = ""
