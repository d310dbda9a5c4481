"""How fast what is known of a pressure fades."""

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.servo.command import followed_by_spool
from pneuservo.diagnosis.noise import LIKELY_WANDER, WANDER_TIME
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
displacement that it adds up to is known to some micrometres [s]."""


def spread_of_pressures(
    time: Array,
    unseen: Array,
    striking: NDArray[np.bool_],
    held: NDArray[np.bool_],
    noise: dict[str, float],
    velocity_rms: Array,
    rig: Rig,
) -> Array:
    """Return how much less is known of each pressure after each interval [Pa^2].

    Parameters
    ----------
    time, unseen, striking, held, noise
        As in `pneuservo.diagnosis.models.servo.feed.Feed`.
    velocity_rms : (n,) array
        How well a velocity that is taken over is known [m/s].
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
    valve = plant.valve
    interval = float(np.median(steps))
    mean, _ = followed_by_spool(unseen, interval, valve.spool_frequency, valve.spool_damping)
    off = mean / valve.full_voltage
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
        found[-1] += held * (drawn_in * velocity_rms) ** 2 * steps * MOTION_MEMORY
    return np.array(found)
