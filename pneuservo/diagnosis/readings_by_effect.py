"""What an effect would make of the ways to read recordings: something late looks like one."""

from collections.abc import Callable, Collection, Mapping, Sequence
from heapq import nlargest

from pneuservo.diagnosis.fit import Fit, gained_most
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.readings import Reading
from pneuservo.diagnosis.screen import MOST_OVER_PROMISE, scores
from pneuservo.diagnosis.signatures import signatures_of
from pneuservo.diagnosis.ways import Cases
from pneuservo.effects.effect import Effect

_WORTH_FITTING = 2
"""So many effects, those that promise most, are fitted to a way of reading."""
_WORTH_ASKING = 2
"""So many other ways of reading, the likeliest, are asked for what any effect would explain."""


def likelier_if_late(
    model: Model, ranked: Sequence[Reading], progress: Callable[[str], None]
) -> Reading | None:
    """Return the reading that something late would make likelier than the first, if there is one.

    Parameters
    ----------
    model : Model
        What is fitted.
    ranked : sequence of Reading
        From `ranked_readings`.
    progress : callable
        Told what is being worked out.

    Notes
    -----
    A command that runs on acts half a sample later than one that is held, and is less sure: read
    so, a spool or a hose that is late hardly shows. (A motor too weak for its spool promised 358
    where the command ran on and 15,900 where it was held, which was less likely by 9,800.) Only
    what stands still and jumps is asked: read as held, the command of an analogue loop comes half a
    sample early, and whatever is late would mend that.
    """
    first = ranked[0]
    others = [
        other
        for other in ranked[1:]
        if other.baseline
        and _misfit(other.baseline) > other.deviance - first.deviance
        and all(model.stored(case) for case in _read_otherwise(other.cases, first.cases))
    ]
    if not others:
        return None
    progress("asking what something late would make of the ways to read the recordings")
    late = [effect for effect in model.effects if effect.block in model.late]
    promises = {id(reading): _promised(model, reading, late) for reading in others}
    near = [
        other
        for other in others
        if MOST_OVER_PROMISE * max(promises[id(other)].values(), default=0.0)
        > other.deviance - first.deviance + LEAST_GAIN
    ]
    if not near:
        return None
    promises[id(first)] = _promised(model, first, late)
    tried = (first, *near)
    deviance = [
        reading.deviance - _explained(model, reading, promises[id(reading)]) for reading in tried
    ]
    best = min(range(len(tried)), key=deviance.__getitem__)
    return tried[best] if deviance[best] < deviance[0] - LEAST_GAIN else None


def likelier_with_another(
    model: Model,
    ranked: Sequence[Reading],
    baseline: Fit,
    found: Fit,
    progress: Callable[[str], None],
) -> Reading | None:
    """Return the reading that an effect makes likelier than any makes the first, if there is one.

    Parameters
    ----------
    model : Model
        What is fitted.
    ranked : sequence of Reading
        From `ranked_readings`.
    baseline, found : Fit
        Of the first, without an effect and with what explains most, whether it was named or not.
    progress : callable
        Told what is being worked out.

    Notes
    -----
    For where more than noise is left. (A pressure that picked up the command of two sampled loops
    was least unlikely where one of them ran on, and friction that lags was found there, which left
    1.2 times the noise; where both are held its own name explains fifteen times as much.)
    """
    reached = ranked[0].deviance - gained_most(baseline, found)
    others = [
        other
        for other in ranked[1:]
        if other.baseline and other.deviance - _misfit(other.baseline) < reached - LEAST_GAIN
    ]
    if not others:
        return None
    progress("asking what other effects would make of the ways to read the recordings")
    likeliest, best = reached - LEAST_GAIN, None
    for other in others[:_WORTH_ASKING]:
        promises = _promised(model, other, model.effects)
        if other.deviance - max(promises.values(), default=0.0) < likeliest:
            deviance = other.deviance - _explained(model, other, promises)
            if deviance < likeliest:
                likeliest, best = deviance, other
    return best


def _read_otherwise(one: Cases, other: Cases) -> list[Case]:
    """Return the cases of recordings that are not read in the same way."""
    same = {id(case) for case in other}
    return [case for case in one if id(case) not in same]


def _misfit(baseline: Fit) -> float:
    """Return the sum of squares beyond noise, which is what an effect may explain at most."""
    return sum(max(float(r @ r) - len(r), 0.0) for r in baseline.residuals)


def _promised(model: Model, reading: Reading, effects: Collection[Effect]) -> dict[str, float]:
    """Return what each of some effects promises to explain, in noise."""
    if reading.baseline is None:
        return {}
    base = reading.baseline.in_noise
    signatures = signatures_of(model, reading.cases, base, list(effects))
    one_sided = {effect.id for effect in effects if effect.parameters[0].low >= 0.0}
    return scores(base, signatures, list(signatures), one_sided)


def _explained(model: Model, reading: Reading, promises: Mapping[str, float]) -> float:
    """Return the most that one of some effects explains, of the two that promise most."""
    baseline = reading.baseline
    if baseline is None:
        return 0.0
    best = nlargest(_WORTH_FITTING, promises, key=promises.__getitem__)
    return max(
        (
            gained_most(
                baseline, fit(model, reading.cases, baseline.hypothesis.adding(name), baseline)
            )
            for name in best
            if MOST_OVER_PROMISE * promises[name] > LEAST_GAIN
        ),
        default=0.0,
    )
