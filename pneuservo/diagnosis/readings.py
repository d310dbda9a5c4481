"""How recordings are to be read and followed: where they do not say, what fits better is taken."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pneuservo.diagnosis.fit import Fit, gained_most
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.problem import values_in_each

Cases = Sequence[Case]


@dataclass(frozen=True)
class Reading:
    """Recordings read in one way.

    Parameters
    ----------
    place : int
        Of that way among those of the model.
    cases : sequence of Case
        As they are then.
    baseline : Fit or None
        Fitted to them, where more than one way had to be tried.
    unlikely : float
        Twice the negative log-likelihood of what is left, but for a constant; a misfit that every
        way leaves all over is forgiven.
    """

    place: int
    cases: Cases
    baseline: Fit | None = None
    unlikely: float = 0.0


def ranked_readings(
    model: Model, readings: Sequence[Cases], progress: Callable[[str], None]
) -> list[Reading]:
    """Return each way to read some recordings, the likeliest first.

    Parameters
    ----------
    model : Model
        What is fitted.
    readings : sequence of sequences of Case
        The same recordings, each time read in another way.
    progress : callable
        Told what is being fitted.

    Notes
    -----
    All recordings are read in the same way. The baseline is fitted first: parameters that are off
    would decide instead, by whatever factor. A misfit that all of them leave all over is no
    argument for any.
    """
    if len(readings) == 1:
        return [Reading(0, readings[0])]
    progress("fitting the baseline to each way in which the recordings may be read")
    fits = _fitted_in_turn(model, readings, None)
    found = [
        Reading(place, cases, baseline, unlikely)
        for place, (cases, baseline, unlikely) in enumerate(
            zip(readings, fits, _unlikely(model, readings, fits), strict=True)
        )
    ]
    return sorted(found, key=lambda reading: reading.unlikely)


def likelier_with(
    model: Model,
    ranked: Sequence[Reading],
    baseline: Fit,
    named: Fit,
    progress: Callable[[str], None],
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
    fits += [fit(model, r.cases, named.hypothesis, r.baseline) for r in tried[1:]]
    unlikely = _unlikely(model, [reading.cases for reading in tried], fits)
    best = tried[unlikely.index(min(unlikely))]
    return None if best is first else best


def _unlikely(model: Model, ways: Sequence[Cases], fits: Sequence[Fit]) -> list[float]:
    """Return how unlikely recordings are in each of some ways.

    Residuals count in what is left all over, so that this decides nothing; but those of a recording
    of which one of the ways leaves no more than noise, in any channel, count in noise.
    """
    values = [_values(*each) for each in zip(ways, fits, strict=True)]
    found = [model.levels(way, known) for way, known in zip(ways, values, strict=True)]
    misfits = [{key[0] for key, level in levels.items() if level > 1.0} for levels in found]
    forgiven = set.intersection(*misfits)
    return [
        model.unlikeliness(
            way, known, {k: level if k[0] in forgiven else 1.0 for k, level in levels.items()}
        )
        for way, known, levels in zip(ways, values, found, strict=True)
    ]


def likeliest_followed(
    model: Model,
    cases: Cases,
    held_back: Cases,
    baseline: Fit | None,
    progress: Callable[[str], None],
) -> tuple[list[Case], list[Case], Fit | None]:
    """Return used and held back cases as they are best followed, and the baseline of the former.

    Parameters
    ----------
    model : Model
        What is fitted.
    cases, held_back : sequence of Case
        Recordings as they are read.
    baseline : Fit or None
        Of the cases, where it is known.
    progress : callable
        Told what is being fitted.

    Notes
    -----
    Each recording is followed in its own way: one that chatters asks for other trust in the model
    than one that moves steadily.
    """
    ways = model.followed(cases)
    if len(ways) == 1:
        return list(cases), list(held_back), baseline
    progress("fitting the baseline to each way in which the recordings may be followed")
    fits = _fitted_in_turn(model, ways, baseline)
    chosen = _likeliest_of_each(
        model, ways, [_values(*each) for each in zip(ways, fits, strict=True)]
    )
    held_ways = model.followed(held_back)
    held_values = [
        values_in_each(way, cases[0], found.shared, [{}] * len(way))
        for way, found in zip(held_ways, fits, strict=True)
    ]
    held = _likeliest_of_each(model, held_ways, held_values)
    for way, found in zip(ways, fits, strict=True):
        if all(one is other for one, other in zip(way, chosen, strict=True)):
            return chosen, held, found
    return chosen, held, refitted(model, chosen, fits[0])


def _fitted_in_turn(model: Model, ways: Sequence[Cases], first: Fit | None) -> list[Fit]:
    """Return the baselines, each begun where the first one, which may be known, has ended."""
    first = first or fit(model, ways[0], Hypothesis())
    return [first, *(refitted(model, way, first) for way in ways[1:])]


def _values(cases: Cases, found: Fit) -> list[dict[str, float]]:
    return values_in_each(cases, cases[0], found.shared, found.own)


def _likeliest_of_each(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[Case]:
    """Return every recording's cases in the way in which it is likeliest."""
    chosen: dict[int, int] = {}
    for recording in {id(case.recording) for case in ways[0]}:
        mine = [i for i, case in enumerate(ways[0]) if id(case.recording) == recording]
        unlikely = [
            model.unlikeliness([way[i] for i in mine], [each[i] for i in mine])
            for way, each in zip(ways, values, strict=True)
        ]
        chosen[recording] = unlikely.index(min(unlikely))
    return [ways[chosen[id(case.recording)]][i] for i, case in enumerate(ways[0])]
