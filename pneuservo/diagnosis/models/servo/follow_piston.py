"""The piston's displacement, followed from the measured pressures."""

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
from pneuservo.plant.servo.sensor_effects import displacement_gain
from pneuservo.plant.servo.stop_effects import bumper_force

CRITICAL = math.sqrt(2.0)
"""Gain on the velocity that makes the observer's damping ratio 0.7."""


@compiled
def follow_piston(
    time,
    reading,
    motion,
    true,
    pressures,
    external_force,
    held,
    bandwidth,
    reversal,
    plant,
    effects,
):
    """Return what the displacement reads beyond what forces and its own past make expected.

    Parameters
    ----------
    time : (n,) array
        [s].
    reading : (n,) array
        Displacement as measured, NaN where there is none [m].
    motion : (3, n) array
        Smoothed displacement, velocity and acceleration of the reading, SI.
    true : (3, n) array
        The same of the piston, the errors of the transducer undone, SI.
    pressures : (2, n) array
        As measured, the errors of the transducers undone [Pa].
    external_force : (n,) array
        At the rod, positive when it resists extension [N].
    held : (n,) array of bool
        While the piston sticks or lies at a stop: friction is then whatever it has to be, so
        that nothing can be judged and the motion is taken over as it is.
    bandwidth : float
        Of the observer [rad/s].
    reversal : float
        Speed over which friction turns round, the resolution of the velocity [m/s].
    plant : SingleAxis
        The numbers of the rig.
    effects : ServoEffects
        Parameters of the effects.

    Returns
    -------
    (n,) array
        Innovation of the displacement [m]; 0 while held.

    Notes
    -----
    Forces are worked out from the smoothed motion, so that the innovation is linear in them; a
    steady-state Kalman filter for white noise on pressures and displacement whitens it.
    """
    innovation = np.zeros(time.shape[0])
    acceleration = _accelerations(time, true, pressures, external_force, reversal, plant, effects)
    position, velocity, lagged = motion[0, 0], motion[1, 0], acceleration[0]
    lag = effects.sensor.displacement_lag
    for k in range(1, time.shape[0]):
        interval = time[k] - time[k - 1]
        slope = displacement_gain(true[0, k], plant.piston.stroke, effects.sensor)
        push = slope * 0.5 * (acceleration[k] + acceleration[k - 1])
        if lag > 0.0:
            lagged += (push - lagged) * -math.expm1(-interval / lag)
            push = lagged
        position += interval * velocity + 0.5 * interval * interval * push
        velocity += interval * push
        if held[k]:
            position, velocity, lagged = motion[0, k], motion[1, k], motion[2, k]
        elif reading[k] == reading[k]:
            error = reading[k] - position
            innovation[k] = error
            position += CRITICAL * bandwidth * interval * error
            velocity += bandwidth * bandwidth * interval * error
    return innovation


@compiled
def _accelerations(time, true, pressures, external_force, reversal, plant, effects):
    piston, friction, load = plant.piston, effects.friction, effects.load
    direction = np.tanh(true[1] / reversal)
    if friction.presliding_travel > 0.0:
        direction = presliding_state(
            true[0], friction.presliding_travel, friction.presliding_exponent, direction[0]
        )
    acceleration = np.empty(time.shape[0])
    felt, mode, mode_rate = true[1, 0], 0.0, 0.0
    for k in range(time.shape[0]):
        interval = time[k] - time[k - 1] if k else 0.0
        place, speed = true[0, k], true[1, k]
        if friction.lag > 0.0:
            felt += (speed - felt) * -math.expm1(-interval / friction.lag)
        if load.mode_share != 0.0:
            mode_rate += interval * mode_acceleration(true[2, k], mode, mode_rate, load)
            mode += interval * mode_rate
        extending, retracting = friction_levels(
            piston.coulomb_friction,
            place,
            speed,
            pressures[0, k],
            pressures[1, k],
            plant.ambient_pressure,
            piston.stroke,
            time[k],
            friction,
        )
        level = extending if direction[k] > 0.0 else retracting
        force = driving_force(
            pressures[0, k],
            pressures[1, k],
            speed,
            external_force[k],
            plant.ambient_pressure,
            piston,
        )
        force += spring_force(place, piston.stroke, load)
        force += tilt_force(piston.mass * piston.gravity, load)
        force += mode_force(piston.mass, mode, mode_rate, load)
        force += bumper_force(place, speed, piston.stroke, effects.stop)
        force -= viscous_excess(speed, felt, piston.viscous_friction, time[k], friction)
        force -= level * direction[k]
        acceleration[k] = force / rigid_mass(piston.mass, load)
    return acceleration
