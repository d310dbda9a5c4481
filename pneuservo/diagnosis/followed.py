"""How recordings are best followed, those held back as well: each in its likeliest way."""

from collections.abc import Callable, Sequence

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import refitted
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import Values, are_the_same
from pneuservo.diagnosis.ways import (
    Cases,
    baselines_of,
    by_recording,
    deviance_in,
    likeliest_of_each,
    likeliest_of_ways,
    of_recording,
    values_elsewhere,
    values_in_ways,
)

_MOVED = 3
"""So many times at most a motion is smoothed again with what is found in it then."""


def likeliest_followed(
    model: Model,
    cases: Cases,
    baseline: Fit | None,
    progress: Callable[[str], None],
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

    Notes
    -----
    Each recording is followed in its own way: one that chatters asks for other trust in the model
    than one that moves steadily.
    """
    if baseline is not None:
        cases, baseline = _moved_by(model, cases, baseline)
    ways = model.followed(cases)
    if len(ways) == 1:
        return list(cases), baseline
    progress("fitting the baseline to each way in which the recordings may be followed")
    fits = baselines_of(model, ways, baseline)
    values = values_in_ways(ways, fits)
    chosen = likeliest_of_ways(model, ways, values)
    for way, found in zip(ways, fits, strict=True):
        if are_the_same(way, chosen):
            return chosen, found
    return chosen, refitted(model, chosen, fits[0])


def _moved_by(model: Model, cases: Cases, found: Fit) -> tuple[Cases, Fit]:
    """Return recordings with motions that follow from a fit, and what is found in them then."""
    for _ in range(_MOVED):
        moved = _moved_as_found(model, cases, values_in_ways([cases], [found])[0])
        if are_the_same(moved, cases):
            break
        cases, found = moved, refitted(model, moved, found)
    return cases, found


def _moved_as_found(model: Model, cases: Cases, known: Sequence[Values]) -> list[Case]:
    """Return every recording with a motion that follows from what is known, if likelier so."""
    ways = model.moved(cases, known)
    if len(ways) == 1:
        return list(cases)
    of_origin = {id(case.origin): values for case, values in zip(cases, known, strict=True)}
    before, after = (
        by_recording(model, way, [of_origin[id(case.origin)] for case in way]) for way in ways
    )
    found = []
    for recording in before:
        likelier = before[recording] - after[recording] > LEAST_GAIN
        found.extend(of_recording(ways[1] if likelier else cases, recording))
    return found


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
        values = values_elsewhere(ways, first, found)
        chosen = likeliest_of_each(ways, deviance_in(model, ways, values))
    if chosen:
        chosen = _moved_as_found(model, chosen, values_elsewhere([chosen], first, found)[0])
    ways = model.followed(chosen)
    if len(ways) > 1:
        values = values_elsewhere(ways, first, found)
        chosen = likeliest_of_ways(model, ways, values)
    return chosen
