"""What recordings have called for so far, and what that leaves of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.bent_laws import bendable, explained_beyond
from pneuservo.diagnosis.by_gain import ByGain
from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypotheses import Hypotheses
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.judge import DECISIVE, ByCriterion, Judge
from pneuservo.diagnosis.ledger import Step
from pneuservo.diagnosis.models import Case
from pneuservo.diagnosis.strained import leaves_noise, only_followed
from pneuservo.diagnosis.unknowns import values_in_each
from pneuservo.effects import CATALOGUE, effect_by_id
from pneuservo.noise import noise_floor, noise_level


@dataclass
class Accepted(Hypotheses):
    """What has been accepted of all that was fitted.

    Parameters
    ----------
    model, cases, progress, seed, fits
        As of `Hypotheses`.

    Attributes
    ----------
    accepted : list of str
        What the recordings call for: effect ids, and ``param.`` ids of wrong parameters.
    ledger : list of Step
        What was tried, in order.
    interrupted : bool
        Whether the user stopped it before it had tried everything.
    """

    accepted: list[str] = field(default_factory=list)
    ledger: list[Step] = field(default_factory=list)
    interrupted: bool = False
    _rests: dict[Hypothesis, Array] = field(default_factory=dict)
    _bent: tuple[Fit, Fit] | None = None
    _beyond: dict[tuple[Hypothesis, Hypothesis], tuple[Fit, Fit, float]] = field(
        default_factory=dict
    )

    @property
    def chosen(self) -> Fit:
        """Return the fit with everything accepted."""
        return self.fitted(self._with(self.accepted))

    @cached_property
    def noise(self) -> list[float]:
        """Return the noise of the judged channel in each recording [unit of the cases].

        Where it was not stated it is the floor of the channel or of what the baseline leaves,
        whichever is lower: what the baseline explains, a jump for example, is no noise. Where what
        is left is compared with noise to go on at all, nothing may be missed for a floor by chance
        too high.
        """
        estimate = noise_level if self.model.steady else noise_floor
        return [
            _noise_of(case, residual, estimate)
            for case, residual in zip(self.cases, self.baseline.residuals, strict=True)
        ]

    @property
    def noise_rms(self) -> float:
        """Return the noise of all recordings together [unit of the cases]."""
        return float(np.sqrt(np.mean(np.square(self.noise))))

    def leaves_noise(self, found: Fit) -> bool:
        """Return whether a fit leaves no more than noise of any channel of any recording.

        Parameters
        ----------
        found : Fit
            Of one of the hypotheses.
        """
        return leaves_noise(self.cases, found, self.unit_of_noise)

    @property
    def unit_of_noise(self) -> list[float]:
        """Return the noise of each case; recordings of a steady model are in units of theirs."""
        return [1.0] * len(self.cases) if self.model.steady else self.noise

    def are_judged(self, found: Fit) -> bool:
        """Return whether it is known of every recording what drove it.

        Parameters
        ----------
        found : Fit
            Of one of the hypotheses.
        """
        return not self.only_followed(found)

    def only_followed(self, found: Fit) -> set[int]:
        """Return the identities of recordings of which nobody knows what drove them.

        Parameters
        ----------
        found : Fit
            Of one of the hypotheses.
        """
        return only_followed(self.model, self.cases, found, self.unit_of_noise)

    def gained_where_judged(self, rest: Fit, closer: Fit) -> float:
        """Return by how much less a fit leaves, in noise, of recordings that are not only followed.

        Parameters
        ----------
        rest, closer : Fit
            Of two of the hypotheses, in the same recordings.
        """
        followed = self.only_followed(closer)
        return sum(
            float(before @ before - after @ after) / size**2
            for case, before, after, size in zip(
                self.cases, rest.residuals, closer.residuals, self.unit_of_noise, strict=True
            )
            if id(case.origin) not in followed
        )

    def unexplained_share(self, found: Fit) -> float:
        """Return what a fit leaves beyond noise, as a share of what the baseline leaves."""
        return self.beyond_noise(found) / max(self.beyond_noise(self.baseline), 1e-300)

    def share(self, member: str) -> float:
        """Return the share of the mismatch that an accepted member explains beside the others."""
        rest = self._rest(member)
        return self.unexplained_share(rest) - self.unexplained_share(self.chosen)

    def beyond_noise(self, found: Fit) -> float:
        """Return the sum of squares of a fit beyond noise.

        Parameters
        ----------
        found : Fit
            Of the recordings.
        """
        noise = sum(len(r) * noise**2 for r, noise in zip(found.residuals, self.noise, strict=True))
        return max(0.0, found.samples * found.rms**2 - noise)

    def block_of(self, member: str) -> str:
        """Return the block of an effect, or of a loosened parameter: its id less the last part.

        Parameters
        ----------
        member : str
            Id of an effect, or a ``param.`` id.
        """
        if member not in CATALOGUE:
            head = member.removeprefix("param.").rpartition(".")[0]
            return self.model.blocks.get(head, head)
        chosen, first = self.chosen, self.cases[0]
        values = values_in_each(self.cases, first, chosen.shared, chosen.own)
        return self.model.block_of(effect_by_id(member, self.model.kind), self.cases, values)

    def _rest(self, member: str) -> Fit:
        """Return the fit with everything accepted but a member.

        For a steady model it is begun from where all of them are, too: it may have come to rest
        elsewhere before the member was there, which then seems to explain what that leaves. (A pair
        left 26,000, and beside it a leak of 2e-18 explained 77,000 of what the pair had not found.)
        """
        hypothesis = self._with([m for m in self.accepted if m != member])
        found, chosen = self.fitted(hypothesis), self.chosen
        if not self.model.steady or not hypothesis.effects:
            return found
        if self._rests.get(hypothesis) is chosen.vector:
            return found
        self._rests[hypothesis] = chosen.vector
        again = fit(self.model, self.cases, hypothesis, chosen)
        if explained(found, again) > DECISIVE:
            self._replace_fit(hypothesis, again)
        return self.fits[hypothesis]

    def _with(self, members: Sequence[str]) -> Hypothesis:
        hypothesis = Hypothesis()
        for member in members:
            hypothesis = hypothesis.adding(member)
        return hypothesis

    def compatible(self, accepted: Sequence[str]) -> list[str]:
        """Return the candidates that may be added to some others.

        Parameters
        ----------
        accepted : sequence of str
            The others; what the rig holds already counts as well.
        """
        group = {effect.id: effect.group for effect in self.model.effects}
        present = [*accepted, *self.cases[0].rig.effects]
        taken = {group.get(name, "") for name in present} - {""}
        return [
            name
            for name in self.candidates
            if name not in accepted and group.get(name, "") not in taken
        ]

    def _judge(self, current: Fit) -> Judge:
        """Return what decides over additions to a fit."""
        if self.model.steady:
            return ByGain(
                current,
                self.baseline,
                self.model.effects,
                lambda name, closer: self.pretence.of(name, current, closer),
                lambda closer: self._elsewhere(current, closer),
            )
        found = (self.beyond_noise(self.baseline), self.beyond_noise(current))
        return ByCriterion(current, self.candidates, *found)

    def _bendable(self, current: Fit) -> Fit:
        """Return a fit that would absorb what its effects change, bent; worked out once."""
        if self._bent is None or self._bent[0] is not current:
            self._bent = current, bendable(self.model, self.cases, current)
        return self._bent[1]

    def _elsewhere(self, current: Fit, closer: Fit) -> float:
        """Return what a closer fit explains that no bent law would; worked out once."""
        asked = current.hypothesis, closer.hypothesis
        known = self._beyond.get(asked)
        if known is None or known[0] is not current or known[1] is not closer:
            found = explained_beyond(self._bendable(current), closer)
            known = self._beyond[asked] = current, closer, found
        return known[2]

    def _drop(self, member: str, why: str) -> None:
        self.accepted.remove(member)
        self.ledger.append(Step(tuple(self.accepted), "", True, member, why=why))


def _noise_of(case: Case, residual: Array, estimate: Callable[[Array, Array], float]) -> float:
    """Return the noise of the judged channel [unit of the case]."""
    if not case.recorded:
        return case.noise_rms
    stated = case.recording.noise_rms.get(case.channel, 0.0) / case.scale
    floor = estimate(residual, case.recording.time[case.usable]) if not stated else 0.0
    return stated or max(min(case.noise_rms, floor), case.resolution)
