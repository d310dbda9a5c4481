"""A law closed round a plant, step by step."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.sliding_mode.laws import Law
from pneuservo.sliding_mode.plants import Plant

_COLUMNS = ("displacement", "velocity", "acceleration", "voltage", "sigma")


@dataclass(frozen=True)
class LoopRun:
    """A run of a law round a plant.

    Attributes
    ----------
    time, displacement, velocity, acceleration : (n,) array
        [s], [m], [m/s], [m/s2].
    voltage : (n,) array
        Held from each time on [V].
    sigma : (n,) array
        Switching function, in its own unit.
    demand : float
        [m].
    """

    time: Array
    displacement: Array
    velocity: Array
    acceleration: Array
    voltage: Array
    sigma: Array
    demand: float

    def mean_error(self, share: float = 0.3) -> float:
        """Return demand less displacement, mean over the end of the run [m].

        Parameters
        ----------
        share : float, optional
            Share of the run that is averaged [-].
        """
        start = round(len(self.time) * (1 - share))
        return float(np.mean(self.demand - self.displacement[start:]))

    def swing(self, share: float = 0.3) -> float:
        """Return the peak-to-peak swing of the switching function at the end of the run.

        Parameters
        ----------
        share : float, optional
            Share of the run that is looked at [-].
        """
        return float(np.ptp(self.sigma[round(len(self.time) * (1 - share)) :]))


def run_loop(
    plant: Plant, law: Law, demand: float, duration: float, step: float = 50e-6
) -> LoopRun:
    """Return the run of a law round a plant from where the plant stands.

    Parameters
    ----------
    plant : Plant
        Moved on by the run.
    law : Law
        Evaluated at the start of each step and held over it.
    demand : float
        [m].
    duration, step : float
        [s]. The step is the shortest time between two switchings.

    Returns
    -------
    LoopRun
        One row for each step.
    """
    rows = np.empty((round(duration / step), len(_COLUMNS)))
    for row in rows:
        x, *derivatives = plant.motion()
        state = (x - demand, *derivatives)
        sigma = law.sigma(state)
        voltage = law.voltage(state, step)
        row[:] = x, derivatives[0], derivatives[1], voltage, sigma
        plant.advance(voltage, step)
    columns = {name: rows[:, k] for k, name in enumerate(_COLUMNS)}
    return LoopRun(time=step * np.arange(len(rows), dtype=float), demand=demand, **columns)
