"""The acceleration that forces give the piston, at a place and speed that are known."""

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.piston import driving_force
from pneuservo.plant.presliding import presliding_state
from pneuservo.plant.servo.friction_effects import friction_levels, viscous_excess
from pneuservo.plant.servo.load_effects import rigid_mass, spring_force, tilt_force
from pneuservo.plant.servo.mechanics import carried_force
from pneuservo.plant.servo.stop_effects import bumper_force
from pneuservo.plant.servo.unexplained_effects import unexplained_force
from pneuservo.plant.single_axis import DISPLACEMENT, PLANT_STATES, PRESSURE_A, PRESSURE_B, SPOOL


@compiled
def friction_direction(displacement, velocity, reversal, friction):
    """Return which way friction acts, from -1 to 1.

    Parameters
    ----------
    displacement, velocity : (n,) array
        Of the piston, SI.
    reversal : float
        Speed over which friction turns round, the resolution of the velocity [m/s].
    friction : FrictionEffects
        Parameters of the effects.

    Returns
    -------
    (n,) array
        Share of the friction level, positive while extending.
    """
    direction = np.tanh(velocity / reversal)
    if friction.presliding_travel > 0.0:
        direction = presliding_state(
            displacement, friction.presliding_travel, friction.presliding_exponent, direction[0]
        )
    return direction


@compiled
def push(
    time,
    state,
    speed,
    felt,
    external_force,
    direction,
    servo,
):
    """Return the acceleration of the piston at one sample [m/s^2].

    Parameters
    ----------
    time : float
        Of the sample [s].
    state : array
        Of the chain, the piston where it was led to.
    speed, felt : float
        Of the piston, and as friction follows it [m/s].
    external_force : float
        At the rod, positive when it resists extension [N].
    direction : float
        From `friction_direction`.
    servo : Servo
        The numbers of rig and effects.
    """
    plant, effects = servo.plant, servo.effects
    piston, friction, load = plant.piston, effects.friction, effects.load
    place, pressure_a, pressure_b = state[DISPLACEMENT], state[PRESSURE_A], state[PRESSURE_B]
    extending, retracting = friction_levels(
        piston.coulomb_friction,
        place,
        speed,
        pressure_a,
        pressure_b,
        plant.ambient_pressure,
        piston.stroke,
        time,
        friction,
    )
    force = driving_force(
        pressure_a, pressure_b, speed, external_force, plant.ambient_pressure, piston
    )
    force += spring_force(place, piston.stroke, load)
    force += tilt_force(piston.mass * piston.gravity, load)
    if state.shape[0] > PLANT_STATES:
        force += carried_force(state, servo)
    force += bumper_force(place, speed, piston.stroke, effects.stop)
    force += unexplained_force(place, speed, pressure_a, pressure_b, state[SPOOL], time, effects)
    force -= viscous_excess(speed, felt, piston.viscous_friction, time, friction)
    force -= (extending if direction > 0.0 else retracting) * direction
    return force / rigid_mass(piston.mass, load)
