"""The whole chain of the single-axis rig: command, spool, flow, chambers, piston, sensor, law.

The functions take the state and the modes as arrays or as tuples, and in tuples `Lanes` in place of
numbers: the same equations advance one run or eight.
"""

from typing import NamedTuple

from pneuservo.plant.analogue_card import differentiator_output, differentiator_rates
from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import (
    CARD_TAPS,
    HELD_VOLTAGE,
    limited,
    switching_surface,
    unlimited_output,
)
from pneuservo.plant.gas import Gas
from pneuservo.plant.lanes import select
from pneuservo.plant.piston import Piston, acceleration, driving_force, is_moving
from pneuservo.plant.valve import (
    Valve,
    chamber_a_mass_flow,
    chamber_b_mass_flow,
    spool_acceleration,
)

# Places in the state; the last four exist only with a card.
(
    DISPLACEMENT,
    VELOCITY,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    SPOOL_RATE,
    CARD_LAGGED_1,
    CARD_DERIVATIVE_1,
    CARD_LAGGED_2,
    CARD_DERIVATIVE_2,
) = range(10)
PLANT_STATES = 6
STATES_WITH_CARD = 10
STATE_LIKE = (0.0,) * STATES_WITH_CARD

# Places in the modes, and the values that are not those of `piston`.
MOTION, SPOOL_LIMIT, RELAY_SIGN = range(3)
SPOOL_FREE = 0
MODES_LIKE = (0.0,) * 3

# Places in a row of inputs, held from one row to the next.
COMMAND, EXTERNAL_FORCE = range(2)


class SingleAxis(NamedTuple):
    """The numbers of the single-axis rig."""

    supply_pressure: float
    """Absolute pressure at the supply port [Pa]."""
    ambient_pressure: float
    """Absolute pressure at the exhaust port and round the rod [Pa]."""
    dead_volume_a: float
    dead_volume_b: float
    """Volumes of chamber a retracted and chamber b extended, pipe included [m^3]."""
    polytropic_index: float
    """Of both chambers [-]."""
    gas: Gas
    valve: Valve
    piston: Piston


@compiled
def piston_force(state, inputs, plant):
    """Return the force on the piston without Coulomb friction, positive extends [N].

    Parameters
    ----------
    state, inputs, plant
        As in `derivative`.
    """
    return driving_force(
        state[PRESSURE_A],
        state[PRESSURE_B],
        state[VELOCITY],
        inputs[EXTERNAL_FORCE],
        plant.ambient_pressure,
        plant.piston,
    )


@compiled
def surface(state, modes, inputs, law, plant):
    """Return the switching function of the law, in its own unit.

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.
    """
    if law.source == CARD_TAPS:
        return switching_surface(
            law.sensitivity * (state[DISPLACEMENT] - inputs[COMMAND]),
            -differentiator_output(state[CARD_DERIVATIVE_1], law.velocity_time_constant),
            differentiator_output(state[CARD_DERIVATIVE_2], law.acceleration_time_constant),
            law,
        )
    force = piston_force(state, inputs, plant)
    return switching_surface(
        state[DISPLACEMENT] - inputs[COMMAND],
        state[VELOCITY],
        acceleration(force, modes[MOTION], plant.piston),
        law,
    )


@compiled
def commanded_voltage(state, modes, inputs, law, plant):
    """Return the command into the valve driver before any limit [V].

    Parameters
    ----------
    state, modes, inputs, law, plant
        As in `derivative`.
    """
    if law.source == HELD_VOLTAGE:
        return inputs[COMMAND]
    return unlimited_output(surface(state, modes, inputs, law, plant), modes[RELAY_SIGN], law)


@compiled
def plant_rates(state, modes, inputs, law, plant, grid):
    """Return the rates of the six states of the plant.

    Parameters
    ----------
    state, modes, inputs, law, plant, grid
        As in `derivative`.

    Returns
    -------
    tuple of 6 floats or Lanes
        In SI per second; places as named in this module.
    """
    piston, valve = plant.piston, plant.valve
    motion = modes[MOTION]
    displacement, opening = state[DISPLACEMENT], state[SPOOL]
    velocity = select(is_moving(motion), state[VELOCITY], 0.0)
    command = limited(commanded_voltage(state, modes, inputs, law, plant), law.level)
    ports = (plant.supply_pressure, plant.ambient_pressure, valve, plant.gas, grid)
    pressure_a, pressure_b = state[PRESSURE_A], state[PRESSURE_B]
    spool_is_free = modes[SPOOL_LIMIT] == SPOOL_FREE
    spool_push = spool_acceleration(
        limited(command, valve.full_voltage), opening, state[SPOOL_RATE], valve
    )
    return (
        velocity,
        acceleration(piston_force(state, inputs, plant), motion, piston),
        pressure_rate(
            chamber_a_mass_flow(opening, pressure_a, *ports),
            pressure_a,
            piston.area_a * displacement + plant.dead_volume_a,
            piston.area_a * velocity,
            plant.polytropic_index,
            plant.gas,
        ),
        pressure_rate(
            chamber_b_mass_flow(opening, pressure_b, *ports),
            pressure_b,
            piston.area_b * (piston.stroke - displacement) + plant.dead_volume_b,
            -piston.area_b * velocity,
            plant.polytropic_index,
            plant.gas,
        ),
        select(spool_is_free, state[SPOOL_RATE], 0.0),
        select(spool_is_free, spool_push, 0.0),
    )


@compiled
def card_rates(state, law):
    """Return the rates of the four states of a card by its figures.

    Parameters
    ----------
    state, law
        As in `derivative`.

    Returns
    -------
    tuple of 4 floats or Lanes
        In V/s and V/s^2; places as named in this module, from `CARD_LAGGED_1` on.
    """
    lagged_1, derivative_1 = differentiator_rates(
        law.sensitivity * state[DISPLACEMENT],
        state[CARD_LAGGED_1],
        state[CARD_DERIVATIVE_1],
        law.velocity_lag_1,
        law.velocity_lag_2,
    )
    lagged_2, derivative_2 = differentiator_rates(
        differentiator_output(state[CARD_DERIVATIVE_1], law.velocity_time_constant),
        state[CARD_LAGGED_2],
        state[CARD_DERIVATIVE_2],
        law.acceleration_lag_1,
        law.acceleration_lag_2,
    )
    return lagged_1, derivative_1, lagged_2, derivative_2


@compiled
def derivative(state, modes, inputs, law, plant, grid, rate):
    """Write the rate of the state of the whole chain.

    Parameters
    ----------
    state : (6,) or (10,) array
        In SI; places as named in this module.
    modes : (3,) array of int
        What the piston is doing, the limit the spool is at, which way a relay is switched.
    inputs : (2,) array
        Held voltage [V] or demand [m], and external force [N].
    law : ControlLaw
        What commands the valve.
    plant : SingleAxis
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients, from `discharge_grid`.
    rate : (6,) or (10,) array
        Written: the rate of the state in SI per second.
    """
    of_plant = plant_rates(state, modes, inputs, law, plant, grid)
    for i in range(PLANT_STATES):
        rate[i] = of_plant[i]
    if law.source == CARD_TAPS:
        of_card = card_rates(state, law)
        for i in range(STATES_WITH_CARD - PLANT_STATES):
            rate[PLANT_STATES + i] = of_card[i]
