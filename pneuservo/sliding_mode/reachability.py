"""Which surfaces a servo reaches: the fastest over a range space, and along a trajectory."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from analog_card.linear_servo import LinearServo
from pneuservo.errors import InputError
from pneuservo.sliding_mode.equivalent_control import servo_gains, worst_equivalent_control
from pneuservo.sliding_mode.range_space import RangeSpace
from pneuservo.sliding_mode.reaching import reaching_phase, sliding_phase
from pneuservo.sliding_mode.surface import Surface, surface_from_settling_time

# Settling times that are looked at: one grid for every search, refined to this [s].
SHORTEST, LONGEST, _POINTS, _RESOLUTION = 0.005, 1.0, 80, 1e-5


@dataclass(frozen=True)
class Reachability:
    """Whether a surface is reachable over a range space, and what is needed for it.

    Attributes
    ----------
    reachable : bool
        Whether the largest equivalent control stays within the level.
    voltage : float
        The largest equivalent control, of all the servos looked at [V].
    level : float
        What there is [V].
    state : tuple of float
        Where it is needed: error [m], velocity [m/s], acceleration [m/s2].
    """

    reachable: bool
    voltage: float
    level: float
    state: tuple[float, ...]


def reachability(
    servos: Sequence[LinearServo], surface: Surface, space: RangeSpace, level: float
) -> Reachability:
    """Return whether a surface is reachable by every one of a set of linear models.

    Parameters
    ----------
    servos : sequence of LinearServo
        The nominal model alone, or one for every position and direction.
    surface : Surface
        Of order 2.
    space : RangeSpace
        The box over which it has to hold.
    level : float
        Largest voltage [V].

    Raises
    ------
    InputError
        When the level is not above 0 V.

    Notes
    -----
    Section 7.5.1 of the thesis: (7.9) for the nominal model, (7.11) with parameter changes.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> space = RangeSpace((-0.03, 0.03), (-0.25, 0.356), (-67.0, 82.0))
    >>> servo = conventional_servo(table_5_2())
    >>> reachability([servo], surface_from_settling_time(0.07), space, 5.0).reachable
    False
    """
    if level <= 0.0:
        raise InputError(f"level is {level:g} V; it has to be greater than 0")
    worst = max(
        (worst_equivalent_control(servo_gains(servo, surface), surface, space) for servo in servos),
        key=lambda found: found.voltage,
    )
    return Reachability(worst.voltage <= level, worst.voltage, level, worst.state)


def fastest_settling_time(
    servos: Sequence[LinearServo], space: RangeSpace, level: float, damping: float = 1.0
) -> float | None:
    """Return the settling time of the fastest surface that is reachable over a range space.

    Parameters
    ----------
    servos, space, level
        As in `reachability`.
    damping : float, optional
        Damping ratio of the surfaces [-].

    Returns
    -------
    float or None
        [s]; None when no surface between 5 ms and 1 s is reachable.

    Notes
    -----
    Figure 7.7 of the thesis.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> space = RangeSpace((-0.03, 0.03), (-0.25, 0.356), (-67.0, 82.0))
    >>> servo = conventional_servo(table_5_2())
    >>> fastest_settling_time([servo], space, 5.0) is None  # at opening 1
    True
    >>> round(fastest_settling_time([opened(servo, 2.0)], space, 5.0), 3)
    0.054
    """

    def excess(settling_time: float) -> float:
        surface = surface_from_settling_time(settling_time, damping)
        return reachability(servos, surface, space, level).voltage - level

    return _first_below_zero(excess)


def opened(servo: LinearServo, opening: float) -> LinearServo:
    """Return a servo with a larger or smaller valve, or one opened only in part.

    Parameters
    ----------
    servo : LinearServo
        The servo.
    opening : float
        Largest flow over that of the servo's own valve [-].
    """
    return replace(servo, b0=servo.b0 * opening)


def control_along_motion(
    servo: LinearServo, surface: Surface, level: float, error: float, sliding: bool = False
) -> float:
    """Return the largest equivalent control along a motion from rest to a surface [V].

    Parameters
    ----------
    servo : LinearServo
        The servo, without the dynamics of its valve.
    surface : Surface
        Of order 2.
    level : float
        Voltage at which it moves there [V].
    error : float
        Displacement less demand at the start [m].
    sliding : bool, optional
        Whether the ideal motion along the surface afterwards counts too.

    Notes
    -----
    Section 7.5.2 of the thesis: where it exceeds the level the state is outside the
    controllability space, and on one side of the surface it is repelled.
    """
    phase = reaching_phase(servo, surface, level, error)
    states = phase.states
    if sliding:
        states = np.vstack((states, sliding_phase(surface, states[-1])))
    return float(np.max(np.abs(states @ servo_gains(servo, surface))))


def fastest_along_motions(
    servos: Sequence[LinearServo],
    level: float,
    errors: Sequence[float],
    damping: float = 1.0,
    sliding: bool = False,
) -> float | None:
    """Return the settling time from which on all surfaces are reachable along motions from rest.

    Parameters
    ----------
    servos : sequence of LinearServo
        Models without the dynamics of their valves; all of them have to reach the surface.
    level : float
        Largest voltage [V].
    errors : sequence of float
        Errors at rest from which the motions start [m].
    damping : float, optional
        Damping ratio of the surfaces [-].
    sliding : bool, optional
        As in `control_along_motion`.

    Returns
    -------
    float or None
        [s]; None when not even a settling time of 1 s will do.

    Notes
    -----
    Section 7.5.2 of the thesis. Faster surfaces may be reachable again, since they lie otherwise
    across the motion: figures 7.10 and 7.11.
    """

    def excess(settling_time: float) -> float:
        surface = surface_from_settling_time(settling_time, damping)
        needed = (
            control_along_motion(servo, surface, level, error, sliding)
            for servo in servos
            for error in errors
        )
        return max(needed) - level

    grid = np.geomspace(LONGEST, SHORTEST, _POINTS)
    slower = None
    for point in grid:
        if excess(float(point)) > 0.0:
            # The switch is sudden where the motion only just touches the surface: bisection.
            return None if slower is None else _boundary(excess, float(point), slower)
        slower = float(point)
    return slower


def _boundary(excess: Callable[[float], float], beyond: float, within: float) -> float:
    while within - beyond > _RESOLUTION:
        middle = 0.5 * (within + beyond)
        if excess(middle) > 0.0:
            beyond = middle
        else:
            within = middle
    return within


def shortest_without_limit_cycle(servo: LinearServo) -> float:
    """Return the shortest settling time of a critically damped surface that causes no limit cycle.

    Parameters
    ----------
    servo : LinearServo
        The servo; the dynamics of its valve are not taken in.

    Returns
    -------
    float
        [s].

    Notes
    -----
    Sections 7.5.3 and 8.1.1 of the thesis: with ws = 4/settling time the frequency response of
    (s + ws)^2 G crosses the negative real axis when ws - sqrt(a1) >= sqrt(2 a2 ws).

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> round(shortest_without_limit_cycle(conventional_servo(table_5_2())), 4)
    0.0126
    """
    root = 0.5 * (math.sqrt(2 * servo.a2) + math.sqrt(2 * servo.a2 + 4 * math.sqrt(servo.a1)))
    return 4 / root**2


def _first_below_zero(excess: Callable[[float], float]) -> float | None:
    """Return the shortest settling time at which something is no longer in excess."""
    grid = np.geomspace(SHORTEST, LONGEST, _POINTS)
    before = None
    for point in grid:
        value = excess(float(point))
        if value <= 0.0:
            if before is None:
                return float(point)
            return float(brentq(excess, before, point, xtol=_RESOLUTION))
        before = float(point)
    return None
