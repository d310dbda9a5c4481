"""How likely recordings of the servo are as they are read and followed."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.model import Case, Levels, Values
from pneuservo.diagnosis.models.servo.feed import CHANNELS, FOLLOWED, Feed
from pneuservo.diagnosis.models.servo.run_observer import run_observer
from pneuservo.rigs import Rig

_NO_MISFIT = 1.25
"""Noise is known to about a tenth: a square that is larger by less is none."""
_MEDIAN = 0.455
"""Of the square of a standard normal variable."""
_RUNS_ON = {"analogue-card": True, "digital": False, "hybrid": False}
"""Whether the command of a controller that a sidecar states runs on from sample to sample."""
_OTHERWISE_THAN_STATED = 50.0
"""What the method's own errors may make of two ways to read a command, as of any two laws; a
computer may sample faster than the recorder, and a command is held then by neither."""


def innovations(fed: Feed, values: Values, rig: Rig) -> Array:
    """Return the innovations of all channels, worked out once for all of them.

    Parameters
    ----------
    fed, values, rig
        As in `pneuservo.diagnosis.models.servo.run_observer.run_observer`.
    """
    return fed.done.get(tuple(sorted(values.items())), lambda: run_observer(fed, values, rig))


def levels_of(cases: Sequence[Case], values: Sequence[Values]) -> Levels:
    """Return how large innovations are where the command is calm, in their noise squared.

    Parameters
    ----------
    cases : sequence of Case
        Recordings as they are read.
    values : sequence of mapping
        What their rig is like, one per case.
    """
    return {
        (id(case.origin), channel): _level(squares, shares, _calm(case.inputs["feed"].voltage))
        for case, mine in zip(cases, values, strict=True)
        if case.inputs["leads"]
        for channel, squares, shares in _seen(case, mine)
    }


def deviance_of(
    cases: Sequence[Case], values: Sequence[Values], levels: Levels | None = None
) -> float:
    """Return how unlikely the innovations of all recordings are, each counted once.

    Parameters
    ----------
    cases, values
        As for `levels_of`.
    levels : mapping, optional
        What innovations count in, of `levels_of`; without them in their noise.

    Notes
    -----
    One whose command is read otherwise than its stated controller puts it out is less likely.
    """
    total = sum(_otherwise_than_stated(case) for case in cases if case.inputs["leads"])
    for case, mine in zip(cases, values, strict=True):
        for channel, squares, shares in _seen(case, mine) if case.inputs["leads"] else ():
            level = levels[id(case.origin), channel] if levels else 1.0
            seen = shares > 0.0
            total += float(np.sum(squares[seen] / level - 2.0 * np.log(shares[seen])))
    return total


def compared(ways: Sequence[Sequence[Case]]) -> list[list[Case]]:
    """Return the cases of all readings, marked with the samples that are judged in each of them.

    Without pressures a piston that chatters may pass for one that sticks in one of them, and what
    is not judged is never unlikely.

    Parameters
    ----------
    ways : sequence of sequence of Case
        The same recordings in several readings.
    """
    everywhere: dict[int, Mask] = {}
    for case in chain(*ways):
        judged = case.inputs["feed"].shares > 0.0
        everywhere[id(case.origin)] = everywhere.get(id(case.origin), True) & judged
    # One that is the same in several readings stays the same: nothing is to be tried twice.
    marked = {
        id(case): replace(case, inputs={**case.inputs, "compared": everywhere[id(case.origin)]})
        for case in chain(*ways)
    }
    return [[marked[id(case)] for case in way] for way in ways]


def _otherwise_than_stated(case: Case) -> float:
    runs_on = _RUNS_ON.get(case.origin.controller.get("kind", ""))
    return 0.0 if runs_on in (None, case.inputs["feed"].ramped) else _OTHERWISE_THAN_STATED


def _seen(case: Case, values: Values) -> Iterator[tuple[str, Array, Array]]:
    """Yield each channel's squared innovations, in noise, and their shares, as in a `Feed`."""
    fed: Feed = case.inputs["feed"]
    shares = np.where(case.inputs.get("compared", True), fed.shares, 0.0)
    noise = fed.noise_of(CHANNELS)[:, np.newaxis]
    squares = (innovations(fed, values, case.rig)[: len(CHANNELS)] / noise) ** 2
    for channel, mine in zip(FOLLOWED, shares.T, strict=True):
        yield channel, squares[CHANNELS.index(channel)], mine
    if len(fed.spool_reading):
        yield "spool", squares[CHANNELS.index("spool")], fed.spool_shares


def _level(squares: Array, shares: Array, calm: Mask) -> float:
    seen = (shares > 0.0) & calm
    level = float(np.median(squares[seen])) / _MEDIAN if np.any(seen) else 1.0
    return level if level > _NO_MISFIT else 1.0


def _calm(voltage: Array) -> Mask:
    """Return the half of the samples at which the command bends least."""
    curve = np.abs(np.diff(voltage, 2, prepend=voltage[0], append=voltage[-1]))
    bend = np.maximum(curve, np.concatenate([[0.0], curve[:-1]]))
    return np.asarray(bend <= np.median(bend))
