"""The motion behind a noisy displacement: where the piston is, and when it moves which way."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array, Mask, bridged
from pneuservo.diagnosis.models.servo.rests import (
    REST_TIME,
    SHORT_REST,
    Likely,
    chatters,
    keeps_its_place,
    rests_at_first_sight,
    settled,
)
from pneuservo.diagnosis.models.servo.smoother import FASTEST_CREEP, GLIDING, smooth
from pneuservo.diagnosis.models.servo.turning import mean_direction

Creep = tuple[float, float]
"""Speed of creep [m/s], and time within which that at which a piston comes to rest fades [s]."""
Way = tuple[Array, Array]
"""How a piston comes to rest and creeps there: both numbers of a `Creep` at each sample."""

FORCE_CHANGES = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Accelerations by which an unmodelled force, friction above all, may jump [m/s^2]; the one that
makes the recorded displacement likeliest is taken."""
RESTS = (
    (GLIDING, 5e-3),
    (1e-6, 5e-3),
    (1e-5, 5e-3),
    (1e-5, 0.02),
    (1e-5, 0.035),
    (1e-5, 0.06),
    (1e-5, 0.12),
)
"""A piston at rest glides to a stop, or creeps at such a speed [m/s] while that at which it came
fades within such a time [s], as loops bring it to a set point; the likeliest for each rest."""
CREEPS = ((FASTEST_CREEP, 0.12), (FASTEST_CREEP, 0.5))
"""Further ones, as a chamber that leaks lets it go: what creeps so fast would pass for rest where
it moves, and is not looked for before it is known where it rests ..."""
PLAINLY = 25.0
"""... nor believed unless it makes the logarithm of the likelihood of a rest larger by this: it may
follow the wandering zero, and of 1,000 rests in 20 pairs of recordings without any effect none
gained more than 21. (One that a leaking rod seal let creep by 70 um/s gained 333; taken to rest as
after the stops it crept by 45, and a quarter of the leak was missed.)"""
_PASSES = 2
"""So many times at most a motion is smoothed again with the friction that it tells itself."""
SLOWEST_MOTION = 5e-4
"""The velocity of a moving piston is never taken to be known better than this [m/s]."""
EDGE = 5e-3
"""When a piston comes to rest and breaks away is known to about this [s]."""
STICK_SLIP = 0.2
"""Share of the speed at which a piston comes to rest, or creeps, by which that may be off: it
sticks and slips by less than its displacement tells. (Of 24 recordings without any effect it makes
the innovations likelier by 720 in all; with half of the speed a play is not recovered any more.)"""


def smooth_motion(
    time: Array,
    displacement: Array,
    noise_rms: float,
    driving: Array | None,
    driving_rms: float,
    friction: float,
) -> tuple[Array, Array, Array, Array, Mask]:
    """Return displacement, velocity and acceleration without the displacement's noise.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    displacement : (n,) array
        As measured; NaN where there is none [m].
    noise_rms : float
        Its noise, whose zero wanders as that of any transducer [m].
    driving : (n,) array or None
        Acceleration that the measured pressures would give without friction [m/s^2].
    driving_rms : float
        Noise of that acceleration [m/s^2].
    friction : float
        Acceleration that the Coulomb friction takes [m/s^2].

    Returns
    -------
    displacement, velocity, acceleration : (n,) array
        [m], [m/s], [m/s^2].
    velocity_rms : (n,) array
        How well the velocity is known [m/s].
    rest : (n,) array of bool
        While the piston rests.

    Notes
    -----
    Kalman filter and Rauch-Tung-Striebel smoother (Rauch, Tung and Striebel 1965) for
    acceleration = driving + disturbance, the disturbance a random walk that takes up friction,
    gravity and a wrong mass. The pressures carry the fast part of the acceleration, so that no
    cut-off has to be chosen. While the piston sticks they do not move it, and what their noise
    makes of its velocity would go on into the chambers: where it makes the readings likelier they
    are left out, and it comes to rest slowly, or creeps. The wandering zero is part of the
    displacement, not of the velocity: a piston at rest does not follow it.
    """
    known = np.zeros_like(time) if driving is None else driving
    start = float(displacement[np.isfinite(displacement)][0])
    variance = max(noise_rms, 1e-9) ** 2
    filtered = _Filter(
        time, displacement - start, variance, known, driving_rms**2, friction, np.zeros_like(time)
    )
    interval = float(np.median(np.diff(time)))
    chatter = chatters(known, driving_rms, friction, math.sqrt(variance), interval)
    rest, way = _where_it_rests(filtered, chatter, interval)
    if rest.any():
        way = filtered.likeliest_way(rest, filtered.likeliest_change(rest, way), CREEPS)
    # While it rests, nothing jumps: how much does otherwise shows now.
    change = filtered.likeliest_change(rest, way)
    states, variances, _ = filtered.passed(rest, change, way, back=True)
    for _ in range(_PASSES if driving is not None else 0):
        slid = filtered.sliding(states[:, 1], math.sqrt(_typical(variances, rest)))
        change = slid.likeliest_change(rest, way)
        if slid.likelihood(rest, change, way) <= filtered.likelihood(rest, change, way):
            break
        filtered = slid
        states, variances, _ = filtered.passed(rest, change, way, back=True)
    # A moving piston's velocity is as well known as it is on the whole.
    typical = _typical(variances, rest)
    acceleration = states[:, 2] + np.where(rest, 0.0, known + filtered.given)
    # Where a rest begins and ends, the velocity is known as well as the moment.
    unsure = _change(states[:, 1], interval) if rest.any() else 0.0
    at_rest = np.clip(variances + unsure**2, 0.0, None)
    at_rest = np.hypot(np.sqrt(at_rest), STICK_SLIP * np.abs(states[:, 1]))
    velocity_rms = np.where(rest, at_rest, np.sqrt(typical))
    return states[:, 0] + states[:, 3] + start, states[:, 1], acceleration, velocity_rms, rest


@dataclass(frozen=True)
class _Filter:
    """A displacement and what drives it, to be smoothed; as in `smooth`."""

    time: Array
    measured: Array
    variance: float
    driving: Array
    driving_variance: float
    friction: float
    given: Array

    def passed(
        self, rest: Mask, change: float, way: Way, back: bool = False
    ) -> tuple[Array, Array, Array]:
        """Return states, variances of the velocity, and how likely each reading is."""
        found: tuple[Array, Array, Array] = smooth(
            self.time,
            self.measured,
            self.variance,
            self.driving,
            self.driving_variance,
            self.given,
            change,
            rest,
            *way,
            self.friction,
            back,
        )
        return found

    def sliding(self, velocity: Array, velocity_rms: float) -> "_Filter":
        """Return the same with the friction of a piston that moves in this way."""
        direction = mean_direction(velocity, max(velocity_rms, SLOWEST_MOTION))
        return replace(self, given=-self.friction * np.roll(direction, 1))

    def likelihood(self, rest: Mask, change: float, way: Way) -> float:
        return float(np.sum(self.passed(rest, change, way)[2]))

    def likeliest_way(self, rest: Mask, change: float, creeps: Sequence[Creep] = ()) -> Way:
        """Return the likeliest way to come to each rest, and one that creeps if plainly so."""
        each, ways = _rest_of_each(rest), (*RESTS, *creeps)
        likely = np.array(
            [np.bincount(each, self.passed(rest, change, self.throughout(*w))[2]) for w in ways]
        )
        likely[len(RESTS) :] -= PLAINLY
        creep, fades = np.array(ways)[np.argmax(likely, axis=0)[each]].T
        return np.ascontiguousarray(creep), np.ascontiguousarray(fades)

    def likeliest_change(self, rest: Mask, way: Way) -> float:
        return max(FORCE_CHANGES, key=lambda change: self.likelihood(rest, change, way))

    def throughout(self, creep: float, fades: float) -> Way:
        """Return one way to come to every rest."""
        return np.full_like(self.time, creep), np.full_like(self.time, fades)


def _where_it_rests(filtered: _Filter, chatter: Mask, interval: float) -> tuple[Mask, Way]:
    """Return where a piston rests and how it comes to rest, or nowhere, as is likeliest."""
    time, measured, variance = filtered.time, filtered.measured, filtered.variance
    nowhere, everywhere = np.zeros(len(time), dtype=np.bool_), np.ones(len(time), dtype=np.bool_)
    glides = filtered.throughout(*RESTS[0])
    change = filtered.likeliest_change(nowhere, glides)

    def likely(rest: Mask) -> Likely:
        way = filtered.likeliest_way(rest, change)
        return lambda close: filtered.passed(close, change, way)[2]

    moving = filtered.passed(nowhere, change, glides)[2]
    at_rest = filtered.passed(everywhere, change, glides)[2]
    long = rests_at_first_sight(at_rest - moving, chatter, interval)
    closed = bridged(time, measured)
    short, still = (
        keeps_its_place(closed, variance, moving, chatter, interval, over)
        for over in (SHORT_REST, REST_TIME)
    )
    best, most = (nowhere, glides), float(np.sum(moving))
    # One that glides along slowly looks at rest, too: where it keeps its place, it does not glide.
    for tried in (long, long | short, still):
        if tried.any() and (tried is not still or _glides(*best)):
            rest = settled(tried, likely, interval)
            way = filtered.likeliest_way(rest, change)
            # Where each begins and ends was chosen too (Schwarz 1978).
            chosen = np.count_nonzero(rest[1:] != rest[:-1])
            worth = filtered.likelihood(rest, change, way) - 0.5 * chosen * math.log(len(rest))
            if worth > most:
                best, most = (rest, way), worth
    return best


def _glides(rest: Mask, way: Way) -> bool:
    """Return whether a piston glides to any rest, or to none."""
    creep, _ = way
    return not rest.any() or bool(np.any(creep[rest] == GLIDING))


def _rest_of_each(rest: Mask) -> NDArray[np.int_]:
    """Return to which rest each sample belongs: to the nearest one.

    Examples
    --------
    >>> _rest_of_each(np.array([False, True, True, False, False, False, True, False])).tolist()
    [0, 0, 0, 0, 1, 1, 1, 1]
    """
    edges = np.flatnonzero(np.diff(rest, prepend=False, append=False))
    begins, ends = edges[::2], edges[1::2]
    halfway = (ends[:-1] + begins[1:]) // 2
    return np.searchsorted(halfway, np.arange(len(rest)), side="right")


def _typical(variances: Array, rest: Mask) -> float:
    """Return how well the velocity of a piston is known on the whole, squared [m^2/s^2]."""
    return float(np.median(variances if rest.all() else variances[~rest]))


def _change(velocity: Array, interval: float) -> Array:
    """Return by how much a velocity changes within the time that an edge may be off [m/s]."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = 2 * max(1, round(EDGE / interval)) + 1
    highest, lowest = maximum_filter1d(velocity, width), minimum_filter1d(velocity, width)
    return np.asarray(np.maximum(highest - velocity, velocity - lowest))
