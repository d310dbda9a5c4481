"""The force at which friction lets go a piston that has been at rest."""

import math
from typing import NamedTuple

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.advance import followed
from pneuservo.diagnosis.models.servo.push import balance_at_rest, push
from pneuservo.diagnosis.models.servo.stops import each_rest
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.drift import drifted_by
from pneuservo.plant.single_axis import DISPLACEMENT, PRESSURE_A, PRESSURE_B, SPOOL

UNEVEN = 0.1
"""Share by which friction at rest differs from place to place, and its laws in form."""
_GIVES_WAY = 1e-5
"""By so much real friction may give way before it slips [m]: how far a piston has come when it has
left its place is known no better. (At 516 departures in recordings without any effect the right
friction was off by 0.58 of what all this makes of the force, root mean square, and by 3.1 at the
most.)"""
_RESTED = 0.06
"""What has been at rest for less may have slid to and fro [s]."""
_BEFORE = 0.06
"""It has gone no earlier than so long before it was seen to move [s] ..."""
_AFTER = 0.1
"""... and has left its place within this time [s] ..."""
_LEFT = 5.0
"""... by so many times the noise of its displacement and what friction may give way by ..."""
_PLACE_KNOWN = 0.4
"""... to this share of which noise the smoothed displacement is known then."""
_AS_FAR = 1.0 - 1e-9
"""One that goes too early waits until it is pushed, and comes as far."""


class Departures(NamedTuple):
    """When a piston left the places at which friction had held it, each (m,)."""

    rested: Array
    """Sample from which it rested."""
    at: Array
    """Sample at which it was last seen at rest."""
    first: Array
    """First sample at which it may have gone."""
    gone: Array
    """Sample at which it had left its place."""
    side: Array
    """Which way, 1 extending and -1 retracting."""
    unsure: Array
    """How well it is known how far it had come then [m]."""


NOWHERE = Departures(*np.empty((6, 0)))
"""Of a piston that was not seen to leave any place."""


def departures(
    motion: Array, held: Mask, stuck: Mask, noise_rms: float, interval: float
) -> Departures:
    """Return when a piston leaves the places at which friction has held it.

    Parameters
    ----------
    motion : (3, n) array
        Smoothed displacement, velocity and acceleration, SI.
    held, stuck : (n,) array of bool
        While it is held, and while nothing but friction holds it.
    noise_rms : float
        Of the displacement [m].
    interval : float
        Of the samples [s].

    Examples
    --------
    >>> place = np.maximum(np.arange(600) - 400, 0) * 1e-5
    >>> motion = np.array([place, np.gradient(place, 1e-3), 0.0 * place])
    >>> stuck = np.arange(600) < 410
    >>> found = departures(motion, stuck, stuck, 1e-5, 1e-3)
    >>> [float(part[0]) for part in found[:5]]
    [0.0, 409.0, 350.0, 408.0, 1.0]
    """
    far = _LEFT * math.hypot(noise_rms, _GIVES_WAY)
    before, after = round(_BEFORE / interval), round(_AFTER / interval)
    found = []
    for begin, end in each_rest(stuck):
        first = max(begin, end - before)
        way = motion[0, first : end + after] - motion[0, first]
        left = np.flatnonzero(np.abs(way) > far)
        if end - begin < _RESTED / interval or end == len(stuck) or not len(left):
            continue
        gone, side = first + int(left[0]), float(np.sign(way[left[0]]))
        if side * motion[1, gone] > 0.0 and gone > first + 1:
            moved = np.flatnonzero(~held[:begin])
            found.append((moved[-1] + 1 if len(moved) else 0, end - 1, first, gone, side))
    unsure = math.hypot(_PLACE_KNOWN * noise_rms, _GIVES_WAY)
    moments = np.array(found, dtype=float).reshape(-1, 5).T
    return Departures(*np.vstack([moments, np.full(moments.shape[1], unsure)]))


def as_in(other: Departures, own: Departures, interval: float) -> Departures:
    """Return departures of a copy at the samples at which the original is judged.

    Parameters
    ----------
    other, own : Departures
        Of the original, and of the copy: what did not leave about then, or the other way, is not
        judged.
    interval : float
        Of the samples [s].
    """
    near = np.abs(other.at[:, np.newaxis] - own.at) <= _BEFORE / interval
    near &= other.side[:, np.newaxis] == own.side
    mine, its = np.nonzero(near)
    mine, once = np.unique(mine, return_index=True)
    matched = Departures(*(part[its[once]] for part in own))
    return matched._replace(at=other.at[mine])


@compiled
def forces_at_breakaway(
    departures, time, path, external_force, force_rms, place, way, state, servo, drift
):
    """Return the force at which a piston breaks away, and how much of it friction should hold.

    Parameters
    ----------
    departures : Departures
        When it leaves its places.
    time : (n,) array
        [s].
    path : (4, n) array
        Pressures and opening as the observer follows them: averages of what was measured would
        begin to change before they do.
    external_force : (n,) array
        At the rod and of what the piston carries, positive when it resists extension [N].
    force_rms : (m,) array
        How well pressures and rod tell the force [N].
    place : (n,) array
        Displacement of the piston [m].
    way : (m,) array
        How far it has come when it has left its place [m].
    state : (PLANT_STATES,) array
        Of the plant alone; written.
    servo : Servo
        The numbers of rig and effects.
    drift : Table or None
        From `pneuservo.plant.servo.drift.drift_of`.

    Returns
    -------
    (3, m) array
        The force at the moment from which it comes as far as it came, towards where it went; what
        friction should hold then; and by how much the one may differ from the other [N].
    """
    found = np.zeros((3, way.size))
    for event in range(way.size):
        state[DISPLACEMENT] = place[int(departures.first[event])]
        broken = drifted_by(servo, drift, time[int(departures.first[event])])
        came = way[event]
        force, held, went = _went(
            event, came, departures, time, path, external_force, state, broken
        )
        # The force that moves it is known no better than the one that it breaks away at.
        taken = time[int(departures.gone[event])] - went
        unsure = 0.5 * force_rms[event] / broken.plant.piston.mass * taken * taken
        unsure = math.hypot(departures.unsure[event], unsure)
        told = 0.0
        for less in (unsure, -unsure):
            other, _, _ = _went(
                event, came - less, departures, time, path, external_force, state, broken
            )
            told = max(told, abs(other - force))
        doubt = math.hypot(force_rms[event], UNEVEN * held)
        found[0, event], found[1, event], found[2, event] = force, held, math.hypot(doubt, told)
    return found


@compiled
def _went(event, way, departures, time, path, external_force, state, servo):
    """Return at what force a piston went that came so far, what friction should hold, and when.

    Once it has gone, what the model has brake a moving piston acts on it: it starts when it is
    pushed by more than that. If it came farther, it left sooner.
    """
    side, rested = departures.side[event], time[int(departures.rested[event])]
    low, high = int(departures.first[event]), int(departures.gone[event])
    farthest, speed = _comes(low, high, side, time, path, external_force, state, servo)
    sought = min(max(way, 0.0), farthest * _AS_FAR)
    start, until, farther, nearer = low, high, farthest, 0.0
    # The later it goes, the less far it comes.
    while until - start > 1:
        middle = (start + until) // 2
        comes, _ = _comes(middle, high, side, time, path, external_force, state, servo)
        if comes >= sought:
            start, farther = middle, comes
        else:
            until, nearer = middle, comes
    later = (farther - sought) / (farther - nearer) if farther > nearer else 0.0
    sooner = (way - sought) / speed if speed > 0.0 else 0.0
    went = time[start] + later * (time[start + 1] - time[start]) - sooner
    while start > low and time[start] > went:
        start -= 1
    went = max(went, time[low])
    share = (went - time[start]) / (time[start + 1] - time[start])
    force, held = 0.0, 0.0
    for k, part in ((start, 1.0 - share), (start + 1, share)):
        state[PRESSURE_A], state[PRESSURE_B], state[SPOOL] = path[0, k], path[1, k], path[2, k]
        now, holding = balance_at_rest(
            time[k], state, 0.0, time[k] - rested, external_force[k], servo
        )
        force += part * side * now
        held += part * holding
    return force, held, went


@compiled
def _comes(start, end, side, time, path, external_force, state, servo):
    """Return how far a piston is read to have come that goes at one sample, and how fast it is."""
    lag = servo.effects.sensor.displacement_lag
    place, speed, read, last, rest = 0.0, 0.0, 0.0, 0.0, state[DISPLACEMENT]
    for k in range(start, end + 1):
        interval = time[k] - time[k - 1] if k > start else 0.0
        # What drags at it grows within the interval: taken as at its beginning, speeds and ways
        # were 4 % too large, and it had to have gone a millisecond later.
        foreseen = max(speed + interval * last, 0.0)
        state[PRESSURE_A], state[PRESSURE_B], state[SPOOL] = path[0, k], path[1, k], path[2, k]
        state[DISPLACEMENT] = rest + side * (place + 0.5 * interval * (speed + foreseen))
        velocity = side * foreseen
        now = side * push(time[k], state, velocity, velocity, external_force[k], side, servo)
        if k > start:
            if speed > 0.0 or now + last > 0.0:
                # As if the acceleration changed evenly.
                gained = interval * (speed + interval * (2.0 * last + now) / 6.0)
                place += max(gained, 0.0)
                speed = max(speed + 0.5 * interval * (last + now), 0.0)
            read += (place - read) * followed(interval, lag)
        last = now
    state[DISPLACEMENT] = rest
    return read, speed
