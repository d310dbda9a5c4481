"""How the piston of a recording moves, and how sure that and its pressures are."""

from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.breakaway import NOWHERE, departures
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.motion import SLOWEST_MOTION, smooth_motion
from pneuservo.diagnosis.models.servo.rests import chatters
from pneuservo.diagnosis.models.servo.spread import shares_of_spool, spread_of_pressures
from pneuservo.diagnosis.models.servo.stops import (
    OF_FULL_FORCE,
    PRESSED,
    around,
    resting,
    touching,
)
from pneuservo.rigs import Rig

STICKING = 3.0
"""A piston whose velocity is not this many times its uncertainty ..."""
HELD_FOR = 8e-3
"""... for this long counts as held [s]."""
NEVER_MOVES = 1.5
"""A piston never moves whose displacement spreads by less than this many times its noise."""
CREEPING = 3e-4
"""A piston that creeps faster than this slides [m/s]."""


def moved_by(fed: Feed, rig: Rig, force_rms: float | None) -> Feed:
    """Return a feed whose motion is smoothed with the help of its pressures.

    Parameters
    ----------
    fed : Feed
        Its motion, and what follows from it, is replaced.
    rig : Rig
        The rig it was taken on.
    force_rms : float or None
        How well pressures and the rod's force tell the force on the piston; None where they do not
        [N].
    """
    mass = rig["load.mass"]
    driving = None
    if force_rms is not None:
        areas = rig["piston.area_a"], rig["piston.area_b"]
        gauge = fed.pressures - rig["ambient.pressure"]
        driving = (areas[0] * gauge[0] - areas[1] * gauge[1] - fed.force) / mass
        driving += rig["load.gravity"]
    *smoothed, velocity_rms, rest = smooth_motion(
        fed.time,
        fed.reading,
        fed.noise["displacement"],
        driving,
        (force_rms or 0.0) / mass,
        rig["piston.coulomb_friction"] / mass,
    )
    chatter = 0.0
    if driving is not None and force_rms is not None:
        known = force_rms / mass, rig["piston.coulomb_friction"] / mass
        chatter = float(np.mean(chatters(driving, *known, fed.noise["displacement"], fed.interval)))
    motion, moving = np.array(smoothed), velocity_rms if rest.all() else velocity_rms[~rest]
    reversal = max(float(np.median(moving)), SLOWEST_MOTION)
    velocity_rms = np.where(rest, velocity_rms, reversal)
    if np.nanstd(fed.reading) < NEVER_MOVES * fed.noise["displacement"]:
        # Of a piston that never moves only noise would be taken for motion.
        motion = np.array(
            [np.full_like(fed.time, np.mean(motion[0])), *np.zeros((2, len(fed.time)))]
        )
        velocity_rms = np.zeros_like(fed.time)
    interval = fed.interval
    stroke, slow = rig["piston.stroke"], STICKING * reversal
    still = _held(motion[1], slow, interval)
    rests = np.zeros(len(fed.time), dtype=np.int64)
    if driving is not None and force_rms is not None:
        full = (rig["supply.pressure"] - rig["ambient.pressure"]) * rig["piston.area_b"]
        friction = rig["piston.coulomb_friction"] + force_rms
        least = max(PRESSED * friction, OF_FULL_FORCE * full)
        rests = resting(motion[0], still, mass * driving, least, interval, stroke)
    near = touching(motion[0], rests, interval, stroke)
    motion[1:, rests != 0] = 0.0
    stuck = _held(motion[1], CREEPING, interval) & rest & ~near & (rests == 0) & all(fed.measured)
    moved = replace(
        fed,
        motion=motion,
        held=still | near,
        reversal=reversal,
        velocity_rms=np.where(rests != 0, 0.0, velocity_rms),
        touching=near,
        striking=near & around(np.abs(motion[1]) > slow, interval),
        resting=rests,
        stuck=stuck,
        departures=departures(motion, still | near, stuck, fed.noise["displacement"], interval),
        chatter=chatter,
    )
    return with_spread(moved, rig)


def with_spread(fed: Feed, rig: Rig) -> Feed:
    """Return a feed that knows how sure pressures and spool are between and at its samples.

    Parameters
    ----------
    fed : Feed
        What that follows from has been changed.
    rig : Rig
        The rig it was taken on.
    """
    spread = spread_of_pressures(
        fed.time,
        fed.unseen,
        fed.blind,
        fed.striking,
        fed.held,
        fed.noise,
        fed.velocity_rms,
        fed.motion_memory,
        rig,
    )
    if not len(fed.spool_reading):
        return replace(fed, spread=spread)
    shares = shares_of_spool(fed.time, fed.unseen, fed.spool_reading, fed.noise["spool"], rig)
    return replace(fed, spread=spread, spool_shares=shares)


def held_at_stops(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of a piston that counts as held at the stops alone.

    Parameters
    ----------
    fed : Feed
        With what sticks held too.
    rig : Rig
        The rig it was taken on.
    """
    rests = np.where(fed.touching, fed.resting, 0)
    stuck = np.zeros_like(fed.stuck)
    freed = replace(fed, held=fed.touching, resting=rests, stuck=stuck, departures=NOWHERE)
    return with_spread(freed, rig)


def _held(velocity: Array, slow: float, interval: float) -> Mask:
    from scipy.ndimage import binary_opening

    width = max(2, round(HELD_FOR / interval))
    return np.asarray(binary_opening(np.abs(velocity) < slow, np.ones(width)))
