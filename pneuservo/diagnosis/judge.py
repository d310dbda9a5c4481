"""Whether a candidate earns its place beside what is already accepted, and which one is named."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from pneuservo.diagnosis.fit import Fit
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
SMALLEST_SHARE = 0.02
"""Share of what the baseline leaves unexplained that an effect has to account for ..."""
LARGE_SHARE_OF_REST = 0.5
"""... or the share of what is still unexplained when it is added."""
SECOND_SHARE = 0.05
"""Share that an effect beside another has to account for where forms of laws are compared that
differ from the real ones: they leave up to 5 % of an effect (`docs/challenge.md`)."""
AS_GOOD = 0.1**2
"""Share by which the simplest effect may fall behind the best and still be named first: the energy
of the tenth of an effect that is left where forms of laws differ."""
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


class Judge(Protocol):
    """Decides over additions to a fit; what has an answer here seldom depends on the judge."""

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
        return 0.0

    def barred(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate is not to be named whatever it explains.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        return False

    def only_relieves(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate is barred for nothing but that it relieves parameters.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        return False

    def may_be_form(self, name: str, closer: Fit) -> bool:
        """Return whether forms of what was found so far may explain as much as a candidate.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        return False

    def acts_elsewhere(self, name: str, closer: Fit) -> bool:
        """Return whether a candidate explains what no other form of what was found would.

        Parameters
        ----------
        name, closer
            As for `earns`.
        """
        return True

    def first_choice(
        self, criteria: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the candidate to be named.

        Parameters
        ----------
        criteria : mapping of str to float
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
class ByCriterion(Judge):
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

    def first_choice(
        self, criteria: Mapping[str, float], tried: Mapping[str, Fit], earning: Sequence[str]
    ) -> str:
        """Return the first in the catalogue's order of those that are tied."""
        among = earning or [*criteria]
        limit = min(criteria[name] for name in among) + TIED
        return next(name for name in self.order if name in among and criteria[name] < limit)

    def share(self, closer: Fit) -> float:
        """Return the share of what the baseline leaves beyond noise."""
        return gain(self.current, closer) / max(self.whole, 1e-300)


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
    criteria = {name: found.information_criterion(effective) for name, found in tried.items()}
    before = current.information_criterion(effective)
    drop = {name: before - value for name, value in criteria.items()}
    return criteria, drop, [name for name in tried if judge.earns(name, tried[name], drop[name])]


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


def beyond_nature(found: Fit) -> set[str]:
    """Return the parameters that came out as the quantity can be on no rig.

    Parameters
    ----------
    found : Fit
        Of whatever hypothesis.
    """
    values = {name: found.shared[name] for name in NATURAL_LIMITS if name in found.shared}
    return {n for n, v in values.items() if not NATURAL_LIMITS[n][0] <= v <= NATURAL_LIMITS[n][1]}
