"""What a run of the single axis gives at every time."""

import math

from pneuservo.plant.analogue_card import differentiator_output
from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import CARD_TAPS, HELD_VOLTAGE, limited
from pneuservo.plant.piston import acceleration
from pneuservo.plant.single_axis import (
    CARD_DERIVATIVE_1,
    CARD_DERIVATIVE_2,
    DISPLACEMENT,
    MOTION,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    VELOCITY,
    commanded_voltage,
    piston_force,
    surface,
)

OUTPUTS = (
    "displacement",
    "velocity",
    "acceleration",
    "pressure_a",
    "pressure_b",
    "spool",
    "valve_voltage",
    "surface",
    "card_velocity",
    "card_acceleration",
)
(
    DISPLACEMENT_OUT,
    VELOCITY_OUT,
    ACCELERATION_OUT,
    PRESSURE_A_OUT,
    PRESSURE_B_OUT,
    SPOOL_OUT,
    VOLTAGE_OUT,
    SURFACE_OUT,
    CARD_VELOCITY_OUT,
    CARD_ACCELERATION_OUT,
) = range(len(OUTPUTS))


@compiled
def output_values(state, modes, inputs, law, plant):
    """Return what `OUTPUTS` names, in SI; NaN for what the law does not have.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `pneuservo.plant.single_axis.derivative`.

    Returns
    -------
    tuple of 10 floats or Lanes
        In the order of `OUTPUTS`.
    """
    sigma = velocity_tap = acceleration_tap = math.nan * state[DISPLACEMENT]
    if law.source != HELD_VOLTAGE:
        sigma = surface(state, modes, inputs, law, plant)
    if law.source == CARD_TAPS:
        velocity_tap = differentiator_output(state[CARD_DERIVATIVE_1], law.velocity_time_constant)
        acceleration_tap = differentiator_output(
            state[CARD_DERIVATIVE_2], law.acceleration_time_constant
        )
    command = commanded_voltage(state, modes, inputs, law, plant)
    return (
        state[DISPLACEMENT],
        state[VELOCITY],
        acceleration(piston_force(state, inputs, plant), modes[MOTION], plant.piston),
        state[PRESSURE_A],
        state[PRESSURE_B],
        state[SPOOL],
        limited(command, law.level),
        sigma,
        velocity_tap,
        acceleration_tap,
    )
