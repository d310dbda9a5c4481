"""How fast what is known of a pressure fades, and how sure it is where a spool should be."""

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.servo.command import followed_by_spool, settling_time
from pneuservo.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.plant.valve import Valve
from pneuservo.rigs import Rig

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
    blind: Mask,
    striking: Mask,
    held: Mask,
    noise: dict[str, float],
    velocity_rms: Array,
    motion_memory: float,
    rig: Rig,
) -> Array:
    """Return how much less is known of each pressure after each interval [Pa^2].

    Parameters
    ----------
    time, unseen, blind, striking, held, noise
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
    from pneuservo.rigs.plant_numbers import single_axis

    plant = single_axis(rig)
    steps = np.diff(time, append=time[-1] + (time[-1] - time[-2]))
    gas, piston = plant.gas, plant.piston
    unsure = ((time < time[0] + START) | blind | striking).astype(float)
    off, _ = _unseen_opening(time, unseen, plant.valve)
    flow = gas.choked_coefficient * plant.supply_pressure / np.sqrt(gas.temperature)
    memory = np.where(held, HELD_MEMORY, MEMORY)
    slowly = steps + 2.0 * LIKELY_WANDER**2 * WANDER_TIME
    middle, halfway = np.array([0.5 * piston.stroke]), np.full((2, 1), 0.5 * plant.supply_pressure)
    volumes = _volumes(middle, plant)
    # A chamber half filled, whose volume changes at a speed that is not quite known.
    rises = rise_per_metre(halfway, middle, plant)
    found = []
    for area, volume, rise, name in (
        (plant.valve.area_s_a, volumes[0], rises[0], "pressure_a"),
        (plant.valve.area_s_b, volumes[1], rises[1], "pressure_b"),
    ):
        rate = plant.polytropic_index * gas.gas_constant * gas.temperature * flow * area / volume
        found.append(noise.get(name, 0.0) ** 2 * slowly * steps / memory**2)
        found[-1] += (off**2 + unsure**2) * (rate * steps) ** 2
        # While it moves, the observer has a speed of its own.
        found[-1] += held * (rise * velocity_rms) ** 2 * steps * motion_memory
    return np.array(found)


def rise_per_metre(pressures: Array, displacement: Array, plant: SingleAxis) -> Array:
    """Return by how much a piston that moves into a closed chamber raises its pressure [Pa/m].

    Parameters
    ----------
    pressures : (2, n) array
        Of both chambers [Pa].
    displacement : (n,) array
        Where the piston is [m].
    plant : SingleAxis
        The servo.

    Returns
    -------
    (2, n) array
        n p A / V of each chamber, the derivative of p V^n = const.

    Examples
    --------
    >>> from pneuservo.rigs.plant_numbers import single_axis
    >>> from pneuservo.rigs import load_rig
    >>> plant = single_axis(load_rig("single-axis"))
    >>> middle = np.array([0.5 * plant.piston.stroke])
    >>> (1e-7 * rise_per_metre(np.full((2, 1), 4e5), middle, plant)).round(1).tolist()
    [[3.0], [2.9]]
    """
    areas = np.array([[plant.piston.area_a], [plant.piston.area_b]])
    volumes = _volumes(displacement, plant)
    return np.asarray(plant.polytropic_index * pressures * areas / volumes)


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
        has followed it: what it did in between is not known; 0 where there is no reading, and until
        the spool has forgotten what the command was before the first sample [-].
    """
    from pneuservo.rigs.plant_numbers import single_axis

    valve = single_axis(rig).valve
    _, off = _unseen_opening(time, unseen, valve)
    begun = time < time[0] + settling_time(valve.spool_frequency, valve.spool_damping)
    return np.where(np.isfinite(reading) & ~begun, noise / np.hypot(noise, off), 0.0)


def _volumes(displacement: Array, plant: SingleAxis) -> Array:
    """Return the volumes of both chambers with the piston at some places [m^3]."""
    piston = plant.piston
    return np.array(
        [
            plant.dead_volume_a + piston.area_a * displacement,
            plant.dead_volume_b + piston.area_b * (piston.stroke - displacement),
        ]
    )


def _unseen_opening(time: Array, unseen: Array, valve: Valve) -> tuple[Array, Array]:
    """Return by how much the opening may be off: its mean in each interval, and at each sample."""
    interval = float(np.median(np.diff(time)))
    mean, at_samples = followed_by_spool(
        unseen, interval, valve.spool_frequency, valve.spool_damping
    )
    return mean / valve.full_voltage, at_samples / valve.full_voltage
