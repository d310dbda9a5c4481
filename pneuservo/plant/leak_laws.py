"""What flows through a leak, by its form: hole, narrow gap, both, or one that opens."""

import math

from pneuservo.plant.compilation import compiled
from pneuservo.plant.gas import gas_mass_flow, orifice_mass_flow

GAP_REFERENCE = 6e5
"""Pressure at which a gap passes as much into a vacuum as an orifice of its area [Pa]."""
REFERENCE_TEMPERATURE = 293.0
"""Of the gas that a conductance is stated for [K]."""


@compiled
def orifice_leak(pressure, ambient, temperature, gas_constant, isentropic_exponent, area):
    """Return the mass flow of a sharp-edged leak of an effective area [kg/s]."""
    return orifice_mass_flow(
        pressure, ambient, area, 1.0, temperature, gas_constant, isentropic_exponent
    )


@compiled
def laminar_leak(pressure, ambient, temperature, conductance):
    """Return the mass flow through a narrow gap: compressible laminar flow [kg/s].

    The conductance is that at `REFERENCE_TEMPERATURE`.
    """
    squares = pressure * pressure - ambient * ambient
    return conductance * squares * REFERENCE_TEMPERATURE / temperature


@compiled
def power_leak(pressure, ambient, coefficient, exponent):
    """Return the mass flow of a leak that follows a power of the gauge pressure [kg/s].

    The coefficient is the flow at 1 bar gauge; below the ambient pressure the flow reverses.
    """
    gauge = (pressure - ambient) / 1e5
    if gauge >= 0.0:
        return coefficient * gauge**exponent
    return -coefficient * (-gauge) ** exponent


@compiled
def gap_as_area(conductance, gas):
    """Return the area of the leak of `mixed_leak` whose gap is all of it [m^2].

    Parameters
    ----------
    conductance : float
        As in `laminar_leak` [kg/(s Pa^2)].
    gas : Gas
        The gas.

    Examples
    --------
    >>> from pneuservo.plant.gas import ideal_gas
    >>> air = ideal_gas(300.0, 287.0, 1.4)
    >>> gap = mixed_leak(5e5, 2e5, gap_as_area(1e-17, air), 1.0, 310.0, air)
    >>> bool(abs(gap / laminar_leak(5e5, 2e5, 310.0, 1e-17) - 1.0) < 1e-12)
    True
    """
    thinner = REFERENCE_TEMPERATURE / gas.temperature
    return (
        conductance * thinner * GAP_REFERENCE * math.sqrt(gas.temperature) / gas.choked_coefficient
    )


@compiled
def mixed_leak(upstream_pressure, downstream_pressure, area, laminar, temperature, gas):
    """Return the mass flow of a leak that is in part a hole and in part a narrow gap [kg/s].

    Parameters
    ----------
    upstream_pressure, downstream_pressure : float
        Absolute [Pa].
    area : float
        Effective area [m^2].
    laminar : float
        Share of the gap: 0 for a hole, 1 for a gap alone [-].
    temperature : float
        Of the gas that flows [K].
    gas : Gas
        The gas.

    Notes
    -----
    The gap's flow goes with the difference of the squared pressures (Richer and Hurmuzlu 2000);
    real leaks lie between the two (Eryilmaz and Wilson 2000 of a spool's clearance). Warm gas is
    thinner: through a hole less flows by the root of that, through a gap in proportion.

    Examples
    --------
    >>> from pneuservo.plant.gas import ideal_gas
    >>> air = ideal_gas(293.0, 287.0, 1.4)
    >>> hole, gap = (mixed_leak(6e5, 0.0, 1e-9, share, 293.0, air) for share in (0.0, 1.0))
    >>> round(gap / hole, 9)
    1.0
    """
    thinner = gas.temperature / temperature
    hole = gas_mass_flow(upstream_pressure, downstream_pressure, area, math.sqrt(thinner), gas)
    if laminar == 0.0:
        return hole
    squares = upstream_pressure * upstream_pressure - downstream_pressure * downstream_pressure
    choked = gas.choked_coefficient * area / math.sqrt(gas.temperature)
    return (1.0 - laminar) * hole + laminar * choked * thinner * squares / GAP_REFERENCE
