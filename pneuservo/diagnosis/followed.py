"""How recordings are best followed, those held back as well: each in its likeliest way."""

from collections.abc import Callable

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import refitted
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import are_the_same
from pneuservo.diagnosis.ways import (
    Cases,
    baselines_of,
    deviance_in,
    likeliest_of_each,
    likeliest_of_ways,
    values_elsewhere,
    values_in_ways,
)


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
    ways = model.followed(chosen)
    if len(ways) > 1:
        values = values_elsewhere(ways, first, found)
        chosen = likeliest_of_ways(model, ways, values)
    return chosen
