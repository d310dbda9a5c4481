"""How recordings are to be read and followed: where they do not say, what fits better is taken."""

from collections.abc import Callable, Sequence

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.problem import values_in_each

Cases = Sequence[Case]


def likeliest_reading(
    model: Model, readings: Sequence[Cases], progress: Callable[[str], None]
) -> tuple[int, Fit | None]:
    """Return the place of the reading that fits best, and its baseline where it was fitted.

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
    would decide instead, by whatever factor. A misfit all over is no argument for a reading.
    """
    if len(readings) == 1:
        return 0, None
    progress("fitting the baseline to each way in which the recordings may be read")
    fits = _fitted_in_turn(model, readings, None)
    unlikely = [
        model.unlikeliness(read, values, forgiving=True)
        for read, values in zip(readings, _values(readings, fits), strict=True)
    ]
    best = unlikely.index(min(unlikely))
    return best, fits[best]


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
    chosen = _likeliest_of_each(model, ways, _values(ways, fits))
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


def _values(ways: Sequence[Cases], fits: Sequence[Fit]) -> list[list[dict[str, float]]]:
    return [
        values_in_each(way, way[0], found.shared, found.own)
        for way, found in zip(ways, fits, strict=True)
    ]


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
