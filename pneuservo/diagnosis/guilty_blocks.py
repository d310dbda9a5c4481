"""How the mismatch is shared out over the blocks of the chain."""

from typing import Any

import numpy as np

from pneuservo.diagnosis.diagnosis import Diagnosis
from pneuservo.diagnosis.judge import SMALLEST_SHARE
from pneuservo.diagnosis.locate import onset_in_words, regime_in_words
from pneuservo.diagnosis.search import Search


def located(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Share out what the baseline leaves unexplained over the blocks that turned out guilty.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.

    Returns
    -------
    list of dict
        ``block``, ``share`` and ``regime``, the largest share first.
    """
    search = diagnosis.search
    if diagnosis.verdict == "parameter" and not diagnosis.unnamed_share:
        return _wrong_parameters(search)
    fits = [search.baseline]
    for member in search.accepted:
        fits.append(search.fitted(fits[-1].hypothesis.adding(member)))
    whole = max(search.beyond_noise(search.baseline), 1e-300)
    shares: dict[str, float] = {}
    regimes: dict[str, list[str]] = {}
    onset = onset_in_words([own.get("start", 0.0) for own in search.chosen.own])

    def blame(block: str, share: float, energy: Any) -> None:
        # Weighed by channel an effect may be worth its place though the plain sum of squares grows.
        shares[block] = shares.get(block, 0.0) + max(share, 0.0)
        words = regime_in_words(search.model, search.cases, energy)
        if words and words not in regimes.setdefault(block, []):
            regimes[block].append(words)

    guilty = [search.block_of(member) for member in search.accepted]
    if diagnosis.unexplained is not None:
        guilty.append(diagnosis.unexplained.table.block)
        fits.append(diagnosis.repaired)
    for block, before, after in zip(guilty, fits, fits[1:], strict=False):
        drop = np.concatenate(before.residuals) ** 2 - np.concatenate(after.residuals) ** 2
        blame(block, float(np.sum(drop)) / whole, drop)
    # What nothing explains belongs to the block whose output is judged.
    rest = max(0.0, 1.0 - sum(shares.values()))
    # Where the noise is known to a fifth only, a small excess over it is nobody's fault.
    blames_rest = rest > SMALLEST_SHARE
    if search.model.steady:
        remains = diagnosis.holds_nameless or diagnosis.structure_remains
        blames_rest = remains and diagnosis.unexplained is None
    if blames_rest or not shares:
        left = search.chosen.residuals
        if diagnosis.misfit is not None:
            rest = max(rest, diagnosis.unnamed_share)
        for block, part in diagnosis.suspects.items():
            blame(block, rest * part, np.concatenate(left) ** 2)
    total = sum(shares.values())
    if total <= 0.0:
        # So little that none of them stands out.
        shares, total = dict.fromkeys(shares, 1.0), float(len(shares))
    entries = [
        {
            "block": block,
            "share": share / total,
            "regime": "; ".join([onset] * bool(onset) + regimes.get(block, []))
            or "throughout the recordings",
        }
        for block, share in shares.items()
    ]
    return sorted(entries, key=lambda entry: -entry["share"])


def _wrong_parameters(search: Search) -> list[dict[str, Any]]:
    """Share out a mismatch over wrong parameters by how far each was off, in tolerances.

    The re-fitted baseline explains it already, so that nothing is left to be shared out.
    """
    rig, values = search.cases[0].rig, search.chosen.shared
    keys = [member.removeprefix("param.") for member in search.accepted]
    off = [((values[key] - rig[key]) / rig.parameters[key].tolerance) ** 2 for key in keys]
    shares: dict[str, float] = {}
    for member, size in zip(search.accepted, off, strict=True):
        block = search.block_of(member)
        shares[block] = shares.get(block, 0.0) + size / sum(off)
    return [
        {"block": block, "share": share, "regime": "throughout the recordings"}
        for block, share in sorted(shares.items(), key=lambda item: -item[1])
    ]
