"""What no equation is known for: a force or a flow tabulated over one quantity."""

import math
from typing import NamedTuple

from pneuservo.plant.servo.compilation import compiled, compiled_apart

QUANTITIES = (
    "displacement",
    "displacement while extending",
    "displacement while retracting",
    "velocity",
    "pressure_a",
    "pressure_b",
    "spool",
    "time",
    "pressure_a - pressure_b",
)
"""What a table may be over; `Table.over` is the place in this list."""
(
    DISPLACEMENT,
    DISPLACEMENT_EXTENDING,
    DISPLACEMENT_RETRACTING,
    VELOCITY,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    TIME,
    PRESSURE_DIFFERENCE,
) = range(len(QUANTITIES))
OVER_PRESSURES = (PRESSURE_A, PRESSURE_B, PRESSURE_DIFFERENCE)

INTERVALS = 8
"""Between the nine knots of a table."""
_DIRECTION_VELOCITY = 5e-3
"""Over which a table for one direction of motion fades in [m/s]."""


class Table(NamedTuple):
    """Values at equally spaced knots of one quantity; none while ``low`` and ``high`` are equal.

    Linear between the knots, constant beyond the ends.
    """

    over: float = 0.0
    """Which quantity, a place in `QUANTITIES`."""
    low: float = 0.0
    """The quantity at the first knot [its SI unit]."""
    high: float = 0.0
    """The quantity at the last knot [its SI unit]."""
    v0: float = 0.0
    """Value at the first knot: force [N] or mass flow [kg/s]; so are the others."""
    v1: float = 0.0
    v2: float = 0.0
    v3: float = 0.0
    v4: float = 0.0
    v5: float = 0.0
    v6: float = 0.0
    v7: float = 0.0
    v8: float = 0.0


@compiled
def _quantity(displacement, velocity, pressure_a, pressure_b, spool, time, over):
    if over == VELOCITY:
        return velocity
    if over == PRESSURE_A:
        return pressure_a
    if over == PRESSURE_B:
        return pressure_b
    if over == SPOOL:
        return spool
    if over == TIME:
        return time
    if over == PRESSURE_DIFFERENCE:
        return pressure_a - pressure_b
    return displacement


@compiled
def _share(velocity, over):
    """Return how much of the table counts in this direction of motion, 0 to 1."""
    if over == DISPLACEMENT_EXTENDING:
        return max(math.tanh(velocity / _DIRECTION_VELOCITY), 0.0)
    if over == DISPLACEMENT_RETRACTING:
        return max(-math.tanh(velocity / _DIRECTION_VELOCITY), 0.0)
    return 1.0


@compiled
def between_knots(quantity, table):
    """Return the value of a table, without regard to the direction of motion.

    Parameters
    ----------
    quantity : float
        What the table is over [its SI unit].
    table : Table
        With ``low`` below ``high``.
    """
    place = INTERVALS * (quantity - table.low) / (table.high - table.low)
    # Asked this way round, NaN of a run that broke down picks no knot that is not there.
    if not place > 0.0:
        return table.v0
    if place >= INTERVALS:
        return table.v8
    values = (
        table.v0, table.v1, table.v2, table.v3, table.v4, table.v5, table.v6, table.v7, table.v8,
    )  # fmt: skip
    knot = int(place)
    return values[knot] + (place - knot) * (values[knot + 1] - values[knot])


@compiled_apart
def _looked_up(displacement, velocity, pressure_a, pressure_b, spool, time, table):
    quantity = _quantity(displacement, velocity, pressure_a, pressure_b, spool, time, table.over)
    return _share(velocity, table.over) * between_knots(quantity, table)


@compiled
def tabulated(displacement, velocity, pressure_a, pressure_b, spool, time, table):
    """Return the value of a table in a state of the rig, 0 without a table [N] or [kg/s].

    Parameters
    ----------
    displacement, velocity : float
        Of the piston [m], [m/s].
    pressure_a, pressure_b : float
        Absolute [Pa].
    spool : float
        Fraction of full opening [-].
    time : float
        Since the start of the run [s].
    table : Table
        What is looked up.

    Notes
    -----
    A table over the displacement in one direction of motion counts with max(tanh(v / 5 mm/s), 0),
    v in that direction: not at all at rest and in the other direction.
    """
    if table.high == table.low:
        return 0.0
    return _looked_up(displacement, velocity, pressure_a, pressure_b, spool, time, table)


@compiled
def unexplained_force(displacement, velocity, pressure_a, pressure_b, spool, time, effects):
    """Return the force on the piston that only a table is known for, positive extends [N].

    Parameters
    ----------
    displacement, velocity, pressure_a, pressure_b, spool, time
        As in `tabulated`.
    effects : ServoEffects
        All effects of the servo.
    """
    return tabulated(
        displacement, velocity, pressure_a, pressure_b, spool, time, effects.unexplained_force
    )
