"""Which way friction acts on a piston that turns round between two samples."""

import math

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.copying import put
from pneuservo.plant.presliding import presliding_step

_STRAIGHT = 0.1
"""Change of the velocity, over that over which friction turns round, below which the mean of an
interval is that of its ends to a thousandth."""

_PARTS = 8
"""Into so many parts an interval is divided in which friction builds up."""


@compiled
def friction_direction(time, displacement, velocity, reversal, friction):
    """Return which way friction acts, from -1 to 1.

    Parameters
    ----------
    time, displacement, velocity : (n,) array
        Of the piston, SI.
    reversal : float
        Speed over which friction turns round, the resolution of the velocity [m/s].
    friction : FrictionEffects
        Parameters of the effects.

    Returns
    -------
    (2, n) array
        Share of the friction level at each sample, positive while extending; and by how much its
        mean until the next sample is beyond that of both.

    Examples
    --------
    >>> from pneuservo.plant.servo.friction_effects import FrictionEffects
    >>> time, velocity = np.array([0.0, 1e-3]), np.array([-1.0, 3.0])
    >>> friction_direction(time, 1e-3 * velocity, velocity, 0.01, FrictionEffects()).round(2)
    array([[-1. ,  1. ],
           [ 0.5,  0. ]])
    """
    if friction.presliding_travel > 0.0:
        return _building_up(time, displacement, velocity, reversal, friction)
    found = np.zeros((2, velocity.size))
    put(np.tanh(velocity / reversal), found[0])
    mean = mean_direction(velocity, reversal)
    for k in range(velocity.size - 1):
        found[1, k] = mean[k] - 0.5 * (found[0, k + 1] + found[0, k])
    return found


@compiled
def _building_up(time, displacement, velocity, reversal, friction):
    travel, exponent = friction.presliding_travel, friction.presliding_exponent
    found = np.zeros((2, velocity.size))
    found[0, 0] = share = math.tanh(velocity[0] / reversal)
    for k in range(velocity.size - 1):
        turns = velocity[k] * velocity[k + 1] < 0.0
        step, bend = displacement[k + 1] - displacement[k], time[k + 1] - time[k]
        place = mean = 0.0
        for part in range(1, _PARTS + 1):
            along = part / _PARTS
            there = along * step
            if turns:
                # Cubic, with the velocity of both ends.
                there = along * along * (3.0 - 2.0 * along) * step
                there += along * (1.0 - along) ** 2 * bend * velocity[k]
                there -= along * along * (1.0 - along) * bend * velocity[k + 1]
            further = presliding_step(share, there - place, travel, exponent)
            mean += 0.5 * (share + further) / _PARTS
            share, place = further, there
        found[0, k + 1] = share
        found[1, k] = mean - 0.5 * (found[0, k] + share)
    return found


@compiled
def mean_direction(velocity, reversal):
    """Return which way friction acts on the mean from each sample to the next, from -1 to 1.

    Parameters
    ----------
    velocity : (n,) array
        Of the piston at each sample [m/s].
    reversal : float
        Speed over which friction turns round, the resolution of the velocity [m/s].

    Returns
    -------
    (n,) array
        Share of the friction level, positive while extending; the last is that of the sample.

    Notes
    -----
    The velocity runs straight from sample to sample, so that the moment at which the piston turns
    round counts: tanh(v/w) integrates to w ln cosh(v/w). At 1 kHz the moment of a sample instead
    leaves, on the mean, a quarter of twice the friction for an interval.

    Examples
    --------
    >>> mean_direction(np.array([-1.0, 3.0]), 0.01).round(2).tolist()
    [0.5, 1.0]
    """
    found = np.tanh(velocity / reversal)
    for k in range(velocity.size - 1):
        faster = velocity[k + 1] - velocity[k]
        if abs(faster) > _STRAIGHT * reversal:
            after, before = velocity[k + 1] / reversal, velocity[k] / reversal
            found[k] = (_log_cosh(after) - _log_cosh(before)) * (reversal / faster)
        else:
            found[k] = 0.5 * (found[k] + found[k + 1])
    return found


@compiled
def _log_cosh(number):
    size = abs(number)
    return size + math.log1p(math.exp(-2.0 * size)) - math.log(2.0)
