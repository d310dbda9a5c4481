"""Whether an effect earns its place where noise and a small misfit cannot be told apart."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.diagnosis.judge import (
    AS_GOOD,
    DECISIVE,
    FORM,
    LEAST_DISTANCE,
    LEAST_GAIN,
    OVER_IMITATIONS,
    SECOND_SHARE,
    TIED,
    UNDECIDED,
    Judge,
    beyond_nature,
    channel_gain,
    gain,
    is_impossible,
    same_physics,
)
from pneuservo.effects import Effect

_MOTION, _PRESSURES = "displacement", {"pressure_a", "pressure_b"}
ELSEWHERE = 0.25
"""Share of what a second effect explains that no other form of what was found may explain, if it is
to have a place where forms leave as much (`SECOND_SHARE`, `AS_GOOD`) ..."""
LEAST_ELSEWHERE = 3.0 * LEAST_GAIN
"""What an effect beside others has to explain, and that share of what they do, where no form of
theirs would explain it: of 20 false ones beside large effects of another simulator the most was
102, and 148 where 100,000 had been explained; true ones were 228 of 64,000, 6,800 and 8,200."""
NEARLY_NOISE = 1.1
"""... and times its noise that a channel may be left at then: noise is known to a tenth. (Beside a
joint that left 1.2 in a chattering loop a flow force explained 800, in no form of the joint, and
left 1.13.)"""
_ONE_CHANNEL = 0.5
AS_PRECISE = 0.003**2
"""Share of what the best explains that decides nothing among laws as simple: the energy of 0.3 % of
an effect. A leak planted by the tool's own kernels explained 5.5 million, and the same as a power
of the pressure 25 more."""
TABLE_LIKE = 3
"""A law with so many sizes of either sign is a table by another name: each of them has to lower the
sum of squares by that. (Six errors of a lineariser explained 137 of two recordings without any
effect, tables of nine knots reach 416; bends of a transducer were named in three such pairs.)"""
MOST_RELIEF = 0.5
"""Share of what an effect gains that may be relief of strained parameters, and not seen in the
recordings: what strains them may be any of them, or how laws differ in form. Of nine true effects
of another simulator with signatures of 11 to 57 standard deviations none reached 0.1."""


@dataclass(frozen=True)
class ByGain(Judge):
    """For innovations, in which noise and a small misfit cannot be told apart.

    A candidate is held against what it pretends to explain of imitations of the recordings, and
    laws that leave a little because the real ones differ in form are not told apart by that.

    Parameters
    ----------
    current, baseline : Fit
        What is added to, and what everything began with.
    effects : sequence of Effect
        Of the rig.
    pretended : callable
        Takes a candidate and the fit with it, and returns what it seems to gain where there is
        nothing.
    elsewhere : callable
        Takes the fit with a candidate, and returns what it explains that no other form of what has
        been found would.
    """

    current: Fit
    baseline: Fit
    effects: Sequence[Effect]
    pretended: Callable[[str, Fit], float]
    elsewhere: Callable[[Fit], float]

    def earns(self, name: str, closer: Fit, drop: float) -> bool:
        """Return whether a candidate explains more than chance, imitations and form would."""
        if self.barred(name, closer):
            return False
        explains, least = drop, self.least(name)
        if not name.startswith("param."):
            if drop <= DECISIVE:
                return False
            explains = explained(self.current, closer)
            if self.may_be_form(name, closer):
                if not self.acts_elsewhere(name, closer):
                    return False
                least = self._least_elsewhere(name)
        return self._explains_enough(name, closer, explains, least)

    def _explains_enough(self, name: str, closer: Fit, explains: float, least: float) -> bool:
        """Return whether more than the least is explained, and than imitations pretend."""
        # Imitations are made only where they may decide.
        return explains > least and explains > OVER_IMITATIONS * self.pretended(name, closer)

    def least(self, name: str) -> float:
        """Return what no noise explains, or what the form of the laws found so far leaves."""
        judged = self.current.effective
        moves = _MOTION in judged or not _PRESSURES & set(judged)
        least = LEAST_DISTANCE if name.startswith("param.") and moves else LEAST_GAIN
        least *= self._sizes(name)
        if not self.current.hypothesis.effects:
            return least
        # It pulls at parameters, and at channels where little else shows, too.
        return max(least, AS_GOOD * explained(self.baseline, self.current))

    def may_be_form(self, name: str, closer: Fit) -> bool:
        """Return whether what was found so far may leave as much where its law differs in form.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        if not self.current.hypothesis.members:
            return False
        small = explained(self.current, closer) <= self.least(name)
        return small or self.share(closer) <= SECOND_SHARE

    def acts_elsewhere(self, name: str, closer: Fit) -> bool:
        """Return whether most of what an effect explains, and all of it, is none of other forms.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        if any(closer.rms_of(channel) > NEARLY_NOISE for channel in closer.effective):
            return False
        least = max(self._least_elsewhere(name), ELSEWHERE * explained(self.current, closer))
        return self.elsewhere(closer) > least

    def _least_elsewhere(self, name: str) -> float:
        """Return what an effect has to explain that no form of what was found would."""
        found = FORM * explained(self.baseline, self.current)
        return max(LEAST_ELSEWHERE * self._sizes(name), found)

    def _sizes(self, name: str) -> int:
        """Return how many sizes have to be earned: 1 but for a law that is like a table."""
        parameters = [p for effect in self.effects if effect.id == name for p in effect.parameters]
        sizes = sum(p.neutral == 0.0 and p.low < 0.0 < p.high for p in parameters)
        return sizes if sizes >= TABLE_LIKE else 1

    def first_choice(
        self, criteria: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the simplest of those that explain as much as the best, or nearly enough."""
        # A flexible candidate that explains little must not shield one that earns its place.
        among = list(earning) or list(criteria)
        best = min(among, key=criteria.__getitem__)
        explains = {name: explained(self.current, tried[name], tried[best]) for name in among}
        # Of two laws of the same physics the plainer stands until the other is decisively better.
        forms = same_physics(self.effects, best)
        undecided = [
            name
            for name in among
            if criteria[name] < criteria[best] + (DECISIVE if name in forms else UNDECIDED)
        ]
        # A wrong parameter has no form that could differ.
        alike = [
            name
            for name in among
            if explains[name] > (1.0 - AS_GOOD) * explains[best] and not name.startswith("param.")
        ]
        rivals = {*undecided, *alike}
        fewest = min(tried[name].unknowns for name in rivals)
        simplest = [n for n in tried if n in rivals and tried[n].unknowns == fewest]
        margin = max(TIED, AS_PRECISE * explains[best])
        limit = min(criteria[name] for name in simplest) + margin
        # In the catalogue's order, in which the plainest form of the same physics is first.
        first = next(name for name in simplest if criteria[name] < limit)
        same = same_physics(self.effects, first)
        return next(name for name in simplest if name in same)

    def share(self, closer: Fit) -> float:
        """Return the share of all that is explained so far, or half of that in one channel.

        What the form of a law leaves is left where the law acts: an effect that shows elsewhere
        does not have to compete with it.
        """
        more, whole = gain(self.current, closer), gain(self.baseline, closer)
        found = [more / whole if more > 0.0 and whole > 0.0 else 0.0]
        for channel in closer.effective:
            here = channel_gain(self.current, closer, channel)
            if here > LEAST_GAIN:
                explains = max(channel_gain(self.baseline, closer, channel), here)
                found.append(_ONE_CHANNEL * here / explains)
        return max(found)

    def barred(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate is impossible, not itself or mostly relief."""
        if name.startswith("param."):
            return is_impossible(name, closer)
        # The air is no colder than on any rig for the sake of a name.
        strange = beyond_nature(closer)
        if strange and strange - beyond_nature(self.current):
            return True
        return self._relieves(closer) or self._is_not_itself(name, closer)

    def only_relieves(self, name: str, closer: Fit) -> bool:
        """Return whether an effect is not to be named for nothing but that it is mostly relief.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        if not self._relieves(closer) or self._is_not_itself(name, closer):
            return False
        explains = explained(self.current, closer)
        return self._explains_enough(name, closer, explains, self.least(name))

    def _relieves(self, closer: Fit) -> bool:
        """Return whether most of a gain is relief of strained parameters."""
        relief = self.current.penalty - closer.penalty
        return relief > MOST_RELIEF * max(explained(self.current, closer), 0.0)

    def _is_not_itself(self, name: str, found: Fit) -> bool:
        """Return whether an effect came out as real parts never show it.

        Its size is none of theirs, or all of its several parameters are at the far ends of their
        ranges: its law takes the shape of something else.
        """
        effect = next(effect for effect in self.effects if effect.id == name)
        values = [(p, found.shared[effect.key(p.name)]) for p in effect.parameters]
        size, value = values[0]
        if not size.least <= abs(value) <= size.most:
            return True
        ends = [v in {p.low, p.high} - {p.neutral} for p, v in values]
        return len(ends) > 1 and all(ends)
