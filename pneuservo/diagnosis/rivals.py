"""What could stand in for something that was accepted, and whether it does better there."""

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import nlargest

from pneuservo.diagnosis.accepted import Accepted
from pneuservo.diagnosis.chance import chance_gain
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.judge import (
    AS_GOOD,
    SECOND_SHARE,
    TIED,
    UNDECIDED,
    gain,
    is_impossible,
    same_physics,
    weighed,
)
from pneuservo.diagnosis.ledger import Rival, Step, probabilities
from pneuservo.diagnosis.screen import within_reach
from pneuservo.diagnosis.strained import out_of_tolerance, relief_of
from pneuservo.effects import CATALOGUE

SUREST = 0.95
"""Largest probability that is claimed: the catalogue never holds everything. (Of 15 names stated
with more in blind trials, 14 were of the right class.)"""
CAUSES_ASKED = 4
"""So many effects, those that would relieve them most, are asked whether one makes parameters seem
wrong."""


@dataclass
class Rivals(Accepted):
    """What has been accepted, held against all that was fitted in its place.

    Parameters
    ----------
    model, cases, progress, seed, fits
        As of `Hypotheses`.
    """

    def rivals(self, member: str) -> list[Rival]:
        """Return what could stand in for an accepted member, most probable first.

        The member itself and its absence (``""``) are among them.
        """
        rest, others = self._in_place_of(member)
        others = {n: f for n, f in others.items() if n == member or not is_impossible(n, f)}
        others[""] = rest
        effective = min(others.values(), key=lambda f: f.rms).effective
        criteria = {name: f.information_criterion(effective) for name, f in others.items()}
        most = max(explained(rest, f) for f in others.values()) if self.model.steady else 0.0
        probability = probabilities(criteria, 1.0 + AS_GOOD * max(most, 0.0))
        found = [Rival(name, min(probability[name], SUREST), criteria[name]) for name in others]
        return sorted(found, key=lambda rival: rival.information_criterion)

    def alike(self, member: str) -> list[str]:
        """Return the effects that, in place of a member, explain nearly as much of the mismatch.

        Laws in a catalogue are not quite those of the real thing: what they leave to choose
        between two of them by is no more than that. Only for a model with steady sensitivities.
        """
        if not self.model.steady:
            return []
        rest, others = self._in_place_of(member)
        own = gain(rest, others[member])
        if own <= 0.0:
            return []
        return [
            name
            for name, found in others.items()
            if name != member
            and not name.startswith("param.")
            and gain(rest, found) > (1.0 - SECOND_SHARE) * own
        ]

    def one_cause_instead(self, base: Fit, several: Fit) -> str | None:
        """Return an effect that leaves no parameter wrong, and explains as much as several do.

        A zero that was off by 1.4 mm made one dead volume too large by 2.8 tolerances and the other
        too small by 3.0, and both were called wrong. Only for a model with steady sensitivities.

        Parameters
        ----------
        base : Fit
            What the effect is added to.
        several : Fit
            The same with the parameters that seem wrong free of their tolerance.
        """
        if not self.model.steady:
            return None
        names = [n for n in self.compatible(base.hypothesis.members) if n in CATALOGUE]
        signatures = self.pretence.signatures_beside(base)
        relief = relief_of(base, out_of_tolerance(base), signatures, names, self._one_sided)
        best = nlargest(CAUSES_ASKED, relief, key=relief.__getitem__)
        found = self._ended_of(self._fitted_with(base, {n: relief[n] for n in best}), best)
        explains = {
            name: explained(several, closer)
            for name, closer in found.items()
            if self.leaves_noise(closer) and not out_of_tolerance(closer)
        }
        cause = max(explains, key=explains.__getitem__, default="")
        return cause if cause and explains[cause] > -UNDECIDED else None

    def _in_place_of(self, member: str) -> tuple[Fit, dict[str, Fit]]:
        """Return the fit without a member, and with each promising candidate in its place."""
        kept = [m for m in self.accepted if m != member]
        if self.interrupted:
            return self._in_place_of_so_far(member, kept)
        rest, forms = self.fitted(self._with(kept)), self.forms_of(member)
        promises = self._promises(rest, self.compatible(kept), keep=forms)
        needed = explained(rest, self.chosen)
        near = within_reach(rest, promises, needed, member)
        near |= {name: promises[name] for name in forms}
        # Forms of the same physics are told apart by less than a fit that stopped short leaves.
        ended = self._ended_of(self._fitted_with(rest, near, needed), forms)
        judge = self._judge(rest)
        if member in ended and judge.may_be_form(member, ended[member]):
            # What forms leave of the others is no rival of what acts elsewhere.
            ended = {
                name: found
                for name, found in ended.items()
                if name not in CATALOGUE or name == member or judge.acts_elsewhere(name, found)
            }
        return rest, ended

    def forms_of(self, member: str) -> list[str]:
        """Return a member and the other laws of the same physics, in the catalogue's order.

        Parameters
        ----------
        member : str
            Id of an effect, or a ``param.`` id, which has no other.
        """
        forms = same_physics(self.model.effects, member) if self.model.steady else {member}
        return [name for name in self.candidates if name in forms]

    def _in_place_of_so_far(self, member: str, kept: Sequence[str]) -> tuple[Fit, dict[str, Fit]]:
        """Return the same from what had been fitted when the search was interrupted."""
        rest = self.fits.get(self._with(kept), self.baseline)
        names = [n for n in self.candidates if rest.hypothesis.adding(n) in self.fits]
        found = {name: self.fits[rest.hypothesis.adding(name)] for name in names}
        # Names that were found elsewhere may have been fitted here together alone.
        return rest, {**found, member: self.chosen}

    def _gain_over_chance(self, member: str) -> float:
        """Return how much more a member explains than the best candidate would of noise."""
        rest, others = self._in_place_of(member)
        chosen = self.chosen
        # All in the weights of what is taken for noise: others would not be absorbed as they are.
        directions = [
            found.in_weights(chosen.scale).sensitivities(name) for name, found in others.items()
        ]
        noise = [
            r / chosen.scale[c] for r, c in zip(chosen.residuals, chosen.channels, strict=True)
        ]
        absorbed = rest.in_weights(chosen.scale).jacobian
        chance = chance_gain(absorbed, directions, noise, self.seed)
        return explained(rest, chosen) / chance if chance > 0.0 else float("inf")

    def _revise(self) -> None:
        """Swap or drop what was accepted early and is no longer the best in its place."""
        for member in list(self.accepted[:-1]):
            best = self._better_than(member)
            if best is not None and self._fits_closer_from(self._rest(member)):
                best = self._better_than(member)
            if best is not None:
                self._replace(member, best.candidate)
        self._drop_needless_last()
        for member in list(self.accepted):
            plainest = self._plainest_form_of(member)
            if plainest != member:
                self._replace(member, plainest)

    def _replace(self, member: str, candidate: str) -> None:
        """Put a candidate, or nothing, in the place of a member."""
        place = self.accepted.index(member)
        self.accepted[place : place + 1] = [candidate] if candidate else []
        self.ledger.append(Step(tuple(self.accepted), candidate, True, member))

    def _plainest_form_of(self, member: str) -> str:
        """Return the law of the same physics that is to be named beside the others as they are now.

        A less plain one may have been named while what another effect does was still left.
        """
        forms = self.forms_of(member)
        if len(forms) < 2 or len(self.accepted) < 2:
            return member
        rest, others = self._in_place_of(member)
        # A form that acts nowhere else than the other names is no rival.
        tried = {name: others[name] for name in forms if name in others}
        judge = self._judge(rest)
        criteria, _, earning = weighed(judge, rest, tried, self.chosen.effective)
        return judge.first_choice(criteria, tried, earning) if earning else member

    def _drop_needless_last(self) -> None:
        """Drop what was accepted last where the others do as well, begun from where it led them."""
        if not self.model.steady or len(self.accepted) < 2:
            return
        last, closer = self.accepted[-1], self.chosen
        rest = self._rest(last)
        drop = rest.information_criterion(closer.effective) - closer.information_criterion(
            closer.effective
        )
        if not self._judge(rest).earns(last, closer, drop):
            self._drop(last, "the others explain as much without it")

    def _better_than(self, member: str) -> Rival | None:
        """Return what is clearly better in the place of a member, if anything."""
        found = self.rivals(member)
        own = next(rival for rival in found if rival.candidate == member)
        absent = next(rival for rival in found if not rival.candidate)
        limit = own.information_criterion - self._margin(member)
        better = [rival for rival in found if rival.information_criterion < limit]
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
            self._replace_fit(again.hypothesis, again)
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
        drop = absent.information_criterion - rival.information_criterion
        closer = self.fitted(rest.hypothesis.adding(rival.candidate), rest)
        return self._judge(rest).earns(rival.candidate, closer, drop)
