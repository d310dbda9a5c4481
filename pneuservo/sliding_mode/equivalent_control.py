"""Equivalent control, and the spaces that its limit bounds."""

from dataclasses import dataclass

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.linear.models import state_matrices, without_valve
from pneuservo.sliding_mode.range_space import RangeSpace
from pneuservo.sliding_mode.surface import Surface


def equivalent_gains(a: Array, b: Array, surface: Surface) -> Array:
    """Return the gains of the voltage that holds a plant on a surface, u = gains x.

    Parameters
    ----------
    a : (n, n) array
        System matrix in the canonical states: the error and its derivatives.
    b : (n, 1) array
        Input matrix.
    surface : Surface
        With n weights.

    Returns
    -------
    (n,) array
        -(s B)^-1 s A.

    Raises
    ------
    InputError
        When the orders of plant and surface do not match, or the input does not act on the
        surface.

    Notes
    -----
    Equation (6.24) of the thesis.
    """
    s = np.array(surface.weights)
    if len(s) != len(a):
        raise InputError(
            f"a plant of order {len(a)} needs a surface with {len(a)} weights; this one has "
            f"{len(s)}"
        )
    action = float(s @ b[:, 0])
    if action == 0.0:
        raise InputError("the input does not act on the surface: the weight it acts through is 0")
    return np.asarray(-(s @ a) / action)


def servo_gains(servo: LinearServo, surface: Surface) -> Array:
    """Return the gains of the equivalent control of a servo without valve dynamics.

    Parameters
    ----------
    servo : LinearServo
        The servo. With parameters other than the nominal ones the gains include what makes up
        for the change, (7.10).
    surface : Surface
        Of order 2.

    Returns
    -------
    (3,) array
        On error, which is 0, velocity and acceleration [V/m], [V s/m], [V s2/m].

    Notes
    -----
    Equation (7.7) of the thesis.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> from pneuservo.sliding_mode.surface import surface_from_settling_time
    >>> gains = servo_gains(conventional_servo(table_5_2()), surface_from_settling_time(0.07))
    >>> [round(float(gain), 3) for gain in gains[1:]]
    [13.195, -0.056]
    """
    return equivalent_gains(*state_matrices(without_valve(servo)), surface)


@dataclass(frozen=True)
class WorstControl:
    """The largest equivalent control over a range space, and where it is needed.

    Attributes
    ----------
    voltage : float
        Its magnitude [V].
    state : tuple of float
        Error [m], velocity [m/s], acceleration [m/s2] there, on the surface.
    """

    voltage: float
    state: tuple[float, ...]


def worst_equivalent_control(gains: Array, surface: Surface, space: RangeSpace) -> WorstControl:
    """Return the largest equivalent control on the part of a surface inside a range space.

    Parameters
    ----------
    gains : (3,) array
        From `servo_gains`.
    surface : Surface
        Of order 2.
    space : RangeSpace
        The box.

    Notes
    -----
    Equations (7.9) and (7.14) of the thesis: the surface is reachable over the whole range space
    when this does not exceed the largest voltage. A linear function is largest at a corner of the
    polygon that the surface cuts out of the box.
    """
    c1, c2, c3 = surface.weights
    (e_low, e_high), (v_low, v_high), (a_low, a_high) = (
        space.displacement,
        space.velocity,
        space.acceleration,
    )
    corners = [(v, a) for v in (v_low, v_high) for a in (a_low, a_high)]
    for error in (e_low, e_high):
        corners += [(v, -(c1 * error + c2 * v) / c3) for v in (v_low, v_high)]
        corners += [(-(c1 * error + c3 * a) / c2, a) for a in (a_low, a_high)]
    v, a = np.array(corners).T
    e = -(c2 * v + c3 * a) / c1
    inside = (
        _within(e, space.displacement) & _within(v, space.velocity) & _within(a, space.acceleration)
    )
    control = np.where(inside, np.abs(gains[1] * v + gains[2] * a), -1.0)
    worst = int(np.argmax(control))
    return WorstControl(float(control[worst]), (float(e[worst]), float(v[worst]), float(a[worst])))


def _within(values: Array, limits: tuple[float, float]) -> Mask:
    # A corner on a limit is inside whatever its rounding.
    slack = 1e-9 * (limits[1] - limits[0])
    return np.asarray((values >= limits[0] - slack) & (values <= limits[1] + slack))


def is_controllable(gains: Array, velocity: Array, acceleration: Array, level: float) -> Mask:
    """Return where the sign of the rate of sigma can be chosen: the controllability space.

    Parameters
    ----------
    gains : (3,) array
        From `servo_gains`.
    velocity, acceleration : array
        Of one shape [m/s], [m/s2].
    level : float
        Largest voltage [V].

    Returns
    -------
    array of bool

    Notes
    -----
    Equation (7.14) of the thesis.
    """
    return np.asarray(np.abs(gains[1] * velocity + gains[2] * acceleration) <= level)


def is_attracted(gains: Array, surface: Surface, state: tuple[Array, ...], level: float) -> Mask:
    """Return where a relay drives the state towards the surface, sigma d(sigma)/dt < 0.

    Parameters
    ----------
    gains : (3,) array
        From `servo_gains`.
    surface : Surface
        Of order 2.
    state : tuple of three arrays
        Error, velocity and acceleration of one shape [m], [m/s], [m/s2].
    level : float
        Of the relay [V].

    Returns
    -------
    array of bool

    Notes
    -----
    Equation (7.6) of the thesis with u = +U sgn(sigma): d(sigma)/dt = c3 b0 (u_eq - u), so that
    u_eq sgn(sigma) < U. Outside the controllability space it holds on one side of the surface
    only: the light grey regions of figures 7.2 and 7.3, against the dark ones.
    """
    e, v, a = state
    c1, c2, c3 = surface.weights
    sigma = -(c1 * e + c2 * v + c3 * a)
    return np.asarray((gains[1] * v + gains[2] * a) * np.sign(sigma) < level)
