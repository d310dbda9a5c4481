"""The compiled equations as functions of arrays, which is what a foreign solver calls fastest."""

import numpy as np
from numpy.typing import NDArray

from benchmarks.problem import CARDS, RIG, numbers
from pneuservo.controllers import AnalogueCard
from pneuservo.plant.compilation import compiled
from pneuservo.plant.events import margin, settle
from pneuservo.plant.lane_arrays import load_tuple
from pneuservo.plant.single_axis import derivative
from pneuservo.rigs import plant_numbers
from pneuservo.simulation.trials import floats_of

# How law and plant are put together from their floats.
_LIKE = numbers(CARDS["boundary layer"])[:2]


@compiled
def rate(state, modes, held, values, grid):
    law, plant = load_tuple(values, _LIKE)
    out = np.empty_like(state)
    derivative(state, modes, held, law, plant, grid, out)
    return out


@compiled
def least_margin(state, modes, held, values):
    law, plant = load_tuple(values, _LIKE)
    return margin(state, modes, held, law, plant)


@compiled
def settle_modes(state, modes, held, values):
    law, plant = load_tuple(values, _LIKE)
    settle(state, modes, held, law, plant)


class CompiledPlant:
    """Rates and events of the closed loop by the product's own compiled equations."""

    def __init__(self, card: AnalogueCard):
        self.law, self.plant, self.start = numbers(card)
        self.values = np.array(floats_of((self.law, self.plant)))
        self.grid = plant_numbers.valve_grid(RIG.valve)

    def rate(self, y: NDArray[np.float64], modes, held) -> NDArray[np.float64]:
        return rate(y, modes, held, self.values, self.grid)

    def margin(self, y: NDArray[np.float64], modes, held) -> float:
        return least_margin(y, modes, held, self.values)

    def settle(self, y: NDArray[np.float64], modes, held) -> None:
        settle_modes(y, modes, held, self.values)
