"""Parameters far from nominal: which are wrong, and what candidates promise if they are not."""

from collections.abc import Collection, Sequence
from heapq import nlargest

import numpy as np

from pneuservo.diagnosis.fit import Fit, rms
from pneuservo.diagnosis.fitting import at_nominal
from pneuservo.diagnosis.judge import LEAST_DISTANCE
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.screen import LEAST_PROMISE, scores
from pneuservo.diagnosis.signatures import Signatures, gained_beyond, signatures_of
from pneuservo.intervals import INTERVAL

STRAINED = 3.0
"""Tolerances from its nominal value beyond which a parameter makes up for something else."""
OUT_OF_TOLERANCE = 2.0
"""Tolerances beyond which all of a parameter's interval has to lie where nothing else is wrong: in
29 pairs of recordings of two other simulators with parameters within 1.4 tolerances the farthest
was fitted at 1.6, of 24 with one that was 1.4 to 7.8 tolerances off every one that shows (d' of 10
and more) within 0.3 of where it was."""
LEAVES_NOISE = 1.15
"""Times its noise, which is known to a tenth, that a channel of a recording is left at where
nothing else is wrong. (Of a relay at 180 Hz that was sampled at 500 Hz nobody knows what its
command was: left at 1.45, three right parameters were called wrong.)"""
FOLLOWED = 0.75
"""Times its noise below which a channel was followed more than judged: of a card that chatters at
half the sampling rate, what its command did between samples is not known, pressures were left at
0.6, and six right parameters called wrong. (Where one was wrong, channels were left at 0.89 and
more.)"""
MANY_WRONG = 3
"""So many parameters of one rig are hardly wrong at once: they make up for something else. (A loop
at rest that was read wrongly had moved an index and three areas of the valve.)"""
WORTH_FITTING = 3
"""So many candidates are fitted for what they promise from nominal parameters."""


def is_strained(base: Fit) -> bool:
    """Return whether anything that is known within a tolerance was fitted far out of it.

    A force at the zero of a recording too: pressures of one chamber read 15 kPa high had become 5 N
    of it, and promised 42 of the 2,000 that their offset gains.

    Parameters
    ----------
    base : Fit
        Of the baseline.
    """
    return bool(np.any(np.abs(base.distance) > STRAINED))


def are_many_strained(found: Fit) -> bool:
    """Return whether so many parameters of the rig are strained that they make up for something.

    Parameters
    ----------
    found : Fit
        With all that was found.
    """
    strained = [name for name, away in _from_nominal(found).items() if away > STRAINED]
    return len(strained) >= MANY_WRONG


def far_out(base: Fit) -> list[str]:
    """Return the parameters that would be worth a name if nothing else had strained them.

    Parameters
    ----------
    base : Fit
        Of the baseline.

    Returns
    -------
    list of str
        As candidates, ``param.`` and their ids.
    """
    return [f"param.{n}" for n, away in _from_nominal(base).items() if away**2 > LEAST_DISTANCE]


def out_of_tolerance(found: Fit) -> list[str]:
    """Return the parameters of the rig that are out of their tolerance beyond doubt.

    Parameters
    ----------
    found : Fit
        That leaves nothing to be explained.

    Returns
    -------
    list of str
        Their ids, the farthest first.
    """
    least = {
        name: away - INTERVAL * found.leverage(name) ** 0.5
        for name, away in _from_nominal(found).items()
    }
    out = [name for name, away in least.items() if away > OUT_OF_TOLERANCE]
    return sorted(out, key=least.__getitem__, reverse=True)


def relief_of(
    base: Fit,
    wrong: Sequence[str],
    signatures: Signatures,
    names: Sequence[str],
    one_sided: Collection[str],
) -> dict[str, float]:
    """Return how far effects would bring wrong parameters back, in tolerances squared.

    Parameters
    ----------
    base : Fit
        In which they seem wrong.
    wrong : sequence of str
        Their ids.
    signatures : mapping
        From `signatures_of`, beside the base.
    names : sequence of str
        Effects asked for.
    one_sided : collection of str
        Effects whose size cannot be negative.

    Notes
    -----
    What effects gain of the distances alone, as if no noise were left. By what they promise to gain
    of everything, a zero of the displacement that made two dead volumes 5.6 and 3.7 tolerances
    wrong, beside a null bias, was the tenth.
    """
    strain = [
        d if name in wrong else 0.0 for name, d in zip(base.tolerated, base.distance, strict=True)
    ]
    left = base.unabsorbed_of(np.concatenate([np.zeros(base.samples), strain]))
    return {
        name: gained_beyond(base, signatures[name], [left], name in one_sided) for name in names
    }


def leaves_noise(cases: Sequence[Case], found: Fit, noise: Sequence[float]) -> bool:
    """Return whether what is left of every channel of every recording is no more than noise.

    Parameters
    ----------
    cases : sequence of Case
        The recordings.
    found : Fit
        To them.
    noise : sequence of float
        Of the judged channel of each [unit of the case].
    """
    return all(
        rms([residual]) < LEAVES_NOISE * size
        for case, residual, size in zip(cases, found.residuals, noise, strict=True)
        if case.recorded
    )


def only_followed(
    model: Model, cases: Sequence[Case], found: Fit, noise: Sequence[float]
) -> set[int]:
    """Return the recordings of which a channel that a model may follow is left far below its noise.

    Where it is known what drove the rig between samples it is not only followed: steep pressures
    may have passed for noise (530 Pa of 380, against an end stop).

    Parameters
    ----------
    model : Model
        What is fitted.
    cases, found, noise
        As for `leaves_noise`.

    Returns
    -------
    set of int
        Their identities.
    """
    return {
        id(case.origin)
        for case, residual, size in zip(cases, found.residuals, noise, strict=True)
        if case.channel in model.follows
        and rms([residual]) <= FOLLOWED * size
        and not model.is_known_between_samples(case)
    }


def _from_nominal(found: Fit) -> dict[str, float]:
    """Return how far the rig's tolerated parameters are from nominal, in tolerances."""
    away = zip(found.tolerated, np.abs(found.distance).tolist(), strict=True)
    return {name: distance for name, distance in away if name in found.shared}


def promises_from_nominal(
    model: Model,
    cases: Sequence[Case],
    base: Fit,
    names: Collection[str],
    one_sided: Collection[str],
) -> dict[str, float]:
    """Return what effects promise to explain beyond a baseline if parameters are nominal after all.

    Parameters
    ----------
    model, cases
        What is fitted to what.
    base : Fit
        Of the baseline, its parameters strained.
    names : collection of str
        Candidates; what is no effect is passed over.
    one_sided : collection of str
        Effects whose size cannot be negative.

    Returns
    -------
    dict of str to float
        Of at most `WORTH_FITTING` effects.

    Notes
    -----
    Where parameters have gone astray for want of an effect, its signature is that of another rig
    and promises nothing. A spool whose motor is too weak left 1.4 to 1.8 times the noise with half
    its natural frequency; beside that the limit of its acceleration promised less than nothing,
    from the nominal frequency 3,990 of 8,330, and no other effect anything.
    """
    nominal = at_nominal(model, cases, base)
    signatures = signatures_of(model, cases, nominal)
    effects = [name for name in signatures if name in names]
    # As a gain is: in the weights of the fit, or in noise alone where a channel looks noisy.
    promised = [
        _beyond(*weighed, signatures, effects, one_sided)
        for weighed in ((base, nominal), (base.in_noise, nominal.in_noise))
    ]
    found = {name: max(each[name] for each in promised) for name in effects}
    worth = {name: promise for name, promise in found.items() if promise > LEAST_PROMISE}
    best = nlargest(WORTH_FITTING, worth, key=worth.__getitem__)
    return {name: worth[name] for name in best}


def _beyond(
    base: Fit,
    nominal: Fit,
    signatures: Signatures,
    effects: Sequence[str],
    one_sided: Collection[str],
) -> dict[str, float]:
    """Return what effects promise beside nominal parameters beyond what a baseline explains."""
    more = float(np.sum(base.left**2) - np.sum(nominal.unabsorbed**2))
    found = scores(nominal, signatures, effects, one_sided)
    return {name: more + score for name, score in found.items()}
