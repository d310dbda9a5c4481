"""What refutes names that were found: they leave too much, or do not hold elsewhere."""

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.held_back import HeldBack, times_missed_at_best
from pneuservo.diagnosis.models.model import Misfit
from pneuservo.diagnosis.search import Search
from pneuservo.effects import CATALOGUE

LACKS_FIT = 1.75
"""Times its noise that a channel is left at by names that are not right. (Of 233 answers to blind
cases none with a right name left more than 1.5; a delay that stood in for a friction left 2.0.)"""
SMALL_PART = 0.5
"""Share of what a channel shows beyond its noise that right names explain at the least: of a pair
one may be missing, and the other may have another form."""


def lack_of_fit(search: Search) -> Misfit | None:
    """Return that names leave far more than noise of what they were fitted to, if so.

    Parameters
    ----------
    search : Search
        Done, in recordings of a model whose channels count in their noise.

    Notes
    -----
    Names that explain little of what a channel shows stand in for what has none, or for what drove
    the servo between its samples: of a loop that chatters, recorded at 200 Hz, a leak and a shift
    left the displacement at 4 times its noise.
    """
    names = _names(search)
    if not search.model.tabulates or not names:
        return None
    found, baseline = search.chosen, search.baseline
    worst, times = "", LACKS_FIT
    for channel in dict.fromkeys(case.channel for case in search.cases if case.recorded):
        left, without = found.rms_of(channel), max(baseline.rms_of(channel) ** 2 - 1.0, 0.0)
        if left > times and left**2 - 1.0 > SMALL_PART * without:
            worst, times = channel, left
    if not worst:
        return None
    words = (
        f"what explains most ({', '.join(names)}) leaves the {worst.replace('_', ' ')} at "
        f"{times:.2g} times its noise, and only stands in for it, or for what drove the servo "
        "between samples that are too far apart"
    )
    return Misfit(search.block_of(names[0]), words, 0.0, refutes=True)


def not_borne_out(search: Search, held_back: HeldBack, before: Fit, after: Fit) -> Misfit | None:
    """Return that names which leave noise of what was used do not hold elsewhere, if so.

    Parameters
    ----------
    search : Search
        Done.
    held_back : HeldBack
        As it is read with what was found.
    before, after : Fit
        Prediction of what was held back, without and with what was found.

    Notes
    -----
    Where they leave more than noise of what was used, a second effect may be what is missing, and
    where another explains as much, that may be the one that holds.
    """
    names = _names(search)
    if not search.model.tabulates or not names or not search.leaves_noise(search.chosen):
        return None
    if any({*search.alike(name)} - {*search.forms_of(name)} for name in names):
        return None
    times = times_missed_at_best(held_back, search.baseline, search.chosen, before, after)
    if not times:
        return None
    words = (
        f"what explains the recordings used ({', '.join(names)}) misses what was held back by "
        f"{times:.2g} times its noise, and only stands in for it"
    )
    return Misfit(search.block_of(names[0]), words, 0.0, refutes=True)


def _names(search: Search) -> list[str]:
    return [name for name in search.accepted if name in CATALOGUE]
