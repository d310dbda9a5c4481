"""What a run is given, checked before the kernels see it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.rigs import Rig, load_rig

# Against a step of 1 us no channel is off by more than 3e-6 of its range, a relay loop by 5e-5.
LARGEST_STEP = 20e-6
# About ten minutes of computing; a longer span is a slip in the unit of the time.
_MOST_STEPS = 2_000_000_000
# No spool is faster. A run takes steps of a share of its time constant, and would never be through
# with one that is a slip in a unit [Hz].
_SPOOL, _FASTEST_SPOOL = "valve.spool.frequency", 1e5


@dataclass(frozen=True)
class Driven:
    """What drives a run from outside, one value for each time.

    Parameters
    ----------
    time : (n,) array
        [s].
    held : (n,) array
        Command [V] or demand [m], each value held until the next time.
    force : (n,) array
        At the rod, positive when it resists extension, held likewise [N].
    supply_pressure : (n,) array or None
        Of the source, straight between the times; None for the rig's [Pa].
    """

    time: Array
    held: Array
    force: Array
    supply_pressure: Array | None = None


def require_kind(rig: Rig | str, kind: str, effects: bool = False) -> Rig:
    """Return a rig that can be simulated.

    Parameters
    ----------
    rig : Rig or str
        A rig, or the name or path of one.
    kind : str
        Which chain of blocks it has to be.
    effects : bool, optional
        Whether it may have physics beyond the baseline.

    Returns
    -------
    Rig
        The rig.

    Raises
    ------
    InputError
        When it is of another kind, has physics beyond the baseline that is not allowed, or a spool
        faster than any.
    """
    if isinstance(rig, str):
        rig = load_rig(rig)
    if rig.kind != kind:
        raise InputError(
            f"rig {rig.name} is of kind {rig.kind}; {kind} is needed here. "
            "Rigs of kind single-axis and dead-volume can be simulated"
        )
    if rig.effects and not effects:
        raise InputError(
            f"rig {rig.name} has effects beyond the baseline that cannot be simulated here: "
            f"{', '.join(sorted(rig.effects))}; remove them from [effects] to simulate without"
        )
    if _SPOOL in rig.parameters and rig[_SPOOL] > _FASTEST_SPOOL:
        raise InputError(
            f"rig {rig.name}: {_SPOOL} is {rig[_SPOOL]:g} Hz; it has to be greater than 0 and "
            f"{_FASTEST_SPOOL:g} Hz at most"
        )
    return rig


def require_times(time: ArrayLike) -> Array:
    """Return times as the kernels take them, refusing any that do not increase [s]."""
    times = np.array(time, dtype=float, order="C")
    if times.ndim != 1 or len(times) < 2:
        raise InputError(f"time has the shape {times.shape}; two or more times in a row are needed")
    if not np.isfinite(times).all():
        raise InputError(f"time {_first_bad(times)}; every time has to be a finite number")
    steps = np.diff(times)
    if not (steps > 0.0).all():
        k = int(np.argmax(steps <= 0.0))
        raise InputError(
            f"time does not increase: {times[k]:g} s is followed by {times[k + 1]:g} s "
            f"(samples {k} and {k + 1})"
        )
    if (times[-1] - times[0]) / LARGEST_STEP > _MOST_STEPS:
        raise InputError(
            f"time spans {times[-1] - times[0]:g} s; up to {_MOST_STEPS * LARGEST_STEP:g} s can be "
            "simulated in one run. Check the unit of the time"
        )
    return times


def require_samples(name: str, values: ArrayLike | None, times: Array) -> Array:
    """Return one value for every time as the kernels take them, refusing missing ones."""
    samples = np.array(values, dtype=float, order="C")
    if samples.ndim == 0:
        samples = np.full(len(times), float(samples))
    if samples.shape != times.shape:
        raise InputError(f"{name} has the shape {samples.shape}, time has {times.shape}")
    if not np.isfinite(samples).all():
        raise InputError(
            f"{name} {_first_bad(samples)}; a value holds until the next, so that every one "
            "has to be a finite number"
        )
    return samples


def _first_bad(values: Array) -> str:
    k = int(np.argmin(np.isfinite(values)))
    return f"is {values[k]} at sample {k}"
