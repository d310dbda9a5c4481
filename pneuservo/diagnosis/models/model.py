"""What every model of the diagnosis offers."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.effects import Effect, effects_of
from pneuservo.errors import InputError
from pneuservo.noise import resolution
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

Values = Mapping[str, float]


@dataclass(frozen=True)
class Unknown:
    """A number that a fit has to find.

    Parameters
    ----------
    key : str
        Its name among the values a model takes.
    start : float
        Where the fit starts.
    low, high : float
        Hard limits.
    sigma : float or None, optional
        How well `start` is known beforehand, one standard deviation; None when it is not.
    unit : str, optional
        SI unit.
    """

    key: str
    start: float
    low: float = -np.inf
    high: float = np.inf
    sigma: float | None = None
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """A tabulated term that may stand for physics without a name.

    Parameters
    ----------
    effect, block : str
        Id of the tabulated effect and where it acts.
    what : str
        What it adds, in words.
    unit : str
        Its SI unit.
    quantity : str
        What it depends on, in words.
    unit_of_quantity : str
        The SI unit of that.
    values : mapping of str to float
        Keys and values that say what the table is over and from where to where.
    low, high : str
        Keys of its two ends.
    knots : tuple of str
        Keys of the values at its knots.
    step : float
        A small value.
    least : float
        Spread of the values below which they are nothing.
    largest : float
        Size of a value beyond which it is impossible.
    least_gain : float
        Drop of the weighted sum of squares that it has to bring: more than an effect, for it has
        more freedom.
    own : bool, optional
        Whether every recording has one of its own: what goes by time does not repeat.
    form_of : str, optional
        Id of the effect of the catalogue that it is a form of, if it is of any.
    """

    effect: str
    block: str
    what: str
    unit: str
    quantity: str
    unit_of_quantity: str
    values: Values
    low: str
    high: str
    knots: tuple[str, ...]
    step: float
    least: float
    largest: float
    least_gain: float
    own: bool = False
    form_of: str = ""


@dataclass(frozen=True)
class Misfit:
    """What a model leaves that is no noise, though no name and no table explains it.

    Parameters
    ----------
    block : str
        Where it acts, as far as that shows.
    words : str
        What it looks like, after "nothing in the catalogue explains what is left:".
    energy : float
        Its sum of squares, in those of the noise.
    refutes : bool, optional
        Whether what has been named does not hold: it only stands in for what has no name.
    """

    block: str
    words: str
    energy: float
    refutes: bool = False


Levels = Mapping[tuple[int, str], float]
"""By identity of a recording and channel."""


@dataclass(frozen=True)
class Case:
    """One recording, prepared for a model.

    Parameters
    ----------
    recording : Recording
        Where it comes from.
    measured : (n,) array
        Samples of the judged channel, in `scale`; NaN where there is none.
    inputs : mapping of str to array or float
        Whatever else the model needs, worked out once.
    noise_rms : float
        Noise of the judged channel, in the unit of `measured`.
    rig : Rig
        The rig as it was under the conditions of the recording.
    usable : (n,) array of bool
        Which samples are judged.
    channel, unit : str
        The judged channel and its SI unit.
    scale : float
        What `measured` counts as one [SI]; 1 where the model has a single channel.
    finest : float
        Misfit below which the fit is perfect; 0 where the readings tell.
    recorded : bool
        Whether it is a channel of the recording, or follows from several.
    """

    recording: Recording
    measured: Array
    inputs: Mapping[str, Any]
    noise_rms: float
    rig: Rig
    usable: Mask = field(default_factory=lambda: np.ones(0, dtype=bool))
    channel: str = ""
    unit: str = ""
    scale: float = 1.0
    finest: float = 0.0
    recorded: bool = True

    @property
    def origin(self) -> Recording:
        """Return the recording as it was read, with what a model has taken out of it."""
        recorded: Recording = self.inputs.get("recorded", self.recording)
        return recorded

    @property
    def resolution(self) -> float:
        """Return the misfit below which the fit is perfect [unit of `measured`]."""
        return self.finest or resolution(self.measured)


def are_the_same(one: Sequence[Case], other: Sequence[Case]) -> bool:
    """Return whether recordings are in the same way, though it was arrived at in another.

    Parameters
    ----------
    one, other : sequence of Case
        Of recordings in their order.
    """
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))


def is_among(one: Sequence[Case], ways: Iterable[Sequence[Case]]) -> bool:
    """Return whether recordings are as they are in one of several ways.

    Parameters
    ----------
    one : sequence of Case
        Of recordings in their order.
    ways : iterable of sequence of Case
        The same recordings, each time in another way.
    """
    return any(are_the_same(one, way) for way in ways)


class Model:
    """A chain of blocks that turns measured inputs into the judged channel or channels.

    A model with several channels prepares one case per recording and channel, each counted in
    its own noise, so that they can be put in one sum of squares.

    A model takes a flat mapping of values: rig parameters by id, effect parameters as
    ``effect:parameter``, and its own nuisances, which differ from recording to recording.
    """

    kind: ClassVar[str]
    channel: ClassVar[str]
    unit: ClassVar[str]
    block: ClassVar[str]
    required: ClassVar[tuple[str, ...]]
    steady: ClassVar[bool] = False
    """Whether what the rig's parameters do hardly changes with their values."""
    joint: ClassVar[bool] = False
    """Whether the unknowns of a recording's first case hold for all its cases."""
    tabulates: ClassVar[bool] = False
    """Whether tables may stand for what no effect explains."""
    follows: ClassVar[tuple[str, ...]] = ()
    """Channels that are followed and not judged where nobody knows what drives them."""
    ridges: ClassVar[tuple[str, ...]] = ()
    """Parameters on either side of whose value a fit may come to rest."""
    blocks: ClassVar[Mapping[str, str]] = {}
    """Block that parameters belong to whose id begins with no block."""
    late: ClassVar[tuple[str, ...]] = ()
    """Blocks whose effects are like a command that is read in another way."""
    unread: ClassVar[tuple[str, ...]] = ()
    """Channels of the rig that the model has no use for."""

    def __init__(self, without: frozenset[str] = frozenset()):
        self.without = without

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects of the catalogue that this rig can show."""
        return effects_of(self.kind)

    def starts(self, effect: Effect, cases: Sequence[Case]) -> dict[str, tuple[float, ...]]:
        """Return where a fit may begin with each parameter of an effect, by its name."""
        return {parameter.name: parameter.starts for parameter in effect.parameters}

    def completed(self, recording: Recording, rig: Rig) -> Recording:
        """Return a recording with channels that others of it can stand for."""
        return recording

    def require_channels(self, recording: Recording) -> None:
        """Refuse a recording that lacks a channel this model needs.

        Raises
        ------
        InputError
            The message lists what is missing and what is there.
        """
        missing = [name for name in self.required if name not in recording]
        if missing:
            raise InputError(
                f"{recording.source or recording.name}: rig {self.kind!r} needs the channel"
                f"{'s' if len(missing) > 1 else ''} {', '.join(missing)}; the recording has "
                f"{', '.join(recording.channels) or 'none'}. Map the missing one in the sidecar's "
                "[channels], or name another rig with --rig"
            )

    def with_word_of_unread(self, recording: Recording) -> Recording:
        """Return a recording with a warning for the channels of it that are not read, if any."""
        names = [name for name in self.unread if name in recording]
        if not names:
            return recording
        several = len(names) > 1
        warning = (
            f"{' and '.join(names)} {'were' if several else 'was'} recorded, but the diagnosis of "
            f"a {self.kind} rig does not read {'them' if several else 'it'}"
        )
        return replace(recording, warnings=(*recording.warnings, warning))

    def prepare(self, recording: Recording, rig: Rig) -> Case:
        """Return the recording as this model needs it."""
        raise NotImplementedError

    def cases(self, recording: Recording, rig: Rig) -> list[Case]:
        """Return the recording once per judged channel."""
        case = self.prepare(recording, rig)
        return [replace(case, channel=self.channel, unit=self.unit)]

    def readings(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases in each way in which recordings may be read that do not say."""
        return [list(cases)]

    def followed(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases with each trust that a model which follows them may have in itself.

        First as they are; the others are different, each with the cases in their order.
        """
        return [list(cases)]

    def moved(self, cases: Sequence[Case], values: Sequence[Values]) -> list[list[Case]]:
        """Return the cases as they are, and moved as what was found of their rig lets them.

        Values are given one per case; those of a recording are together, as many as are judged.
        """
        return [list(cases)]

    def told(self, cases: Sequence[Case], used: Sequence[Case]) -> list[Case]:
        """Return cases that were held back, what only they tell of the rig not judged."""
        return list(cases)

    def excused(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases with each trust by which a way to read them may be judged.

        First as they are; each with the cases in their order.
        """
        return self.followed(cases)

    def trusted(self, cases: Sequence[Case]) -> list[Case]:
        """Return the cases with the trust of a model that lacks nothing, in their order."""
        return list(cases)

    def stored(self, case: Case) -> bool:
        """Return whether what drives the rig stands still but for jumps, as what is stored does."""
        return False

    def is_known_between_samples(self, case: Case) -> bool:
        """Return whether what drives the rig is known between its samples as well."""
        return self.stored(case)

    def levels(self, cases: Sequence[Case], values: Sequence[Values]) -> Levels:
        """Return how large a misfit is all over, by recording and channel, in its noise squared."""
        raise NotImplementedError

    def deviance(
        self, cases: Sequence[Case], values: Sequence[Values], levels: Levels | None = None
    ) -> float:
        """Return twice the negative log-likelihood of recordings, but for a constant.

        Where levels are given, residuals count in these instead of in noise.
        """
        raise NotImplementedError

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return the rig parameters that one recording tells of."""
        return ()

    def fitted_to(self, cases: Sequence[Case]) -> tuple[str, ...]:
        """Return the rig parameters that a refit to several recordings may move."""
        return tuple(dict.fromkeys(key for case in cases for key in self.fitted(case)))

    def first_guess(self, case: Case) -> dict[str, float]:
        """Return where a fit of the free rig parameters should start, as far as data tell."""
        return {}

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return the unknowns of one recording alone, given the effects that are on."""
        raise NotImplementedError

    def predict(self, case: Case, values: Values) -> Array:
        """Return the judged channel as the model has it [unit of `Case.measured`]."""
        raise NotImplementedError

    def channel_in_si(self, case: Case, values: Values) -> Array:
        """Return the judged channel as the model has it, as it would be recorded [SI]."""
        return self.predict(case, values) * case.scale

    def regimes(self, case: Case) -> dict[str, Mask]:
        """Return phrases that name parts of a recording, with the samples they cover."""
        raise NotImplementedError

    def imitate(
        self, cases: Sequence[Case], values: Sequence[Values], rng: np.random.Generator
    ) -> list[Case]:
        """Return the cases as a rig of these values would have given them; none if it can't."""
        return []

    def tables(self, cases: Sequence[Case]) -> list[Table]:
        """Return the tables that may stand for what no effect explains, of a model that has any."""
        raise NotImplementedError

    def misfit(self, cases: Sequence[Case], residuals: Sequence[Array]) -> Misfit | None:
        """Return what residuals show beside noise, of a model that tables may be added to."""
        return None

    def suspects(
        self, cases: Sequence[Case], residuals: Sequence[Array], noise: Sequence[float]
    ) -> dict[str, float]:
        """Return the blocks that what is left may belong to, with their shares of it."""
        return {self.block: 1.0}

    def block_of(self, effect: Effect, cases: Sequence[Case], values: Sequence[Values]) -> str:
        """Return the block where an effect of this size acts, which may be one of several."""
        return effect.block

    def derived(
        self, case: Case, effect: str
    ) -> dict[str, tuple[str, Callable[[Values, Values], float]]]:
        """Return what follows from an effect's parameters and says more to people.

        Name to unit and a function of the shared and the recording's own values.
        """
        return {}

    def circumstances(self, case: Case) -> dict[str, tuple[float, str]]:
        """Return under which circumstances a recording was taken: value and SI unit."""
        return {"sampling interval": (case.recording.sampling_interval, "s")}

    def forces_at_rest(self, case: Case, values: Values) -> Array:
        """Return the force on what rests and how much of it friction can hold, (2, n) [N].

        Of a case that was not recorded but follows from what friction held.
        """
        raise NotImplementedError

    def breaks_away(self, case: Case) -> Mask:
        """Return where that force is the one at which what rested breaks away, (n,)."""
        raise NotImplementedError

    def closeup(self, case: Case) -> slice:
        """Return the stretch of a recording that a picture should show."""
        return slice(None)

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return the quantities that what is left over may depend on."""
        return {"time": case.recording.time}
