"""The acceleration that forces give the piston, at a place and speed that are known."""

import math

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.piston import driving_force
from pneuservo.plant.presliding import presliding_state
from pneuservo.plant.servo.friction_effects import friction_levels, viscous_excess
from pneuservo.plant.servo.load_effects import (
    mode_acceleration,
    mode_force,
    rigid_mass,
    spring_force,
    tilt_force,
)
from pneuservo.plant.servo.stop_effects import bumper_force
from pneuservo.plant.servo.unexplained_effects import unexplained_force

FELT, MODE, MODE_RATE = range(3)
"""Places of what friction and the load remember: velocity felt, transverse mode and its rate."""


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
    interval,
    motion,
    pressure_a,
    pressure_b,
    spool,
    external_force,
    direction,
    remembered,
    plant,
    effects,
):
    """Return the acceleration of the piston at one sample [m/s^2].

    Parameters
    ----------
    time, interval : float
        Of the sample, and since the one before [s].
    motion : (3,) array
        Displacement, velocity and acceleration of the piston, SI.
    pressure_a, pressure_b : float
        [Pa].
    spool : float
        Fraction of full opening [-].
    external_force : float
        At the rod, positive when it resists extension [N].
    direction : float
        From `friction_direction`.
    remembered : (3,) array
        What friction and the load remember; written.
    plant : SingleAxis
        The numbers of the rig.
    effects : ServoEffects
        Parameters of the effects.
    """
    piston, friction, load = plant.piston, effects.friction, effects.load
    place, speed = motion[0], motion[1]
    felt = remembered[FELT]
    if friction.lag > 0.0:
        felt += (speed - felt) * -math.expm1(-interval / friction.lag)
        remembered[FELT] = felt
    if load.mode_share != 0.0:
        remembered[MODE_RATE] += interval * mode_acceleration(
            motion[2], remembered[MODE], remembered[MODE_RATE], load
        )
        remembered[MODE] += interval * remembered[MODE_RATE]
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
    force += mode_force(piston.mass, remembered[MODE], remembered[MODE_RATE], load)
    force += bumper_force(place, speed, piston.stroke, effects.stop)
    force += unexplained_force(place, speed, pressure_a, pressure_b, spool, time, effects)
    force -= viscous_excess(speed, felt, piston.viscous_friction, time, friction)
    force -= (extending if direction > 0.0 else retracting) * direction
    return force / rigid_mass(piston.mass, load)
