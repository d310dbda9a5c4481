"""Whether a candidate earns its place beside what is already accepted, and which one is named."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from pneuservo.diagnosis.fit import Fit, explained
from pneuservo.effects import Effect
from pneuservo.rigs.natural_limits import NATURAL_LIMITS

DECISIVE = 10.0
"""Drop of the information criterion that decides (Kass and Raftery 1995: very strong)."""
UNDECIDED = 6.0
"""Rivals closer than this cannot be told apart (Kass and Raftery 1995: below strong)."""
TIED = 2.0
"""Rivals closer than this are not worth more than a mention; the catalogue's order decides."""
LEAST_DISTANCE = 25.0
"""Drop that a parameter out of its tolerance has to bring where laws differ in form from the real
ones: five tolerances. Where the piston hardly moves it was 22 in recordings of another simulator
without a wrong one, and 37 where no motion was judged at all: what is then taken over for its
velocity is noise, which shrinks with a larger volume. There it is that of an effect."""
_MOTION, _PRESSURES = "displacement", {"pressure_a", "pressure_b"}
SMALLEST_SHARE = 0.02
"""Share of what the baseline leaves unexplained that an effect has to account for ..."""
SECOND_SHARE = 0.05
"""Share that an effect beside another has to account for where forms of laws are compared that
differ from the real ones: they leave up to 5 % of an effect (section 5 of the method notes)."""
ELSEWHERE = 0.5
"""... unless so much of what it explains no other form of what was found would explain."""
_ONE_CHANNEL = 0.5
AS_GOOD = 0.1**2
"""Share by which the simplest effect may fall behind the best and still be named first: the energy
of the tenth of an effect that is left where forms of laws differ."""
AS_PRECISE = 0.003**2
"""Share of what the best explains that decides nothing among laws as simple: the energy of 0.3 % of
an effect. A leak planted by the tool's own kernels explained 5.5 million, and the same as a power
of the pressure 25 more."""
LARGE_SHARE_OF_REST = 0.5
"""... or the share of what is still unexplained when it is added."""
OVER_IMITATIONS = 4.0
"""An effect has to explain so many times what it seems to explain of recordings without it: in 26
pairs of recordings of another simulator without any effect, relays among them, the best candidate
of those that gained more than 20 reached 3 times."""
LEAST_GAIN = 50.0
"""... and lower the weighted sum of squares by this, a signature of seven standard deviations: the
most that was gained in those pairs by more than twice what imitations pretend was 37."""
FORM = 0.05**2
"""Share of what effects explain that a fit may lose where the real law may differ in form: sizes of
two laws for one effect then mean the same to a twentieth."""
NEARLY_NOISE = 1.1
"""Times its noise that a channel may be left at then: noise is known to a tenth. (Beside a joint
that left 1.2 in a chattering loop a flow force explained 800, in no form of the joint, and left
1.13.)"""
LEAST_ELSEWHERE = 3.0 * LEAST_GAIN
"""What an effect beside others has to explain, and that share of what they do, where no form of
theirs would explain it: of 20 false ones beside large effects of another simulator the most was
102, and 148 where 100,000 had been explained; true ones were 228 of 64,000, 6,800 and 8,200."""

TABLE_LIKE = 3
"""A law with so many sizes of either sign is a table by another name: each of them has to lower the
sum of squares by that. (Six errors of a lineariser explained 137 of two recordings without any
effect, tables of nine knots reach 416; bends of a transducer were named in three such pairs.)"""

MOST_RELIEF = 0.5
"""Share of what an effect gains that may be relief of strained parameters, and not seen in the
recordings: what strains them may be any of them, or how laws differ in form. Of nine true effects
of another simulator with signatures of 11 to 57 standard deviations none reached 0.1."""


class Judge(Protocol):
    """Decides over additions to a fit."""

    def earns(self, name: str, closer: Fit, drop: float) -> bool:
        """Return whether a candidate earns its place.

        Parameters
        ----------
        name : str
            Effect id, or ``param.`` and the id of a parameter.
        closer : Fit
            With the candidate.
        drop : float
            By how much the information criterion falls with it.
        """

    def least(self, name: str) -> float:
        """Return how much a candidate has to explain at least, whatever else there is.

        Parameters
        ----------
        name
            As for `earns`.
        """

    def barred(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate is not to be named whatever it explains.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """

    def only_relieves(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate is barred for nothing but that it relieves parameters.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """

    def may_be_form(self, name: str, closer: Fit) -> bool:
        """Return whether forms of what was found so far may explain as much as a candidate.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """

    def acts_elsewhere(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate explains what no other form of what was found would.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """

    def first_choice(
        self, evidence: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the candidate to be named.

        Parameters
        ----------
        evidence : mapping of str to float
            Information criterion of each candidate.
        tried : mapping of str to Fit
            With each candidate.
        earning : sequence of str
            Candidates that earn their place.
        """

    def share(self, closer: Fit) -> float:
        """Return the share of what the baseline leaves unexplained that a candidate explains.

        Parameters
        ----------
        closer : Fit
            With the candidate.
        """


def gain(current: Fit, closer: Fit) -> float:
    """Return the drop of the sum of squares from one fit to a closer one.

    Parameters
    ----------
    current, closer : Fit
        Of the same recordings.
    """
    return current.samples * (current.rms**2 - closer.rms**2)


def channel_gain(current: Fit, closer: Fit, channel: str) -> float:
    """Return the drop of the sum of squares of one channel, in the spread that it has at last.

    Parameters
    ----------
    current, closer : Fit
        Of the same recordings.
    channel : str
        The channel.
    """
    spread = closer.rms_of(channel) ** 2
    drop = current.rms_of(channel) ** 2 - spread
    return current.samples_of(channel) * drop / spread


@dataclass(frozen=True)
class ByEvidence:
    """For models whose noise can be told from a misfit: the information criterion decides.

    Parameters
    ----------
    current : Fit
        What is added to.
    order : sequence of str
        Candidates, physics first and simple first.
    whole, rest : float
        What the baseline and the current fit leave beyond noise.
    """

    current: Fit
    order: Sequence[str]
    whole: float
    rest: float

    def earns(self, name: str, closer: Fit, drop: float) -> bool:
        """Return whether the criterion decides for a candidate that explains enough."""
        if name.startswith("param.") or drop <= DECISIVE:
            # A refit may already have moved a parameter far out of its tolerance: freeing it then
            # explains nothing more, but says what is wrong.
            return drop > DECISIVE
        enough = self.share(closer) > SMALLEST_SHARE
        return enough or gain(self.current, closer) > LARGE_SHARE_OF_REST * self.rest

    def least(self, name: str) -> float:
        """Return nothing: it shows in the fit."""
        return 0.0

    def barred(self, name: str, closer: Fit) -> bool:
        """Return that no candidate is."""
        return False

    def only_relieves(self, name: str, closer: Fit) -> bool:
        """Return that no candidate does."""
        return False

    def may_be_form(self, name: str, closer: Fit) -> bool:
        """Return that the criterion decides, whatever forms leave."""
        return False

    def acts_elsewhere(self, name: str, closer: Fit) -> bool:
        """Return that it does not matter where it acts."""
        return True

    def first_choice(
        self, evidence: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the first in the catalogue's order of those that are tied."""
        limit = min(evidence.values()) + TIED
        return next(name for name in self.order if name in evidence and evidence[name] < limit)

    def share(self, closer: Fit) -> float:
        """Return the share of what the baseline leaves beyond noise."""
        return gain(self.current, closer) / max(self.whole, 1e-300)


@dataclass(frozen=True)
class ByGain:
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
        return explains > max(least, OVER_IMITATIONS * self.pretended(name, closer))

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
        self, evidence: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the simplest of those that explain as much as the best, or nearly enough."""
        # A flexible candidate that explains little must not shield one that earns its place.
        among = list(earning) or list(evidence)
        best = min(among, key=evidence.__getitem__)
        explains = {name: explained(self.current, tried[name], tried[best]) for name in among}
        # Of two laws of the same physics the plainer stands until the other is decisively better.
        forms = same_physics(self.effects, best)
        undecided = [
            name
            for name in among
            if evidence[name] < evidence[best] + (DECISIVE if name in forms else UNDECIDED)
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
        limit = min(evidence[name] for name in simplest) + margin
        # In the catalogue's order, in which the plainest form of the same physics is first.
        first = next(name for name in simplest if evidence[name] < limit)
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
        return self._relieves(closer) or self._is_not_itself(name, closer)

    def only_relieves(self, name: str, closer: Fit) -> bool:
        """Return whether an effect is not to be named for nothing but that it is mostly relief.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        explains = explained(self.current, closer)
        enough = explains > max(self.least(name), OVER_IMITATIONS * self.pretended(name, closer))
        return enough and self._relieves(closer) and not self._is_not_itself(name, closer)

    def _relieves(self, closer: Fit) -> bool:
        """Return whether most of a gain is relief of strained parameters."""
        relief = self.current.penalty - closer.penalty
        return relief > MOST_RELIEF * max(explained(self.current, closer), 0.0)

    def _is_not_itself(self, name: str, found: Fit) -> bool:
        """Return whether an effect came out as real parts never show it.

        It is too small, or has all of its several parameters at the far ends of their ranges:
        its law takes the shape of something else.
        """
        effect = next(effect for effect in self.effects if effect.id == name)
        values = [(p, found.shared[effect.key(p.name)]) for p in effect.parameters]
        size, value = values[0]
        if abs(value) < size.least:
            return True
        ends = [v in {p.low, p.high} - {p.neutral} for p, v in values]
        return len(ends) > 1 and all(ends)


def same_physics(effects: Sequence[Effect], name: str) -> set[str]:
    """Return the ids of an effect and of the other laws of the same physics.

    Parameters
    ----------
    effects : sequence of Effect
        Of the rig.
    name : str
        Effect id, or ``param.`` and the id of a parameter, which stands alone.
    """
    group = next((effect.group for effect in effects if effect.id == name), "")
    return {name} | {effect.id for effect in effects if group and effect.group == group}


def weighed(
    judge: Judge, current: Fit, tried: Mapping[str, Fit], effective: Mapping[str, float]
) -> tuple[dict[str, float], dict[str, float], list[str]]:
    """Return the criterion of each candidate, by how much it falls with it, and who earns a place.

    Parameters
    ----------
    judge : Judge
        Of additions to the current fit.
    current : Fit
        What is added to.
    tried : mapping of str to Fit
        With each candidate.
    effective : mapping of str to float
        What the samples of each channel are worth.
    """
    evidence = {name: found.evidence(effective) for name, found in tried.items()}
    before = current.evidence(effective)
    drop = {name: before - value for name, value in evidence.items()}
    return evidence, drop, [name for name in tried if judge.earns(name, tried[name], drop[name])]


def is_impossible(name: str, found: Fit) -> bool:
    """Return whether all of a parameter's interval is beyond what the quantity can be on any rig.

    Recordings that hardly tell a parameter move it far for little.

    Parameters
    ----------
    name : str
        Effect id, which is always possible, or ``param.`` and the id of a parameter.
    found : Fit
        With that candidate.
    """
    parameter = name.removeprefix("param.")
    if parameter == name or parameter not in NATURAL_LIMITS:
        return False
    lowest, highest = NATURAL_LIMITS[parameter]
    low, high = found.intervals[parameter]
    return high < lowest or low > highest
