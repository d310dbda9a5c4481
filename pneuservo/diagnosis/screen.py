"""Which candidates are worth a fit: those whose signature the residual contains."""

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.judge import LEAST_DISTANCE, LEAST_GAIN
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import Signatures, gained_beyond

WORTH_FITTING = 6
"""So many effects are fitted at each step; where there are no more, all of them."""
PARAMETERS_WORTH_FITTING = 2
"""So many parameters are loosened at each step, each for the price of a few simulations."""
LEAST_PROMISE = LEAST_GAIN / 3.0
"""Gain that an effect's signature has to promise: in 150 fits of development cases no effect gained
more than 2.8 times what it had promised."""
MOST_OVER_PROMISE = 3.0
"""No candidate gains more than so many times what it promised, unless its rivals do; see
`LEAST_PROMISE`."""
MOST_LEFT = 2.0
"""... and only one that promises to leave no more than so many times what a rival does."""
SMOOTH = 0.1
"""A misfit worth fewer than this share of its samples is looked into without any promise ..."""
FEW = 0.01
"""... where they are more than this share of all."""


def promising(
    base: Fit,
    signatures: Signatures,
    names: Sequence[str],
    keep: Sequence[str] = (),
    one_sided: Collection[str] = (),
) -> dict[str, float]:
    """Return the candidates that a fit is worth trying with, in the order given, and their promise.

    Parameters
    ----------
    base : Fit
        What they would be added to.
    signatures : mapping
        From `signatures_of`.
    names : sequence of str
        Candidates: effect ids and ``param.`` ids.
    keep : sequence of str, optional
        Candidates that are returned in any case.
    one_sided : collection of str, optional
        Effects whose size cannot be negative: one that would have to be promises nothing.

    Returns
    -------
    dict of str to float
        At most `WORTH_FITTING` effects, and those to keep; none that promises too little to earn
        its place. Of each the larger of both scores.

    Notes
    -----
    A projected score test: the gain that a candidate's signature promises once what the fitted
    parameters absorb, within their tolerances, is taken out of it. Half of them are the best in
    the weights of the fit, the others in those of the noise alone, in which a channel that an
    effect has made to look noisy counts fully.
    """
    as_fitted, as_noise = (
        scores(weighed, signatures, names, one_sided) for weighed in (base, base.in_noise)
    )
    worth = sorted(
        (n for n in names if max(as_fitted[n], as_noise[n]) > _least_promise(n, base)),
        key=as_fitted.__getitem__,
        reverse=True,
    )
    parameters = [name for name in worth if name.startswith("param.")]
    effects = [name for name in worth if not name.startswith("param.")]
    best = {*effects[: WORTH_FITTING // 2], *keep}
    for name in sorted(effects, key=as_noise.__getitem__, reverse=True):
        if len(best) >= WORTH_FITTING + len(keep):
            break
        best.add(name)
    best.update(parameters[:PARAMETERS_WORTH_FITTING])
    return {name: max(as_fitted[name], as_noise[name]) for name in names if name in best}


def within_reach(
    base: Fit, promises: Mapping[str, float], reached: float, by: str
) -> dict[str, float]:
    """Return the candidates that may still explain as much as one of them did, and that one.

    Parameters
    ----------
    base : Fit
        What they are added to.
    promises : mapping of str to float
        From `promising`, or from nominal parameters.
    reached : float
        What has been explained.
    by : str
        The candidate that explained it.

    Notes
    -----
    Where it explained more than it had promised, and had not promised nearly everything, what is
    missing is far from linear, and its rivals may do so too: a delay of the spool promised 12,420
    of 54,440 and gained 30,090, the hose's delay, which it was, 5,560 and 34,640.
    """
    promised = min(reached, promises.get(by, reached))
    near = {n for n, p in promises.items() if n == by or MOST_OVER_PROMISE * p > reached}
    as_near = {n for n, p in promises.items() if MOST_OVER_PROMISE * p > promised}
    if not as_near <= near:
        whole = float(np.sum(base.in_noise.unabsorbed**2))
        left = max(whole - promised, 0.0)
        near |= {n for n in as_near if whole - promises[n] < MOST_LEFT * left}
    return {name: promise for name, promise in promises.items() if name in near}


def promises_count(base: Fit) -> bool:
    """Return whether a fit leaves enough independent samples for a signature to promise anything.

    Parameters
    ----------
    base : Fit
        What candidates would be added to.
    """
    for channel, worth in base.effective.items():
        # So few promise nothing, whatever they hide.
        samples = base.samples_of(channel)
        if FEW * base.samples < samples and worth < SMOOTH * samples:
            return False
    return True


def _least_promise(name: str, base: Fit) -> float:
    if not promises_count(base):
        return 0.0
    return LEAST_DISTANCE / 2.0 if name.startswith("param.") else LEAST_PROMISE


def scores(
    base: Fit, signatures: Signatures, names: Sequence[str], one_sided: Collection[str]
) -> dict[str, float]:
    """Return what the signature of each candidate promises to explain.

    Parameters
    ----------
    base, signatures, names, one_sided
        As for `promising`.
    """
    left = base.unabsorbed

    def score(name: str) -> float:
        if name not in signatures:
            return base.loosened(name.removeprefix("param."), left)
        return gained_beyond(base, signatures[name], [left], name in one_sided)

    return dict(zip(names, side_by_side(score, names), strict=True))
