"""What is read off a run: step responses and limit cycles, from a simulation or from samples."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Samples = NDArray[np.float64]

# Share of a hold, at its end, over which what is left of the error is averaged.
_FINAL_SHARE = 0.2
# Fewer periods than this are a transient.
_LEAST_PERIODS = 5
# A crossing counts once the signal has gone beyond this share of its range on the other side.
_HYSTERESIS = 0.1
# A cycle whose range shrinks to less than this from one half of the window to the other dies out.
_SUSTAINED = 0.5


@dataclass(frozen=True)
class StepResponse:
    """How a loop answered one change of the demand.

    Parameters
    ----------
    start, end : float
        When the demand changed, and when it changed again or the run ended [s].
    origin, target : float
        Displacement just before the change, and the new demand [m].
    rise_time : float
        From the change to 63.2 % of the way to the final value; NaN when never reached [s].
    settling_time : float
        From the change to where the displacement stays within the band about its final value; NaN
        when it is still outside near the end [s].
    overshoot : float
        Beyond the final value, as a share of the way to it [-].
    steady_state_error : float
        Demand less displacement, mean over the last fifth of the hold [m].
    """

    start: float
    end: float
    origin: float
    target: float
    rise_time: float
    settling_time: float
    overshoot: float
    steady_state_error: float


@dataclass(frozen=True)
class LimitCycle:
    """A sustained oscillation.

    Parameters
    ----------
    frequency : float
        Whole periods over the time they took [Hz].
    periods : int
        How many.
    low, high : float
        Extremes of the signal, in its unit.
    start, end : float
        The whole periods lie between these times [s].
    """

    frequency: float
    periods: int
    low: float
    high: float
    start: float
    end: float


def step_responses(
    time: Samples, demand: Samples, displacement: Samples, band: float = 0.02
) -> list[StepResponse]:
    """Return how a loop answered every change of its demand.

    Parameters
    ----------
    time, demand, displacement : (n,) array
        [s], [m], [m].
    band : float, optional
        Half width of the settling band, as a share of the step [-].

    Returns
    -------
    list of StepResponse
        One per change, in order; empty when the demand never changes.

    Notes
    -----
    Times are those of samples. The band lies about the final value, not about the demand, so that
    a loop with a steady-state error still settles. The error itself takes 0.45 s or more to settle.
    """
    changes = np.flatnonzero(np.diff(demand) != 0.0) + 1
    bounds = [*changes, len(time)]
    return [
        _step_response(time, demand, displacement, int(start), int(end), band)
        for start, end in pairwise(bounds)
    ]


def limit_cycle(time: Samples, signal: Samples) -> LimitCycle | None:
    """Return the limit cycle of a signal that swings about zero, such as the switching function.

    Parameters
    ----------
    time, signal : (n,) array
        [s], and the signal in any unit; a window without demand changes.

    Returns
    -------
    LimitCycle or None
        None when there are fewer than five whole periods, or the swing dies out.

    Notes
    -----
    Counted on the switching function and over whole periods: a count on the displacement is
    biased by the slow creep underneath.

    Examples
    --------
    >>> time = np.arange(0.0, 1.0, 1e-3)
    >>> round(limit_cycle(time, np.sin(2.0 * np.pi * 50.0 * time)).frequency, 3)
    50.0
    """
    low, high = float(np.min(signal)), float(np.max(signal))
    if not low < 0.0 < high:
        return None
    crossings = _upward_crossings(time, signal, _HYSTERESIS * low)
    half = len(signal) // 2
    if len(crossings) <= _LEAST_PERIODS:
        return None
    if np.ptp(signal[half:]) < _SUSTAINED * np.ptp(signal[:half]):
        return None
    periods = len(crossings) - 1
    start, end = float(crossings[0]), float(crossings[-1])
    inside = signal[(time >= start) & (time <= end)]
    return LimitCycle(
        periods / (end - start),
        periods,
        float(np.min(inside)),
        float(np.max(inside)),
        start,
        end,
    )


def _upward_crossings(time: Samples, signal: Samples, armed_below: float) -> Samples:
    """Return when the signal crosses zero upwards after having been below a threshold."""
    up = np.flatnonzero((signal[:-1] < 0.0) & (signal[1:] >= 0.0))
    crossings = []
    last = 0
    for k in up:
        if np.min(signal[last : k + 1]) <= armed_below:
            share = signal[k] / (signal[k] - signal[k + 1])
            crossings.append(time[k] + share * (time[k + 1] - time[k]))
        last = int(k) + 1
    return np.array(crossings)


def _step_response(
    time: Samples, demand: Samples, displacement: Samples, k: int, end: int, band: float
) -> StepResponse:
    final_part = slice(end - max(round((end - k) * _FINAL_SHARE), 1), end)
    final = float(np.mean(displacement[final_part]))
    origin, target = float(displacement[k]), float(demand[k])
    way = final - origin
    since = time[k:end] - time[k]
    progress = (displacement[k:end] - origin) / way if way else np.zeros(end - k)
    outside = np.flatnonzero(
        np.abs(displacement[k:end] - final) > band * abs(target - float(demand[k - 1]))
    )
    settled = 0 if len(outside) == 0 else int(outside[-1]) + 1
    risen = np.flatnonzero(progress >= 1.0 - np.exp(-1.0))
    return StepResponse(
        start=float(time[k]),
        end=float(time[end - 1]),
        origin=origin,
        target=target,
        rise_time=float(since[risen[0]]) if len(risen) else float("nan"),
        # What only settles inside the part that defines the final value has not settled.
        settling_time=float(since[settled]) if k + settled < final_part.start else float("nan"),
        overshoot=max(float(np.max(progress)) - 1.0, 0.0),
        steady_state_error=float(np.mean(demand[final_part] - displacement[final_part])),
    )
