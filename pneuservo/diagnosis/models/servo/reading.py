"""A recording of the servo as it is read: what of it is judged, with its command taken one way."""

from collections.abc import Callable, Sequence

import numpy as np

from pneuservo.diagnosis.models.model import Case, Values
from pneuservo.diagnosis.models.servo.between_samples import OTHER_WAYS, AsGiven
from pneuservo.diagnosis.models.servo.estimate import as_it_moves, with_gains
from pneuservo.diagnosis.models.servo.feed import AT_REST, SUPPLY, Feed
from pneuservo.diagnosis.models.servo.likelihood import compared
from pneuservo.diagnosis.models.servo.moved import held_at_stops
from pneuservo.diagnosis.models.servo.stops import judged_at_rest
from pneuservo.diagnosis.models.servo.without_hum import without_hum
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

FEWEST = 50
"""Samples below which a channel is not judged: a piston that rests all the time tells nothing."""
_FEWEST_RESTS = 4
"""Moments below which the force on a piston at rest is not judged."""
_JUDGED = (
    ("displacement", "m"),
    ("pressure_a", "Pa"),
    ("pressure_b", "Pa"),
    (SUPPLY, "Pa"),
    ("spool", ""),
)


def read(
    recorded: Recording, rig: Rig, as_given: AsGiven, begun: Feed, looks_for_rests: bool
) -> list[Case]:
    """Return a recording once per judged channel, each in units of its noise.

    Parameters
    ----------
    recorded : Recording
        With its hum.
    rig : Rig
        The rig it was taken on.
    as_given : callable
        Makes of a feed one whose command is read in one way.
    begun : Feed
        Of the recording, whatever its command.
    looks_for_rests : bool
        Whether friction may hold the piston on its way, or the stops alone.

    Raises
    ------
    InputError
        If there is nothing to judge.
    """
    recording, fed = without_hum(recorded, rig, as_given, begun)
    if not looks_for_rests:
        fed = with_gains(held_at_stops(fed, rig), rig)
    return _judged(recorded, recording, rig, begun, fed)


def moved_as_found(
    cases: Sequence[Case], values: Sequence[Values], looks_for_rests: bool
) -> list[list[Case]]:
    """Return recordings as they are, and with a motion smoothed by what was found of their rig.

    Parameters
    ----------
    cases : sequence of Case
        Of `read`.
    values : sequence of mapping
        What is known of each of them by now.
    looks_for_rests : bool
        As for `read`.

    Notes
    -----
    How a piston moves within the noise of its displacement is told by the force on it, and by what
    friction takes of that. Of a relay's loop whose piston was held by 12 N instead of 2, the right
    parameters left 2.4 times the noise of the displacement, and 1.1 times once it was smoothed so.
    """
    found: list[Case] = []
    for case, known in zip(cases, values, strict=True):
        if not case.inputs["leads"]:
            continue
        rig = case.rig.with_values({key: known[key] for key in known if key in case.rig.parameters})
        fed = as_it_moves(case.inputs["feed"], rig)
        if not looks_for_rests:
            fed = held_at_stops(fed, rig)
        fed = with_gains(fed, rig)
        begun = case.inputs["begun"]
        try:
            found += _judged(case.origin, case.recording, case.rig, begun, fed)
        except InputError:
            found += [other for other in cases if other.origin is case.origin]
    return compared([list(cases), found])


def _judged(
    recorded: Recording, recording: Recording, rig: Rig, begun: Feed, fed: Feed
) -> list[Case]:
    """Return a recording without its hum once per channel that can be judged."""
    found: list[Case] = []
    too_few: dict[str, int] = {}
    for channel, unit in _JUDGED:
        if channel not in recording:
            continue
        noise = fed.noise[channel]
        usable = np.isfinite(recording[channel]) & ~fed.blind
        if channel == "displacement":
            usable = usable & (~fed.held | (fed.resting != 0))
        if np.count_nonzero(usable) < FEWEST:
            too_few[channel] = int(np.count_nonzero(usable))
            continue
        found.append(
            Case(
                recording,
                recording[channel] / noise,
                {"feed": fed, "leads": not found, "recorded": recorded, "begun": begun},
                1.0,
                rig,
                usable,
                channel,
                unit,
                noise,
            )
        )
    at_rest = judged_at_rest(fed.stuck & ~fed.blind, recording.sampling_interval)
    at_rest[fed.breaks_away] = ~fed.blind[fed.breaks_away]
    if found and np.count_nonzero(at_rest) >= _FEWEST_RESTS:
        found.append(
            Case(
                recording,
                np.zeros_like(fed.time),
                {"feed": fed, "leads": False, "recorded": recorded},
                1.0,
                rig,
                at_rest,
                AT_REST,
                "",
                finest=1.0,
                recorded=False,
            )
        )
    if not found:
        raise InputError(
            f"{recorded.source or recorded.name}: there is nothing to judge: where the piston does "
            "not move its place tells nothing, and there are "
            + ", ".join(f"{count} usable samples of {name}" for name, count in too_few.items())
            + f"; {FEWEST} are needed. Record both pressures, a motion, or for longer"
        )
    return found


def in_each_way(cases: Sequence[Case], looks_for_rests: bool) -> list[list[Case]]:
    """Return recordings as they are read and in every other way in which their command may be.

    Parameters
    ----------
    cases : sequence of Case
        Of `read`.
    looks_for_rests : bool
        As for `read`.
    """
    feeds = [case.inputs["feed"] for case in cases if case.inputs["leads"]]
    asked = [way for way in OTHER_WAYS if any(way[1](fed) for fed in feeds)]
    others = side_by_side(lambda way: _otherwise(cases, *way, looks_for_rests), asked)
    return compared([list(cases), *others])


def _otherwise(
    cases: Sequence[Case],
    as_given: AsGiven,
    where: Callable[[Feed], bool],
    looks_for_rests: bool,
) -> list[Case]:
    """Return the cases read in another way; those of which nothing could be judged as before.

    Read in the wrong way a relay leaves lines that pass for hum: it is looked for in each.
    """
    found: list[Case] = []
    for case in cases:
        if not case.inputs["leads"]:
            continue
        as_before = [other for other in cases if other.origin is case.origin]
        try:
            asked = where(case.inputs["feed"])
            begun = case.inputs["begun"]
            found += (
                read(case.origin, case.rig, as_given, begun, looks_for_rests)
                if asked
                else as_before
            )
        except InputError:
            found += as_before
    return found
