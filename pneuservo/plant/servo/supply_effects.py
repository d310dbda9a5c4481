"""What the supply does beyond one constant pressure."""

import math
from typing import NamedTuple

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.servo.compilation import compiled


class SupplyEffects(NamedTuple):
    """Parameters of the effects on the supply."""

    reservoir_volume: float = 0.0
    """Between the line's restriction and the valve [m^3]; 0 for none."""
    line_area: float = 0.0
    """Effective area of the restriction that feeds the reservoir [m^2]."""
    drift: float = 0.0
    """Rate of the source pressure [Pa/s]."""
    ripple: float = 0.0
    """Amplitude of the source's ripple [Pa]."""
    ripple_frequency: float = 1.0
    """[Hz]."""
    ripple_phase: float = 0.0
    """[rad]."""


@compiled
def source_pressure(pressure, time, effects):
    """Return the pressure of the source [Pa].

    Parameters
    ----------
    pressure : float
        What it is without effects [Pa].
    time : float
        Since the start of the run [s].
    effects : SupplyEffects
        The effects.

    Examples
    --------
    >>> source_pressure(6.5e5, 10.0, SupplyEffects(drift=100.0))
    651000.0
    """
    pressure += effects.drift * time
    if effects.ripple != 0.0:
        angle = 2.0 * math.pi * effects.ripple_frequency * time + effects.ripple_phase
        pressure += effects.ripple * math.sin(angle)
    return pressure


@compiled
def has_reservoir(effects):
    """Return whether the valve draws from a reservoir.

    Parameters
    ----------
    effects : SupplyEffects
        The effects.
    """
    return effects.reservoir_volume > 0.0 and effects.line_area > 0.0


@compiled
def reservoir_rate(pressure, source, drawn, polytropic_index, gas, effects):
    """Return the rate of the reservoir's pressure [Pa/s].

    Parameters
    ----------
    pressure, source : float
        In the reservoir and in front of the restriction [Pa].
    drawn : float
        Mass flow that the valve takes [kg/s].
    polytropic_index : float
        Of the reservoir [-].
    gas : Gas
        The gas.
    effects : SupplyEffects
        The effects.

    Notes
    -----
    Equations (4.12) and (4.15) for a rigid volume behind an orifice (Beater 2007).
    """
    refilled = gas_mass_flow(source, pressure, effects.line_area, 1.0, gas)
    return pressure_rate(
        refilled - drawn, pressure, effects.reservoir_volume, 0.0, polytropic_index, gas
    )
