"""What a law of another form than the one that was fitted would explain."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.locate import in_all
from pneuservo.diagnosis.models import Case, Model

PLACES = 5
"""A law may be more or less than was fitted at so many places along everything that was recorded,
straight between them."""


def bendable(model: Model, cases: Sequence[Case], found: Fit) -> Fit:
    """Return a fit that would absorb what its effects change, bent in any smooth way.

    Parameters
    ----------
    model, cases, found
        What was fitted to what.

    Returns
    -------
    Fit
        The same, with more columns in its `sensitivity`: what each size of an effect changes in a
        channel, more or less of it along every quantity that was recorded, and its rate, as if it
        came a little later.

    Notes
    -----
    Real laws differ in form from those of a catalogue, and what they leave is left where they act.
    What acts elsewhere, or otherwise, is not among that.
    """
    sizes = [
        effect.key(parameter.name)
        for effect in model.effects
        if effect.id in found.hypothesis.effects
        for parameter in effect.parameters
        if parameter.neutral == 0.0
    ]
    first = np.cumsum([0, *(len(r) for r in found.residuals)])
    bends = []
    for channel in dict.fromkeys(found.channels):
        here = [place for place, c in enumerate(found.channels) if c == channel]
        here = [place for place in here if cases[place].recorded]
        if here:
            rows = np.concatenate([np.arange(first[place], first[place + 1]) for place in here])
            along = _along([cases[place] for place in here], model)
            for size in sizes:
                change = found.sensitivity[: found.samples, found.keys.index(size)][rows]
                bend = np.zeros((len(found.left), along.shape[1] + 1))
                bend[rows] = np.column_stack([along * change[:, np.newaxis], np.gradient(change)])
                bends.append(bend)
    return replace(found, sensitivity=np.hstack([found.sensitivity, *bends]))


def explained_beyond(bent: Fit, closer: Fit) -> float:
    """Return what a closer fit explains that no bent law would.

    Parameters
    ----------
    bent : Fit
        From `bendable`.
    closer : Fit
        With one effect more.
    """
    weighed = bent.in_weights(closer.scale)
    left = weighed.unabsorbed_of(closer.left)
    return float(np.sum(weighed.unabsorbed**2) - np.sum(left**2))


def _along(cases: Sequence[Case], model: Model) -> Array:
    """Return how near every usable sample is to each place along what was recorded, (n, k)."""
    recorded = [model.regressors(case) for case in cases]
    columns = [np.ones(sum(int(case.usable.sum()) for case in cases))]
    for name in in_all(recorded):
        values = np.concatenate(
            [each[name][case.usable] for each, case in zip(recorded, cases, strict=True)]
        )
        places = np.unique(np.quantile(values, np.linspace(0.0, 1.0, PLACES)))
        # All together are one everywhere, and that is there already.
        columns += [np.interp(values, places, one) for one in np.eye(len(places))[1:]]
    return np.column_stack(columns)
