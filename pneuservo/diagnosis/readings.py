"""How recordings are to be read and followed: where they do not say, what fits better is taken."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from pneuservo.diagnosis.fit import Fit, gained_most
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Levels, Values
from pneuservo.diagnosis.problem import values_in_each
from pneuservo.diagnosis.screen import MOST_OVER_PROMISE, scores
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import signatures_of

Cases = Sequence[Case]
_LATE_WORTH_FITTING = 2
"""So many effects that are late, those that promise most, are fitted to a way of reading."""
_MOST_FORGIVEN = 4.0
"""So many times the least of what the ways of reading leave all over, squared, decides nothing."""
_NOT_HOPELESS = 1.25
"""A recording that is so many times as unlikely in another way is not turned to it alone."""


@dataclass(frozen=True)
class Reading:
    """Recordings as they may be read: all in one way, or each in its likeliest.

    Parameters
    ----------
    cases : sequence of Case
        As they are then.
    baseline : Fit or None
        Fitted to them, where more than one way had to be tried.
    unlikely : float
        Twice the negative log-likelihood of what is left, but for a constant; a misfit that every
        way leaves all over is forgiven.
    """

    cases: Cases
    baseline: Fit | None = None
    unlikely: float = 0.0


def ranked_readings(
    model: Model, readings: Sequence[Cases], progress: Callable[[str], None], jobs: int = 1
) -> list[Reading]:
    """Return the ways to read some recordings, the likeliest first, a mixture among them.

    Parameters
    ----------
    model : Model
        What is fitted.
    readings : sequence of sequences of Case
        The same recordings, each time read in another way.
    progress : callable
        Told what is being fitted.
    jobs : int, optional
        So many fits at a time.

    Notes
    -----
    The baseline is fitted first: parameters that are off would decide instead, by whatever factor.
    A misfit that all of them leave all over is no argument for any. Recordings of one rig may have
    to be read in different ways, for a relay that samples may have been followed by an analogue
    loop; each in its likeliest is a way of its own.
    """
    if len(readings) == 1:
        return [Reading(readings[0])]
    progress("fitting the baseline to each way in which the recordings may be read")
    ways, fits, unlikely = _with_mixtures(model, readings, jobs)
    # Of mixtures only the likeliest is worth coming back to.
    best = _likeliest(unlikely)
    kept = [n for n in range(len(ways)) if n < len(readings) or n == best]
    found = [Reading(ways[n], fits[n], sum(unlikely[n].values())) for n in kept]
    return sorted(found, key=lambda reading: reading.unlikely)


def _with_mixtures(
    model: Model, readings: Sequence[Cases], jobs: int
) -> tuple[list[Cases], list[Fit], list[dict[int, float]]]:
    """Return ways to read recordings, mixtures among them, baselines, and how unlikely each is.

    Each recording in its likeliest way first; then the likeliest of all, one recording turned at a
    time: beside a relay that was read wrongly a proportional loop seemed likelier read wrongly too.
    """
    ways, fits = list(readings), _baselines(model, readings, None, jobs)
    unlikely = _unlikely(model, ways, _values(ways, fits))

    def try_as_well(mixture: Cases) -> None:
        nonlocal unlikely
        if not any(_are_the_same(mixture, way) for way in ways):
            nearest = fits[_likeliest(unlikely)]
            ways.append(mixture)
            fits.append(refitted(model, mixture, nearest))
            unlikely = _unlikely(model, ways, _values(ways, fits))

    try_as_well(_likeliest_of_each(ways, unlikely))
    for recording in unlikely[0]:
        for n in range(len(readings)):
            best = _likeliest(unlikely)
            if unlikely[n][recording] < _NOT_HOPELESS * unlikely[best][recording]:
                try_as_well(_turned(ways[best], ways[n], recording))
    return ways, fits, unlikely


def _likeliest(unlikely: Sequence[Mapping[int, float]]) -> int:
    """Return which of some ways is the likeliest."""
    return min(range(len(unlikely)), key=lambda n: sum(unlikely[n].values()))


def _turned(cases: Cases, other: Cases, recording: int) -> list[Case]:
    """Return cases with one recording's in another way."""
    mine = [case for case in other if id(case.origin) == recording]
    first = next(i for i, case in enumerate(cases) if id(case.origin) == recording)
    rest = [case for case in cases if id(case.origin) != recording]
    return [*rest[:first], *mine, *rest[first:]]


def likelier_if_late(
    model: Model, ranked: Sequence[Reading], progress: Callable[[str], None], jobs: int = 1
) -> Reading | None:
    """Return the reading that something late would make likelier than the first, if there is one.

    Parameters
    ----------
    model : Model
        What is fitted.
    ranked : sequence of Reading
        From `ranked_readings`.
    progress : callable
        Told what is being worked out.
    jobs : int, optional
        So many effects at a time.

    Notes
    -----
    A command that runs on acts half a sample later than one that is held, and is less sure: read
    so, a spool or a hose that is late hardly shows. (A motor too weak for its spool promised 358
    where the command ran on and 15,900 where it was held, which was less likely by 9,800.) Only
    what stands still and jumps is asked: read as held, the command of an analogue loop comes half a
    sample early, and whatever is late would mend that.
    """
    first = ranked[0]
    others = [
        other
        for other in ranked[1:]
        if other.baseline
        and _misfit(other.baseline) > other.unlikely - first.unlikely
        and all(model.stored(case) for case in _read_otherwise(other.cases, first.cases))
    ]
    if not others:
        return None
    progress("asking what something late would make of the ways to read the recordings")
    promises = {id(reading): _promised_if_late(model, reading, jobs) for reading in others}
    near = [
        other
        for other in others
        if MOST_OVER_PROMISE * max(promises[id(other)].values(), default=0.0)
        > other.unlikely - first.unlikely + LEAST_GAIN
    ]
    if not near:
        return None
    promises[id(first)] = _promised_if_late(model, first, jobs)
    tried = (first, *near)
    unlikely = [
        reading.unlikely - _explained_if_late(model, reading, promises[id(reading)])
        for reading in tried
    ]
    best = min(range(len(tried)), key=unlikely.__getitem__)
    return tried[best] if unlikely[best] < unlikely[0] - LEAST_GAIN else None


def _read_otherwise(one: Cases, other: Cases) -> list[Case]:
    """Return the cases of recordings that are not read in the same way."""
    same = {id(case) for case in other}
    return [case for case in one if id(case) not in same]


def _misfit(baseline: Fit) -> float:
    """Return the sum of squares beyond noise, which is what an effect may explain at most."""
    return sum(max(float(r @ r) - len(r), 0.0) for r in baseline.residuals)


def _promised_if_late(model: Model, reading: Reading, jobs: int) -> dict[str, float]:
    """Return what each effect that is late promises to explain, in noise."""
    if reading.baseline is None:
        return {}
    effects = [effect for effect in model.effects if effect.block in model.late]
    base = reading.baseline.in_noise
    signatures = signatures_of(model, reading.cases, base, jobs, effects)
    one_sided = {effect.id for effect in effects if effect.parameters[0].low >= 0.0}
    return scores(base, signatures, list(signatures), one_sided)


def _explained_if_late(model: Model, reading: Reading, promises: Mapping[str, float]) -> float:
    """Return the most that an effect which is late explains, of the two that promise most."""
    baseline = reading.baseline
    if baseline is None:
        return 0.0
    best = sorted(promises, key=promises.__getitem__, reverse=True)[:_LATE_WORTH_FITTING]
    return max(
        (
            gained_most(
                baseline, fit(model, reading.cases, baseline.hypothesis.adding(name), baseline)
            )
            for name in best
            if MOST_OVER_PROMISE * promises[name] > LEAST_GAIN
        ),
        default=0.0,
    )


def likelier_with(
    model: Model,
    ranked: Sequence[Reading],
    baseline: Fit,
    named: Fit,
    progress: Callable[[str], None],
    jobs: int = 1,
) -> Reading | None:
    """Return the reading that a name makes likelier than the first of them, if there is one.

    Parameters
    ----------
    model : Model
        What is fitted.
    ranked : sequence of Reading
        From `ranked_readings`.
    baseline, named : Fit
        Of the first, without the name and with it.
    progress : callable
        Told what is being fitted.
    jobs : int, optional
        So many fits at a time.

    Notes
    -----
    What an effect leaves unexplained may be so much that it decides how recordings are read. Only
    what explains more than lay between two readings can turn their order.
    """
    first = ranked[0]
    gain = gained_most(baseline, named)
    others = [other for other in ranked[1:] if other.unlikely - first.unlikely < gain]
    if not others:
        return None
    progress("fitting what was found to each way in which the recordings may be read")
    # It may have taken more than one fit to find it: the first is judged by the likelier.
    tried = (first, first, *others)
    fits = [named]
    fits += side_by_side(
        lambda r: fit(model, r.cases, named.hypothesis, r.baseline), tried[1:], jobs
    )
    ways = [reading.cases for reading in tried]
    unlikely = _unlikely(model, ways, _values(ways, fits))
    best = min(zip(tried, unlikely, strict=True), key=lambda each: sum(each[1].values()))[0]
    return None if best is first else best


def _unlikely(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[dict[int, float]]:
    """Return how unlikely each recording is in each of some ways.

    Residuals count in what is left all over, so that this decides nothing; but those of a recording
    of which one of the ways leaves no more than noise, in any channel, count in noise, and none in
    far more than one of the ways leaves: a relay that switches between its samples was left at 18
    times the noise where it was held, at 1.1 times where it ran on, and all of it forgiven.
    """
    found = [model.levels(way, known) for way, known in zip(ways, values, strict=True)]
    misfits = [{key[0] for key, level in levels.items() if level > 1.0} for levels in found]
    forgiven = set.intersection(*misfits)
    least = {key: min(levels.get(key, math.inf) for levels in found) for key in found[0]}
    return [
        _by_recording(
            model,
            way,
            known,
            {
                key: min(level, _MOST_FORGIVEN * least.get(key, level))
                if key[0] in forgiven
                else 1.0
                for key, level in levels.items()
            },
        )
        for way, known, levels in zip(ways, values, found, strict=True)
    ]


def _by_recording(
    model: Model, cases: Cases, values: Sequence[Values], levels: Levels | None = None
) -> dict[int, float]:
    """Return how unlikely each recording is."""
    found = {}
    for recording in dict.fromkeys(id(case.origin) for case in cases):
        mine = [i for i, case in enumerate(cases) if id(case.origin) == recording]
        found[recording] = model.unlikeliness(
            [cases[i] for i in mine], [values[i] for i in mine], levels
        )
    return found


def likeliest_followed(
    model: Model,
    cases: Cases,
    baseline: Fit | None,
    progress: Callable[[str], None],
    jobs: int = 1,
) -> tuple[list[Case], Fit | None]:
    """Return recordings as they are best followed, and their baseline.

    Parameters
    ----------
    model : Model
        What is fitted.
    cases : sequence of Case
        Recordings as they are read.
    baseline : Fit or None
        Of the cases, where it is known.
    progress : callable
        Told what is being fitted.
    jobs : int, optional
        So many fits at a time.

    Notes
    -----
    Each recording is followed in its own way: one that chatters asks for other trust in the model
    than one that moves steadily.
    """
    ways = model.followed(cases)
    if len(ways) == 1:
        return list(cases), baseline
    progress("fitting the baseline to each way in which the recordings may be followed")
    fits = _baselines(model, ways, baseline, jobs)
    values = _values(ways, fits)
    unlikely = [_by_recording(model, *each) for each in zip(ways, values, strict=True)]
    chosen = _likeliest_of_each(ways, unlikely)
    for way, found in zip(ways, fits, strict=True):
        if _are_the_same(way, chosen):
            return chosen, found
    return chosen, refitted(model, chosen, fits[0])


def likeliest_held_back(model: Model, held_back: Cases, found: Fit, first: Case) -> list[Case]:
    """Return recordings that are held back as they are best read and followed.

    Parameters
    ----------
    model : Model
        What was fitted.
    held_back : sequence of Case
        Recordings to which nothing is fitted.
    found : Fit
        To what is used, with everything that was found there: what is missing from a model may
        decide how recordings are read.
    first : Case
        The first of those that were used.
    """
    chosen = list(held_back)
    ways = model.readings(chosen) if chosen else []
    if len(ways) > 1:
        values = _values_elsewhere(ways, first, found)
        chosen = _likeliest_of_each(ways, _unlikely(model, ways, values))
    ways = model.followed(chosen)
    if len(ways) > 1:
        values = _values_elsewhere(ways, first, found)
        unlikely = [_by_recording(model, *each) for each in zip(ways, values, strict=True)]
        chosen = _likeliest_of_each(ways, unlikely)
    return chosen


def _baselines(model: Model, ways: Sequence[Cases], first: Fit | None, jobs: int) -> list[Fit]:
    """Return the baselines, each begun where the first one, which may be known, has ended."""
    begun = first or fit(model, ways[0], Hypothesis())
    return [begun, *side_by_side(lambda way: refitted(model, way, begun), ways[1:], jobs)]


def _values(ways: Sequence[Cases], fits: Sequence[Fit]) -> list[list[dict[str, float]]]:
    """Return what a fit to each of some ways says of its cases."""
    return [
        values_in_each(way, way[0], found.shared, found.own)
        for way, found in zip(ways, fits, strict=True)
    ]


def _values_elsewhere(
    ways: Sequence[Cases], first: Case, found: Fit
) -> list[list[dict[str, float]]]:
    """Return what a fit says of recordings that it was not made of, in each of some ways."""
    return [values_in_each(way, first, found.shared, [{}] * len(way)) for way in ways]


def _likeliest_of_each(
    ways: Sequence[Cases], unlikely: Sequence[Mapping[int, float]]
) -> list[Case]:
    """Return every recording's cases in the way in which it is likeliest."""
    return [
        case
        for recording in unlikely[0]
        for case in min(zip(ways, unlikely, strict=True), key=lambda way: way[1][recording])[0]
        if id(case.origin) == recording
    ]


def _are_the_same(one: Cases, other: Cases) -> bool:
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))
