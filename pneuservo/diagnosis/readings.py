"""How recordings are to be read: where they do not say, what fits better is taken."""

from collections.abc import Callable, Sequence
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
    deviance_as_followed,
    likeliest_of_each,
    of_recording,
    values_in_ways,
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
    deviance : float
        Twice the negative log-likelihood of what is left and of the parameters that leave it, but
        for a constant; a misfit that every way leaves all over is forgiven.
    """

    cases: Cases
    baseline: Fit | None = None
    deviance: float = 0.0


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
    tried = _with_mixtures(model, readings)
    # Of mixtures only the likeliest is worth coming back to.
    best = tried.likeliest
    found = [
        reading for n, reading in enumerate(tried.as_readings()) if n < len(readings) or n == best
    ]
    return least_strained_first(sorted(found, key=lambda reading: reading.deviance))


def least_strained_first(ranked: list[Reading]) -> list[Reading]:
    """Return readings with one that is hardly less likely first where the likeliest is strained.

    Parameters
    ----------
    ranked : list of Reading
        The likeliest first.
    """
    first = ranked[0]
    for other in ranked[1:]:
        if other.deviance - first.deviance > LEAST_GAIN:
            break
        if _strain(other) < _strain(first) - DECISIVE:
            return [other, *(reading for reading in ranked if reading is not other)]
    return ranked


def _strain(reading: Reading) -> float:
    return reading.baseline.penalty if reading.baseline else 0.0


@dataclass
class _Tried:
    """Ways to read recordings that have been tried, with a fit to each.

    Parameters
    ----------
    model : Model
        What is fitted.
    ways : list of sequences of Case
        The same recordings, each time read in another way.
    fits : list of Fit
        To each of them.
    """

    model: Model
    ways: list[Cases]
    fits: list[Fit]

    def __post_init__(self) -> None:
        """Work out how unlikely each recording is in each of the ways."""
        self._values = values_in_ways(self.ways, self.fits)
        self._excused = all_excused(self.model, self.ways, self._values)
        self._compare()

    def _compare(self) -> None:
        self.deviance = deviance_as_followed(self.model, self._excused, self._values)

    @property
    def totals(self) -> list[float]:
        """Return how unlikely all recordings are in each way, and what its fit has found."""
        each = zip(self.deviance, self.fits, strict=True)
        return [sum(deviance.values()) + found.penalty for deviance, found in each]

    @property
    def likeliest(self) -> int:
        """Return which of the ways is the likeliest."""
        totals = self.totals
        return totals.index(min(totals))

    def try_as_well(self, mixture: Cases) -> bool:
        """Add a mixture of the ways, fitted from the likeliest; return whether it is a new one."""
        if is_among(mixture, self.ways):
            return False
        found = refitted(self.model, mixture, self.fits[self.likeliest])
        (values,) = values_in_ways([mixture], [found])
        self.ways.append(mixture)
        self.fits.append(found)
        self._values.append(values)
        self._excused.append(best_excused(self.model, mixture, values))
        self._compare()
        return True

    def as_readings(self) -> list[Reading]:
        """Return all of them as readings, in order."""
        return [Reading(*each) for each in zip(self.ways, self.fits, self.totals, strict=True)]


def _with_mixtures(model: Model, readings: Sequence[Cases]) -> _Tried:
    """Return ways to read recordings, mixtures among them.

    Each recording in its likeliest way first; then the likeliest of all, one recording at a time
    turned to the likeliest way that it was not read in beside the others: beside a relay that was
    read wrongly a proportional loop seemed likelier read wrongly too. At last, each in the way in
    which it is likeliest alone: by parameters that a wrong way to read the other had led to, the
    right way was too unlikely to be turned to.
    """
    fits = baselines_of(model, readings, None)
    tried = _Tried(model, list(readings), list(fits))
    if len(tried.deviance[0]) == 1:
        return tried
    at_best = at_their_best(model, readings, fits)
    tried.try_as_well(likeliest_of_each(tried.ways, tried.deviance))
    for recording in tried.deviance[0]:
        best = tried.likeliest
        turned = [_turned(tried.ways[best], reading, recording) for reading in readings]
        others = [way for way, mixture in enumerate(turned) if not is_among(mixture, tried.ways)]
        if not others:
            continue
        other = min(others, key=lambda way: at_best[way][recording])
        if at_best[other][recording] < _NOT_HOPELESS * tried.deviance[best][recording]:
            tried.try_as_well(turned[other])
    if leaves_little(tried.fits[tried.likeliest]):
        tried.try_as_well(likeliest_of_each(readings, alone(model, readings, at_best)))
    return tried


def leaves_little(found: Fit) -> bool:
    """Return whether a fit leaves little more than noise, wherever.

    Parameters
    ----------
    found : Fit
        To recordings in one way in which they may be read.
    """
    return max(rms([residual]) for residual in found.residuals) < _FAR_MORE


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
    others = [other for other in ranked[1:] if other.deviance - first.deviance < gain]
    if not others:
        return None
    progress("fitting what was found to each way in which the recordings may be read")
    # It may have taken more than one fit to find it: the first is judged by the likelier.
    asked = [first, first, *others]

    def fitted_in(reading: Reading) -> Fit:
        near = reading.baseline
        return fit(model, reading.cases, named.hypothesis, near, elsewhere=named)

    fits = [named, *side_by_side(fitted_in, asked[1:])]
    tried = _Tried(model, [reading.cases for reading in asked], fits)
    mixture = likeliest_of_each(tried.ways, at_their_best(model, tried.ways, fits))
    if tried.try_as_well(mixture):
        asked.append(Reading(mixture))
    by_name = tried.as_readings()
    ranked_by_name = sorted(by_name, key=lambda reading: reading.deviance)
    likeliest = least_strained_first(ranked_by_name)[0]
    best = next(reading for reading, own in zip(asked, by_name, strict=True) if own is likeliest)
    return None if best is first else best
