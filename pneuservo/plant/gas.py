"""Compressible flow through an orifice."""

import math
from typing import NamedTuple

import numpy as np

from pneuservo.plant.compilation import compiled
from pneuservo.plant.lane_arrays import load_tuple
from pneuservo.plant.lanes import select

# Coefficients of the polynomial in place of the powers of subsonic flow.
POLYNOMIAL_TERMS = 13
_POLYNOMIAL_LIKE = (0.0,) * POLYNOMIAL_TERMS


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
    subsonic_polynomial: tuple[float, ...]
    """Subsonic mass-flow coefficient over sqrt(1 - Pr), by powers of 1 - Pr [s sqrt(K)/m]."""


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
    critical, choked, factor = _flow_constants(gas_constant, isentropic_exponent)
    return Gas(
        temperature,
        gas_constant,
        isentropic_exponent,
        critical,
        choked,
        factor,
        load_tuple(_subsonic_polynomial(isentropic_exponent, critical, factor), _POLYNOMIAL_LIKE),
    )


@compiled
def _flow_constants(gas_constant, isentropic_exponent):
    """Return critical pressure ratio, choked coefficient and factor of the subsonic one."""
    g = isentropic_exponent
    return (
        (2.0 / (g + 1.0)) ** (g / (g - 1.0)),
        math.sqrt(g / gas_constant) * (2.0 / (g + 1.0)) ** ((g + 1.0) / (2.0 * (g - 1.0))),
        math.sqrt(2.0 * g / (gas_constant * (g - 1.0))),
    )


@compiled
def subsonic_coefficient(pressure_ratio, isentropic_exponent, factor):
    """Return the mass-flow coefficient Cm of an orifice that is not choked [s sqrt(K)/m].

    Parameters
    ----------
    pressure_ratio : float
        Downstream over upstream absolute pressure, critical to 1 [-].
    isentropic_exponent : float
        Ratio of specific heats [-].
    factor : float
        sqrt(2 g / (R (g - 1))) [s sqrt(K)/m].

    Notes
    -----
    Equation (4.17). With y = Pr^((g-1)/g) the difference Pr^(2/g) - Pr^((g+1)/g) is
    (Pr/y)^2 (1 - y), which takes one power instead of two.
    """
    g = isentropic_exponent
    y = pressure_ratio ** ((g - 1.0) / g)
    return factor * pressure_ratio / y * math.sqrt(max(1.0 - y, 0.0))


@compiled
def _subsonic_polynomial(isentropic_exponent, critical_pressure_ratio, factor):
    """Return `subsonic_coefficient` over sqrt(1 - Pr) by powers of 1 - Pr.

    Interpolated at the nodes of Chebyshev between critical and equal pressures: the quotient is
    smooth there, its nearest singularity being at vacuum.
    """
    count, width = POLYNOMIAL_TERMS, 1.0 - critical_pressure_ratio
    series = np.zeros(count)
    for node in range(count):
        angle = math.pi * (node + 0.5) / count
        below = 0.5 * width * (1.0 + math.cos(angle))
        value = subsonic_coefficient(1.0 - below, isentropic_exponent, factor) / math.sqrt(below)
        for k in range(count):
            series[k] += 2.0 / count * value * math.cos(k * angle)
    series[0] *= 0.5
    powers, before, now = np.zeros(count), np.zeros(count), np.zeros(count)
    now[0] = 1.0
    for k in range(count):
        powers += series[k] * now
        # T(k+1) = 2 t T(k) - T(k-1) with t = 2 s - 1 on the whole width, s = (1 - Pr)/width.
        following = -2.0 * now - before
        for place in range(1, count):
            following[place] += 4.0 * now[place - 1]
        if k == 0:
            following *= 0.5
        before, now = now, following
    for k in range(count):
        powers[k] /= width**k
    return powers


@compiled
def mass_flow_coefficient(pressure_ratio, gas):
    """Return the mass-flow coefficient Cm of an orifice [s sqrt(K)/m].

    Parameters
    ----------
    pressure_ratio : float or Lanes
        Downstream over upstream absolute pressure, 0 to 1 [-].
    gas : Gas
        The gas.

    Returns
    -------
    float or Lanes
        The coefficient: constant while choked, falling to 0 at equal pressures.

    Notes
    -----
    Equations (4.17) and (4.18); `subsonic_coefficient` by a polynomial times sqrt(1 - Pr), which
    agrees with it to 1e-12 (relative) and costs a fraction.

    Examples
    --------
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> round(mass_flow_coefficient(0.8, air), 6)
    0.033095
    >>> mass_flow_coefficient(1.0, air)
    0.0
    """
    choked = pressure_ratio <= gas.critical_pressure_ratio
    # Never below zero: a ratio just above 1 is the rounding of one at 1.
    w = max(1.0 - pressure_ratio, 0.0)
    c = gas.subsonic_polynomial
    # Powers of two of w first, so that the sums do not wait for one another.
    w2 = w * w
    w4 = w2 * w2
    low = (c[0] + c[1] * w) + (c[2] + c[3] * w) * w2
    middle = (c[4] + c[5] * w) + (c[6] + c[7] * w) * w2
    high = (c[8] + c[9] * w) + (c[10] + c[11] * w) * w2
    subsonic = math.sqrt(w) * (low + (middle + (high + c[12] * w4) * w4) * w4)
    return select(choked, gas.choked_coefficient, subsonic)


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
    higher = max(upstream_pressure, downstream_pressure)
    lower = min(upstream_pressure, downstream_pressure)
    coefficient = discharge_coefficient * mass_flow_coefficient(lower / higher, gas)
    flow = coefficient * area * higher / math.sqrt(gas.temperature)
    return select(downstream_pressure > upstream_pressure, -flow, flow)


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
    critical, choked, factor = _flow_constants(gas_constant, isentropic_exponent)
    higher = max(upstream_pressure, downstream_pressure)
    ratio = min(upstream_pressure, downstream_pressure) / higher
    coefficient = choked
    if ratio > critical:
        coefficient = subsonic_coefficient(ratio, isentropic_exponent, factor)
    flow = discharge_coefficient * coefficient * area * higher / math.sqrt(temperature)
    return -flow if downstream_pressure > upstream_pressure else flow
