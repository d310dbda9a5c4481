"""What the hoses between valve and cylinder do beyond adding to the dead volume."""

import math
from typing import NamedTuple

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.servo.compilation import compiled

# The dead volume is pipe for the most part; half of it counts to either end.
_SHARE_AT_VALVE = 0.5


class LineEffects(NamedTuple):
    """Parameters of the effects of the hoses."""

    area: float = 0.0
    """Effective area of each hose as a throttle at its port [m^2]; 0 for none."""
    delay: float = 0.0
    """Time the flow takes from the valve to the chamber [s]."""
    attenuating_area: float = 0.0
    """Effective area of what throttles it on the way [m^2]; 0 for nothing."""
    frequency: float = 0.0
    """Resonance of hose and chamber at mid-stroke [Hz]; 0 for none."""
    damping: float = 0.2
    """Its damping ratio [-]."""
    compliance: float = 0.0
    """Relative growth of the dead volume per pressure [1/Pa]."""


@compiled
def throttling_area(effects):
    """Return the effective area of all that throttles the flow in a hose [m^2]; 0 for nothing.

    Parameters
    ----------
    effects : LineEffects
        The effects.

    Examples
    --------
    >>> round(throttling_area(LineEffects(area=3e-6, attenuating_area=4e-6)) * 1e6, 9)
    2.4
    """
    if effects.area > 0.0 and effects.attenuating_area > 0.0:
        both = effects.area * effects.area + effects.attenuating_area * effects.attenuating_area
        return effects.area * effects.attenuating_area / math.sqrt(both)
    return max(effects.area, effects.attenuating_area)


@compiled
def hose_volume(dead_volume, effects):
    """Return the part of the dead volume that lies at the valve's end of a hose [m^3].

    Parameters
    ----------
    dead_volume : float
        Of the chamber, hose included [m^3].
    effects : LineEffects
        The effects.
    """
    return _SHARE_AT_VALVE * dead_volume if effects.frequency > 0.0 else 0.0


@compiled
def hose_rates(
    valve_flow, flow, port_pressure, pressure, dead_volume, middle_volume, index, gas, effects
):
    """Return the rate of the flow through a hose [kg/s^2] and of its pressure at the valve [Pa/s].

    Parameters
    ----------
    valve_flow, flow : float
        Mass flow out of the valve, and into the chamber [kg/s].
    port_pressure, pressure : float
        Absolute, at the valve's end and in the chamber [Pa].
    dead_volume, middle_volume : float
        Dead volume of the chamber, and its whole volume at mid-stroke [m^3].
    index : float
        Polytropic [-].
    gas : Gas
        The gas.
    effects : LineEffects
        The effects.

    Notes
    -----
    The inertia of the air in the hose between two volumes, half the dead volume at the valve and
    the rest with the chamber: passive, whatever the valve does. At mid-stroke inertia and chamber
    alone resonate at the frequency given (Helmholtz; Richer and Hurmuzlu 2000); elsewhere the
    square of the frequency goes with one over the volume.
    """
    w = 2.0 * math.pi * effects.frequency
    hose = hose_volume(dead_volume, effects)
    stiffness = index * gas.gas_constant * gas.temperature
    admittance = w * w * (middle_volume - hose) / stiffness
    return (
        admittance * (port_pressure - pressure) - 2.0 * effects.damping * w * flow,
        pressure_rate(valve_flow - flow, port_pressure, hose, 0.0, index, gas),
    )


@compiled
def compliant_volume(volume, pressure, dead_volume, polytropic_index, effects):
    """Return the volume a chamber with soft walls seems to have [m^3].

    Parameters
    ----------
    volume : float
        Geometric volume [m^3].
    pressure : float
        Absolute [Pa].
    dead_volume : float
        Part of it that lies in the hose [m^3].
    polytropic_index : float
        [-].
    effects : LineEffects
        The effects.

    Notes
    -----
    With dV = k V_hose dp equation (4.12) becomes that of the volume V + n p k V_hose.
    """
    return volume + polytropic_index * pressure * effects.compliance * dead_volume
