"""The single-axis servo, followed by an observer from command and measurements."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.model import (
    Case,
    Levels,
    Misfit,
    Model,
    Table,
    Unknown,
    Values,
    is_among,
)
from pneuservo.diagnosis.models.plausible import require_absolute, require_on_stroke, require_times
from pneuservo.diagnosis.models.servo.between_samples import AsGiven, with_running_command
from pneuservo.diagnosis.models.servo.command import is_relay
from pneuservo.diagnosis.models.servo.converted import with_noise_of_steps
from pneuservo.diagnosis.models.servo.estimate import with_gains
from pneuservo.diagnosis.models.servo.feed import AT_REST, CHANNELS, PRESSURES, SUPPLY, Feed
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.gaps import with_gaps_as_missing
from pneuservo.diagnosis.models.servo.imitation import imitation_of
from pneuservo.diagnosis.models.servo.likelihood import deviance_of, innovations, levels_of
from pneuservo.diagnosis.models.servo.misfit import misfit_of
from pneuservo.diagnosis.models.servo.nuisances import nuisances_of
from pneuservo.diagnosis.models.servo.reading import (
    FEWEST,
    in_each_way,
    moved_as_found,
    read,
)
from pneuservo.diagnosis.models.servo.regimes import regimes_of
from pneuservo.diagnosis.models.servo.run_observer import forces_at_rest
from pneuservo.diagnosis.models.servo.stand_ins import with_stand_ins
from pneuservo.diagnosis.models.servo.supply import (
    phase_of,
    sharpest_frequency,
    strongest_frequency,
)
from pneuservo.diagnosis.models.servo.tables import quantities_of, tables_of
from pneuservo.diagnosis.models.servo.trust import (
    steadily,
    surer_of_command,
    unsure,
    unsure_of_approach,
    unsure_of_rest,
)
from pneuservo.effects import Effect
from pneuservo.effects.supply import RIPPLE
from pneuservo.plant.servo.unexplained_effects import QUANTITIES
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_INTERVALS = (5e-6, 0.05)
"""Between samples of a servo [s]: a spool is done within 10 ms, and a piston swings in 50."""
_ONLY_NOISE = ("sensor.noise-colour", "sensor.quantisation")
_STANDS_STILL = 0.5
"""Share of the intervals in which a command does that comes from a table and not from a loop."""
_ROWS = (*CHANNELS, AT_REST)


class ServoModel(Model):
    """Displacement and pressures, each expected from the command and from all that came before.

    Notes
    -----
    The servo is simulated and told, at every sample, how wrong it was: what is left are
    innovations, white and of the size of the noise when nothing is missing. Every channel counts
    in its own noise; a pressure that was not measured is estimated on the way.
    """

    kind: ClassVar[str] = "single-axis"
    channel: ClassVar[str] = "displacement"
    unit: ClassVar[str] = "m"
    block: ClassVar[str] = "piston"
    follows: ClassVar[tuple[str, ...]] = PRESSURES
    # The air outside is what the exhaust edges blow into, that inside of both chambers one gas.
    blocks: ClassVar[Mapping[str, str]] = {
        "ambient": "valve.flow",
        "chamber": "chamber.a",
        "": "supply",
    }
    required: ClassVar[tuple[str, ...]] = (
        "valve_voltage",
        "displacement",
    )
    steady: ClassVar[bool] = True
    joint: ClassVar[bool] = True
    tabulates: ClassVar[bool] = True
    # Whether a spool that swings beyond a large command hits the end of its travel.
    ridges: ClassVar[tuple[str, ...]] = ("valve.spool.damping",)
    late: ClassVar[tuple[str, ...]] = ("valve.spool", "lines")
    unread: ClassVar[tuple[str, ...]] = (
        "velocity",
        "acceleration",
        "temperature_a",
        "temperature_b",
    )

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects that change what is expected; noise explains nothing."""
        return tuple(effect for effect in super().effects if effect.id not in _ONLY_NOISE)

    def starts(self, effect: Effect, cases: Sequence[Case]) -> dict[str, tuple[float, ...]]:
        """Return the catalogue's starts, but for a ripple whose frequency shows.

        Of a supply that was not recorded it shows in both chambers, beside what they do.
        """
        found = super().starts(effect, cases)
        fed: Feed = cases[0].inputs["feed"]
        if effect is not RIPPLE:
            return found
        if fed.supply is not None:
            found["frequency"] = (_ripple_in(cases[0])[0],)
        elif any(fed.measured):
            found["frequency"] += (_ripple_in(cases[0])[0],)
        return found

    def completed(self, recording: Recording, rig: Rig) -> Recording:
        """Return a recording whose command and displacement may be those of the card's taps.

        Its noise is that of its transducers and of their converters. What changes in the course of
        a recording counts from where that begins.
        """
        require_times(recording, *_INTERVALS)
        require_absolute(recording, *PRESSURES, SUPPLY)
        complete = with_stand_ins(with_gaps_as_missing(recording.from_its_start()), rig)
        return with_noise_of_steps(complete)

    def cases(self, recording: Recording, rig: Rig) -> list[Case]:
        """Return the recording once per judged channel, each in units of its noise."""
        require_on_stroke(recording, rig["piston.stroke"])
        begun = feed(recording, rig)
        return read(recording, rig, with_running_command, begun, self._looks_for_rests)

    def readings(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases with a command that runs on and with one that is held.

        A controller that samples holds its command, and a recorder sees what it holds from then on
        or what it has held until then; an analogue one, or a generator, does not hold it. One
        whose set point comes from a converter jumps with that, and runs on in between; so does one
        that hears the noise of a transducer which is sampled.
        """
        return in_each_way(cases, self._looks_for_rests)

    @property
    def _looks_for_rests(self) -> bool:
        return "stick-mask" not in self.without

    def stored(self, case: Case) -> bool:
        """Return whether the command stands still but for jumps and is not that of a relay.

        At its highest and its lowest that of a loop stands still, too.
        """
        voltage = case.inputs["feed"].voltage
        between = (voltage > np.min(voltage)) & (voltage < np.max(voltage))
        inside = between[1:] | between[:-1]
        still = np.mean(np.diff(voltage)[inside] == 0.0) if inside.any() else 0.0
        return bool(still > _STANDS_STILL) and not is_relay(voltage)

    def is_known_between_samples(self, case: Case) -> bool:
        """Return whether the command is held from sample to sample, or stands still but for jumps.

        Where the motion or another pressure is not known well, a held one's pressure may be left at
        less than its noise all the same: a relay's at 0.66, with the other pressure missing.
        """
        return not case.inputs["feed"].ramped or self.stored(case)

    def followed(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases with as much of an unmodelled force as ever, with little, and unsure.

        An observer that allows for much of it follows a slow misfit instead of showing it. So
        does one that is unsure of the motion: that is for what moves unseen alone.
        """
        return _different([cases, self.trusted(cases), _followed(cases, unsure)])

    def moved(self, cases: Sequence[Case], values: Sequence[Values]) -> list[list[Case]]:
        """Return the cases as they are, and with motions smoothed by what was found of the rig."""
        return moved_as_found(cases, values, self._looks_for_rests)

    def told(self, cases: Sequence[Case], used: Sequence[Case]) -> list[Case]:
        """Return cases that were held back; where a stop is that was never reached is not judged.

        The stroke is known within its tolerance alone: 0.14 mm of it, read while the piston lay at
        the far stop, decided whether friction that grows with rest was there.
        """
        if any(np.any(case.inputs["feed"].resting == 1) for case in used):
            return list(cases)
        found = []
        for case in cases:
            usable = case.usable & (case.inputs["feed"].resting != 1)
            is_told = case.channel != "displacement" or np.count_nonzero(usable) < FEWEST
            found.append(case if is_told else replace(case, usable=usable))
        return found

    def excused(self, cases: Sequence[Case]) -> list[list[Case]]:
        """Return the cases with each trust by which a way to read them may be judged.

        What a piston at rest does unseen must not tell how a command is read: one of 7 kg that
        rang by 10 um before it stuck left so much that a command which was held was likelier, by
        757, one that ran on, for what that does between its samples excuses as much. Nor would it
        do to follow recordings so: what is that unsure of a piston at rest does not see it leak.
        Nor must how one comes to rest: by stops and goes of a piston that comes slowly two loops on
        a computer were likelier by 132 and 160 as ones that run on, which allows for more between
        their samples (now less likely by 220 and 460). Nor must what a noisy command may have
        done between its samples, and did not: one that a card had smoothed was likelier held, by
        247, with its spool five tolerances too fast, for both missed the pressures by as little,
        and only one had allowed for more.
        """
        steady = self.trusted(cases)
        unsure_ways = [_followed(cases, way) for way in (unsure, unsure_of_rest)]
        surer_ways = [_followed(way, surer_of_command) for way in (cases, steady)]
        stopping = _followed(steady, unsure_of_approach)
        return _different([cases, steady, *unsure_ways, stopping, *surer_ways])

    def trusted(self, cases: Sequence[Case]) -> list[Case]:
        """Return the cases with next to no unmodelled force."""
        return _followed(cases, steadily)

    def levels(self, cases: Sequence[Case], values: Sequence[Values]) -> Levels:
        """Return how large innovations are where the command is calm, in their noise squared."""
        return levels_of(cases, values)

    def deviance(
        self, cases: Sequence[Case], values: Sequence[Values], levels: Levels | None = None
    ) -> float:
        """Return how unlikely the innovations of all recordings are, each counted once.

        In their noise, or in the levels that are given.
        """
        return deviance_of(cases, values, levels)

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return every parameter that is known within a tolerance only."""
        measured_supply = case.inputs["feed"].supply is not None
        return tuple(
            key
            for key, parameter in case.rig.parameters.items()
            if parameter.tolerance
            and not (measured_supply and key == "supply.pressure")
            and not ("nuisances" in self.without and key.startswith("valve.spool."))
        )

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return what differs from recording to recording though the rig is the same."""
        fitted = "nuisances" not in self.without
        found = nuisances_of(case, fitted)
        fed: Feed = case.inputs["feed"]
        tells = fed.supply is not None or any(fed.measured)
        if fitted and tells and case.inputs["leads"] and RIPPLE.id in active:
            # When a recording begins a swing of the supply is anywhere.
            phase = _ripple_in(case)[1]
            found.append(Unknown(RIPPLE.key("phase"), phase, -np.inf, np.inf, None, "rad"))
        return found

    def predict(self, case: Case, values: Values) -> Array:
        """Return the judged channel as expected from its surroundings and its own past."""
        fed: Feed = case.inputs["feed"]
        left = innovations(fed, values, case.rig)[_ROWS.index(case.channel)]
        expected: Array = case.measured - left / case.scale
        return expected

    def forces_at_rest(self, case: Case, values: Values) -> Array:
        """Return the force on the piston at rest and how much of it friction can hold [N]."""
        return forces_at_rest(case.inputs["feed"], values, case.rig)

    def breaks_away(self, case: Case) -> Mask:
        """Return where that force is the one at which the piston breaks away."""
        found = np.zeros(len(case.recording.time), dtype=np.bool_)
        found[case.inputs["feed"].breaks_away] = True
        return found

    def tables(self, cases: Sequence[Case]) -> list[Table]:
        """Return tables of a force or a flow over everything that was recorded."""
        return tables_of(cases)

    def misfit(self, cases: Sequence[Case], residuals: Sequence[Array]) -> Misfit | None:
        """Return what innovations of the right model never show."""
        return misfit_of(cases, residuals)

    def imitate(
        self, cases: Sequence[Case], values: Sequence[Values], rng: np.random.Generator
    ) -> list[Case]:
        """Return the recordings as the rig of these values would have given them."""
        found: list[Case] = []
        copies: dict[int, Feed] = {}
        for case, mine in zip(cases, values, strict=True):
            fed: Feed = case.inputs["feed"]
            if id(fed) not in copies:
                copies[id(fed)] = imitation_of(case, mine, rng)
            copy = copies[id(fed)]
            reading = copy.reading
            if case.channel in PRESSURES:
                reading = copy.pressures[PRESSURES.index(case.channel)]
            elif case.channel == SUPPLY:
                reading = copy.supply_reading
            elif case.channel == "spool":
                reading = copy.spool_reading
            elif case.channel == AT_REST:
                reading = case.measured
            found.append(
                replace(case, measured=reading / case.scale, inputs={**case.inputs, "feed": copy})
            )
        return found

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return motion, pressures, opening and time."""
        recorded = zip(QUANTITIES, quantities_of(case.inputs["feed"], case.rig), strict=True)
        # A displacement in one direction is the same one.
        return {name: values for name, values in recorded if " while " not in name}

    def regimes(self, case: Case) -> dict[str, Mask]:
        """Return parts of the recording by motion, place, opening, pressure ratio and time."""
        return regimes_of(case.inputs["feed"], case.rig)


def _different(ways: Sequence[Sequence[Case]]) -> list[list[Case]]:
    """Return ways to follow the same recordings, each once."""
    found: list[list[Case]] = []
    for way in ways:
        if not is_among(way, found):
            found.append(list(way))
    return found


def _followed(cases: Sequence[Case], as_given: AsGiven) -> list[Case]:
    """Return cases whose observers are given another feed, or the same where it is no other."""
    feeds: dict[int, Feed] = {}
    found = []
    for case in cases:
        fed: Feed = case.inputs["feed"]
        if id(fed) not in feeds:
            other = as_given(fed, case.rig)
            feeds[id(fed)] = fed if other is fed else with_gains(other, case.rig)
        other = feeds[id(fed)]
        found.append(case if other is fed else replace(case, inputs={**case.inputs, "feed": other}))
    return found


def _ripple_in(case: Case) -> tuple[float, float]:
    """Return frequency [Hz] and phase [rad] of what may be a ripple of the supply.

    Of a supply that was not recorded it shows in both chambers, beside what they do.
    """
    fed: Feed = case.inputs["feed"]
    if fed.supply is not None:
        frequency = strongest_frequency(fed.time, fed.supply_reading)
        return frequency, phase_of(fed.time, fed.supply_reading, frequency)
    left = np.sum(innovations(fed, {}, case.rig)[: len(PRESSURES)], axis=0)
    frequency = sharpest_frequency(fed.time, left)
    return frequency, phase_of(fed.time, left, frequency)
