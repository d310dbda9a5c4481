"""The piston: forces, set-valued friction, end stops."""

from typing import NamedTuple

from pneuservo.plant.compilation import compiled
from pneuservo.plant.lanes import select

# What the piston is doing. Magnitude 1 is motion, with its direction as the sign.
EXTENDING = 1
RETRACTING = -1
AT_REST = 0
AT_RETRACTED_STOP = -2
AT_EXTENDED_STOP = 2


class Piston(NamedTuple):
    """The numbers of the cylinder and what it carries."""

    area_a: float
    """Full piston area [m^2]."""
    area_b: float
    """Piston area less rod area [m^2]."""
    stroke: float
    """Distance between the end stops [m]."""
    mass: float
    """Whole moved mass [kg]."""
    gravity: float
    """Gravity along the axis, positive when it extends [m/s^2]."""
    viscous_friction: float
    """Friction force per velocity [N s/m]."""
    coulomb_friction: float
    """Friction force that does not depend on velocity; also the largest force at rest [N]."""


@compiled
def driving_force(pressure_a, pressure_b, velocity, external_force, ambient_pressure, piston):
    """Return the force on the piston without Coulomb friction, positive extends [N].

    Parameters
    ----------
    pressure_a, pressure_b : float
        Absolute chamber pressures [Pa].
    velocity : float
        Piston velocity [m/s].
    external_force : float
        Force at the rod, positive when it resists extension [N].
    ambient_pressure : float
        Acts on the rod's cross-section [Pa].
    piston : Piston
        The numbers of the piston.

    Notes
    -----
    Equation (4.23) with the ambient pressure on the rod, which absolute pressures require.
    """
    return (
        pressure_a * piston.area_a
        - pressure_b * piston.area_b
        - ambient_pressure * (piston.area_a - piston.area_b)
        + piston.mass * piston.gravity
        - piston.viscous_friction * velocity
        - external_force
    )


@compiled
def is_moving(motion):
    """Return whether a piston that does this has a velocity.

    Parameters
    ----------
    motion : int
        One of the constants of this module.
    """
    return abs(motion) == 1


@compiled
def acceleration(force, motion, piston):
    """Return the acceleration of the piston [m/s^2].

    Parameters
    ----------
    force : float
        From `driving_force` [N].
    motion : int
        What the piston is doing; 0 is returned at rest and at a stop, where friction or the
        stop takes the force.
    piston : Piston
        The numbers of the piston.

    Notes
    -----
    Equation (4.53): Coulomb friction opposes motion with a constant force.
    """
    moving = (force - motion * piston.coulomb_friction) / piston.mass
    return select(is_moving(motion), moving, 0.0)


@compiled
def friction_margin(motion, velocity, force, piston):
    """Return how far the piston is from stopping or breaking away: negative once it has to.

    Parameters
    ----------
    motion : int
        What it is doing.
    velocity : float
        How fast [m/s].
    force : float
        From `driving_force` [N].
    piston : Piston
        The numbers of the piston.

    Returns
    -------
    float
        While moving the velocity in the direction of motion [m/s]; otherwise the force that
        friction can still take, at a stop against leaving it [N].
    """
    # At a stop the motion is twice the direction that the stop is in.
    push = select(motion == AT_REST, abs(force), -0.5 * motion * force)
    return select(is_moving(motion), motion * velocity, piston.coulomb_friction - push)


@compiled
def stop_margin(motion, displacement, piston):
    """Return the distance to the stop ahead, negative beyond it; 1 while nothing moves [m].

    Parameters
    ----------
    motion : int
        What the piston is doing.
    displacement : float
        Where it is [m].
    piston : Piston
        The numbers of the piston.
    """
    ahead = select(motion == EXTENDING, piston.stroke - displacement, displacement)
    return select(is_moving(motion), ahead, 1.0)


@compiled
def motion_margin(motion, displacement, velocity, force, piston):
    """Return how far the piston is from doing something else: negative once it has to change.

    Parameters
    ----------
    motion : int
        What it is doing.
    displacement, velocity : float
        Where it is and how fast [m], [m/s].
    force : float
        From `driving_force` [N].
    piston : Piston
        The numbers of the piston.

    Returns
    -------
    float
        The smaller of `friction_margin` and `stop_margin`. Only the sign and the zero mean
        anything.
    """
    return min(
        friction_margin(motion, velocity, force, piston),
        stop_margin(motion, displacement, piston),
    )


@compiled
def motion_from(displacement, velocity, force, piston):
    """Return what a piston in this state does next.

    Parameters
    ----------
    displacement, velocity : float
        Where it is and how fast [m], [m/s].
    force : float
        From `driving_force` [N].
    piston : Piston
        The numbers of the piston.

    Returns
    -------
    int
        `EXTENDING`, `RETRACTING`, `AT_REST`, `AT_RETRACTED_STOP` or `AT_EXTENDED_STOP`.

    Notes
    -----
    The stops are inelastic: at a stop a velocity into it counts as none. The piston leaves the
    stop, or its place, when the force in that direction exceeds Coulomb friction.
    """
    if displacement <= 0.0 and velocity <= 0.0:
        return EXTENDING if force > piston.coulomb_friction else AT_RETRACTED_STOP
    if displacement >= piston.stroke and velocity >= 0.0:
        return RETRACTING if force < -piston.coulomb_friction else AT_EXTENDED_STOP
    if velocity > 0.0:
        return EXTENDING
    if velocity < 0.0:
        return RETRACTING
    if force > piston.coulomb_friction:
        return EXTENDING
    if force < -piston.coulomb_friction:
        return RETRACTING
    return AT_REST
