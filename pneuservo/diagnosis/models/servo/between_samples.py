"""Feeds whose command is read in one way or another between its samples."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.command import (
    held_command,
    is_relay,
    noise_of_command,
    running_command,
    unseen,
)
from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.heard_noise import gain_of_noise
from pneuservo.diagnosis.models.servo.moved import with_spread
from pneuservo.diagnosis.models.servo.set_point import AtOnce, at_its_limit, at_once, jumping
from pneuservo.rigs import Rig

AsGiven = Callable[[Feed, Rig], Feed]
"""One way to read or to follow a recording."""
Asked = Callable[[Feed], bool]
"""Whether a way would make a difference to a recording."""

_MOVES = 0.1
"""Share of the intervals in which a set point moves that does not only jump."""
_NO_NOISE = 8.0
"""So many times its noise a command never moves by in one interval: 5.7 standard deviations."""


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


def with_command_of_before(fed: Feed, rig: Rig) -> Feed:
    """Return the feed with a command that was held until each sample, and is another from then on.

    Parameters
    ----------
    fed : Feed
        With a command that runs on between samples.
    rig : Rig
        The rig it was taken on.

    Notes
    -----
    A controller that samples puts out what it has made of a sample a little later: a recorder that
    samples at the same moments sees the command of before. Taken to hold from its sample on, that
    of a relay at 1 kHz left 2.6 times the noise of a pressure with a spool of 511 Hz for 200.
    """
    later = np.append(fed.voltage[1:], fed.voltage[-1:])
    return with_held_command(replace(fed, voltage=later, converted=True), rig)


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
    return _read_again(replace(fed, in_steps=True), rig)


def with_jumps_at_samples(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of an analogue loop whose command jumps at samples.

    Parameters
    ----------
    fed : Feed
        Of a recording that has such jumps, see `jumps_untold`.
    rig : Rig
        The rig it was taken on.

    Notes
    -----
    The computer that records often makes the set point, too; where that is not in the recording,
    the command's own jumps tell when it did. Taken to be anywhere in their intervals, they made a
    spool of 200 Hz one of 140.
    """
    return _read_again(replace(fed, jumps=_jumps(fed.voltage)), rig)


def with_heard_noise(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of an analogue loop that hears the noise of its reading in steps.

    Parameters
    ----------
    fed : Feed
        Of a recording that tells it, see `tells_noise`.
    rig : Rig
        The rig it was taken on.

    Notes
    -----
    A transducer that is sampled, or simulated with noise at its samples, tells a loop that runs on
    the same error until the next sample: the command jumps by it and runs on from there. Taken to
    run on from sample to sample, it made a spool of 200 Hz one of 322, and overlap of none.
    """
    return _read_again(replace(fed, heard=_heard(fed)), rig)


def with_noise_that_runs_on(fed: Feed, rig: Rig) -> Feed:
    """Return the feed of an analogue loop that hears no more noise than its samples tell.

    Parameters
    ----------
    fed : Feed
        Of a recording that tells it, see `tells_noise`.
    rig : Rig
        The rig it was taken on.

    Notes
    -----
    What is noise of a command may reach beyond half the sampling rate, and say nothing of what lies
    between samples; what the loop has heard of its transducer, whose noise does not, is known.
    """
    known = unseen(fed.voltage - _heard(fed), _told(fed, fed.voltage))
    return with_spread(replace(fed, unseen=known), rig)


def tells_noise(fed: Feed) -> bool:
    """Return whether a command tells that its loop hears the noise of the displacement.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    """
    return bool(np.any(_heard(fed)))


def tells_noise_alone(fed: Feed) -> bool:
    """Return whether a command tells so by a gain, and its bends are not fitted.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    """
    return not fed.of_noise and tells_noise(fed)


def _read_again(fed: Feed, rig: Rig) -> Feed:
    """Return a feed whose command runs on with what is known of it now."""
    told = _told(fed, fed.voltage)
    command = running_command(fed.time, fed.voltage, rig["valve.full_voltage"], told)
    known = unseen(fed.voltage, told, of_noise=fed.of_noise)
    return with_spread(replace(fed, command=command, unseen=known), rig)


def _jumps(voltage: Array) -> Mask:
    """Return in which intervals a command jumps by more than its noise ever does."""
    return jumping(voltage) & (np.abs(np.diff(voltage)) > _NO_NOISE * noise_of_command(voltage))


def _heard(fed: Feed) -> Array:
    """Return what the noise of the displacement adds to a command at each sample [V]."""
    limited = at_its_limit(fed.voltage)
    noise = np.nan_to_num(fed.reading - fed.motion[0])
    return np.where(limited, 0.0, -gain_of_noise(fed.voltage, noise, limited) * noise)


def _told(fed: Feed, voltage: Array) -> AtOnce:
    """Return what is known of a command that changes at once, as a feed is read."""
    told = at_once(voltage, fed.set_point, fed.gain_of_set_point, fed.in_steps)
    if len(fed.jumps):
        told = replace(told, unknown=told.unknown | fed.jumps)
    return replace(told, added=told.added + fed.heard) if len(fed.heard) else told


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


def jumps_untold(fed: Feed) -> bool:
    """Return whether a command that is no relay's jumps, of a loop whose set point is not known.

    Parameters
    ----------
    fed : Feed
        Of a recording.
    """
    untold = not len(fed.set_point) and not is_relay(fed.voltage)
    return untold and bool(np.any(_jumps(fed.voltage)))


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
    return running_command(fed.time, voltage, rig["valve.full_voltage"], _told(fed, voltage))


def _as_it_is(fed: Feed, rig: Rig) -> Feed:
    return fed


def _always(fed: Feed) -> bool:
    return True


def _one_after_the_other(first: AsGiven, second: AsGiven) -> AsGiven:
    return lambda fed, rig: second(first(fed, rig), rig)


def _both(one: Asked, other: Asked) -> Asked:
    return lambda fed: one(fed) and other(fed)


_SET_POINT: tuple[tuple[AsGiven, Asked], ...] = (
    (_as_it_is, _always),
    (with_set_point_in_steps, tells_set_point),
    (with_jumps_at_samples, jumps_untold),
)
_NOISE: tuple[tuple[AsGiven, Asked], ...] = (
    (_as_it_is, _always),
    (with_heard_noise, tells_noise),
    (with_noise_that_runs_on, tells_noise_alone),
)
OTHER_WAYS: tuple[tuple[AsGiven, Asked], ...] = (
    (with_held_command, _always),
    (with_command_of_before, _always),
    *(
        (_one_after_the_other(steps, noise), _both(has_steps, has_noise))
        for (steps, has_steps), (noise, has_noise) in product(_SET_POINT, _NOISE)
        if steps is not _as_it_is or noise is not _as_it_is
    ),
)
"""Ways to read a command other than as one that runs on, and for which recordings each is one: held
in two ways, and running on beside whatever comes in steps."""
