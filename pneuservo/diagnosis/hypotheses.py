"""Hypotheses fitted to recordings, each once, and which of them are worth a fit."""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from heapq import nlargest
from threading import Lock
from typing import Any

from pneuservo.diagnosis.fit import Fit, explained, gained_most, misses_more
from pneuservo.diagnosis.fitting import fit, polished
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import DECISIVE, LEAST_GAIN, SECOND_SHARE, Judge
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.pretence import FAR, Pretence
from pneuservo.diagnosis.screen import promising, within_reach
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.starts import Begin
from pneuservo.diagnosis.strained import far_out, is_strained, leaves_noise, promises_from_nominal

FITTED_FIRST = 2
"""So many candidates are fitted before the others are asked whether they can still catch up."""
LEAST_KEPT = 0.5
"""Share of its promise that a fit has to keep: where it does not, the sensitivities that it took
over from the fit before may have led it nowhere. (An elastic joint promised 83 and gained 7 with
those, 88 with its own.)"""
ALMOST = 0.5
"""Share of the least that they have to explain from which the best candidates are carried to their
ends before they are judged. (A hysteresis promised 32, gained 31, and 56 at its end.)"""


@dataclass
class Hypotheses:
    """What has been fitted to a set of recordings.

    Parameters
    ----------
    model : Model
        The rig's model.
    cases : sequence of Case
        Prepared recordings.
    progress : callable, optional
        Told what is being fitted.
    seed : int, optional
        Seed of the noise that chance is judged by.
    fits : dict, optional
        Every hypothesis fitted so far.

    Attributes
    ----------
    may_guess : bool
        Whether parameters that stay strained are believed for the time being.
    guessed : bool
        Whether they were: another effect may have strained them than the one that seems the best.
    """

    model: Model
    cases: Sequence[Case]
    progress: Callable[[str], None] = lambda step: None
    seed: int = 0
    fits: dict[Hypothesis, Fit] = field(default_factory=dict)
    may_guess: bool = False
    guessed: bool = False
    _promising: dict[Any, dict[str, float]] = field(default_factory=dict)
    _hopeless: dict[str, list[Hypothesis]] = field(default_factory=dict)
    """Candidates beside which the fit ended worse than without them."""
    _ended: set[Hypothesis] = field(default_factory=set)
    _bookkeeping: Lock = field(default_factory=Lock, repr=False)
    _from_nominal: Mapping[str, float] | None = None
    """What effects promise if parameters that are strained are nominal after all, once asked."""

    @property
    def baseline(self) -> Fit:
        """Return the baseline with its own parameters re-fitted."""
        return self.fitted(Hypothesis())

    @cached_property
    def pretence(self) -> Pretence:
        """Return what the method itself pretends, for a model whose sensitivities are steady."""
        return Pretence(self.model, self.cases, self.baseline, self.progress, self.seed)

    def _promises(
        self, base: Fit, names: Sequence[str], keep: Sequence[str] = ()
    ) -> Mapping[str, float]:
        """Return what the candidates that are worth a fit beside a base promise to explain.

        Where sensitivities are not steady nothing is known beforehand, and all are worth it.
        """
        if not self.model.steady:
            return dict.fromkeys(names, math.inf)
        asked = (base.hypothesis, tuple(names), tuple(keep))
        if asked not in self._promising:
            self._promising[asked] = promising(
                base, self.pretence.signatures_beside(base), names, keep, self._one_sided
            )
        found = dict(self._promising[asked])
        if base is self.baseline and self._from_nominal:
            found |= {name: max(p, found.get(name, 0.0)) for name, p in self._from_nominal.items()}
        return {
            name: found[name]
            for name in names
            if name in found and (name in keep or not self._is_hopeless(name, base))
        }

    def _is_hopeless(self, name: str, base: Fit) -> bool:
        """Return whether a candidate has made worse what a base began with."""
        return any(
            tried.effects <= base.hypothesis.effects for tried in self._hopeless.get(name, [])
        )

    @cached_property
    def _one_sided(self) -> frozenset[str]:
        """Return the effects whose size cannot be negative."""
        return frozenset(e.id for e in self.model.effects if e.parameters[0].low >= 0.0)

    @property
    def candidates(self) -> list[str]:
        """Return every effect of the rig and every tolerated parameter."""
        rig = self.cases[0].rig
        tolerated = [
            f"param.{key}"
            for key in self.model.fitted_to(self.cases)
            if rig.parameters[key].tolerance and not rig.parameters[key].free
        ]
        present = rig.effects
        return [*(e.id for e in self.model.effects if e.id not in present), *tolerated]

    def fitted(self, hypothesis: Hypothesis, near: Fit | None = None) -> Fit:
        """Return the fit of a hypothesis, fitted once."""
        if hypothesis not in self.fits:
            self.progress("fitting " + (" + ".join(hypothesis.members) or "the baseline"))
            near = near or self._nearest(hypothesis)
            self.fits[hypothesis] = fit(self.model, self.cases, hypothesis, near)
        return self.fits[hypothesis]

    def _nearest(self, hypothesis: Hypothesis) -> Fit | None:
        """Return the fit of most of a hypothesis, for a model with steady sensitivities.

        From scratch it might end on the other side of a ridge.
        """
        if not self.model.steady:
            return None
        parts = [found for tried, found in tuple(self.fits.items()) if tried.is_part_of(hypothesis)]
        # Of several as large, one that does not depend on which was fitted first.
        return max(
            parts,
            key=lambda found: (len(found.hypothesis.members), found.hypothesis.members),
            default=None,
        )

    def _fitted_with(
        self, base: Fit, promises: Mapping[str, float], reached: float = 0.0, again: bool = False
    ) -> dict[str, Fit]:
        """Return the fits of a base with each of some candidates added.

        What promises far less than what has been reached is not worth a second try, nor what has
        been fitted already, unless it is to be tried again for a promise that it has made since.
        """

        def add(name: str) -> Fit:
            hypothesis = base.hypothesis.adding(name)
            return self._keeping(promises[name], base, hypothesis, reached, again)

        names = list(promises)
        found = dict(zip(names, side_by_side(add, names), strict=True))
        for name, closer in found.items():
            if self.model.steady and explained(base, closer) < -DECISIVE:
                self._hopeless.setdefault(name, []).append(base.hypothesis)
            elif again:
                self._hopeless.pop(name, None)
        return found

    def _keeping(
        self,
        promise: float,
        base: Fit,
        hypothesis: Hypothesis,
        reached: float,
        again: bool = False,
    ) -> Fit:
        """Return the fit of a hypothesis, carried to its end where it breaks what it promised."""
        known = hypothesis in self.fits and not again
        found = self.fitted(hypothesis, base)
        # Where sensitivities are not steady nothing was promised.
        if known or math.isinf(promise) or promise <= max(LEAST_GAIN, LEAST_KEPT * reached):
            return found
        for begin in (Begin.ALONE, Begin.NOMINAL, Begin.IN_NOISE):
            more = misses_more(base, found)
            if not more and gained_most(base, found) >= LEAST_KEPT * promise:
                break
            if begin is Begin.IN_NOISE and not (more or again):
                break
            other = fit(self.model, self.cases, hypothesis, base, begin=begin)
            if again and begin is Begin.IN_NOISE:
                # Counted in noise it may leave more at first than it does at its end.
                other = polished(self.model, self.cases, other)
            if explained(found, other) > 0.0:
                self._replace_fit(hypothesis, other)
            found = self.ended(hypothesis)
        return found

    def ended(self, hypothesis: Hypothesis) -> Fit:
        """Return a fit carried to its end with sensitivities of its own, for a steady model.

        What stopped short would be explained by the next effect, whatever that is.
        """
        found = self.fitted(hypothesis)
        if not self.model.steady or not hypothesis.effects or hypothesis in self._ended:
            return found
        again = polished(self.model, self.cases, found)
        if explained(found, again) > 0.0:
            self._replace_fit(hypothesis, again)
        self._ended.add(hypothesis)
        return self.fits[hypothesis]

    def _replace_fit(self, hypothesis: Hypothesis, closer: Fit) -> None:
        """Put a closer fit in the place of one, and forget what was made of that if it is far off.

        In another minimum other effects are missing, and what was fitted from the old one may leave
        more than the new one alone: beside a lag that had been 0.2 ms, and was 0.41 as soon as a
        delay had shown the way, a leak at null "explained" minus 8,000.
        """
        # Fits that are done beside each other may be replaced at the same time.
        with self._bookkeeping:
            before, self.fits[hypothesis] = self.fits[hypothesis], closer
            self._ended.discard(hypothesis)
            if explained(before, closer) >= FAR:
                self._forget_what_came_of(hypothesis, closer)

    def _forget_what_came_of(self, hypothesis: Hypothesis, closer: Fit) -> None:
        self.pretence.forget(hypothesis)
        self._promising = {a: p for a, p in self._promising.items() if a[0] != hypothesis}
        for name, tried in self._hopeless.items():
            self._hopeless[name] = [h for h in tried if h != hypothesis]
        for other, found in tuple(self.fits.items()):
            larger = hypothesis.is_part_of(other) and other != hypothesis
            if larger and explained(closer, found) < 0.0:
                # A fit that is done beside this one may have dropped it already.
                self.fits.pop(other, None)
                self._ended.discard(other)

    def _best_fitted(
        self,
        base: Fit,
        names: Sequence[str],
        promises: Mapping[str, float],
        barred: Callable[[str, Fit], bool],
    ) -> dict[str, Fit]:
        """Return the fits of a base with each of some candidates that may turn out the best.

        What has promised most is fitted first; the others have to promise enough to reach it,
        unless it is barred. Where parameters of the base are strained, and stay so or more than
        noise stays, what may have strained them as well.
        A parameter that is far out is fitted with the first: what reaches farther may not earn its
        place. (Under a relay a presliding promised 870 of a friction that was 14 tolerances off.)
        """
        first = nlargest(FITTED_FIRST, promises, key=promises.__getitem__)
        if self.model.steady and base is self.baseline:
            first += [name for name in far_out(base) if name in promises]
        found = self._fitted_with(base, {name: promises[name] for name in first})
        best, reached = best_of(base, found, barred)
        near = within_reach(base, promises, reached, best)
        found |= self._fitted_with(base, {n: p for n, p in near.items() if n not in found}, reached)
        if self.model.steady and base is self.baseline:
            # A parameter that is let go is strained no more, whatever strained it.
            effects = {n: closer for n, closer in found.items() if not n.startswith("param.")}
            best, reached = best_of(base, effects, barred)
            closest = effects.get(best, base)
            self.guessed = self.may_guess and is_strained(closest)
            if is_strained(base) and not self.guessed and not self._settles(closest):
                hidden = self._promised_from_nominal(names)
                found |= self._fitted_with(base, hidden, reached, again=True)
        return {name: found[name] for name in names if name in found}

    def _settles(self, closest: Fit) -> bool:
        """Return whether a fit leaves no parameter strained, and no more than noise."""
        noise = [1.0] * len(self.cases)
        return not is_strained(closest) and leaves_noise(self.cases, closest, noise)

    def _promised_from_nominal(self, names: Sequence[str]) -> Mapping[str, float]:
        """Return which of some effects may have strained the parameters of the baseline."""
        if self._from_nominal is None:
            self.progress("working out what each effect would change at nominal parameters")
            self._from_nominal = promises_from_nominal(
                self.model, self.cases, self.baseline, names, self._one_sided
            )
        return self._from_nominal

    def _best_ended(self, base: Fit, tried: Mapping[str, Fit], judge: Judge) -> dict[str, Fit]:
        """Return fits, those that may decide carried to their ends: the best and those like it."""
        explains = {name: explained(base, closer) for name, closer in tried.items()}
        may_be = [name for name, closer in tried.items() if not judge.barred(name, closer)]
        near = (1.0 - SECOND_SHARE) * max((explains[name] for name in may_be), default=0.0)
        least = {name: max(ALMOST * judge.least(name), near) for name in tried}
        return self._ended_of(tried, [name for name in tried if explains[name] > least[name]])

    def _ended_of(self, found: Mapping[str, Fit], names: Collection[str]) -> dict[str, Fit]:
        """Return fits, those of some candidates carried to their ends."""
        asked = [name for name in found if name in names]
        ended = side_by_side(lambda name: self.ended(found[name].hypothesis), asked)
        return {**found, **dict(zip(asked, ended, strict=True))}


def best_of(
    base: Fit, found: Mapping[str, Fit], barred: Callable[[str, Fit], bool]
) -> tuple[str, float]:
    """Return the candidate that gains most and what it gains; none if nothing does.

    Parameters
    ----------
    base : Fit
        What they were added to.
    found : mapping of str to Fit
        Fits with each of them.
    barred : callable
        From `Judge.barred`.
    """
    gains = {n: gained_most(base, closer) for n, closer in found.items() if not barred(n, closer)}
    best = max(gains, key=gains.__getitem__, default="")
    return (best, gains[best]) if gains.get(best, 0.0) > 0.0 else ("", 0.0)
