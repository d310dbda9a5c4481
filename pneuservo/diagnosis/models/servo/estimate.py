"""The observer's gains, and what it makes of pressures that were not measured."""

from dataclasses import replace

import numpy as np

from pneuservo.diagnosis.models.servo.feed import Feed
from pneuservo.diagnosis.models.servo.moved import moved_by
from pneuservo.diagnosis.models.servo.run_observer import learn_to_observe
from pneuservo.diagnosis.models.servo.steps import steps_along
from pneuservo.rigs import Rig

PASSES = 2
"""Pressures estimated with a motion make the motion better, which makes the pressures better."""


def with_observer(fed: Feed, rig: Rig) -> Feed:
    """Return a feed with the missing pressures estimated, and the observer's gains.

    Parameters
    ----------
    fed : Feed
        What was measured.
    rig : Rig
        The baseline.

    Returns
    -------
    Feed
        With everything that the observer needs.
    """
    return with_gains(with_pressures(fed, rig), rig)


def as_it_moves(fed: Feed, rig: Rig) -> Feed:
    """Return a feed whose motion is smoothed again, with another rig's friction and mass.

    Parameters
    ----------
    fed : Feed
        What the observer is fed with.
    rig : Rig
        Its numbers decide how the piston moves.
    """
    if all(fed.measured):
        return moved_by(fed, rig, fed.spread_of_force)
    return with_pressures(fed, rig)


def with_pressures(fed: Feed, rig: Rig) -> Feed:
    """Return a feed with the missing pressures estimated.

    Parameters
    ----------
    fed : Feed
        What was measured.
    rig : Rig
        The baseline.
    """
    for _ in range(0 if all(fed.measured) else PASSES):
        _, _, path, known, _ = learn_to_observe(fed, rig)
        force_rms = float(np.hypot(np.median(known[len(known) // 10 :]), fed.force_rms))
        pressures = fed.pressures.copy()
        for side, there in enumerate(fed.measured):
            if not there:
                pressures[side] = path[side]
        fed = moved_by(replace(fed, pressures=pressures), rig, force_rms)
    return fed


def with_gains(fed: Feed, rig: Rig) -> Feed:
    """Return a feed with the observer's gains for its weights.

    Parameters
    ----------
    fed : Feed
        What the observer is fed with.
    rig : Rig
        The baseline.
    """
    gains, shares, _, known, decays = learn_to_observe(fed, rig)
    steps = steps_along(fed.time, fed.command, rig["valve.full_voltage"], decays)
    return replace(fed, gains=gains, shares=shares, force_spread=known, steps=steps)
