"""What the set point of a loop changes of its command at once."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.recordings.converter import converter_step

_AVERAGED = 40e-3
"""Everything is averaged twice over this before a loop is asked for its gain: what velocity and
acceleration lack within it is then as small as the noise of the transducer [s]."""
_PASSES = 3
_FEWEST_AVERAGES = 25
"""So many averages that do not overlap tell a gain."""
_AS_A_LOOP = 0.05
"""What a linear loop leaves of its averaged command at the most [-] ..."""
_KNOWN = 0.05
"""... and how well its gain has to be known [-]."""
_ARRIVES = 0.5
"""Share of its jumps that a set point which comes at once has brought by the next sample."""
_LEAST_JUMP = 0.01
"""Share of all that a set point moves by that a jump of it has: converters have steps."""
_OF_NEIGHBOURS = 10.0
"""So many times what it moves by in both neighbouring intervals."""
_AT_A_LIMIT = 1e-3
"""A command within this of the largest [-], ..."""
_STANDS_STILL = 2e-4
"""... or that stands still to this share of it, or a step of its converter, at an end ..."""
_AN_END = 0.5
"""An end of what a command does is a limit if it is at least this share as far from zero as the
other: at rest it may be at none."""
_STAYS_AT_IT = 5
"""... for so many samples is at its limit: a piston takes some to follow a jump."""


@dataclass(frozen=True)
class AtOnce:
    """What a set point changes of a command at once.

    Parameters
    ----------
    added : (n,) array
        Until each sample [V].
    unknown : (n - 1,) array of bool
        Intervals in which it changes the command by nobody knows how much.
    """

    added: Array
    unknown: Mask


def at_once(voltage: Array, demand: Array, gain: float, in_steps: bool = False) -> AtOnce:
    """Return what a set point changes of the command of its loop at once.

    Parameters
    ----------
    voltage, demand : (n,) array
        Command and set point at the samples [V], [m]; an empty set point changes nothing.
    gain : float
        From `gain_of_set_point`; 0 where it is not known [V/m].
    in_steps : bool, optional
        Whether the set point stays as it is from sample to sample, as a generator with a converter
        tells it; otherwise only its jumps come at once.

    Notes
    -----
    Beside a command that is at its limit nobody knows how much of a jump passes. Where less than
    half of the jumps has come by the next sample, a filter keeps them back and nothing comes at
    once. (A set point that passed a filter of 2 ms was taken to jump by 1.5 V for a sample, so that
    its loop was likelier to be one that samples, with a spool five tolerances too fast.)

    Examples
    --------
    >>> demand = np.array([0.0, 0.0, 0.0, 0.01, 0.01, 0.01])
    >>> voltage = np.array([0.0, 0.0, 0.0, 2.5, 2.0, 1.6])
    >>> told = at_once(voltage, demand, 250.0)
    >>> told.added.tolist(), bool(told.unknown.any())
    ([0.0, 0.0, 0.0, 2.5, 2.5, 2.5], False)
    >>> bool(at_once(np.array([0.0, 0.0, 0.0, 0.1, 0.7, 1.2]), demand, 250.0).added.any())
    False
    >>> at_once(voltage, demand, 0.0).unknown.tolist()
    [False, False, True, False, False]
    """
    if not len(demand):
        return AtOnce(np.zeros_like(voltage), np.zeros(len(voltage) - 1, dtype=bool))
    change = np.diff(demand)
    sudden = change != 0.0 if in_steps else jumping(demand)
    if not gain:
        return AtOnce(np.zeros_like(voltage), sudden)
    limited = at_its_limit(voltage)
    unknown = sudden & (limited[1:] | limited[:-1])
    known = np.where(sudden & ~unknown, gain * change, 0.0)
    if not in_steps and known @ np.diff(voltage) < _ARRIVES * (known @ known):
        return AtOnce(np.zeros_like(voltage), np.zeros(len(change), dtype=bool))
    return AtOnce(np.append(0.0, np.cumsum(known)), unknown)


def gain_of_set_point(time: Array, voltage: Array, demand: Array, displacement: Array) -> float:
    """Return what a linear loop adds to its command per metre of its set point [V/m].

    Parameters
    ----------
    time, voltage, demand, displacement : (n,) array
        [s], [V], [m], [m].

    Returns
    -------
    float
        0 where the command is not that of a loop which is linear in set point, displacement,
        velocity and acceleration, or does not tell.

    Notes
    -----
    Least squares on averages, of what is not limited: in a chattering sliding mode velocity and
    acceleration are otherwise so noisy that a gain of 3,265 V/m was found to be 839.

    Examples
    --------
    >>> time = np.arange(0.0, 4.0, 1e-3)
    >>> demand, late = (np.sin(2.0 * t) + np.sin(5.0 * t**1.5) for t in (time, time + 0.1))
    >>> round(gain_of_set_point(time, 250.0 * (demand - late), demand, late))
    250
    """
    from scipy.ndimage import binary_dilation, uniform_filter1d

    samples = max(1, round(_AVERAGED / float(np.median(np.diff(time)))))

    def averaged(values: Array) -> Array:
        for _ in range(_PASSES):
            values = uniform_filter1d(values, samples)
        return values

    place = averaged(displacement)
    speed = np.gradient(place, time)
    reach = _PASSES * samples
    free = ~binary_dilation(at_its_limit(voltage), np.ones(reach + 1))
    # What lies beyond the ends is not known.
    free[:reach] = free[-reach:] = False
    averages = np.count_nonzero(free) / samples
    if averages < _FEWEST_AVERAGES:
        return 0.0
    causes = (averaged(demand), place, speed, np.gradient(speed, time), np.ones_like(time))
    columns, given = np.column_stack(causes)[free], averaged(voltage)[free]
    sizes = np.linalg.norm(columns, axis=0)
    if not np.all(sizes > 0.0):
        return 0.0
    columns /= sizes
    shares = np.linalg.lstsq(columns, given, rcond=None)[0]
    left = float(np.std(given - columns @ shares))
    spread = left * np.sqrt(np.linalg.pinv(columns.T @ columns)[0, 0] * samples)
    tells = left < _AS_A_LOOP * float(np.std(given)) and spread < _KNOWN * shares[0]
    return float(shares[0] / sizes[0]) if tells else 0.0


def jumping(demand: Array) -> Mask:
    """Return in which intervals a set point jumps: it moves there and in neither neighbour.

    Parameters
    ----------
    demand : (n,) array
        Or whatever else may jump [any unit].
    """
    moves = np.abs(np.diff(demand))
    least = _LEAST_JUMP * float(np.nanmax(demand) - np.nanmin(demand))
    return np.asarray((moves > _OF_NEIGHBOURS * beside(moves)) & (moves > least))


def beside(moves: Array) -> Array:
    """Return the larger of both neighbours of each.

    Parameters
    ----------
    moves : (n,) array
        Whatever has neighbours.
    """
    return np.maximum(np.append(0.0, moves[:-1]), np.append(moves[1:], 0.0))


def at_its_limit(voltage: Array) -> Mask:
    """Return where a command is at its limit, and stays there for some samples.

    Parameters
    ----------
    voltage : (n,) array
        As sampled [V].
    """
    from scipy.ndimage import binary_opening

    low, high = float(np.min(voltage)), float(np.max(voltage))
    largest, step = max(-low, high), converter_step(voltage)
    there = np.abs(voltage) >= (1.0 - _AT_A_LIMIT) * largest
    for end in (low, high):
        # A recorded command may be off by an offset, so that its ends are not as far from zero.
        if abs(end) > _AN_END * largest:
            there |= np.abs(voltage - end) <= max(_STANDS_STILL * largest, step)
    return np.asarray(binary_opening(there, np.ones(_STAYS_AT_IT)))
