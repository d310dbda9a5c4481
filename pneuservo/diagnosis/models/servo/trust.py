"""How much an observer of the servo trusts its model, and the motion that was smoothed."""

import math
from dataclasses import replace

import numpy as np

from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.moved import with_spread
from pneuservo.diagnosis.models.servo.spread import MOTION_MEMORY_AT_REST
from pneuservo.rigs import Rig

_STEADY, _STEADY_TURNING = 0.02, 2.0
"""Unmodelled force that the observer allows for where the model leaves next to nothing, as a share
of what it else does, and where the piston turns round, for it may stick there unseen."""
_CHATTERS = 0.2
"""Share of the time in which a piston chatters by less than its displacement tells, from which it
may be known so little that way friction acts ..."""
_UNSTEADY = 4.0
"""... that so many times the unmodelled force is allowed for. (A relay at 180 Hz whose piston moved
by half the noise was left at 2.3 times the noise by the right parameters.)"""
_SURER = 0.1
"""Share of what a noisy command may do between its samples that may be all it does: noise that a
card's filters have smoothed looks, sampled, like any other."""
LOOKED_AT = 0.1
"""Time over which it shows whether a piston rests [s]."""
RESTLESS = 5e-3
"""Share of the full command by which that moves in this time where a piston may only seem to rest:
a loop that hears the noise of its transducer pushes it to and fro."""


def steadily(fed: Feed, rig: Rig) -> Feed:
    """Return a feed with little of an unmodelled force.

    Parameters
    ----------
    fed : Feed
        Of a recording; returned as it is where it is such a feed.
    rig : Rig
        The rig it was taken on.
    """
    if fed.unsteadiness == _STEADY:
        return fed
    return replace(fed, unsteadiness=_STEADY, turning_unsteadiness=_STEADY_TURNING)


def unsure(fed: Feed, rig: Rig) -> Feed:
    """Return a feed that is unsure of the motion that the displacement does not tell, if any.

    Parameters
    ----------
    fed : Feed
        Of a recording; returned as it is where the displacement tells.
    rig : Rig
        The rig it was taken on.
    """
    if fed.chatter > _CHATTERS:
        fed = replace(fed, unsteadiness=_UNSTEADY, turning_unsteadiness=_UNSTEADY)
    return unsure_of_rest(fed, rig) if may_only_seem_to_rest(fed, rig) else fed


def may_only_seem_to_rest(fed: Feed, rig: Rig) -> bool:
    """Return whether the command keeps on moving while the piston is held.

    Parameters
    ----------
    fed, rig
        As in `steadily`.
    """
    from scipy.ndimage import uniform_filter1d

    still = fed.held & ~fed.touching
    if not still.any():
        return False
    width = max(2, round(LOOKED_AT / fed.interval))
    beside = fed.voltage - np.mean(fed.voltage)
    square = uniform_filter1d(beside**2, width) - uniform_filter1d(beside, width) ** 2
    return bool(np.median(square[still]) > (RESTLESS * rig["valve.full_voltage"]) ** 2)


def surer_of_command(fed: Feed, rig: Rig) -> Feed:
    """Return a feed whose command is known better between its samples than their noise says.

    Parameters
    ----------
    fed, rig
        As in `steadily`; returned as it is where nothing is unknown.
    """
    if not np.any(fed.unseen):
        return fed
    return with_spread(replace(fed, unseen=_SURER * fed.unseen), rig)


def unsure_of_rest(fed: Feed, rig: Rig) -> Feed:
    """Return a feed whose piston at rest may creep by as much as the displacement does not tell.

    Parameters
    ----------
    fed, rig
        As in `steadily`.
    """
    samples = LOOKED_AT / fed.interval
    slope = math.sqrt(12.0 / samples) * fed.noise["displacement"] / LOOKED_AT
    still = fed.held & ~fed.touching
    unsure = replace(
        fed,
        velocity_rms=np.where(still, np.maximum(fed.velocity_rms, slope), fed.velocity_rms),
        motion_memory=MOTION_MEMORY_AT_REST,
    )
    return with_spread(unsure, rig)


def unsure_of_approach(fed: Feed, rig: Rig) -> Feed:
    """Return a feed whose piston may stop and go on while it comes to rest, or creeps.

    Parameters
    ----------
    fed, rig
        As in `steadily`.
    """
    still = fed.held & ~fed.touching
    speed = np.where(still, np.abs(fed.motion[1]), 0.0)
    return with_spread(replace(fed, velocity_rms=np.hypot(fed.velocity_rms, speed)), rig)
