"""What a rig's transducers make of a run: noise drawn from a seed, and readings inside a range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.rigs import Rig, Transducer

Seed = int | Sequence[int]

EXACT = Transducer()


@dataclass(frozen=True)
class Noise:
    """The noise of one run, one value for each time.

    Parameters
    ----------
    displacement : (n,) array
        Of the displacement transducer [m].
    pressure_a, pressure_b : (n,) array
        Of the pressure transducers; a test volume has the first [Pa].
    """

    displacement: Array
    pressure_a: Array
    pressure_b: Array


def draw_noise(rig: Rig, length: int, seed: Seed) -> Noise:
    """Return the noise of a rig's transducers.

    Parameters
    ----------
    rig : Rig
        The rig.
    length : int
        Number of times.
    seed : int or sequence of int
        The same seed gives the same noise.

    Raises
    ------
    InputError
        When the seed is negative.

    Notes
    -----
    Normal, independent from sample to sample, and drawn for each transducer from a stream of its
    own, so that quieting one leaves the noise of the others as it is.

    Examples
    --------
    >>> from pneuservo.rigs import load_rig
    >>> float(draw_noise(load_rig("single-axis"), 3, seed=1).displacement.sum())
    0.0
    """
    parts = [seed] if isinstance(seed, int) else list(seed)
    if any(part < 0 for part in parts):
        raise InputError(f"seed is {seed}; it has to be 0 or more")
    streams = np.random.default_rng(parts).spawn(3)
    displacement, pressure = (
        rig.transducers.get(name, EXACT).noise for name in ("displacement", "pressure")
    )
    return Noise(
        *(
            deviation * stream.standard_normal(length)
            for stream, deviation in zip(streams, (displacement, pressure, pressure), strict=True)
        )
    )


def in_parts(time: Array, parts: int) -> Array:
    """Return times with every interval divided into equal parts.

    Parameters
    ----------
    time : (n,) array
        [s].
    parts : int
        1 and more.

    Returns
    -------
    ((n - 1) parts + 1,) array
        [s].

    Examples
    --------
    >>> in_parts(np.array([0.0, 1.0, 3.0]), 2).tolist()
    [0.0, 0.5, 1.0, 2.0, 3.0]
    """
    steps = np.arange(parts) / parts
    inside = time[:-1, np.newaxis] + np.diff(time)[:, np.newaxis] * steps
    return np.append(inside.ravel(), time[-1])


def smooth_noise(time: Array, noise: Array, finer: Array) -> Array:
    """Return the noise of a transducer between its samples, as a loop hears it.

    Parameters
    ----------
    time, noise : (n,) array
        [s] and of the transducer.
    finer : (m,) array
        Times of which those are every so many [s].

    Notes
    -----
    A cubic spline: its bandwidth is half the sampling rate. Noise that stood still from sample to
    sample, or had a kink at each, would jump at the very moments at which it is recorded, and so
    would all that differentiators make of it.

    Examples
    --------
    >>> time = np.arange(5.0)
    >>> smooth_noise(time, time**2, np.array([0.0, 0.5, 4.0])).tolist()
    [0.0, 0.25, 16.0]
    """
    from scipy.interpolate import CubicSpline

    if len(time) == len(finer):
        return noise
    return np.asarray(CubicSpline(time, noise)(finer))


def within_range(reading: Array, transducer: Transducer) -> Array:
    """Return readings held inside what the transducer can give.

    Examples
    --------
    >>> within_range(np.array([-1e-3, 0.02, 0.04]), Transducer(0.0, 0.0, 0.03)).tolist()
    [0.0, 0.02, 0.03]
    """
    return np.clip(reading, transducer.low, transducer.high)


def require_exact_transducers(rig: Rig, where: str) -> None:
    """Refuse a rig whose transducers have noise or a range.

    Parameters
    ----------
    rig : Rig
        The rig.
    where : str
        What cannot have them.

    Raises
    ------
    InputError
        When it has.
    """
    if rig.transducers:
        raise InputError(
            f"rig {rig.name} has [transducers], {', '.join(sorted(rig.transducers))}, which "
            f"{where} leaves out; remove them from the rig, or use simulate"
        )
