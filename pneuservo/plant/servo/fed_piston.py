"""Piston and load driven by the pressures that were measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo import layout
from pneuservo.plant.servo.layout import Fed, Servo
from pneuservo.plant.servo.load_effects import rigid_mass
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import NEUTRAL, ServoEffects
from pneuservo.plant.servo.starting import Samples, servo_inputs, servo_state
from pneuservo.plant.servo.transducers import (
    displacement_gain_along,
    first_order_lag,
    read_displacement,
    true_motion,
    true_pressures,
)
from pneuservo.plant.single_axis import PLANT_STATES, SingleAxis

# The fastest of the piston alone is friction's m/c, 18 ms; a stiff joint needs shorter steps.
LARGEST_STEP = 500e-6
_NO_GRID = np.zeros((4, 51, 101))


@dataclass(frozen=True)
class FedPiston:
    """What the piston does under measured pressures.

    Parameters
    ----------
    displacement, velocity, acceleration : (n,) array
        As the transducer has them [m], [m/s], [m/s^2].
    friction_force : (n,) array
        What Coulomb friction and stops take, positive when it resists extension [N].
    """

    displacement: Samples
    velocity: Samples
    acceleration: Samples
    friction_force: Samples


@dataclass(frozen=True)
class PistonBalance:
    """The balance of forces on a piston whose motion and pressures were measured.

    Parameters
    ----------
    residual : (n,) array
        Force that the model lacks to give the measured acceleration, positive when the piston is
        pushed to extend by something the model does not have [N]. At rest friction takes
        whatever it is given, so that samples at rest say nothing.
    driving_force : (n,) array
        Every modelled force but Coulomb friction and inertia [N].
    friction_force : (n,) array
        Modelled Coulomb friction, positive when it resists extension [N].
    """

    residual: Samples
    driving_force: Samples
    friction_force: Samples


def fed_piston(
    time: Samples,
    pressure_a: Samples,
    pressure_b: Samples,
    displacement: Samples,
    velocity: Samples,
    plant: SingleAxis,
    effects: ServoEffects = NEUTRAL,
    *,
    acceleration: Samples | None = None,
    external_force: Samples | float = 0.0,
    mass_flow_a: Samples | None = None,
    mass_flow_b: Samples | None = None,
    restarts: ArrayLike = (),
    largest_step: float = LARGEST_STEP,
) -> FedPiston:
    """Simulate the piston under measured pressures.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    pressure_a, pressure_b : (n,) array
        As the transducers read them; straight between samples [Pa].
    displacement, velocity : (n,) array
        As read. Only the first sample and those of `restarts` are used [m], [m/s].
    plant : SingleAxis
        The numbers of the rig.
    effects : ServoEffects, optional
        The baseline by default.
    acceleration : (n,) array, optional
        As read, for undoing a lag of the displacement transducer at restarts [m/s^2].
    external_force : (n,) array or float, optional
        At the rod, positive when it resists extension, held between samples [N].
    mass_flow_a, mass_flow_b : (n,) array, optional
        Through the pipes of the transducers, for the effect of reading static pressure [kg/s].
    restarts : sequence of int, optional
        Samples at which the motion is set to what was read.
    largest_step : float, optional
        Of the integration; stick and slip are located inside a step [s].

    Returns
    -------
    FedPiston
        Free running between restarts.
    """
    servo = Servo(plant, effects, OPEN_LOOP, Fed(pressures=True))
    inputs = _inputs(
        time, pressure_a, pressure_b, displacement, velocity, acceleration, servo,
        external_force, mass_flow_a, mass_flow_b,
    )  # fmt: skip
    again = np.zeros(len(time), dtype=bool)
    again[np.asarray(restarts, dtype=int)] = True
    out = _run(inputs, again, servo, largest_step)
    return FedPiston(
        read_displacement(out[:, 0], effects.sensor),
        out[:, 1],
        out[:, 2],
        out[:, layout.FRICTION_OUT],
    )


def piston_balance(
    time: Samples,
    pressure_a: Samples,
    pressure_b: Samples,
    displacement: Samples,
    velocity: Samples,
    acceleration: Samples,
    plant: SingleAxis,
    effects: ServoEffects = NEUTRAL,
    *,
    external_force: Samples | float = 0.0,
    mass_flow_a: Samples | None = None,
    mass_flow_b: Samples | None = None,
) -> PistonBalance:
    """Return what the balance of forces lacks under measured pressures and motion.

    Parameters
    ----------
    time, pressure_a, pressure_b, displacement, velocity, plant, effects
        As in `fed_piston`; every sample of the motion is used.
    acceleration : (n,) array
        As read [m/s^2].
    external_force, mass_flow_a, mass_flow_b
        As in `fed_piston`.

    Returns
    -------
    PistonBalance
        Effects with a memory (presliding, lag, swinging loads) follow the measured motion.
    """
    servo = Servo(plant, effects, OPEN_LOOP, Fed(motion=True, pressures=True))
    inputs = _inputs(
        time, pressure_a, pressure_b, displacement, velocity, acceleration, servo,
        external_force, mass_flow_a, mass_flow_b,
    )  # fmt: skip
    out = _run(inputs, np.zeros(len(time), dtype=bool), servo, np.inf)
    mass = float(rigid_mass(plant.piston.mass, effects.load))
    sensor = effects.sensor
    driving, friction = out[:, layout.DRIVING_OUT], out[:, layout.FRICTION_OUT]
    net = driving - friction
    if sensor.displacement_lag > 0.0:
        # Forward through the transducer: undoing its lag would differentiate the acceleration.
        net = first_order_lag(time, net, sensor.displacement_lag)
    slope = displacement_gain_along(displacement, plant.piston.stroke, sensor)
    return PistonBalance(mass * acceleration / slope - net, driving, friction)


def _inputs(
    time: Samples,
    pressure_a: Samples,
    pressure_b: Samples,
    displacement: Samples,
    velocity: Samples,
    acceleration: Samples | None,
    servo: Servo,
    external_force: Samples | float,
    mass_flow_a: Samples | None,
    mass_flow_b: Samples | None,
) -> Samples:
    plant, sensor = servo.plant, servo.effects.sensor
    true_x, true_v = true_motion(displacement, velocity, acceleration, plant.piston.stroke, sensor)
    true_a, true_b = true_pressures(
        time, pressure_a, pressure_b, mass_flow_a, mass_flow_b, plant.gas, sensor
    )
    return servo_inputs(
        time,
        plant.supply_pressure,
        external_force=external_force,
        fed_displacement=true_x,
        fed_velocity=true_v,
        fed_pressure_a=true_a,
        fed_pressure_b=true_b,
    )


def _run(inputs: Samples, restarts: np.ndarray, servo: Servo, largest_step: float) -> Samples:
    start = np.zeros(PLANT_STATES)
    start[:4] = inputs[0, layout.FED_DISPLACEMENT : layout.FED_PRESSURE_B + 1]
    state = servo_state(start, servo, float(inputs[0, layout.SUPPLY]))
    out: Samples = run_servo(inputs, restarts, state, servo, _NO_GRID, largest_step)
    return out
