"""Compressible flow through an orifice."""

import math
from typing import NamedTuple

from pneuservo.plant.compilation import compiled


class Gas(NamedTuple):
    """An ideal gas at constant temperature, with the flow constants that follow from it."""

    temperature: float
    """Stagnation temperature [K]."""
    gas_constant: float
    """Specific gas constant [J/(kg K)]."""
    isentropic_exponent: float
    """Ratio of specific heats [-]."""
    critical_pressure_ratio: float
    """Pressure ratio at and below which the flow is choked [-]."""
    choked_coefficient: float
    """Mass-flow coefficient of choked flow [s sqrt(K)/m]."""
    subsonic_factor: float
    """Factor in front of the subsonic mass-flow coefficient [s sqrt(K)/m]."""


@compiled
def ideal_gas(temperature, gas_constant, isentropic_exponent):
    """Return a gas with its flow constants.

    Parameters
    ----------
    temperature : float
        Stagnation temperature [K].
    gas_constant : float
        Specific gas constant [J/(kg K)].
    isentropic_exponent : float
        Ratio of specific heats, above 1 [-].

    Returns
    -------
    Gas
        The gas.

    Notes
    -----
    Critical pressure ratio, equation (4.16) of the thesis, and choked coefficient (4.18).

    Examples
    --------
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> round(air.critical_pressure_ratio, 4), round(air.choked_coefficient, 6)
    (0.5283, 0.040418)
    """
    g = isentropic_exponent
    return Gas(
        temperature,
        gas_constant,
        g,
        (2.0 / (g + 1.0)) ** (g / (g - 1.0)),
        math.sqrt(g / gas_constant) * (2.0 / (g + 1.0)) ** ((g + 1.0) / (2.0 * (g - 1.0))),
        math.sqrt(2.0 * g / (gas_constant * (g - 1.0))),
    )


@compiled
def mass_flow_coefficient(pressure_ratio, gas):
    """Return the mass-flow coefficient Cm of an orifice [s sqrt(K)/m].

    Parameters
    ----------
    pressure_ratio : float
        Downstream over upstream absolute pressure, 0 to 1 [-].
    gas : Gas
        The gas.

    Returns
    -------
    float
        The coefficient: constant while choked, falling to 0 at equal pressures.

    Notes
    -----
    Equations (4.17) and (4.18). With y = Pr^((g-1)/g) the subsonic branch
    Pr^(2/g) - Pr^((g+1)/g) is (Pr/y)^2 (1 - y), which takes one power instead of two.

    Examples
    --------
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> round(mass_flow_coefficient(0.8, air), 6)
    0.033095
    >>> mass_flow_coefficient(1.0, air)
    0.0
    """
    if pressure_ratio <= gas.critical_pressure_ratio:
        return gas.choked_coefficient
    y = pressure_ratio ** ((gas.isentropic_exponent - 1.0) / gas.isentropic_exponent)
    return gas.subsonic_factor * pressure_ratio / y * math.sqrt(max(1.0 - y, 0.0))


@compiled
def gas_mass_flow(upstream_pressure, downstream_pressure, area, discharge_coefficient, gas):
    """Return the mass flow through an orifice, for inner loops.

    Parameters
    ----------
    upstream_pressure, downstream_pressure, area, discharge_coefficient : float
        As in `orifice_mass_flow`.
    gas : Gas
        From `ideal_gas`, worked out once.

    Returns
    -------
    float
        Mass flow, negative when the downstream pressure is the higher one [kg/s].
    """
    sign = 1.0
    higher, lower = upstream_pressure, downstream_pressure
    if lower > higher:
        sign = -1.0
        higher, lower = lower, higher
    return (
        sign
        * discharge_coefficient
        * mass_flow_coefficient(lower / higher, gas)
        * area
        * higher
        / math.sqrt(gas.temperature)
    )


@compiled
def orifice_mass_flow(
    upstream_pressure,
    downstream_pressure,
    area,
    discharge_coefficient,
    temperature,
    gas_constant,
    isentropic_exponent,
):
    """Return the mass flow through an orifice.

    Parameters
    ----------
    upstream_pressure, downstream_pressure : float
        Absolute pressures on the side the flow is counted from and on the other side [Pa].
    area : float
        Geometric area [m^2].
    discharge_coefficient : float
        Effective over geometric area [-].
    temperature : float
        Stagnation temperature on either side [K].
    gas_constant : float
        Specific gas constant [J/(kg K)].
    isentropic_exponent : float
        Ratio of specific heats [-].

    Returns
    -------
    float
        Mass flow, negative when the downstream pressure is the higher one [kg/s].

    Notes
    -----
    Equation (4.15). Ideal gas, isentropic to the throat, equal stagnation temperatures.

    Examples
    --------
    >>> flow = orifice_mass_flow(6.5e5, 1.013e5, 0.87e-6, 0.8, 293.0, 287.0, 1.4)
    >>> round(flow * 1e3, 4)
    1.0682
    >>> orifice_mass_flow(1.013e5, 6.5e5, 0.87e-6, 0.8, 293.0, 287.0, 1.4) == -flow
    True
    """
    gas = ideal_gas(temperature, gas_constant, isentropic_exponent)
    return gas_mass_flow(upstream_pressure, downstream_pressure, area, discharge_coefficient, gas)
