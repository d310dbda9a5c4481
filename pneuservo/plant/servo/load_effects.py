"""What else hangs on the rod."""

import math
from typing import NamedTuple

from pneuservo.plant.servo.compilation import compiled

# What the flanks of a joint with backlash are taken to be when it has no stiffness of its own.
_FLANK_STIFFNESS = 1e6
_FLANK_DAMPING = 100.0


_STANDARD_GRAVITY = 9.81


class LoadEffects(NamedTuple):
    """Parameters of the effects of the load."""

    spring: float = 0.0
    """Stiffness of a spring [N/m]."""
    spring_origin: float = 0.0
    """How far beyond mid-stroke it is free [m]."""
    tilt: float = 0.0
    """Angle by which the axis is turned from where it is said to stand, rod upwards [rad]."""
    mode_share: float = 0.0
    """Moving mass of a structural mode as a share of the whole [-]."""
    mode_frequency: float = 20.0
    """[Hz]."""
    mode_damping: float = 0.02
    """Damping ratio [-]."""
    joint_share: float = 0.0
    """Mass behind the joint as a share of the whole [-]; 0 for no joint."""
    joint_stiffness: float = 0.0
    """[N/m]; 0 for the flanks of a joint with backlash."""
    joint_damping: float = 0.0
    """[N s/m]."""
    joint_play: float = 0.0
    """Free travel of the joint [m]."""


@compiled
def spring_force(displacement, stroke, effects):
    """Return the force of the spring, positive extends [N].

    Parameters
    ----------
    displacement, stroke : float
        [m].
    effects : LoadEffects
        The effects.
    """
    return -effects.spring * (displacement - 0.5 * stroke - effects.spring_origin)


@compiled
def tilt_force(mass, gravity, effects):
    """Return what a tilt changes in the weight along the axis [N].

    Parameters
    ----------
    mass : float
        Whole moved mass [kg].
    gravity : float
        Its component along the axis without tilt, positive extends [m/s^2].
    effects : LoadEffects
        The effects.

    Notes
    -----
    From where the axis stands without it, as the component says, a positive tilt turns the rod
    upwards (4.23). Of one that hangs straight down both signs are alike.

    Examples
    --------
    A rod that hangs down loses 1 - cos of its weight, one that lies level sin:

    >>> round(tilt_force(1.0, 9.81, LoadEffects(tilt=0.1)), 3)
    -0.049
    >>> round(tilt_force(1.0, 0.0, LoadEffects(tilt=0.1)), 3)
    -0.979
    """
    if effects.tilt == 0.0:
        return 0.0
    whole = max(_STANDARD_GRAVITY, abs(gravity))
    turned = math.acos(gravity / whole) + effects.tilt
    return mass * (whole * math.cos(turned) - gravity)


@compiled
def mode_force(mass, mode_displacement, mode_rate, effects):
    """Return the force of the mode on the piston [N].

    Parameters
    ----------
    mass : float
        Whole moved mass [kg].
    mode_displacement, mode_rate : float
        Of the mode's mass against the rod [m], [m/s].
    effects : LoadEffects
        The effects.

    Notes
    -----
    q'' + 2 z w q' + w^2 q = -x''; its mass counts with the rest while it does not swing
    (thesis section 4.3.3).
    """
    if effects.mode_share == 0.0:
        return 0.0
    return (
        -effects.mode_share * mass * mode_acceleration(0.0, mode_displacement, mode_rate, effects)
    )


@compiled
def mode_acceleration(acceleration, mode_displacement, mode_rate, effects):
    """Return the second derivative of the mode's displacement [m/s^2].

    Parameters
    ----------
    acceleration : float
        Of the rod [m/s^2].
    mode_displacement, mode_rate : float
        As in `mode_force`.
    effects : LoadEffects
        The effects.
    """
    w = 2.0 * math.pi * effects.mode_frequency
    return -acceleration - w * (w * mode_displacement + 2.0 * effects.mode_damping * mode_rate)


@compiled
def joint_stiffness(effects):
    """Return the stiffness of the joint in contact [N/m].

    Parameters
    ----------
    effects : LoadEffects
        The effects.
    """
    return effects.joint_stiffness if effects.joint_stiffness > 0.0 else _FLANK_STIFFNESS


@compiled
def joint_force(stretch, stretch_rate, effects):
    """Return the force of the joint on the rod [N].

    Parameters
    ----------
    stretch, stretch_rate : float
        Of the load against the rod [m], [m/s].
    effects : LoadEffects
        The effects.

    Notes
    -----
    Linear outside the free travel, where also the damping acts.
    """
    half = 0.5 * effects.joint_play
    if abs(stretch) <= half:
        return 0.0
    damping = effects.joint_damping if effects.joint_damping > 0.0 else _FLANK_DAMPING
    return joint_stiffness(effects) * (stretch - math.copysign(half, stretch)) + (
        damping * stretch_rate
    )


@compiled
def joint_at_rest(weight, effects):
    """Return the stretch at which the joint carries its load [m].

    Parameters
    ----------
    weight : float
        Of the whole moved mass along the axis [N].
    effects : LoadEffects
        The effects.
    """
    carried = effects.joint_share * weight
    if carried == 0.0:
        return 0.0
    return carried / joint_stiffness(effects) + math.copysign(0.5 * effects.joint_play, carried)


@compiled
def rigid_mass(mass, effects):
    """Return the mass that moves with the rod at once [kg].

    Parameters
    ----------
    mass : float
        Whole moved mass [kg].
    effects : LoadEffects
        The effects.
    """
    return mass * (1.0 - effects.mode_share - effects.joint_share)
