"""The plant under the behavioural card: the card advances first, the plant follows.

Over a step the card hears the displacement with the velocity and acceleration that the piston has
at its start; what that leaves out is jerk times the step cubed, some 1e-11 m. The mean of its
control voltage then commands the valve over the same step, which the spool (200 Hz) cannot tell
from its course.
"""

import math

import numpy as np

from analog_card.behaviour_kernel import OUTPUTS as CARD_OUTPUTS
from analog_card.behaviour_kernel import advance_card
from analog_card.behaviour_kernel import outputs as card_outputs
from analog_card.differentiator_kernel import EXTENDED
from pneuservo.plant.compilation import compiled
from pneuservo.plant.events import settle
from pneuservo.plant.integrator import advance, initial_modes
from pneuservo.plant.outputs import (
    ACCELERATION_OUT,
    CARD_ACCELERATION_OUT,
    CARD_VELOCITY_OUT,
    DISPLACEMENT_OUT,
    OUTPUTS,
    PRESSURE_A_OUT,
    PRESSURE_B_OUT,
    SPOOL_OUT,
    SURFACE_OUT,
    VELOCITY_OUT,
    VOLTAGE_OUT,
)
from pneuservo.plant.piston import acceleration, is_moving
from pneuservo.plant.single_axis import (
    COMMAND,
    DISPLACEMENT,
    EXTERNAL_FORCE,
    MOTION,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    VELOCITY,
    piston_force,
)

# Places of the card's voltages among its outputs.
FIRST, SECOND, SURFACE, CONTROL = (
    CARD_OUTPUTS.index(name) for name in ("first", "second", "surface", "control")
)


@compiled
def write_voltages(voltages, output):
    """Write the outputs that are voltages of the card.

    Parameters
    ----------
    voltages : (n,) array
        The card's outputs [V].
    output : (m,) array
        Written: places as in `pneuservo.plant.outputs.OUTPUTS`.
    """
    output[VOLTAGE_OUT] = voltages[CONTROL]
    output[SURFACE_OUT] = voltages[SURFACE]
    output[CARD_VELOCITY_OUT] = voltages[FIRST]
    output[CARD_ACCELERATION_OUT] = voltages[SECOND]


@compiled
def mean_voltage(card_state, motion, sensitivity, demand, duration, substeps, card, work):
    """Advance the card by one step of the plant and return its mean control voltage [V].

    Parameters
    ----------
    card_state, sensitivity, demand, duration, substeps, card, work
        As in `card_step`.
    motion : tuple of 3 floats
        Displacement [m], velocity [m/s] and acceleration [m/s^2] at the start of the step, as the
        transducer has them.
    """
    displacement, velocity, rate = motion
    total = 0.0
    for i in range(substeps):
        passed = duration * i / substeps
        total += advance_card(
            card_state,
            sensitivity * (displacement + (velocity + 0.5 * rate * passed) * passed),
            sensitivity * (velocity + rate * passed),
            sensitivity * rate,
            sensitivity * demand,
            card,
            work,
        )
    return total / substeps


@compiled
def card_step(
    state, card_state, modes, held, sensitivity, demand, duration, substeps, card, plant, work
):
    """Advance the card by one step of the plant and return its mean control voltage [V].

    Parameters
    ----------
    state : (6,) array
        Of the plant, at the start of the step.
    card_state : (16,) array
        Changed.
    modes, held, plant
        As modes, inputs and plant in `pneuservo.plant.single_axis.derivative`.
    sensitivity : float
        Displacement transducer [V/m].
    demand : float
        [m].
    duration : float
        Length of the step [s].
    substeps : int
        Steps of the card in it.
    card : CardNumbers
        The card.
    work : (2, 12) array
        Overwritten.
    """
    velocity = state[VELOCITY] if is_moving(modes[MOTION]) else 0.0
    rate = acceleration(piston_force(state, held, plant), modes[MOTION], plant.piston)
    motion = (state[DISPLACEMENT], velocity, rate)
    return mean_voltage(card_state, motion, sensitivity, demand, duration, substeps, card, work)


@compiled
def run_with_card(
    time,
    inputs,
    initial_state,
    card_state,
    sensitivity,
    steps,
    substeps,
    card,
    law,
    plant,
    grid,
):
    """Return the outputs at every time of a run under the behavioural card.

    Parameters
    ----------
    time : (n,) array
        Equally spaced [s].
    inputs : (n, 2) array
        Demand [m] and external force [N]; a row holds until the next time.
    initial_state : (6,) array
        Of the plant, in SI.
    card_state : (16,) array
        At the first time; changed.
    sensitivity : float
        Displacement transducer [V/m].
    steps, substeps : int
        Steps of the plant from one time to the next, and of the card in each.
    card : CardNumbers
        The card, for steps of this length.
    law : ControlLaw
        `pneuservo.plant.control_law.OPEN_LOOP`: the card's voltage is held over a step.
    plant, grid
        As in `pneuservo.plant.single_axis.derivative`.

    Returns
    -------
    (n, 10) array
        One column per name of `pneuservo.plant.outputs.OUTPUTS`, in SI, each row just after
        its time.
    """
    state = initial_state.copy()
    work, result = np.empty((3, PLANT_STATES)), np.empty(PLANT_STATES)
    card_work, voltages = np.empty((2, EXTENDED)), np.empty(len(CARD_OUTPUTS))
    outputs = np.empty((time.shape[0], len(OUTPUTS)))
    held = inputs[0].copy()
    modes = initial_modes(state, held, plant)
    for k in range(time.shape[0]):
        demand = inputs[k, COMMAND]
        held[EXTERNAL_FORCE] = inputs[k, EXTERNAL_FORCE]
        card_outputs(card_state, sensitivity * state[DISPLACEMENT], card, card_work, voltages)
        held[COMMAND] = voltages[CONTROL]
        settle(state, modes, held, law, plant)
        row = outputs[k]
        row[DISPLACEMENT_OUT], row[VELOCITY_OUT] = state[DISPLACEMENT], state[VELOCITY]
        row[ACCELERATION_OUT] = acceleration(
            piston_force(state, held, plant), modes[MOTION], plant.piston
        )
        row[PRESSURE_A_OUT], row[PRESSURE_B_OUT] = state[PRESSURE_A], state[PRESSURE_B]
        row[SPOOL_OUT] = state[SPOOL]
        write_voltages(voltages, row)
        if k + 1 == time.shape[0] or not math.isfinite(state[DISPLACEMENT]):
            outputs[k + 1 :] = math.nan
            break
        duration = (time[k + 1] - time[k]) / steps
        for _ in range(steps):
            held[COMMAND] = card_step(
                state,
                card_state,
                modes,
                held,
                sensitivity,
                demand,
                duration,
                substeps,
                card,
                plant,
                card_work,
            )
            settle(state, modes, held, law, plant)
            advance(state, duration, modes, held, law, plant, grid, work, result)
    return outputs
