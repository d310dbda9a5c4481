"""Several ways to read or to follow recordings, and how unlikely each makes them."""

import math
from collections.abc import Mapping, Sequence

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Levels, Values, is_among
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.unknowns import values_in_each

Cases = Sequence[Case]
_MOST_FORGIVEN = 4.0
"""So many times the least of what the ways of reading leave all over, squared, decides nothing."""
_HOPELESS_ALONE = 2.0
"""A recording that is so many times as unlikely in another way is not fitted alone in that."""


def deviance_in(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[dict[int, float]]:
    """Return how unlikely each recording is in each of some ways, followed as suits it in each.

    Parameters
    ----------
    model : Model
        What is fitted.
    ways : sequence of sequences of Case
        The same recordings, each time in another way.
    values : sequence of sequences of mapping
        What is known of each case of each way, see `values_in_ways`.

    Returns
    -------
    list of dict of int to float
        Of each way, by identity of the recording: twice the negative log-likelihood.
    """
    return deviance_as_followed(model, all_excused(model, ways, values), values)


def deviance_as_followed(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[dict[int, float]]:
    """Return how unlikely each recording is in each of some ways, followed as it is.

    Parameters
    ----------
    model, ways, values
        As for `deviance_in`; the ways from `best_excused`.

    Returns
    -------
    list of dict of int to float
        As of `deviance_in`.

    Notes
    -----
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
        by_recording(
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


def by_recording(
    model: Model, cases: Cases, values: Sequence[Values], levels: Levels | None = None
) -> dict[int, float]:
    """Return how unlikely each recording is.

    Parameters
    ----------
    model : Model
        What is fitted.
    cases : sequence of Case
        In one way.
    values : sequence of mapping
        What is known of each case.
    levels : mapping, optional
        What residuals count in; noise without them.
    """
    found = {}
    for recording in dict.fromkeys(id(case.origin) for case in cases):
        mine = [i for i, case in enumerate(cases) if id(case.origin) == recording]
        found[recording] = model.deviance(
            [cases[i] for i in mine], [values[i] for i in mine], levels
        )
    return found


def best_excused(model: Model, cases: Cases, values: Sequence[Values]) -> list[Case]:
    """Return cases with the trust, of those by which readings are judged, that suits each best.

    Parameters
    ----------
    model : Model
        What is fitted.
    cases : sequence of Case
        In one way, those of a recording together.
    values : sequence of mapping
        What is known of each case.
    """
    trusts = model.excused(cases)
    return likeliest_of_ways(model, trusts, [values] * len(trusts))


def all_excused(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[list[Case]]:
    """Return recordings in each of some ways with the trust that suits each best, `best_excused`.

    Parameters
    ----------
    model, ways, values
        As for `deviance_in`.
    """
    each = list(zip(ways, values, strict=True))
    return side_by_side(lambda one: best_excused(model, *one), each)


def baselines_of(model: Model, ways: Sequence[Cases], first: Fit | None) -> list[Fit]:
    """Return the baselines, each begun where the first one has ended.

    Parameters
    ----------
    model : Model
        What is fitted.
    ways : sequence of sequences of Case
        The same recordings, each time in another way.
    first : Fit or None
        To the first of them, where it is known.
    """
    begun = first or fit(model, ways[0], Hypothesis())
    return [begun, *side_by_side(lambda way: refitted(model, way, begun), ways[1:])]


def values_in_ways(ways: Sequence[Cases], fits: Sequence[Fit]) -> list[list[dict[str, float]]]:
    """Return what a fit to each of some ways says of its cases."""
    return [
        values_in_each(way, way[0], found.shared, found.own)
        for way, found in zip(ways, fits, strict=True)
    ]


def values_elsewhere(
    ways: Sequence[Cases], first: Case, found: Fit
) -> list[list[dict[str, float]]]:
    """Return what a fit says of recordings that it was not made of, in each of some ways."""
    return [values_in_each(way, first, found.shared, [{}] * len(way)) for way in ways]


def of_recording(cases: Cases, recording: int) -> list[Case]:
    """Return the cases of one recording.

    Parameters
    ----------
    cases : sequence of Case
        Of several.
    recording : int
        Its identity, as it was read.
    """
    return [case for case in cases if id(case.origin) == recording]


def at_their_best(
    model: Model, ways: Sequence[Cases], fits: Sequence[Fit]
) -> list[dict[int, float]]:
    """Return how unlikely each recording is in each of some ways, by what suits it best.

    Parameters
    ----------
    model, ways
        As for `deviance_in`.
    fits : sequence of Fit
        Of the same ways; the nominal parameters are tried beside theirs.

    Notes
    -----
    A fit to several recordings of which one is read wrongly makes the others unlikely too, however
    they are read.
    """
    found: list[dict[int, float]] = []
    for way, own in zip(ways, values_in_ways(ways, fits), strict=True):
        first = way[0]
        nothing: list[Values] = [{}] * len(way)
        tried = [
            own,
            values_in_each(way, first, {}, nothing),
            *(values_in_each(way, first, fitted.shared, nothing) for fitted in fits),
        ]
        each = [by_recording(model, way, known) for known in tried]
        found.append({recording: min(one[recording] for one in each) for recording in each[0]})
    return found


def alone(
    model: Model, ways: Sequence[Cases], at_best: Sequence[Mapping[int, float]]
) -> list[dict[int, float]]:
    """Return how unlikely each recording is in each way by a baseline fitted to it alone.

    Parameters
    ----------
    model, ways
        As for `deviance_in`.
    at_best : sequence of mapping
        From `at_their_best`; ways that are hopeless there are infinitely unlikely.

    Notes
    -----
    Of a sliding mode on a computer, beside an analogue loop, the right way left 4 times the noise
    by the parameters that the wrong way to read the other had led to, and 1.0 by its own.
    """
    recordings = list(at_best[0])
    limits = {each: _HOPELESS_ALONE * min(way[each] for way in at_best) for each in recordings}
    mine = [{each: of_recording(way, each) for each in recordings} for way in ways]
    asked = [
        (way, each)
        for way in range(len(ways))
        for each in recordings
        if at_best[way][each] < limits[each]
        # What reads a recording as one before it does would only be fitted twice.
        and not is_among(mine[way][each], (before[each] for before in mine[:way]))
    ]

    def by_its_own(asked: tuple[int, int]) -> float:
        way, each = asked
        cases = mine[way][each]
        found = fit(model, cases, Hypothesis())
        known = values_in_ways([cases], [found])[0]
        excused = best_excused(model, cases, known)
        return by_recording(model, excused, known)[each] + found.penalty

    found = [dict.fromkeys(recordings, math.inf) for _ in ways]
    for (way, each), deviance in zip(asked, side_by_side(by_its_own, asked), strict=True):
        found[way][each] = deviance
    return found


def likeliest_of_ways(
    model: Model, ways: Sequence[Cases], values: Sequence[Sequence[Values]]
) -> list[Case]:
    """Return every recording's cases in the way in which it is likeliest, in noise.

    Parameters
    ----------
    model, ways, values
        As for `deviance_in`.
    """
    if len(ways) == 1:
        return list(ways[0])
    deviances = [by_recording(model, *each) for each in zip(ways, values, strict=True)]
    return likeliest_of_each(ways, deviances)


def likeliest_of_each(
    ways: Sequence[Cases], deviances: Sequence[Mapping[int, float]]
) -> list[Case]:
    """Return every recording's cases in the way in which it is likeliest.

    Parameters
    ----------
    ways : sequence of sequences of Case
        The same recordings, each time in another way.
    deviances : sequence of mapping
        From `deviance_in`, or of each way from `by_recording`.
    """
    found = []
    for recording in deviances[0]:
        way = min(range(len(ways)), key=lambda each: deviances[each][recording])
        found.extend(of_recording(ways[way], recording))
    return found
