"""What is timed: the card steps the piston of the single-axis rig from 15 to 24 mm and back.

The card by its figures, with breaks of 5 kHz; boundary layer of 5 m/s2, or a relay. The start lies
0.5 mm beside the set point, because exactly on it the rounding would decide how a relay switches.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard
from pneuservo.plant import integrator
from pneuservo.plant.control_law import ControlLaw
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate
from pneuservo.simulation.run import with_card_at_rest

RIG = load_rig("single-axis")
START = InitialState(0.0145)
ALLOWED_ERROR = 0.1e-6  # m, against the reference
REFERENCE_STEP = 1e-6  # s, of the classical Runge-Kutta method
_RATE, _UP, _BACK = 1e3, 0.02, 0.5
_BREAK = 5e3  # Hz

_FIGURES = replace(
    card_figures(load_design()),
    velocity_breaks=(_BREAK, _BREAK),
    acceleration_breaks=(_BREAK, _BREAK),
)
CARDS = {
    "boundary layer": AnalogueCard(_FIGURES),
    "relay": AnalogueCard(replace(_FIGURES, output_gain=math.inf)),
}


def course(duration: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return times [s] and demand [m]; after 1 s it all begins again."""
    time = np.arange(round(duration * _RATE) + 1) / _RATE
    within = time % 1.0
    return time, np.where((within >= _UP) & (within < _BACK), 0.024, 0.015)


def displacement(card: AnalogueCard, duration: float, step: float) -> NDArray[np.float64]:
    """Return the displacement of a run of the product [m]."""
    time, demand = course(duration)
    return simulate(
        RIG, time=time, controller=card, demand=demand, initial=START, largest_step=step
    )["displacement"]


def numbers(card: AnalogueCard) -> tuple[ControlLaw, SingleAxis, NDArray[np.float64]]:
    """Return law, plant and the state at the start, as the kernels take them."""
    law, plant = card.law(RIG), plant_numbers.single_axis(RIG)
    return law, plant, with_card_at_rest(START.state(plant, 0.0, 0.0), law)


def reference(card: AnalogueCard, duration: float) -> NDArray[np.float64]:
    """Return the displacement by the classical Runge-Kutta method in short steps [m].

    Its steps, and how it locates events, are not those of the runs that are compared with it.
    """
    time, demand = course(duration)
    law, plant, state = numbers(card)
    inputs = np.column_stack((demand, np.zeros_like(demand)))
    grid = plant_numbers.valve_grid(RIG.valve)
    outputs = integrator.run(time, inputs, state, law, plant, grid, REFERENCE_STEP)
    return np.asarray(outputs[:, integrator.OUTPUTS.index("displacement")])
