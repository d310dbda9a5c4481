"""Which effects the recordings call for: hypotheses are added while they earn their place."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from heapq import nlargest

from pneuservo.diagnosis.by_gain import LEAST_ELSEWHERE
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.held_back import HeldBack
from pneuservo.diagnosis.hypotheses import FITTED_FIRST, best_of
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import (
    DECISIVE,
    FORM,
    LARGE_SHARE_OF_REST,
    LEAST_DISTANCE,
    LEAST_GAIN,
    Judge,
    is_impossible,
    weighed,
)
from pneuservo.diagnosis.ledger import Step
from pneuservo.diagnosis.pretence import FAR
from pneuservo.diagnosis.profile import RISE, with_profiles
from pneuservo.diagnosis.rivals import Rivals
from pneuservo.diagnosis.screen import MOST_OVER_PROMISE, promises_count, scores
from pneuservo.diagnosis.strained import MANY_WRONG, is_strained, out_of_tolerance
from pneuservo.effects import CATALOGUE

UNKNOWN_BETWEEN_SAMPLES = "what the command did between its samples is not known"
MOST_EFFECTS = 3


@dataclass
class Search(Rivals):
    """All that was tried on a set of recordings.

    Parameters
    ----------
    model, cases, progress, seed, fits
        As of `Hypotheses`.

    Attributes
    ----------
    accepted, ledger, interrupted
        As of `Accepted`.
    over_chance : dict
        How much more each of what was accepted explains than the best candidate would of noise.
    """

    over_chance: dict[str, float] = field(default_factory=dict)

    def begin(self, guess: bool = False) -> None:
        """Search for the first of what the recordings call for; `run` goes on from there.

        Parameters
        ----------
        guess : bool, optional
            Whether what is found may be a guess, see `guessed`; with nothing found it is none.

        Raises
        ------
        KeyboardInterrupt
            When not even the baseline is fitted yet.
        """
        with self.kept_when_interrupted():
            self._begin(guess)
            if self.guessed and not self.accepted:
                self._begin(guess=False)

    def _begin(self, guess: bool) -> None:
        self.accepted.clear()
        self.ledger.clear()
        self.may_guess, self.guessed = guess, False
        self._add(1)
        # What is looked for later, from the baseline again or not, is no guess.
        self.may_guess = False

    def first_guess(self) -> Fit | None:
        """Return the baseline with one of what promises most, if that explains far more than noise.

        Raises
        ------
        KeyboardInterrupt
            When the user interrupts it; what has been fitted is kept.
        """
        base = self.baseline
        judge = self._judge(base)
        promises = self._worth_fitting(base, self.compatible([]), judge)
        best = nlargest(FITTED_FIRST, promises, key=promises.__getitem__)
        found = self._fitted_with(base, {name: promises[name] for name in best})
        name, gained = best_of(base, found, judge.barred)
        return found[name] if gained > FAR else None

    def run(self) -> None:
        """Search, and keep what has been found when the user interrupts it.

        Raises
        ------
        KeyboardInterrupt
            When not even the baseline is fitted yet.
        """
        if self.interrupted:
            return
        with self.kept_when_interrupted():
            settled: set[frozenset[str]] = set()
            # What was tried in vain would only be tried again.
            while self.accepted or not self.ledger:
                self._add(MOST_EFFECTS)
                if not self._drop_chance() or frozenset(self.accepted) in settled:
                    break
                # Where one had to go the others may do its work, and leave room for another.
                settled.add(frozenset(self.accepted))

    def go_on_with(self, other: "Search") -> None:
        """Hold what was found against its rivals here, and search for more.

        Parameters
        ----------
        other : Search
            In recordings followed otherwise; what it has accepted has been fitted here.
        """
        if other.accepted:
            self.accepted[:], self.ledger[:] = other.accepted, other.ledger
        with self.kept_when_interrupted():
            self._revise()
        self.run()

    @contextmanager
    def kept_when_interrupted(self) -> Iterator[None]:
        """Keep what has been found where the user interrupts what is done in this context.

        Raises
        ------
        KeyboardInterrupt
            When not even the baseline is fitted yet.
        """
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
        seen: dict[frozenset[str], Fit] = {}
        # What is revised may come back to where it was: then it would go round for ever.
        while len(self.accepted) < most and self._worth_going_on:
            members = frozenset(self.accepted)
            if seen.get(members) is self.ended(self._with(self.accepted)):
                break
            seen[members] = self.chosen
            best = self._best_addition()
            if best is not None:
                self.accepted.append(best)
            elif self._hides_a_pair and (pair := self._best_pair()):
                self.accepted.extend(pair)
            else:
                break
            self._revise()

    def _drop_chance(self) -> bool:
        """Drop what chance explains; return whether something was.

        Chance is judged last, by what the final model leaves: while a second effect is still in
        the residual, it would pass for noise and shield the first.
        """
        before = len(self.accepted)
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
        return len(self.accepted) < before

    def name_wrong_parameters(self) -> None:
        """Name parameters that are out of their tolerance, where nothing else was found.

        They cost little to explain recordings with, so that setting them free hardly explains more.
        None is named where there are many, or where one of them cannot be it; nor are two that one
        effect would make seem so, which is named instead, also beside others.
        """
        if not self.leaves_noise(self.chosen) or not self.are_judged(self.chosen):
            return
        if self.accepted:
            self._name_one_cause_beside()
            return
        while wrong := out_of_tolerance(self.chosen):
            current, name = self.chosen, f"param.{wrong[0]}"
            if len(self.accepted) + 1 >= MANY_WRONG or not self._may_be_wrong(name):
                self.give_up(f"{name} had to go too: they make up for something else")
                break
            free = self.ended(current.hypothesis.adding(name))
            self.accepted.append(name)
            drop = current.information_criterion(free.effective) - free.information_criterion(
                free.effective
            )
            step = Step(current.hypothesis.members, name, True, criterion_drop=drop, share=0.0)
            self.ledger.append(step)
        several = self.chosen
        if (
            self.accepted
            and len(out_of_tolerance(self.baseline)) > 1
            and (cause := self.one_cause_instead(self.baseline, several))
        ):
            self.give_up(f"{cause} alone explains as much")
            self._name(cause, 0.0)

    def _name_one_cause_beside(self) -> None:
        """Name, beside others, one effect that makes two parameters or more seem wrong."""
        chosen = self.chosen
        wrong = out_of_tolerance(chosen)
        if len(wrong) < 2:
            return
        free = self._with([*self.accepted, *(f"param.{name}" for name in wrong)])
        if cause := self.one_cause_instead(chosen, self.ended(free)):
            self._name(cause, 0.0)

    def _name(self, effect: str, share: float) -> None:
        """Name an effect beside what was found for less than would have earned its place."""
        members, rest = tuple(self.accepted), self.chosen
        self.accepted.append(effect)
        found = self.chosen
        drop = rest.information_criterion(found.effective) - found.information_criterion(
            found.effective
        )
        self.ledger.append(Step(members, effect, True, criterion_drop=drop, share=share))

    def _may_be_wrong(self, name: str) -> bool:
        """Return whether setting a parameter free leaves it possible, and noise."""
        free = self.ended(self.chosen.hypothesis.adding(name))
        return not is_impossible(name, free) and self.leaves_noise(free)

    def name_what_relieves(self, held_back: HeldBack) -> None:
        """Name an effect that mostly relieves strained parameters where what was held back says so.

        What strained them may be any of them. Where it is an effect that was absorbed they are
        wrong elsewhere, and it explains that, too.

        Parameters
        ----------
        held_back : HeldBack
            None of them may have been fitted to.
        """
        if not held_back.cases or not is_strained(self.baseline):
            return
        judge, chosen = self._judge(self.baseline), self.chosen
        gains = {
            name: explained(chosen, self.fits[alone])
            for name in self.candidates
            if name in CATALOGUE
            and (alone := self._with([name])) in self.fits
            and judge.only_relieves(name, self.fits[alone])
        }
        best = max(gains, key=gains.__getitem__, default="")
        if gains.get(best, 0.0) <= LEAST_GAIN:
            return
        self.progress(f"asking what was held back about {best}")
        found = self.ended(self._with([best]))
        if held_back.are_predicted_worse(found, chosen, LEAST_GAIN):
            self.give_up(f"what was held back is predicted far better with {best}")
            self._name(best, judge.share(found))

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
            rest = self._rest(member)
            if member.removeprefix("param.") in out_of_tolerance(rest):
                # Without the name it is as wrong.
                continue
            if held_back.refute(rest, self.chosen):
                self._drop(member, "what was held back is predicted worse with it")

    def drop_what_was_only_followed(self) -> None:
        """Drop what shows in no recording but those of which nobody knows what drove them.

        A loop that chatters between the samples of its command does what no effect does.
        """
        if self.are_judged(self.chosen):
            return
        for member in self.accepted[::-1]:
            least = LEAST_DISTANCE if member.startswith("param.") else LEAST_GAIN
            if self.gained_where_judged(self._rest(member), self.chosen) < least:
                self._drop(member, UNKNOWN_BETWEEN_SAMPLES)

    def profile(self) -> None:
        """Take the intervals of what was accepted from their profile likelihood."""
        chosen = self.ended(self._with(self.accepted))
        keys = [key for key in chosen.shared if key.partition(":")[0] in self.accepted]
        if keys:
            self.progress("looking how far the sizes found can go")
            rise = RISE
            if self.model.steady:
                rise += FORM * max(explained(self.baseline, chosen), 0.0)
            self.fits[chosen.hypothesis] = with_profiles(self.model, self.cases, chosen, keys, rise)

    def give_up(self, why: str) -> None:
        """Drop every name.

        Parameters
        ----------
        why : str
            As the report says it.
        """
        for member in list(self.accepted):
            self._drop(member, why)

    @property
    def _worth_going_on(self) -> bool:
        """Return whether more than noise is left; innovations hide a small misfit in theirs."""
        return self.model.steady or self.beyond_noise(self.chosen) > 0.0

    @property
    def _hides_a_pair(self) -> bool:
        """Return whether two effects may be at work though no single one earned its place."""
        return not self.accepted and not self.model.steady

    def _best_pair(self) -> tuple[str, str] | None:
        """Return two candidates that are decisive together though neither is alone.

        What the second explains may be so slow that the first, alone, leaves next to no
        independent samples to be judged by.
        """
        if not self.ledger:
            # Nothing could be added to what the rig holds already.
            return None
        alone = self.ledger[-1].candidate
        first = self.fitted(self._with([alone]))
        tried = self._fitted_with(first, self._promises(first, self.compatible([alone])))
        if not tried:
            return None
        name = min(tried, key=lambda candidate: tried[candidate].rms)
        effective = tried[name].effective
        drop = self.baseline.information_criterion(effective) - tried[name].information_criterion(
            effective
        )
        share = 1.0 - self.unexplained_share(tried[name])
        earned = drop > 2.0 * DECISIVE and share > LARGE_SHARE_OF_REST
        rms = {f"{alone} + {n}": found.rms for n, found in tried.items()}
        self.ledger.append(Step((alone,), name, earned, criterion_drop=drop, share=share, rms=rms))
        return (alone, name) if earned else None

    def _promised_elsewhere(self, current: Fit) -> dict[str, float]:
        """Return what effects promise that no other form of what has been found would explain.

        The two that promise most: others explain more of what forms leave, and would keep them out.
        """
        if not self.model.steady or explained(self.baseline, current) < FAR:
            return {}
        names = [n for n in self.compatible(self.accepted) if n in CATALOGUE]
        signatures = self.pretence.signatures_beside(current)
        found = scores(self._bendable(current), signatures, names, self._one_sided)
        best = nlargest(FITTED_FIRST, found, key=found.__getitem__)
        return {n: found[n] for n in best if MOST_OVER_PROMISE * found[n] > LEAST_ELSEWHERE}

    def _worth_fitting(
        self, current: Fit, names: Sequence[str], judge: Judge
    ) -> Mapping[str, float]:
        """Return what those additions promise that may earn their place."""
        promises = self._promises(current, names)
        if not promises_count(current):
            return promises
        worth = {n: p for n, p in promises.items() if MOST_OVER_PROMISE * p > judge.least(n)}
        return {**self._promised_elsewhere(current), **worth}

    def _best_addition(self) -> str | None:
        current = self.chosen
        judge = self._judge(current)
        names = self.compatible(self.accepted)
        if self.model.steady:
            self.pretence.work_out_beside(current)
        promises = self._worth_fitting(current, names, judge)
        tried = self._best_fitted(current, names, promises, judge.barred)
        if not tried:
            return None
        tried = self._best_ended(current, tried, judge)
        effective = min(tried.values(), key=lambda f: f.rms).effective
        criteria, drop, earning = weighed(judge, current, tried, effective)
        name = judge.first_choice(criteria, tried, earning)
        self.ledger.append(
            Step(
                current.hypothesis.members,
                name,
                name in earning,
                criterion_drop=drop[name],
                share=judge.share(tried[name]),
                rms={n: f.rms for n, f in tried.items()},
            )
        )
        return name if name in earning else None
