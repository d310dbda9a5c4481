"""Sizing of components: the valve and the supply pressure that a required response needs."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from analog_card.linear_servo import LinearServo
from pneuservo.errors import InputError
from pneuservo.linear.servo_data import ServoData
from pneuservo.sliding_mode.range_space import RangeSpace
from pneuservo.sliding_mode.reachability import LONGEST, SHORTEST, reachability
from pneuservo.sliding_mode.surface import Surface, surface_from_settling_time

# Supply pressures that are looked at, over that of the rig [-].
_LOWEST, _HIGHEST = 0.5, 4.0

Models = Callable[[ServoData], Sequence[LinearServo]]


def required_opening(
    servos: Sequence[LinearServo], surface: Surface, space: RangeSpace, level: float
) -> float:
    """Return the valve that a surface needs, as a multiple of the one there is [-].

    Parameters
    ----------
    servos : sequence of LinearServo
        With the valve there is; all of them have to reach the surface.
    surface : Surface
        Of order 2; what it does is the required response.
    space : RangeSpace
        Over which it has to be reachable.
    level : float
        Largest voltage [V].

    Notes
    -----
    Section 7.5.2 of the thesis, closing remark. The equivalent control falls with the flow.

    Examples
    --------
    >>> from pneuservo.linear import conventional_servo, table_5_2
    >>> from pneuservo.sliding_mode.surface import surface_from_settling_time
    >>> space = RangeSpace((-0.03, 0.03), (-0.25, 0.356), (-67.0, 82.0))
    >>> servos = [conventional_servo(table_5_2())]
    >>> round(required_opening(servos, surface_from_settling_time(0.05), space, 5.0), 2)
    2.14
    """
    return reachability(servos, surface, space, level).voltage / level


def least_opening(
    servo: LinearServo, space: RangeSpace, level: float, damping: float = 1.0
) -> tuple[float, float]:
    """Return the smallest valve with which any surface is reachable, and that surface.

    Parameters
    ----------
    servo, space, level
        As in `required_opening`.
    damping : float, optional
        Of the surfaces [-].

    Returns
    -------
    opening, settling_time : float
        As a multiple of the valve there is [-], and [s]; among surfaces of 5 ms to 1 s.

    Notes
    -----
    Where the curve of figure 7.7 of the thesis begins.
    """

    def opening(logarithm: float) -> float:
        surface = surface_from_settling_time(math.exp(logarithm), damping)
        return required_opening([servo], surface, space, level)

    grid = np.linspace(math.log(SHORTEST), math.log(LONGEST), 200)
    best = int(np.argmin([opening(float(point)) for point in grid]))
    bounds = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
    found = minimize_scalar(opening, bounds=bounds, method="bounded")
    return float(found.fun), math.exp(float(found.x))


def required_supply_pressure(
    data: ServoData, models: Models, surface: Surface, space: RangeSpace, level: float
) -> float | None:
    """Return the supply pressure that a surface needs.

    Parameters
    ----------
    data : ServoData
        The servo as it is.
    models : callable
        Returns its linear models at another supply pressure.
    surface, space, level
        As in `required_opening`.

    Returns
    -------
    float or None
        Absolute [Pa]; None when no pressure from half to four times the rig's will do.

    Raises
    ------
    InputError
        When a pressure is not a number.

    Notes
    -----
    The pressure raises the flow, but also the stiffness of the chambers, against which the
    equivalent control works: often it does not help.
    """
    if not math.isfinite(data.supply_pressure):
        raise InputError(f"supply pressure is {data.supply_pressure}; it has to be a finite number")

    def excess(pressure: float) -> float:
        scale = pressure / data.supply_pressure
        changed = replace(
            data,
            supply_pressure=pressure,
            pressure_a=data.pressure_a * scale,
            pressure_b=data.pressure_b * scale,
        )
        return required_opening(models(changed), surface, space, level) - 1.0

    low, high = _LOWEST * data.supply_pressure, _HIGHEST * data.supply_pressure
    if excess(low) <= 0.0:
        return low
    if excess(high) > 0.0:
        return None
    return float(brentq(excess, low, high, xtol=1.0))
