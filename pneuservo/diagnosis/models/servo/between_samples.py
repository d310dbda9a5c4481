"""Feeds whose command is read in one way or another between its samples."""

from dataclasses import replace

import numpy as np

from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.models.servo.command import held_command, running_command, unseen
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.moved import with_spread
from pneuservo.diagnosis.models.servo.set_point import at_once, jumping
from pneuservo.rigs import Rig

_MOVES = 0.1
"""Share of the intervals in which a set point moves that does not only jump."""


def with_running_command(fed: Feed, rig: Rig) -> Feed:
    """Return the feed as it is made: its command runs on from sample to sample.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    rig : Rig
        The rig it was taken on.
    """
    return fed


def with_held_command(fed: Feed, rig: Rig) -> Feed:
    """Return the feed with a command that is held from sample to sample.

    Parameters
    ----------
    fed : Feed
        With a command that runs on between samples.
    rig : Rig
        The rig it was taken on.
    """
    held = replace(fed, command=held_command(fed.voltage), unseen=np.zeros_like(fed.time))
    return with_spread(held, rig)


def with_set_point_in_steps(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of an analogue loop whose set point stays as it is from sample to sample.

    Parameters
    ----------
    fed : Feed
        Of a recording that tells it, see `tells_set_point`.
    rig : Rig
        The rig it was taken on.

    Notes
    -----
    Its command is a sawtooth then, of which the samples are the crests. Where it was taken to run
    on from crest to crest, a control left 1.2 times the noise of a displacement, and of a right
    model stiction of the spool gained 538.
    """
    found = at_once(fed.voltage, fed.set_point, fed.gain_of_set_point, in_steps=True)
    limit = rig["valve.full_voltage"]
    stepped = replace(
        fed,
        command=running_command(fed.time, fed.voltage, limit, found),
        unseen=unseen(fed.voltage, found),
        in_steps=True,
    )
    return with_spread(stepped, rig)


def tells_set_point(fed: Feed) -> bool:
    """Return whether a set point that comes in steps would make a difference to a command.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    """
    if not fed.gain_of_set_point:
        return False
    moves = (np.diff(fed.set_point) != 0.0) & ~jumping(fed.set_point)
    return float(np.mean(moves)) > _MOVES


def read_alike(fed: Feed, voltage: Array, rig: Rig) -> Array:
    """Return another command between its samples, as that of a feed is read.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    voltage : (n,) array
        The other command at the same samples [V].
    rig : Rig
        The rig.
    """
    if not fed.ramped:
        return held_command(voltage)
    told = None
    if len(fed.set_point):
        told = at_once(voltage, fed.set_point, fed.gain_of_set_point, fed.in_steps)
    return running_command(fed.time, voltage, rig["valve.full_voltage"], told)
