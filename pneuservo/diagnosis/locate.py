"""Where a model falls short: which samples, and what they have in common."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models import Case, Model
from pneuservo.noise import surrogate

_LIFT = 1.3
"""A regime is named when its mean square is this many times that of the whole."""
_COVERAGE = 0.25
"""And when it holds at least this share of the energy."""
_BINS = 12
_BLOCKS = 40
_DRAWS = 40
_LEAST_SHARE = 0.05
"""A dependence that accounts for less than this is not worth a word."""


def regime_in_words(model: Model, cases: Sequence[Case], energy: Array) -> str:
    """Return where in the recordings an energy is concentrated.

    Parameters
    ----------
    model : Model
        The rig's model, which names the regimes.
    cases : sequence of Case
        The recordings.
    energy : (n,) array
        Energy of each usable sample, all recordings end to end.

    Returns
    -------
    str
        A phrase; empty when no regime stands out.
    """
    total = float(np.sum(energy))
    if total <= 0.0:
        return ""
    masks: dict[str, list[Mask]] = {}
    for case in cases:
        for phrase, mask in model.regimes(case).items():
            masks.setdefault(phrase, []).append(mask[case.usable])
    found = []
    for phrase, parts in masks.items():
        if sum(len(part) for part in parts) != len(energy):
            continue  # a regime that only some of the recordings know
        mask = np.concatenate(parts)
        share = float(np.sum(energy[mask])) / total
        covered = float(np.mean(mask))
        if 0.0 < covered < 0.9 and share > _COVERAGE and share / covered > _LIFT:
            found.append((share / covered, phrase))
    return ", ".join(phrase for _, phrase in sorted(found, reverse=True)[:2])


def onset_in_words(starts: Sequence[float]) -> str:
    """Return since when a mismatch is there.

    Parameters
    ----------
    starts : sequence of float
        When it began in each recording; 0 from the first sample [s].

    Returns
    -------
    str
        A phrase; empty when it was there from the first sample.

    Examples
    --------
    >>> onset_in_words([7.02])
    'since 7.0 s in the recording'
    """
    if not any(start > 0.0 for start in starts):
        return ""
    return "since " + " / ".join(f"{start:.1f} s" for start in starts) + " in the recording"


@dataclass(frozen=True)
class Dependence:
    """What a residual depends on.

    Parameters
    ----------
    name : str
        The quantity; empty when there is none.
    share : float
        Share of the residual variance that a curve over this quantity explains on samples
        that did not shape the curve [-].
    beyond_chance : bool
        Whether noise of the same spectrum depends less on it, in 95 of 100 draws.
    """

    name: str
    share: float
    beyond_chance: bool


def strongest_dependence(
    model: Model, cases: Sequence[Case], residuals: Sequence[Array], seed: int = 0
) -> Dependence:
    """Return the quantity that residuals depend on most, beyond what noise would.

    Parameters
    ----------
    model : Model
        The rig's model, which names the quantities.
    cases : sequence of Case
        The recordings.
    residuals : sequence of array
        Residuals, usable samples only.
    seed : int, optional
        Seed of the noise it is compared with.

    Returns
    -------
    Dependence
        The one that stands out most from chance.
    """
    rng = np.random.default_rng(seed)
    draws = [
        np.concatenate([surrogate(part - part.mean(), rng) for part in residuals])
        for _ in range(_DRAWS)
    ]
    residual = np.concatenate(residuals)
    best, margin = Dependence("", 0.0, False), -np.inf
    for name, values in _joined(model, cases).items():
        share = _explained(residual, values)
        chance = float(np.quantile([_explained(draw, values) for draw in draws], 0.95))
        if share - chance > margin:
            margin = share - chance
            best = Dependence(name, max(share, 0.0), share > max(chance, _LEAST_SHARE))
    return best


def _explained(residual: Array, values: Array) -> float:
    """Return the share of a residual that its mean over bins of a quantity explains."""
    train = (np.arange(len(residual)) * _BLOCKS // len(residual)) % 2 == 0
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, _BINS + 1))[1:-1])
    bins = np.digitize(values, edges)
    sums = np.bincount(bins[train], residual[train], _BINS)
    counts = np.bincount(bins[train], minlength=_BINS)
    curve = sums / np.maximum(counts, 1)
    test = residual[~train]
    return 1.0 - float(np.mean((test - curve[bins[~train]]) ** 2) / np.mean(test**2))


def in_all(quantities: Sequence[Mapping[str, Array]]) -> list[str]:
    """Return the names of what was recorded in all of some recordings.

    Parameters
    ----------
    quantities : sequence of mapping
        What was recorded, by name.

    Examples
    --------
    >>> in_all([{"velocity": [0.1], "demand": [0.2]}, {"velocity": [0.3]}])
    ['velocity']
    """
    first, *others = quantities
    return [name for name in first if all(name in each for each in others)]


def _joined(model: Model, cases: Sequence[Case]) -> Mapping[str, Array]:
    recorded = [model.regressors(case) for case in cases]
    return {
        name: np.concatenate(
            [
                np.nan_to_num(each[name][case.usable])
                for each, case in zip(recorded, cases, strict=True)
            ]
        )
        for name in in_all(recorded)
    }
