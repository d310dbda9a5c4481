"""What a search tried, step by step, and what could have been named instead."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Rival:
    """A hypothesis that stands in for a chosen effect, and its probability."""

    candidate: str
    probability: float
    evidence: float


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
    evidence_drop : float, optional
        By how much the information criterion fell.
    share : float, optional
        Share of what the baseline leaves unexplained.
    rms : mapping of str to float, optional
        What each candidate leaves [SI].
    """

    base: tuple[str, ...]
    candidate: str
    accepted: bool
    replaced: str = ""
    evidence_drop: float = 0.0
    share: float = 0.0
    rms: Mapping[str, float] = field(default_factory=dict)
