"""How recordings are to be read and followed: where they do not say, what fits better is taken."""

from collections.abc import Callable, Sequence

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import fit, refitted
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.problem import values_in_each


def likeliest(
    model: Model,
    readings: Sequence[Sequence[Case]],
    progress: Callable[[str], None],
    first: Fit | None = None,
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
    first : Fit, optional
        The baseline of the first reading, where it is known.

    Notes
    -----
    All recordings are read in the same way. The baseline is fitted first: parameters that are off
    would decide instead, by whatever factor.
    """
    if len(readings) == 1:
        return 0, first
    progress("fitting the baseline to each way in which the recordings may be read")
    first = first or fit(model, readings[0], Hypothesis())
    fits = [first, *(refitted(model, read, first) for read in readings[1:])]
    unlikely = [
        model.unlikeliness(read, values_in_each(read, read[0], found.shared, found.own))
        for read, found in zip(readings, fits, strict=True)
    ]
    best = unlikely.index(min(unlikely))
    return best, fits[best]
