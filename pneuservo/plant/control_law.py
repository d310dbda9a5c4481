"""What commands the valve: a held voltage, or a switching surface with a limited output."""

import math
from typing import NamedTuple

from pneuservo.plant.compilation import compiled
from pneuservo.plant.lanes import first_lane

# What the law works from.
HELD_VOLTAGE, TRUE_STATES, CARD_TAPS = range(3)


class ControlLaw(NamedTuple):
    """output = gain x surface, limited; surface = -(w_x (x - xd) + w_v v + w_a a), limited.

    With `CARD_TAPS` displacement, velocity and acceleration are the voltages of the card.
    An infinite gain is a relay.
    """

    source: int
    """`HELD_VOLTAGE`, `TRUE_STATES` or `CARD_TAPS`."""
    weight_displacement: float
    weight_velocity: float
    weight_acceleration: float
    surface_limit: float
    """Largest magnitude of the surface."""
    gain: float
    """Output per surface."""
    level: float
    """Largest magnitude of the output [V]."""
    sensitivity: float
    """Displacement transducer [V/m]."""
    velocity_time_constant: float
    """RC of the first differentiator [s]."""
    velocity_lag_1: float
    velocity_lag_2: float
    """Time constants of the two breaks of the first differentiator [s]."""
    acceleration_time_constant: float
    """RC of the second differentiator [s]."""
    acceleration_lag_1: float
    acceleration_lag_2: float
    """Time constants of the two breaks of the second differentiator [s]."""


# A replayed command: the figures of a controller have no part in it.
OPEN_LOOP = ControlLaw(
    source=HELD_VOLTAGE,
    weight_displacement=0.0,
    weight_velocity=0.0,
    weight_acceleration=0.0,
    surface_limit=math.inf,
    gain=1.0,
    level=math.inf,
    sensitivity=1.0,
    velocity_time_constant=0.0,
    velocity_lag_1=1.0,
    velocity_lag_2=1.0,
    acceleration_time_constant=0.0,
    acceleration_lag_1=1.0,
    acceleration_lag_2=1.0,
)


@compiled
def limited(value, limit):
    """Return a value limited in magnitude.

    Parameters
    ----------
    value, limit : float
        In the same unit; the limit is not negative.

    Examples
    --------
    >>> limited(-7.0, 5.0), limited(3.0, 5.0)
    (-5.0, 3.0)
    """
    return min(max(value, -limit), limit)


@compiled
def switching_surface(error, velocity, acceleration, law):
    """Return the switching function.

    Parameters
    ----------
    error : float
        Displacement minus demand [m], or the same in transducer volts.
    velocity, acceleration : float
        True derivatives in SI, or the card's voltages with the sign of the derivative.
    law : ControlLaw
        Weights and limit.

    Notes
    -----
    Equation (7.1) of the thesis, sigma = -(c1 (x - xd) + c2 v + c3 a).
    """
    return limited(
        -(
            law.weight_displacement * error
            + law.weight_velocity * velocity
            + law.weight_acceleration * acceleration
        ),
        law.surface_limit,
    )


@compiled
def unlimited_output(surface, relay_sign, law):
    """Return the output before its level limits it [V].

    Parameters
    ----------
    surface : float
        From `switching_surface`.
    relay_sign : int
        Which way a relay is switched; ignored for a finite gain.
    law : ControlLaw
        Gain and level.
    """
    if is_relay(law):
        return relay_sign * law.level
    return law.gain * surface


@compiled
def is_relay(law):
    """Return whether a law switches instead of acting continuously.

    Parameters
    ----------
    law : ControlLaw
        What commands the valve; of lanes either all switch or none.
    """
    return law.source != HELD_VOLTAGE and math.isinf(first_lane(law.gain))
