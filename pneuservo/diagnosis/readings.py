"""How recordings are to be read, where they do not say: the reading that fits better is taken."""

from collections.abc import Callable, Sequence

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.problem import values_in_each

OVERWHELMING = 0.5
"""One reading that is so many times less unlikely than the other needs no fit to be the better."""


def likeliest(
    model: Model, readings: Sequence[Sequence[Case]], progress: Callable[[str], None]
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
    within their tolerances would decide instead.
    """
    if len(readings) == 1:
        return 0, None
    unlikely = [model.unlikeliness(read, [{} for _ in read]) for read in readings]
    left = [i for i, u in enumerate(unlikely) if OVERWHELMING * u < min(unlikely)]
    if len(left) == 1:
        return left[0], None
    progress("fitting the baseline to each way in which the command may be read")
    fits = {i: fit(model, readings[i], Hypothesis()) for i in left}
    fitted = {
        i: model.unlikeliness(
            readings[i], values_in_each(readings[i], readings[i][0], found.shared, found.own)
        )
        for i, found in fits.items()
    }
    best = min(left, key=fitted.__getitem__)
    return best, fits[best]
