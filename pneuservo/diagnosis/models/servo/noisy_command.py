"""What a command that is full of its loop's own noise does between its samples."""

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.model import Values
from pneuservo.diagnosis.models.servo.heard_noise import ORDER

COMMAND_BENDS = ("command_bend", "command_lean")
"""How far a command goes on in an interval of one recording as it bends at both ends, and as it
bends more at the later one [-]."""
_HEARD_FOR = 4
"""So many samples a loop's filters remember enough of a noise to tell that it is heard."""
_SHARE = 0.5
"""Of a command's fourth differences, what the noise that is heard explains at least."""
_A_JUMP = 6.0
"""What is so many times as large as its median is a jump, and no noise."""
_LEAST_PARTS = 2
"""Of an interval, to bend in."""


def made_of_noise(voltage: Array, noise: Array, usable: Mask) -> bool:
    """Return whether what a command does from sample to sample is noise that its loop hears.

    Parameters
    ----------
    voltage : (n,) array
        Command at the samples [V].
    noise : (n,) array
        Displacement as measured less what the piston has moved [m].
    usable : (n,) array of bool
        Where both are known, and the command is not at its limit.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> noise, all_of_it = 5e-6 * rng.standard_normal(4000), np.ones(4000, dtype=bool)
    >>> slow = np.sin(0.03 * np.arange(4000))
    >>> heard = np.convolve(noise, [2e3, 4e4, -3e4])[:4000]
    >>> made_of_noise(slow + heard, noise, all_of_it), made_of_noise(slow, noise, all_of_it)
    (True, False)
    """
    first = _HEARD_FOR
    if len(voltage) <= 2 * (first + ORDER):
        return False
    given, cause = np.diff(voltage, ORDER), np.diff(noise, ORDER)
    columns = np.array([cause[first - lag : len(cause) - lag] for lag in range(first + 1)]).T
    given = given[first:]
    # A difference and what was heard before it: all of these samples are usable.
    told = np.convolve(~usable, np.ones(first + ORDER + 1), mode="valid") == 0.0
    told &= without_jumps(given)
    if np.count_nonzero(told) <= 10 * (first + 1):
        return False
    given, columns = given[told], columns[told]
    reply, *_ = np.linalg.lstsq(columns, given, rcond=None)
    left = given - columns @ reply
    return bool(left @ left < (1.0 - _SHARE) * (given @ given))


def bends_of(voltage: Array, parts: int) -> Array:
    """Return what a command may do in an interval beside a smooth curve through its samples.

    Parameters
    ----------
    voltage : (n,) array
        As sampled [V].
    parts : int
        Of each sampling interval.

    Returns
    -------
    (2, n, parts + 1) array
        At the ends of the parts, as in `COMMAND_BENDS`, of a mean in each interval that is a sum of
        the samples around it; zero where that jumps, and where an interval has no parts [V].

    Notes
    -----
    The mean between two samples of noise that has passed a filter is a sum of the samples around
    them that depends on the filter and on how the noise itself goes on. Of sums that leave alone
    what is slow these are the even and the odd one of four samples. Of noise that passes a filter
    of 150 Hz of the third order, twice differentiated and sampled at 1 kHz, they leave 0.3 to 0.4
    of what a cubic is off by where the noise is straight or stays from sample to sample. (Sums of
    six leave 0.15 of it: likelier by 50 where these are by 1,600.)

    Examples
    --------
    >>> even, odd = 0.5 * bends_of(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), 2)[:, 1:-2, 1]
    >>> even.tolist(), odd.tolist()
    ([1.0, -1.0, -1.0, 1.0], [1.0, -3.0, 3.0, -1.0])
    """
    found = np.zeros((len(COMMAND_BENDS), len(voltage), parts + 1))
    if parts < _LEAST_PARTS or len(voltage) <= ORDER:
        return found
    bend = np.diff(voltage, 2)
    earlier, later = bend[:-1], bend[1:]
    place = np.linspace(0.0, 1.0, parts + 1)
    arch = place * (1.0 - place)
    arch /= np.mean(0.5 * (arch[1:] + arch[:-1]))
    for row, sums in enumerate((later + earlier, later - earlier)):
        found[row, 1:-2] = np.where(without_jumps(sums), sums, 0.0)[:, np.newaxis] * arch
    return found


def bent(command: Array, bends: Array, values: Values, limit: float) -> Array:
    """Return a command between its samples with what was fitted of its bends.

    Parameters
    ----------
    command : (n, m + 1) array
        Of a feed [V].
    bends : (2, n, m + 1) array
        From `bends_of`; empty where the command is not made of noise [V].
    values : mapping of str to float
        With `COMMAND_BENDS`.
    limit : float
        Beyond this the valve's driver does not go [V].
    """
    sizes = bends_in(values)
    if not len(bends) or not any(sizes):
        return command
    return np.clip(command + np.tensordot(sizes, bends, 1), -limit, limit)


def bends_in(values: Values) -> tuple[float, ...]:
    """Return how far a command bends in each of the ways of `COMMAND_BENDS`, of what was fitted."""
    return tuple(values.get(name, 0.0) for name in COMMAND_BENDS)


def without_jumps(differences: Array) -> Mask:
    """Return where differences of a noisy command are those of noise, and not of a jump.

    Parameters
    ----------
    differences : array
        Of whatever order.

    Examples
    --------
    >>> without_jumps(np.array([0.1, -0.2, 5.0, 0.1])).tolist()
    [True, True, False, True]
    """
    size = np.abs(differences)
    return np.asarray(size <= _A_JUMP * np.median(size))
