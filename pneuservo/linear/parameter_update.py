"""The parameter-update model: the linear model with its parameters taken where the piston is."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.linear.models import advanced_servo
from pneuservo.linear.servo_data import ServoData

# Voltage from time [s], displacement [m], velocity [m/s] and acceleration [m/s2].
Law = Callable[[float, float, float, float], float]


@dataclass(frozen=True)
class Motion:
    """A motion of the piston.

    Attributes
    ----------
    time, displacement, velocity, acceleration : (n,) array
        [s], [m], [m/s], [m/s2].
    """

    time: Array
    displacement: Array
    velocity: Array
    acceleration: Array


def parameter_update_jerk(
    data: ServoData, displacement: float, velocity: float, acceleration: float, voltage: float
) -> float:
    """Return the jerk of the parameter-update model [m/s3].

    Parameters
    ----------
    data : ServoData
        The servo at its quiescent pressures, which stay as they are.
    displacement, velocity, acceleration : float
        Of the piston; beyond an end of the stroke the parameters are those of the end [m],
        [m/s], [m/s2].
    voltage : float
        At the valve; its sign is the direction of opening [V].

    Notes
    -----
    Equation (5.50) of the thesis.
    """
    servo = advanced_servo(data, min(max(displacement, 0.0), data.stroke), voltage >= 0.0)
    return servo.b0 * voltage - servo.a1 * velocity - servo.a2 * acceleration


def parameter_update_response(
    data: ServoData, law: Law, time: Array, displacement: float
) -> Motion:
    """Return the motion of the parameter-update model from rest under a continuous law.

    Parameters
    ----------
    data : ServoData
        The servo.
    law : callable
        Voltage from time, displacement, velocity and acceleration; limited to the full voltage.
    time : (n,) array
        [s].
    displacement : float
        At the first time [m].

    Returns
    -------
    Motion
        At the times.

    Raises
    ------
    InputError
        When the integration fails.
    """

    def rate(t: float, state: Array) -> list[float]:
        x, v, a = (float(value) for value in state)
        voltage = float(np.clip(law(t, x, v, a), -data.full_voltage, data.full_voltage))
        return [v, a, parameter_update_jerk(data, x, v, a, voltage)]

    found = solve_ivp(
        rate,
        (float(time[0]), float(time[-1])),
        [displacement, 0.0, 0.0],
        t_eval=time,
        rtol=1e-7,
        atol=[1e-9, 1e-7, 1e-5],
        max_step=1e-2,
    )
    if not found.success:
        raise InputError(f"the parameter-update model cannot be integrated: {found.message}")
    return Motion(np.asarray(time, float), *found.y)
