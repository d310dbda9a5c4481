"""Which effects the recordings call for: hypotheses are added while they earn their place."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pneuservo.diagnosis.controls import chance_gain
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.held_back import HeldBack
from pneuservo.diagnosis.hypotheses import Hypotheses
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import (
    AS_GOOD,
    DECISIVE,
    LARGE_SHARE_OF_REST,
    SECOND_SHARE,
    TIED,
    ByEvidence,
    ByGain,
    Judge,
    gain,
    is_impossible,
)
from pneuservo.diagnosis.ledger import Rival, Step, probabilities
from pneuservo.diagnosis.models import Case
from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.noise import noise_floor
from pneuservo.diagnosis.profile import FORM, RISE, with_profiles
from pneuservo.diagnosis.screen import MOST_OVER_PROMISE, promises_count, within_reach

SUREST = 0.95
"""Largest probability that is claimed: the catalogue never holds everything. (Of 15 names stated
with more in blind trials, 14 were of the right class.)"""
MOST_EFFECTS = 3


@dataclass
class Search(Hypotheses):
    """All that was tried on a set of recordings.

    Parameters
    ----------
    model, cases, progress, seed, jobs, fits
        As of `Hypotheses`.

    Attributes
    ----------
    accepted : list of str
        What the recordings call for: effect ids, and ``param.`` ids of wrong parameters.
    over_chance : dict
        How much more each of them explains than the best candidate would of noise.
    ledger : list of Step
        What was tried, in order.
    interrupted : bool
        Whether the user stopped it before it had tried everything.
    """

    accepted: list[str] = field(default_factory=list)
    ledger: list[Step] = field(default_factory=list)
    interrupted: bool = False
    over_chance: dict[str, float] = field(default_factory=dict)

    @property
    def chosen(self) -> Fit:
        """Return the fit with everything accepted."""
        return self.fitted(self._with(self.accepted))

    @cached_property
    def noise(self) -> list[float]:
        """Return the noise of the judged channel in each recording [SI].

        Where it was not stated it is the floor of the channel or of what the baseline leaves,
        whichever is lower: what the baseline explains, a jump for example, is no noise.
        """
        return [
            _noise_of(case, residual)
            for case, residual in zip(self.cases, self.baseline.residuals, strict=True)
        ]

    @property
    def noise_rms(self) -> float:
        """Return the noise of all recordings together [SI]."""
        return float(np.sqrt(np.mean(np.square(self.noise))))

    def begin(self) -> None:
        """Search for the first of what the recordings call for; `run` goes on from there.

        Raises
        ------
        KeyboardInterrupt
            When not even the baseline is fitted yet.
        """
        with self._kept_when_interrupted():
            self._add(1)

    def run(self) -> None:
        """Search, and keep what has been found when the user interrupts it.

        Raises
        ------
        KeyboardInterrupt
            When not even the baseline is fitted yet.
        """
        if self.interrupted:
            return
        with self._kept_when_interrupted():
            # What was tried in vain would only be tried again.
            if self.accepted or not self.ledger:
                self._add(MOST_EFFECTS)
            self._drop_chance()

    @contextmanager
    def _kept_when_interrupted(self) -> Iterator[None]:
        try:
            yield
        except KeyboardInterrupt:
            if Hypothesis() not in self.fits:
                raise
            self.interrupted = True
            known = [m for m in self.accepted if self._with([m]) in self.fits]
            # Only what has been fitted together can be answered with.
            if self._with(self.accepted) not in self.fits:
                self.accepted[:] = known[:1]

    def _add(self, most: int) -> None:
        """Add the best candidate until none earns its place, or so many have."""
        seen: set[frozenset[str]] = set()
        # What is revised may come back to where it was: then it would go round for ever.
        while (
            len(self.accepted) < most
            and frozenset(self.accepted) not in seen
            and self._worth_going_on
        ):
            seen.add(frozenset(self.accepted))
            self.ended(self._with(self.accepted))
            best = self._best_addition()
            if best is not None:
                self.accepted.append(best)
            elif self._hides_a_pair and (pair := self._best_pair()):
                self.accepted.extend(pair)
            else:
                break
            self._revise()

    def _drop_chance(self) -> None:
        """Drop what chance explains.

        Chance is judged last, by what the final model leaves: while a second effect is still in
        the residual, it would pass for noise and shield the first.
        """
        while self.accepted:
            self.over_chance = {
                member: self._gain_over_chance(member)
                for member in self.accepted
                if not member.startswith("param.")
            }
            weakest = min(self.over_chance, key=self.over_chance.__getitem__, default="")
            if not weakest or self.over_chance[weakest] > 1.0:
                break
            self._drop(weakest, "chance explains as much")

    def _drop(self, member: str, why: str) -> None:
        self.accepted.remove(member)
        self.ledger.append(Step(tuple(self.accepted), "", True, member, why=why))

    def drop_refuted(self, held_back: HeldBack) -> None:
        """Drop what recordings that were held back speak against, the last that was added first.

        Parameters
        ----------
        held_back : HeldBack
            None of them may have been fitted to.
        """
        if not self.model.steady or not held_back.cases or not self.accepted:
            return
        self.progress("asking what was held back about what was found")
        for member in self.accepted[::-1]:
            if held_back.read_with(self.chosen).refute(self._rest(member), self.chosen):
                self._drop(member, "what was held back is predicted worse with it")

    def profile(self) -> None:
        """Take the intervals of what was accepted from their profile likelihood."""
        chosen = self.ended(self._with(self.accepted))
        keys = [key for key in chosen.shared if key.partition(":")[0] in self.accepted]
        if keys:
            self.progress("looking how far the sizes found can go")
            rise = RISE
            if self.model.steady:
                rise += FORM * max(explained(self.baseline, chosen), 0.0)
            self.fits[chosen.hypothesis] = with_profiles(
                self.model, self.cases, chosen, keys, rise, self._at_a_time
            )

    def give_up(self) -> None:
        """Drop every name: something without one explains the recordings better."""
        for member in list(self.accepted):
            self._drop(member, "something without a name explains more")

    @property
    def _worth_going_on(self) -> bool:
        """Return whether more than noise is left; innovations hide a small misfit in theirs."""
        return self.model.steady or self._unexplained(self.chosen) > 0.0

    def rivals(self, member: str) -> list[Rival]:
        """Return what could stand in for an accepted member, most probable first.

        The member itself and its absence (``""``) are among them.
        """
        rest, others = self._in_place_of(member)
        others = {n: f for n, f in others.items() if n == member or not is_impossible(n, f)}
        others[""] = rest
        effective = min(others.values(), key=lambda f: f.rms).effective
        evidence = {name: f.evidence(effective) for name, f in others.items()}
        most = max(explained(rest, f) for f in others.values()) if self.model.steady else 0.0
        probability = probabilities(evidence, 1.0 + AS_GOOD * max(most, 0.0))
        found = [Rival(name, min(probability[name], SUREST), evidence[name]) for name in others]
        return sorted(found, key=lambda rival: rival.evidence)

    def _in_place_of(self, member: str) -> tuple[Fit, dict[str, Fit]]:
        """Return the fit without a member, and with each promising candidate in its place."""
        kept = [m for m in self.accepted if m != member]
        if self.interrupted:
            return self._in_place_of_so_far(kept)
        rest = self.fitted(self._with(kept))
        promises = self._promises(rest, self._compatible(kept), keep=(member,))
        needed = explained(rest, self.chosen)
        near = within_reach(rest, promises, needed, member)
        return rest, self._fitted_with(rest, near, needed)

    def _in_place_of_so_far(self, kept: Sequence[str]) -> tuple[Fit, dict[str, Fit]]:
        """Return the same from what had been fitted when the search was interrupted."""
        rest = self.fits.get(self._with(kept), self.baseline)
        names = [n for n in self.candidates if rest.hypothesis.adding(n) in self.fits]
        return rest, {name: self.fits[rest.hypothesis.adding(name)] for name in names}

    def _gain_over_chance(self, member: str) -> float:
        """Return how much more a member explains than the best candidate would of noise."""
        rest, others = self._in_place_of(member)
        chosen = self.chosen
        directions = [found.sensitivities(name) for name, found in others.items()]
        noise = [
            r / chosen.scale[c] for r, c in zip(chosen.residuals, chosen.channels, strict=True)
        ]
        chance = chance_gain(rest.jacobian, directions, noise, self.seed)
        return explained(rest, chosen) / chance if chance > 0.0 else float("inf")

    def _revise(self) -> None:
        """Swap or drop what was accepted early and is no longer the best in its place."""
        for member in list(self.accepted[:-1]):
            best = self._better_than(member)
            if best is not None and self._fits_closer_from(self._rest(member)):
                best = self._better_than(member)
            if best is None:
                continue
            place = self.accepted.index(member)
            self.accepted[place : place + 1] = [best.candidate] if best.candidate else []
            self.ledger.append(Step(tuple(self.accepted), best.candidate, True, member))

    def _better_than(self, member: str) -> Rival | None:
        """Return what is clearly better in the place of a member, if anything."""
        found = self.rivals(member)
        own = next(rival for rival in found if rival.candidate == member)
        absent = next(rival for rival in found if not rival.candidate)
        limit = own.evidence - self._margin(member)
        better = [rival for rival in found if rival.evidence < limit]
        return next((r for r in better if self._may_replace(member, r, absent)), None)

    def _fits_closer_from(self, rest: Fit) -> bool:
        """Fit what is accepted from where its rivals began; return whether that is closer.

        What was fitted in another order may have come to rest in another minimum.
        """
        if not self.model.steady:
            return False
        again = fit(self.model, self.cases, self.chosen.hypothesis, rest)
        closer = explained(self.chosen, again) > 0.0
        if closer:
            self.fits[again.hypothesis] = again
        return closer

    def _margin(self, member: str) -> float:
        """Return by how much a rival has to be better: what decided for a member still stands."""
        if not self.model.steady:
            return TIED
        return max(TIED, AS_GOOD * explained(self._rest(member), self.chosen))

    def _may_replace(self, member: str, rival: Rival, absent: Rival) -> bool:
        """Return whether a rival earns its place where a member would leave it."""
        if not self.model.steady or not rival.candidate:
            return True
        rest = self._rest(member)
        drop = absent.evidence - rival.evidence
        closer = self.fitted(rest.hypothesis.adding(rival.candidate), rest)
        return self._judge(rest).earns(rival.candidate, closer, drop)

    def _judge(self, current: Fit) -> Judge:
        """Return what decides over additions to a fit."""
        if self.model.steady:
            return ByGain(
                current,
                self.baseline,
                self.model.effects,
                lambda name, closer: self.pretence.of(name, current, closer),
            )
        found = (self._unexplained(self.baseline), self._unexplained(current))
        return ByEvidence(current, self.candidates, *found)

    def _compatible(self, accepted: Sequence[str]) -> list[str]:
        """Return the candidates that may be added to some others."""
        group = {effect.id: effect.group for effect in self.model.effects}
        present = [*accepted, *self.cases[0].rig.effects]
        taken = {group.get(name, "") for name in present} - {""}
        return [
            name
            for name in self.candidates
            if name not in accepted and group.get(name, "") not in taken
        ]

    def _rest(self, member: str) -> Fit:
        """Return the fit with everything accepted but a member."""
        return self.fitted(self._with([m for m in self.accepted if m != member]))

    def _with(self, members: Sequence[str]) -> Hypothesis:
        hypothesis = Hypothesis()
        for member in members:
            hypothesis = hypothesis.adding(member)
        return hypothesis

    def unexplained_share(self, found: Fit) -> float:
        """Return what a fit leaves beyond noise, as a share of what the baseline leaves."""
        return self._unexplained(found) / max(self._unexplained(self.baseline), 1e-300)

    def share(self, member: str) -> float:
        """Return the share of the mismatch that an accepted member explains beside the others."""
        rest = self._rest(member)
        return self.unexplained_share(rest) - self.unexplained_share(self.chosen)

    def _unexplained(self, found: Fit) -> float:
        """Return the sum of squares beyond noise."""
        noise = sum(len(r) * noise**2 for r, noise in zip(found.residuals, self.noise, strict=True))
        return max(0.0, found.samples * found.rms**2 - noise)

    @property
    def _hides_a_pair(self) -> bool:
        """Return whether two effects may be at work though no single one earned its place."""
        return not self.accepted and not self.model.steady

    def _best_pair(self) -> tuple[str, str] | None:
        """Return two candidates that are decisive together though neither is alone.

        What the second explains may be so slow that the first, alone, leaves next to no
        independent samples to be judged by.
        """
        alone = self.ledger[-1].candidate
        first = self.fitted(self._with([alone]))
        tried = self._fitted_with(first, self._promises(first, self._compatible([alone])))
        if not tried:
            return None
        name = min(tried, key=lambda candidate: tried[candidate].rms)
        effective = tried[name].effective
        drop = self.baseline.evidence(effective) - tried[name].evidence(effective)
        share = 1.0 - self.unexplained_share(tried[name])
        earned = drop > 2.0 * DECISIVE and share > LARGE_SHARE_OF_REST
        rms = {f"{alone} + {n}": found.rms for n, found in tried.items()}
        self.ledger.append(Step((alone,), name, earned, evidence_drop=drop, share=share, rms=rms))
        return (alone, name) if earned else None

    def _best_addition(self) -> str | None:
        current = self.chosen
        judge = self._judge(current)
        names = self._compatible(self.accepted)
        if self.model.steady:
            self.pretence.work_out_beside(current)
        promises = self._promises(current, names)
        if promises_count(current):
            promises = {
                name: promise
                for name, promise in promises.items()
                if MOST_OVER_PROMISE * promise > judge.least(name)
            }
        tried = self._best_fitted(current, names, promises, judge.barred)
        if not tried:
            return None
        tried = self._best_ended(current, tried, judge)
        effective = min(tried.values(), key=lambda f: f.rms).effective
        evidence = {name: f.evidence(effective) for name, f in tried.items()}
        drop = {name: current.evidence(effective) - value for name, value in evidence.items()}
        earning = [name for name in tried if judge.earns(name, tried[name], drop[name])]
        name = judge.first_choice(evidence, tried, earning)
        self.ledger.append(
            Step(
                current.hypothesis.members,
                name,
                name in earning,
                evidence_drop=drop[name],
                share=judge.share(tried[name]),
                rms={n: f.rms for n, f in tried.items()},
            )
        )
        return name if name in earning else None

    def alike(self, member: str) -> list[str]:
        """Return the effects that, in place of a member, explain nearly as much of the mismatch.

        Laws in a catalogue are not quite those of the real thing: what they leave to choose
        between two of them by is no more than that. Only for a model with steady sensitivities.
        """
        if not self.model.steady:
            return []
        rest, others = self._in_place_of(member)
        own = gain(rest, others[member])
        return [
            name
            for name, found in others.items()
            if name != member
            and not name.startswith("param.")
            and gain(rest, found) > (1.0 - SECOND_SHARE) * own
        ]


def _noise_of(case: Case, residual: Array) -> float:
    """Return the noise of the judged channel [unit of the case]."""
    if not case.recorded:
        return case.noise_rms
    stated = case.recording.noise_rms.get(case.channel, 0.0) / case.scale
    floor = noise_floor(residual, case.recording.time[case.usable]) if not stated else 0.0
    return stated or max(min(case.noise_rms, floor), case.resolution)
