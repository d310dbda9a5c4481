"""The way to the surface and along it: reaching time, and what is left against disturbances."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.linear.models import state_matrices
from pneuservo.sliding_mode.surface import Surface

# How finely a motion is looked at, and after how long at full voltage it is given up at the
# earliest [s], or at so many times what the way takes at full speed [-].
_STEP, _LONGEST, _TIMES_AS_LONG = 2e-4, 2.0, 3.0
_MOST_POINTS = 5000


@dataclass(frozen=True)
class ReachingPhase:
    """A motion at full voltage up to the surface.

    Attributes
    ----------
    time : float
        When the surface is reached [s].
    voltage : float
        With its sign [V].
    states : (n, 3) array
        Error [m], velocity [m/s] and acceleration [m/s2] on the way, the last on the surface.
    """

    time: float
    voltage: float
    states: Array


def reaching_phase(
    servo: LinearServo, surface: Surface, level: float, error: float
) -> ReachingPhase:
    """Return the motion of a linear servo from rest to the surface.

    Parameters
    ----------
    servo : LinearServo
        The servo, with or without the dynamics of its valve.
    surface : Surface
        Of order 2.
    level : float
        Of the relay [V].
    error : float
        Displacement less demand at the start, not zero [m].

    Returns
    -------
    ReachingPhase
        Up to the first time that the switching function is zero.

    Raises
    ------
    InputError
        When the error is zero, or the surface is not reached within 2 s, or three times what the
        way takes at full speed where that is longer.

    Notes
    -----
    Exact: the voltage is constant until then, and the servo linear.

    Examples
    --------
    >>> from pneuservo.linear import advanced_servo, table_5_2, without_valve
    >>> from pneuservo.sliding_mode.surface import surface_from_settling_time
    >>> servo = without_valve(advanced_servo(table_5_2(), 0.015, extending=True))
    >>> surface = surface_from_settling_time(0.07)
    >>> round(reaching_phase(servo, surface, 5.0, -0.03).time, 3)  # the thesis: 0.065 s
    0.063
    """
    if error == 0.0:
        raise InputError("the error is 0: the motion starts on the surface already")
    a, b = state_matrices(servo)
    voltage = -np.sign(error) * level
    # The constant voltage as one more state.
    order = len(a)
    augmented = np.zeros((order + 1, order + 1))
    augmented[:order, :order], augmented[:order, order] = a, b[:, 0]
    start = np.zeros(order + 1)
    start[0], start[-1] = error, voltage
    weights = np.array(surface.weights)

    def sigma(state: Array) -> float:
        return float(-weights @ state[:3]) * np.sign(voltage)

    longest = max(_LONGEST, _TIMES_AS_LONG * abs(error) * servo.a1 / (servo.b0 * level))
    step, passed = _STEP, 0.0
    onwards = expm(augmented * step)
    states = [start]
    while sigma(following := onwards @ states[-1]) > 0.0:
        states.append(following)
        passed += step
        if passed > longest:
            raise InputError(
                f"the surface is not reached within {longest:.3g} s at {level:g} V from a step of "
                f"{1e3 * abs(error):.3g} mm; give a smaller step or a higher level"
            )
        if passed > _LONGEST and step == _STEP:
            # What the start stirred up is over: the rest of a long way is even.
            step *= longest / _LONGEST
            onwards = expm(augmented * step)
    rest = brentq(lambda t: sigma(expm(augmented * t) @ states[-1]), 0.0, step, xtol=1e-12)
    at = float(passed + rest)
    states.append(expm(augmented * rest) @ states[-1])
    return ReachingPhase(at, float(voltage), np.array(states)[:, :3])


def sliding_phase(surface: Surface, state: Array, duration: float | None = None) -> Array:
    """Return the ideal motion along a surface.

    Parameters
    ----------
    surface : Surface
        Of order 2.
    state : (3,) array
        On the surface: error, velocity and acceleration [m], [m/s], [m/s2].
    duration : float, optional
        By default until it has settled, twice the settling time [s].

    Returns
    -------
    (n, 3) array
        Error, velocity and acceleration.
    """
    c1, c2, c3 = surface.weights
    motion = np.array([[0.0, 1.0], [-c1 / c3, -c2 / c3]])
    length = 2 * surface.settling_time if duration is None else duration
    count = min(math.ceil(length / _STEP), _MOST_POINTS)
    step = expm(motion * length / count)
    states = [np.asarray(state[:2], float)]
    for _ in range(count):
        states.append(step @ states[-1])
    both = np.array(states)
    return np.column_stack((both, both @ motion[1]))
