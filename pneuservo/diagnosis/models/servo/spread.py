"""How fast what is known of a pressure fades, and how sure it is where a spool should be."""

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.servo.command import followed_by_spool
from pneuservo.diagnosis.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.valve import Valve
from pneuservo.rigs import Rig

Array = NDArray[np.float64]

MEMORY = 0.3
"""Time over which a pressure is followed while the piston moves: slower errors of the flow fade,
and an observer of the whole motion that trusts its model for longer runs away with a large one
[s]."""
HELD_MEMORY = 1.0
"""The same of a piston that is held, whose motion is known [s]."""
START = 0.02
"""At the start nothing is known of the spool and of the pressures' past for this long [s]."""
MOTION_MEMORY = 1.5e-3
"""Time over which an error of a velocity that is taken over lasts: about a sample, for the
displacement that it adds up to is known to some micrometres [s] ..."""
MOTION_MEMORY_AT_REST = 0.05
"""... but that of a piston which only seems to rest lasts as long as it has to look so [s]."""


def spread_of_pressures(
    time: Array,
    unseen: Array,
    striking: NDArray[np.bool_],
    held: NDArray[np.bool_],
    noise: dict[str, float],
    velocity_rms: Array,
    motion_memory: float,
    rig: Rig,
) -> Array:
    """Return how much less is known of each pressure after each interval [Pa^2].

    Parameters
    ----------
    time, unseen, striking, held, noise
        As in `pneuservo.diagnosis.models.servo.feed.Feed`.
    velocity_rms : (n,) array
        How well a velocity that is taken over is known [m/s].
    motion_memory : float
        How long it is off by that [s].
    rig : Rig
        The rig.

    Returns
    -------
    (2, n) array
        A steady part, which fades what is older than `MEMORY` or `HELD_MEMORY` though the zeros of
        the transducers wander, one for what a command does between two samples, one for what
        cannot be judged, and one for a motion that is taken over.
    """
    from pneuservo.plant.from_rig import single_axis

    plant = single_axis(rig)
    steps = np.diff(time, append=time[-1] + (time[-1] - time[-2]))
    gas, piston = plant.gas, plant.piston
    unsure = ((time < time[0] + START) | striking).astype(float)
    off, _ = _unseen_opening(time, unseen, plant.valve)
    flow = gas.choked_coefficient * plant.supply_pressure / np.sqrt(gas.temperature)
    memory = np.where(held, HELD_MEMORY, MEMORY)
    slowly = steps + 2.0 * LIKELY_WANDER**2 * WANDER_TIME
    found = []
    for area, dead, side, name in (
        (plant.valve.area_s_a, plant.dead_volume_a, piston.area_a, "pressure_a"),
        (plant.valve.area_s_b, plant.dead_volume_b, piston.area_b, "pressure_b"),
    ):
        volume = dead + 0.5 * side * piston.stroke
        rate = plant.polytropic_index * gas.gas_constant * gas.temperature * flow * area / volume
        found.append(noise.get(name, 0.0) ** 2 * slowly * steps / memory**2)
        found[-1] += (off**2 + unsure**2) * (rate * steps) ** 2
        # A chamber half filled, whose volume changes at a speed that is not quite known.
        drawn_in = 0.5 * plant.polytropic_index * plant.supply_pressure * side / volume
        # While it moves, the observer has a speed of its own.
        found[-1] += held * (drawn_in * velocity_rms) ** 2 * steps * motion_memory
    return np.array(found)


def shares_of_spool(time: Array, unseen: Array, reading: Array, noise: float, rig: Rig) -> Array:
    """Return the noise of each reading of the spool over the spread of what is beyond expected.

    Parameters
    ----------
    time, unseen
        As in `spread_of_pressures`.
    reading : (n,) array
        Of the spool's transducer; NaN where there is none [-].
    noise : float
        Of the reading [-].
    rig : Rig
        The rig.

    Returns
    -------
    (n,) array
        Less than one where a command that runs on bends between two samples, and until the spool
        has followed it: what it did in between is not known; 0 where there is no reading [-].
    """
    from pneuservo.plant.from_rig import single_axis

    _, off = _unseen_opening(time, unseen, single_axis(rig).valve)
    return np.where(np.isfinite(reading), noise / np.hypot(noise, off), 0.0)


def _unseen_opening(time: Array, unseen: Array, valve: Valve) -> tuple[Array, Array]:
    """Return by how much the opening may be off: its mean in each interval, and at each sample."""
    interval = float(np.median(np.diff(time)))
    mean, at_samples = followed_by_spool(
        unseen, interval, valve.spool_frequency, valve.spool_damping
    )
    return mean / valve.full_voltage, at_samples / valve.full_voltage
