"""A recording of the servo as its blocks are fed with it."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.servo.motion import smooth_motion
from pneuservo.diagnosis.noise import noise_floor
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

Array = NDArray[np.float64]

STICKING = 3.0
"""A piston whose velocity is not this many times its uncertainty ..."""
HELD_FOR = 8e-3
"""... for this long counts as held [s]."""
SLOWEST_MOTION = 5e-4
"""A velocity is never taken to be known better than this [m/s]."""
NEAR_STOP = 5e-4
"""Distance from a stop within which the piston may touch it [m]."""
IMPACT = 0.01
"""Time round a touch during which the motion is not known well [s]."""
SLOWEST, FASTEST = 10.0, 300.0
"""Limits of the bandwidth with which the displacement is followed [rad/s]."""
MEMORY = 0.3
"""Time over which a pressure is followed: slower errors of the flow fade [s]."""
EDGE = 0.6
"""Error of the moment of a jump of the command, as a share of the sampling interval: at most
half of it to either side, and a little for the bend of a command that runs on."""
START = 0.02
"""At the start nothing is known of the spool and of the pressures' past for this long [s]."""
PRESSURE_SMOOTHING = 3e-3
"""Time over which pressures are averaged where their rate is wanted [s]."""


@dataclass(frozen=True)
class Feed:
    """What is measured round each block, once per recording.

    Parameters
    ----------
    time, voltage : (n,) array
        [s], [V].
    ramped : bool
        Whether the command runs straight between samples instead of being held.
    reading : (n,) array
        Displacement as measured; NaN where there is none [m].
    motion : (3, n) array
        Smoothed displacement, velocity and acceleration, SI.
    pressures : (2, n) array
        Pressures as measured, gaps closed [Pa].
    pressure_rates : (2, n) array
        Their smoothed rates [Pa/s].
    supply : (n,) array or None
        Measured supply pressure, smoothed [Pa].
    force : (n,) array
        At the rod [N].
    held : (n,) array of bool
        While the piston sticks or lies at a stop.
    reversal : float
        How well the velocity is known: friction turns round over this [m/s].
    bandwidth : float
        With which the displacement is followed [rad/s].
    touching : (n,) array of bool
        While the piston may touch a stop.
    spread : (2, n) array
        Variance that each interval adds to what is known of each pressure [Pa^2].
    noise : mapping of str to float
        Noise of each judged channel [SI].
    done : dict
        Results of the blocks, so that a change in one does not have the other run again.
    """

    time: Array
    voltage: Array
    ramped: bool
    reading: Array
    motion: Array
    pressures: Array
    pressure_rates: Array
    supply: Array | None
    force: Array
    held: NDArray[np.bool_]
    reversal: float
    bandwidth: float
    touching: NDArray[np.bool_]
    spread: Array
    noise: dict[str, float]
    done: dict[object, object] = field(default_factory=dict, repr=False)


def feed(recording: Recording, rig: Rig) -> Feed:
    """Return a recording as the blocks of the servo are fed with it.

    Parameters
    ----------
    recording : Recording
        With valve voltage, displacement and both pressures.
    rig : Rig
        The rig it was taken on.

    Returns
    -------
    Feed
        In SI.
    """
    time, interval = recording.time, recording.sampling_interval
    noise = {
        channel: recording.noise_rms.get(channel) or noise_floor(recording[channel], time)
        for channel in ("displacement", "pressure_a", "pressure_b")
    }
    pressures = np.array([_closed(recording[name], time) for name in ("pressure_a", "pressure_b")])
    areas = np.array([rig["piston.area_a"], rig["piston.area_b"]])
    mass = rig["load.mass"]
    spread_of_force = float(
        np.hypot(areas[0] * noise["pressure_a"], areas[1] * noise["pressure_b"])
    )
    force = _closed(recording["force"], time) if "force" in recording else np.zeros_like(time)
    driving = (areas[0] * pressures[0] - areas[1] * pressures[1] - force) / mass
    *smoothed, uncertainty = smooth_motion(
        time,
        recording["displacement"],
        noise["displacement"],
        driving,
        spread_of_force / mass,
    )
    motion, reversal = np.array(smoothed), max(float(uncertainty), SLOWEST_MOTION)
    voltage = _closed(recording["valve_voltage"], time)
    touching = _touching(motion[0], interval, rig["piston.stroke"])
    bandwidth = np.sqrt(spread_of_force / mass / noise["displacement"])
    return Feed(
        time=time,
        voltage=voltage,
        ramped=True,
        reading=recording["displacement"],
        motion=motion,
        pressures=pressures,
        pressure_rates=np.array([_rate(p, interval) for p in pressures]),
        supply=_supply(recording, interval),
        force=force,
        held=_held(motion[1], STICKING * reversal, interval) | touching,
        reversal=reversal,
        bandwidth=float(np.clip(bandwidth, SLOWEST, FASTEST)),
        touching=touching,
        spread=spread_of_pressures(time, voltage, True, touching, noise, rig),
        noise=noise,
    )


def _closed(samples: Array, time: Array) -> Array:
    good = np.isfinite(samples)
    return np.asarray(np.interp(time, time[good], samples[good]))


def _rate(samples: Array, interval: float) -> Array:
    from scipy.signal import savgol_filter

    window = max(5, 2 * round(PRESSURE_SMOOTHING / interval) + 1)
    return np.asarray(savgol_filter(samples, min(window, len(samples) | 1), 2, 1, interval))


def _supply(recording: Recording, interval: float) -> Array | None:
    from scipy.ndimage import uniform_filter1d

    if "supply_pressure" not in recording:
        return None
    width = max(1, round(PRESSURE_SMOOTHING / interval))
    closed = _closed(recording["supply_pressure"], recording.time)
    return np.asarray(uniform_filter1d(closed, width, mode="nearest"))


def _held(velocity: Array, slow: float, interval: float) -> NDArray[np.bool_]:
    from scipy.ndimage import binary_opening

    width = max(2, round(HELD_FOR / interval))
    return np.asarray(binary_opening(np.abs(velocity) < slow, np.ones(width)))


def _touching(displacement: Array, interval: float, stroke: float) -> NDArray[np.bool_]:
    """Return when the piston may touch a stop, where a force acts that nothing tells."""
    from scipy.ndimage import binary_dilation

    near = (displacement < NEAR_STOP) | (displacement > stroke - NEAR_STOP)
    return np.asarray(binary_dilation(near, np.ones(2 * max(1, round(IMPACT / interval)) + 1)))


def held_command(fed: Feed, rig: Rig) -> Feed:
    """Return the feed with a command that is held from sample to sample.

    Parameters
    ----------
    fed : Feed
        With a command that runs straight between samples.
    rig : Rig
        The rig it was taken on.
    """
    spread = spread_of_pressures(fed.time, fed.voltage, False, fed.touching, fed.noise, rig)
    return replace(fed, ramped=False, spread=spread, done={})


def spread_of_pressures(
    time: Array,
    voltage: Array,
    ramped: bool,
    touching: NDArray[np.bool_],
    noise: dict[str, float],
    rig: Rig,
) -> Array:
    """Return how much less is known of each pressure after each interval [Pa^2].

    Parameters
    ----------
    time, voltage, ramped, touching, noise
        As in `Feed`.
    rig : Rig
        The rig.

    Returns
    -------
    (2, n) array
        A steady part, which fades what is older than `MEMORY`, one for the moment at which a
        command that bends between two samples really jumped, and one for what cannot be judged.
    """
    from pneuservo.plant.from_rig import single_axis

    plant = single_axis(rig)
    steps = np.diff(time, append=time[-1] + (time[-1] - time[-2]))
    bend = np.zeros_like(voltage)
    if ramped:
        curve = np.abs(np.diff(voltage, 2, prepend=voltage[0], append=voltage[-1]))
        bend = np.maximum(curve, np.append(curve[1:], 0.0)) / plant.valve.full_voltage
    gas, piston = plant.gas, plant.piston
    unsure = ((time < time[0] + START) | touching).astype(float)
    flow = gas.choked_coefficient * plant.supply_pressure / np.sqrt(gas.temperature)
    found = []
    for area, dead, side, name in (
        (plant.valve.area_s_a, plant.dead_volume_a, piston.area_a, "pressure_a"),
        (plant.valve.area_s_b, plant.dead_volume_b, piston.area_b, "pressure_b"),
    ):
        volume = dead + 0.5 * side * piston.stroke
        rate = plant.polytropic_index * gas.gas_constant * gas.temperature * flow * area / volume
        found.append((noise[name] * steps / MEMORY) ** 2 + (EDGE * bend * rate * steps) ** 2)
        found[-1] += (unsure * rate * steps) ** 2
    return np.array(found)
