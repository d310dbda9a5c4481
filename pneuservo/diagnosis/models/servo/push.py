"""The acceleration that forces give the piston, at a place and speed that are known."""

from pneuservo.plant.compilation import compiled
from pneuservo.plant.piston import driving_force
from pneuservo.plant.servo.friction_effects import (
    breakaway_gain,
    friction_levels,
    viscous_excess,
)
from pneuservo.plant.servo.load_effects import rigid_mass, spring_force, tilt_force
from pneuservo.plant.servo.mechanics import carried_force
from pneuservo.plant.servo.stop_effects import bumper_force
from pneuservo.plant.servo.unexplained_effects import unexplained_force
from pneuservo.plant.single_axis import DISPLACEMENT, PLANT_STATES, PRESSURE_A, PRESSURE_B, SPOOL


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
        From `pneuservo.diagnosis.models.servo.turning.friction_direction`.
    servo : Servo
        The numbers of rig and effects.
    """
    plant, effects = servo.plant, servo.effects
    extending, retracting = dry_friction(time, state, speed, servo)
    force = acting_force(time, state, speed, external_force, servo)
    force -= viscous_excess(speed, felt, plant.piston.viscous_friction, time, effects.friction)
    force -= (extending if direction > 0.0 else retracting) * direction
    return force / rigid_mass(plant.piston.mass, effects.load)


@compiled
def balance_at_rest(time, state, creep, rested, external_force, servo):
    """Return the force on a piston at rest, and how much of it friction can hold.

    Parameters
    ----------
    time, state, external_force, servo
        As for `push`.
    creep : float
        Speed at which it creeps: what moves so slowly passes for rest [m/s].
    rested : float
        How long it has been at rest [s].

    Returns
    -------
    force, holding : float
        Positive towards extension [N]; the piston slips where the force is larger [N].
    """
    extending, retracting = dry_friction(time, state, 0.0, servo)
    force = acting_force(time, state, creep, external_force, servo)
    gained = breakaway_gain(rested, servo.effects.friction)
    return force, gained + (extending if force > 0.0 else retracting)


@compiled
def dry_friction(time, state, speed, servo):
    """Return the friction that does not depend on viscosity, extending and retracting [N]."""
    plant = servo.plant
    return friction_levels(
        plant.piston.coulomb_friction,
        state[DISPLACEMENT],
        speed,
        state[PRESSURE_A],
        state[PRESSURE_B],
        plant.ambient_pressure,
        plant.piston.stroke,
        time,
        servo.effects.friction,
    )


@compiled
def acting_force(time, state, speed, external_force, servo):
    """Return the force on the piston but for dry and extra viscous friction [N]."""
    plant, effects = servo.plant, servo.effects
    piston, load = plant.piston, effects.load
    place, pressure_a, pressure_b = state[DISPLACEMENT], state[PRESSURE_A], state[PRESSURE_B]
    force = driving_force(
        pressure_a, pressure_b, speed, external_force, plant.ambient_pressure, piston
    )
    force += spring_force(place, piston.stroke, load)
    force += tilt_force(piston.mass, piston.gravity, load)
    if state.shape[0] > PLANT_STATES:
        force += carried_force(state, servo)
    force += bumper_force(place, speed, piston.stroke, effects.stop)
    force += unexplained_force(place, speed, pressure_a, pressure_b, state[SPOOL], time, effects)
    return force
