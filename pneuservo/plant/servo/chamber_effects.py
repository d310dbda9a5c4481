"""What the gas in a chamber does beyond the polytropic law."""

import math
from typing import NamedTuple

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.servo.compilation import compiled


class ChamberEffects(NamedTuple):
    """Parameters of the effects in the chambers."""

    heat_conductance: float = 0.0
    """Between gas and wall of a chamber at mid-stroke [W/K]."""
    cooling_loss: float = 0.0
    """Heat transfer missing while the gas is warmer than the wall, relative [-]."""
    outflow_share: float = 0.0
    """Share of the gas temperature's excess that flows out with the gas, without heat transfer
    [-]; 0 keeps one constant temperature."""
    wall_capacity: float = 0.0
    """Heat capacity of a chamber's wall [J/K]; 0 for a wall that stays at room temperature."""
    wall_resistance: float = 1.0
    """Thermal resistance from the wall to the room [K/W]."""
    port_length: float = 0.0
    """Distance from the end of the stroke over which the piston covers the port [m]."""
    port_loss: float = 0.0
    """Flow lost with the port covered furthest, relative [-]."""


@compiled
def has_energy_balance(effects):
    """Return whether the chambers have a temperature of their own.

    Parameters
    ----------
    effects : ChamberEffects
        The effects.
    """
    return effects.heat_conductance > 0.0 or effects.outflow_share > 0.0


@compiled
def wall_area_share(distance, dead_volume, area, stroke):
    """Return the wall area of a chamber over that at mid-stroke [-].

    Parameters
    ----------
    distance : float
        Of the piston from the chamber's end [m].
    dead_volume : float
        [m^3].
    area : float
        Of the piston on this side [m^2].
    stroke : float
        [m].

    Notes
    -----
    Two end faces and a tube of the same cross-section; the dead volume counts as tube.
    """
    girth = 2.0 * math.sqrt(math.pi * area)
    clearance = dead_volume / area
    ends = 2.0 * area
    return (ends + girth * (distance + clearance)) / (ends + girth * (0.5 * stroke + clearance))


@compiled
def gas_rates(
    inflow,
    outflow,
    pressure,
    temperature,
    wall,
    volume,
    volume_rate,
    conductance,
    n,
    inflow_temperature,
    gas,
    effects,
):
    """Return the rates of pressure [Pa/s], gas temperature [K/s] and wall temperature [K/s].

    Parameters
    ----------
    inflow, outflow : float
        Mass flows into and out of the chamber, neither negative [kg/s].
    pressure, temperature : float
        Of the gas [Pa], [K].
    wall : float
        Temperature of the wall [K].
    volume, volume_rate : float
        [m^3], [m^3/s].
    conductance : float
        Between gas and wall as the piston stands [W/K].
    n : float
        Polytropic index of the baseline [-].
    inflow_temperature : float
        [K].
    gas : Gas
        The gas; its temperature is that of the room.
    effects : ChamberEffects
        The effects.

    Notes
    -----
    Without a temperature of its own the chamber follows (4.12) at the room's temperature, which
    what flows in takes at once, however warm it is. With it the exact energy balance
    (4.10) and (4.14): ideal gas, uniform in the chamber, heat by one constant coefficient
    (Carneiro and Gomes de Almeida 2006). No heat transfer makes it adiabatic, much isothermal.
    """
    if not has_energy_balance(effects):
        return pressure_rate(inflow - outflow, pressure, volume, volume_rate, n, gas), 0.0, 0.0
    g = gas.isentropic_exponent
    share = 1.0 if conductance > 0.0 else effects.outflow_share
    leaving = gas.temperature + share * (temperature - gas.temperature)
    carried = (inflow * inflow_temperature - outflow * leaving) / gas.temperature
    heat = conductance * (wall - temperature)
    if heat < 0.0:
        heat *= 1.0 - effects.cooling_loss
    rate = pressure_rate(carried, pressure, volume, volume_rate, g, gas) + (g - 1.0) * heat / volume
    gained = gas.gas_constant * temperature * (inflow - outflow)
    warming = temperature / (pressure * volume) * (volume * rate + pressure * volume_rate - gained)
    wall_rate = 0.0
    if effects.wall_capacity > 0.0:
        lost = (wall - gas.temperature) / effects.wall_resistance
        wall_rate = (-heat - lost) / effects.wall_capacity
    return rate, warming, wall_rate


@compiled
def port_share(distance, effects):
    """Return the flow that a port near the end of the stroke still passes, relative [-].

    Parameters
    ----------
    distance : float
        Of the piston from the chamber's end [m].
    effects : ChamberEffects
        The effects.

    Notes
    -----
    Slots and round holes are covered nearly in proportion to the way, what is chamfered or squeezed
    through a narrowing gap has a tail: the power is between them (assumed).

    Examples
    --------
    >>> port_share(1.5e-3, ChamberEffects(port_length=2e-3, port_loss=0.8))
    0.9
    """
    if distance < effects.port_length:
        return 1.0 - effects.port_loss * (1.0 - max(distance, 0.0) / effects.port_length) ** 1.5
    return 1.0
