"""The signals of the force balance, from a recording of displacement and pressures."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array, Mask, bridged
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

# Section 4.3.2.1 of the thesis.
CUTOFF_FREQUENCY = 50.0
_ORDER = 2
# The filter needs so many periods of its cut-off to forget how the recording begins and ends.
SETTLING_PERIODS = 2.0
# Cut-off over sampling frequency; above it a difference quotient is no derivative any more.
_HIGHEST_SHARE = 0.2
# So near to an end stop, as a share of the stroke, the stop may take part of the force.
_AT_STOP = 0.01


@dataclass(frozen=True)
class ForceBalance:
    """The terms of m a + cf v + Fc sgn(v) = f, all filtered alike.

    Parameters
    ----------
    name : str
        Of the recording.
    time : (n,) array
        [s].
    velocity : (n,) array
        [m/s].
    inertia : (n,) array
        Acceleration less gravity along the axis: what the mass multiplies [m/s^2].
    direction : (n,) array
        Sign of the velocity, filtered like everything else [-].
    force : (n,) array
        Net force of the pressures, less a measured external force [N].
    free : (n,) array of bool
        Where the piston is away from both end stops.
    cutoff : float
        Of the filter [Hz].
    """

    name: str
    time: Array
    velocity: Array
    inertia: Array
    direction: Array
    force: Array
    free: Mask
    cutoff: float


def even(recording: Recording, channels: tuple[str, ...]) -> tuple[Array, dict[str, Array]]:
    """Return channels of a recording evenly sampled, without gaps.

    Parameters
    ----------
    recording : Recording
        The recording.
    channels : tuple of str
        Which channels.

    Returns
    -------
    time : (n,) array
        In steps of the median interval [s].
    samples : dict of str to (n,) array
        By channel, interpolated [SI].

    Raises
    ------
    InputError
        When a channel is missing or has no readings.
    """
    missing = [name for name in channels if name not in recording]
    if missing:
        raise InputError(
            f"{recording.source or recording.name}: an identification needs the channels "
            f"{', '.join(channels)}; {', '.join(missing)} is not there. The recording has: "
            f"{', '.join(recording.channels) or 'none'}. Map it in the sidecar's [channels]"
        )
    first, last = float(recording.time[0]), float(recording.time[-1])
    count = round((last - first) / recording.sampling_interval) + 1
    time = np.asarray(first + recording.sampling_interval * np.arange(count), dtype=np.float64)
    samples: dict[str, Array] = {}
    for name in channels:
        if np.isfinite(recording[name]).sum() < 2:
            raise InputError(f"{recording.name}: channel {name} has no readings")
        samples[name] = np.interp(time, recording.time, bridged(recording.time, recording[name]))
    return time, samples


def filtered(samples: Array, interval: float, cutoff: float = CUTOFF_FREQUENCY) -> Array:
    """Return a signal without what is above the cut-off, and without delay.

    Parameters
    ----------
    samples : (n,) array
        Evenly sampled [any unit].
    interval : float
        Between samples [s].
    cutoff : float, optional
        [Hz].

    Notes
    -----
    Second-order Butterworth, run forwards and backwards so that the sign of the velocity, which is
    worked out from filtered signals and filtered again, keeps its place in time.
    """
    from scipy.signal import butter, sosfiltfilt

    sections = butter(_ORDER, cutoff, fs=1.0 / interval, output="sos")
    smooth: Array = sosfiltfilt(sections, samples)
    return smooth


def force_balance(recording: Recording, rig: Rig, cutoff: float = CUTOFF_FREQUENCY) -> ForceBalance:
    """Return the terms of the force balance of a recording.

    Parameters
    ----------
    recording : Recording
        Displacement and both chamber pressures; an external force counts when it is there.
    rig : Rig
        Of kind ``single-axis``, with the conditions of the recording.
    cutoff : float, optional
        Of the filter; at most a fifth of the sampling frequency is used [Hz].

    Returns
    -------
    ForceBalance
        Without the first and the last sample.

    Raises
    ------
    InputError
        When a channel is missing, or the recording is too short or too slow for the cut-off.

    Notes
    -----
    Equations (4.36) to (4.41) of the thesis with centred differences (4.40), the ambient pressure
    on the rod and gravity taken in. Every term, the sign of the velocity too, passes the same
    filter: the balance then still holds term by term, which it does not when only the measured
    signals are filtered.
    """
    names: tuple[str, ...] = ("displacement", "pressure_a", "pressure_b")
    if "force" in recording:
        names = (*names, "force")
    time, samples = even(recording, names)
    interval = float(time[1] - time[0])
    _require_cutoff(recording.name, cutoff, interval, float(time[-1] - time[0]))
    cutoff = min(cutoff, _HIGHEST_SHARE / interval)
    smooth = {name: filtered(values, interval, cutoff) for name, values in samples.items()}
    x = smooth["displacement"]
    velocity = (x[2:] - x[:-2]) / (2.0 * interval)
    acceleration = (x[2:] - 2.0 * x[1:-1] + x[:-2]) / interval**2
    area_a, area_b = rig["piston.area_a"], rig["piston.area_b"]
    force = (
        area_a * smooth["pressure_a"]
        - area_b * smooth["pressure_b"]
        - rig["ambient.pressure"] * (area_a - area_b)
        - smooth.get("force", np.zeros_like(x))
    )
    return ForceBalance(
        recording.name,
        time[1:-1],
        velocity,
        acceleration - rig["load.gravity"],
        filtered(np.sign(velocity), interval, cutoff),
        force[1:-1],
        _free(x / rig["piston.stroke"], round(1.0 / (cutoff * interval)))[1:-1],
        cutoff,
    )


def _require_cutoff(name: str, cutoff: float, interval: float, duration: float) -> None:
    """Refuse a filter that does not settle within a recording, or that is none at its rate."""
    # What is used unless said is lowered to what the rate allows.
    lowest, highest = 2.0 * SETTLING_PERIODS / duration, max(0.5 / interval, CUTOFF_FREQUENCY)
    if not lowest < cutoff <= highest:
        raise InputError(
            f"{name}: a cut-off of {cutoff:g} Hz cannot be used with {duration:.4g} s at "
            f"{1.0 / interval:.4g} Hz; it has to be above {lowest:.3g} Hz, for the filter to "
            f"settle, and at most {highest:.4g} Hz. Give another --cutoff, or record longer"
        )


def _free(share: Array, settling: int) -> Mask:
    """Return where the piston has been away from both stops for as long as the filter settles."""
    from scipy.ndimage import binary_dilation

    touching = (share < _AT_STOP) | (share > 1.0 - _AT_STOP)
    return ~binary_dilation(touching, iterations=max(1, settling))
