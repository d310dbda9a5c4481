"""What happens at the ends of the stroke beyond a rigid inelastic stop."""

from typing import NamedTuple

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.servo.compilation import compiled

# While the cushion is open its pressure is that of the port, followed within this time [s].
_OPEN_TIME = 1e-3
# Volume left in a cushion at the very end, as a length of the piston [m].
_CLEARANCE = 1e-3


class StopEffects(NamedTuple):
    """Parameters of the effects at the ends of the stroke."""

    stiffness: float = 0.0
    """Of a bumper in front of each stop [N/m]; 0 for none."""
    damping: float = 0.0
    """Of the bumper [N s/m]."""
    length: float = 0.0002
    """Of the bumper [m]."""
    cushion_length: float = 0.0
    """Last part of the stroke in which the chamber is trapped behind a needle [m]."""
    needle_area: float = 1e-7
    """Effective area of the needle [m^2]."""


@compiled
def bumper_force(displacement, velocity, stroke, effects):
    """Return the force of the bumpers, positive extends [N].

    Parameters
    ----------
    displacement, velocity : float
        Of the piston [m], [m/s].
    stroke : float
        [m].
    effects : StopEffects
        The effects.

    Notes
    -----
    Spring and damper in parallel; a bumper only pushes.

    Examples
    --------
    >>> bumper_force(0.0, 0.0, 0.03, StopEffects(stiffness=1e6))
    200.0
    """
    if effects.stiffness == 0.0:
        return 0.0
    pressed = effects.length - displacement
    if pressed > 0.0:
        return max(effects.stiffness * pressed - effects.damping * velocity, 0.0)
    pressed = displacement - (stroke - effects.length)
    if pressed > 0.0:
        return min(-effects.stiffness * pressed - effects.damping * velocity, 0.0)
    return 0.0


@compiled
def resting_place(side, force, stroke, effects):
    """Return where a piston rests that is pressed on a stop [m].

    Parameters
    ----------
    side : int
        -1 for the retracted stop, 1 for the extended one.
    force : float
        That presses it, positive extends [N].
    stroke : float
        [m].
    effects : StopEffects
        The effects.

    Notes
    -----
    A bumper gives way by force over stiffness from where it begins; behind a short one the stop
    itself gives way.

    Examples
    --------
    >>> resting_place(-1, -50.0, 0.03, StopEffects()), resting_place(1, 50.0, 0.03, StopEffects())
    (0.0, 0.03)
    >>> round(resting_place(1, 50.0, 0.03, StopEffects(stiffness=1e6)), 6)
    0.02985
    """
    given = 0.0
    if effects.stiffness > 0.0:
        given = effects.length - abs(force) / effects.stiffness
    return given if side < 0 else stroke - given


@compiled
def cushion_force(distance, cushion_pressure, pressure, area, effects):
    """Return what a cushion adds to the force of its chamber [N].

    Parameters
    ----------
    distance : float
        Of the piston from the end [m].
    cushion_pressure, pressure : float
        Absolute, in front of the piston and at the port [Pa].
    area : float
        Of the piston on this side [m^2].
    effects : StopEffects
        The effects.
    """
    if distance < effects.cushion_length:
        return (cushion_pressure - pressure) * area
    return 0.0


@compiled
def cushion_rate(distance, closing, cushion_pressure, pressure, area, index, gas, effects):
    """Return the rate of the pressure in a cushion [Pa/s].

    Parameters
    ----------
    distance : float
        Of the piston from the end [m].
    closing : float
        Piston velocity towards the end [m/s].
    cushion_pressure, pressure, area
        As in `cushion_force`.
    index : float
        Polytropic [-].
    gas : Gas
        The gas.
    effects : StopEffects
        The effects.

    Notes
    -----
    A trapped volume behind an orifice, (4.12) and (4.15), with a check valve that fills it from
    the port; what it takes from the port is left out of the port's own balance.
    """
    if distance >= effects.cushion_length or pressure > cushion_pressure:
        return (pressure - cushion_pressure) / _OPEN_TIME
    inflow = gas_mass_flow(pressure, cushion_pressure, effects.needle_area, 1.0, gas)
    volume = area * (max(distance, 0.0) + _CLEARANCE)
    return pressure_rate(inflow, cushion_pressure, volume, -area * closing, index, gas)
