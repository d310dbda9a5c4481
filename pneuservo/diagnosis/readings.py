"""How recordings are to be read: where they do not say, what fits better is taken."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from pneuservo.diagnosis.fit import Fit, gained_most, rms
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.judge import DECISIVE, LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.models.model import is_among
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.ways import (
    Cases,
    all_excused,
    alone,
    at_their_best,
    baselines_of,
    best_excused,
    likeliest_of_each,
    of_recording,
    unlikeliness_as_followed,
    values_in,
)

_NOT_HOPELESS = 1.25
"""A recording that is so many times as unlikely in another way is not turned to it alone."""
_FAR_MORE = 2.0
"""Where so many times the noise is left, something is missing that no way to read makes up for."""


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
        Twice the negative log-likelihood of what is left and of the parameters that leave it, but
        for a constant; a misfit that every way leaves all over is forgiven.
    """

    cases: Cases
    baseline: Fit | None = None
    unlikely: float = 0.0


def ranked_readings(
    model: Model, readings: Sequence[Cases], progress: Callable[[str], None]
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

    Notes
    -----
    The baseline is fitted first: parameters that are off would decide instead, by whatever factor.
    A misfit that all of them leave all over is no argument for any. Recordings of one rig may have
    to be read in different ways, for a relay that samples may have been followed by an analogue
    loop; each in its likeliest is a way of its own. Half a sample is also made up for by a slower
    spool: where two ways are told apart by no more than the method's own errors, the one that
    strains no parameter comes first. (An analogue loop without any effect was likelier by 38 as one
    that samples, with its spool at 127 Hz instead of 200, and the spool was called wrong.)
    """
    if len(readings) == 1:
        return [Reading(readings[0])]
    progress("fitting the baseline to each way in which the recordings may be read")
    ways, fits, unlikely = _with_mixtures(model, readings)
    # Of mixtures only the likeliest is worth coming back to.
    best = _likeliest(unlikely, fits)
    kept = [n for n in range(len(ways)) if n < len(readings) or n == best]
    found = [Reading(ways[n], fits[n], _total(unlikely[n], fits[n])) for n in kept]
    return least_strained_first(sorted(found, key=lambda reading: reading.unlikely))


def least_strained_first(ranked: list[Reading]) -> list[Reading]:
    """Return readings with one that is hardly less likely first where the likeliest is strained.

    Parameters
    ----------
    ranked : list of Reading
        The likeliest first.
    """
    first = ranked[0]
    for other in ranked[1:]:
        if other.unlikely - first.unlikely > LEAST_GAIN:
            break
        if _strain(other) < _strain(first) - DECISIVE:
            return [other, *(reading for reading in ranked if reading is not other)]
    return ranked


def _strain(reading: Reading) -> float:
    return reading.baseline.penalty if reading.baseline else 0.0


def _with_mixtures(
    model: Model, readings: Sequence[Cases]
) -> tuple[list[Cases], list[Fit], list[dict[int, float]]]:
    """Return ways to read recordings, mixtures among them, baselines, and how unlikely each is.

    Each recording in its likeliest way first; then the likeliest of all, one recording at a time
    turned to the likeliest way that it was not read in beside the others: beside a relay that was
    read wrongly a proportional loop seemed likelier read wrongly too. At last, each in the way in
    which it is likeliest alone: by parameters that a wrong way to read the other had led to, the
    right way was too unlikely to be turned to.
    """
    ways, fits = list(readings), baselines_of(model, readings, None)
    values = values_in(ways, fits)
    excused = all_excused(model, ways, values)
    unlikely = unlikeliness_as_followed(model, excused, values)
    if len(unlikely[0]) == 1:
        return ways, fits, unlikely
    at_best = at_their_best(model, readings, fits)

    def try_as_well(mixture: Cases) -> None:
        nonlocal unlikely
        if not is_among(mixture, ways):
            nearest = fits[_likeliest(unlikely, fits)]
            ways.append(mixture)
            fits.append(refitted(model, mixture, nearest))
            values.extend(values_in(ways[-1:], fits[-1:]))
            excused.append(best_excused(model, mixture, values[-1]))
            unlikely = unlikeliness_as_followed(model, excused, values)

    try_as_well(likeliest_of_each(ways, unlikely))
    for recording in unlikely[0]:
        best = _likeliest(unlikely, fits)
        turned = [_turned(ways[best], reading, recording) for reading in readings]
        others = [way for way, mixture in enumerate(turned) if not is_among(mixture, ways)]
        if not others:
            continue
        other = min(others, key=lambda way: at_best[way][recording])
        if at_best[other][recording] < _NOT_HOPELESS * unlikely[best][recording]:
            try_as_well(turned[other])
    if leaves_little(fits[_likeliest(unlikely, fits)]):
        try_as_well(likeliest_of_each(readings, alone(model, readings, at_best)))
    return ways, fits, unlikely


def leaves_little(found: Fit) -> bool:
    """Return whether a fit leaves little more than noise, wherever.

    Parameters
    ----------
    found : Fit
        To recordings in one way in which they may be read.
    """
    return max(rms([residual]) for residual in found.residuals) < _FAR_MORE


def _likeliest(unlikely: Sequence[Mapping[int, float]], fits: Sequence[Fit]) -> int:
    """Return which of some ways is the likeliest."""
    return min(range(len(unlikely)), key=lambda n: _total(unlikely[n], fits[n]))


def _total(unlikely: Mapping[int, float], found: Fit) -> float:
    """Return how unlikely all recordings are, and the parameters that a fit has found."""
    return sum(unlikely.values()) + found.penalty


def _turned(cases: Cases, other: Cases, recording: int) -> list[Case]:
    """Return cases with one recording's in another way."""
    first = next(i for i, case in enumerate(cases) if id(case.origin) == recording)
    rest = [case for case in cases if id(case.origin) != recording]
    return [*rest[:first], *of_recording(other, recording), *rest[first:]]


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
    what explains more than lay between two readings can turn their order. Each recording in the way
    that suits it best with the name is tried as well: of two that both lag, one sampled and one
    analogue, the baseline was likeliest with neither read rightly.
    """
    first = ranked[0]
    gain = gained_most(baseline, named)
    others = [other for other in ranked[1:] if other.unlikely - first.unlikely < gain]
    if not others:
        return None
    progress("fitting what was found to each way in which the recordings may be read")
    # It may have taken more than one fit to find it: the first is judged by the likelier.
    tried = [first, first, *others]
    fits = [named]

    def fitted_in(reading: Reading) -> Fit:
        near = reading.baseline
        return fit(model, reading.cases, named.hypothesis, near, elsewhere=named)

    fits += side_by_side(fitted_in, tried[1:])
    ways = [reading.cases for reading in tried]
    mixture = likeliest_of_each(ways, at_their_best(model, ways, fits))
    values = values_in(ways, fits)
    excused = all_excused(model, ways, values)
    unlikely = unlikeliness_as_followed(model, excused, values)
    if not is_among(mixture, ways):
        tried.append(Reading(mixture))
        ways.append(mixture)
        fits.append(refitted(model, mixture, fits[_likeliest(unlikely, fits)]))
        values.extend(values_in(ways[-1:], fits[-1:]))
        excused.append(best_excused(model, mixture, values[-1]))
        unlikely = unlikeliness_as_followed(model, excused, values)
    by_name = [
        Reading(way, found, _total(each, found))
        for way, found, each in zip(ways, fits, unlikely, strict=True)
    ]
    ranked_by_name = sorted(by_name, key=lambda reading: reading.unlikely)
    likeliest = least_strained_first(ranked_by_name)[0]
    best = next(reading for reading, own in zip(tried, by_name, strict=True) if own is likeliest)
    return None if best is first else best
