"""Where a run of the servo with effects starts, and what drives it, as the kernel takes them."""

import numpy as np

from pneuservo.arrays import Array
from pneuservo.plant.control_law import CARD_TAPS, ControlLaw
from pneuservo.plant.servo import layout
from pneuservo.plant.servo.chamber_effects import has_energy_balance
from pneuservo.plant.servo.drift import drift_of, drifted
from pneuservo.plant.servo.layout import Servo
from pneuservo.plant.servo.load_effects import joint_at_rest, spring_force, tilt_force
from pneuservo.plant.servo.sensor_effects import displacement_error
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.supply_effects import has_reservoir
from pneuservo.plant.servo.unexplained_effects import OVER_PRESSURES, tabulated
from pneuservo.plant.single_axis import (
    CARD_LAGGED_1,
    DISPLACEMENT,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    VELOCITY,
    SingleAxis,
)


def has_own_states(effects: ServoEffects, law: ControlLaw) -> bool:
    """Return whether an effect or the card needs states beyond the plant's six.

    Parameters
    ----------
    effects : ServoEffects
        The effects.
    law : ControlLaw
        What commands the valve.
    """
    return bool(
        law.source == CARD_TAPS
        or has_energy_balance(effects.chamber)
        or has_reservoir(effects.supply)
        or effects.line.frequency > 0.0
        or effects.friction.lag > 0.0
        or effects.sensor.displacement_lag > 0.0
        or effects.load.mode_share > 0.0
        or effects.load.joint_share > 0.0
        or effects.stop.cushion_length > 0.0
    )


def resting_force(displacement: float, plant: SingleAxis, effects: ServoEffects) -> float:
    """Return what the effects' own forces take from a piston at rest [N].

    Parameters
    ----------
    displacement : float
        Where it rests [m].
    plant : SingleAxis
        The numbers of the rig.
    effects : ServoEffects
        The effects.

    Returns
    -------
    float
        Counted like an external force: positive when it resists extension. Without a tabulated
        force over a pressure: the pressures at rest follow from what is returned here.
    """
    piston = plant.piston
    own = spring_force(displacement, piston.stroke, effects.load)
    own += tilt_force(piston.mass, piston.gravity, effects.load)
    table = effects.unexplained_force
    if table.over not in OVER_PRESSURES:
        own += tabulated(displacement, 0.0, 0.0, 0.0, 0.0, 0.0, table)
    return -float(own)


def servo_state(plant_state: Array, servo: Servo, supply_pressure: float) -> Array:
    """Return the state of the kernel for a state of the plant.

    Parameters
    ----------
    plant_state : (6,) array
        Places as in `pneuservo.plant.single_axis`, in SI.
    servo : Servo
        The numbers of rig, effects and law.
    supply_pressure : float
        At the start [Pa].

    Returns
    -------
    (6,) or (27,) array
        Gas and walls at room temperature, reservoir full, hoses, load and transducer settled.
    """
    if drift_of(servo.effects):
        servo = drifted(servo, 0.0)
    plant, effects = servo.plant, servo.effects
    if not has_own_states(effects, servo.law):
        return plant_state.copy()
    piston, room = plant.piston, plant.gas.temperature
    state = np.zeros(layout.SERVO_STATES)
    state[:PLANT_STATES] = plant_state
    displacement = plant_state[DISPLACEMENT]
    read = displacement + displacement_error(displacement, piston.stroke, effects.sensor)
    state[CARD_LAGGED_1] = servo.law.sensitivity * read
    state[[layout.TEMPERATURE_A, layout.TEMPERATURE_B, layout.WALL_A, layout.WALL_B]] = room
    state[layout.RESERVOIR] = supply_pressure
    state[layout.LAGGED_VELOCITY] = plant_state[VELOCITY]
    state[layout.LAGGED_DISPLACEMENT] = read
    state[layout.JOINT] = joint_at_rest(piston.mass * piston.gravity, effects.load)
    state[[layout.CUSHION_A, layout.PORT_PRESSURE_A]] = plant_state[PRESSURE_A]
    state[[layout.CUSHION_B, layout.PORT_PRESSURE_B]] = plant_state[PRESSURE_B]
    return state


def servo_inputs(time: Array, supply_pressure: Array | float, **columns: Array | float) -> Array:
    """Return the inputs of the kernel.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    supply_pressure : (n,) array or float
        Of the source [Pa].
    **columns : (n,) array or float
        By the name of the column in `layout` in lower case, such as ``command``; 0 without.

    Returns
    -------
    (n, 5) array
        Columns as in `layout`.
    """
    inputs = np.zeros((len(time), layout.INPUTS))
    inputs[:, layout.TIME] = time
    inputs[:, layout.SUPPLY] = supply_pressure
    for name, values in columns.items():
        inputs[:, getattr(layout, name.upper())] = values
    return inputs
