"""Where the cylinder leaks."""

import math
from typing import NamedTuple

from pneuservo.plant.leak_laws import gap_as_area, laminar_leak, mixed_leak, power_leak
from pneuservo.plant.servo.compilation import compiled


class LeakageEffects(NamedTuple):
    """Parameters of the leaks of the cylinder."""

    cross_conductance: float = 0.0
    """Narrow gap past the piston seal [kg/(s Pa^2)]."""
    cross_hole: float = 0.0
    """Share of what leaks past the piston that flows as through a hole [-]."""
    cross_back_flow: float = 1.0
    """What of it is open to air that flows from chamber b to a, where a lip seals [-]."""
    chamber_a_area: float = 0.0
    """Effective area of a leak from chamber a to the outside [m^2]."""
    chamber_a_laminar: float = 0.0
    """Share of it that flows as through a narrow gap, not as through a hole [-]."""
    rod_seal_area: float = 0.0
    """Effective area of a leak from chamber b to the outside [m^2]."""
    rod_seal_laminar: float = 0.0
    """Share of it that flows as through a narrow gap [-]."""
    opening_a_coefficient: float = 0.0
    """Flow at 1 bar gauge of a leak of chamber a that opens under pressure [kg/s]."""
    opening_a_exponent: float = 1.25
    opening_b_coefficient: float = 0.0
    """The same of chamber b [kg/s]."""
    opening_b_exponent: float = 1.25
    worn_conductance: float = 0.0
    """Narrow gap past the piston in the middle of a worn zone [kg/(s Pa^2)]."""
    worn_centre: float = 0.5
    """Where the zone is, as a share of the stroke [-]."""
    worn_width: float = 0.1
    """Its half width, as a share of the stroke [-]."""
    unworn_conductance: float = 0.0
    """The same gap in the rest of the bore [kg/(s Pa^2)]."""
    moving_conductance: float = 0.0
    """Narrow gap past the piston per piston speed [kg/(s Pa^2) per m/s]."""
    lifted_conductance: float = 0.0
    """What of this gap is open at rest [kg/(s Pa^2)]."""


@compiled
def cross_leak(pressure_a, pressure_b, displacement, velocity, stroke, temperature, gas, effects):
    """Return the mass flow past the piston, from a to b [kg/s].

    Parameters
    ----------
    pressure_a, pressure_b : float
        Absolute [Pa].
    displacement, velocity : float
        Of the piston [m], [m/s].
    stroke : float
        [m].
    temperature : float
        Of the gas that flows [K].
    gas : Gas
        The gas.
    effects : LeakageEffects
        The effects.

    Notes
    -----
    Compressible laminar gap, q = G (pa^2 - pb^2) (Richer and Hurmuzlu 2000); a lip that is pressed
    on by one of the pressures and lifted by the other has another G the other way; a worn zone adds
    a bell-shaped G(x) to that of the rest, a seal lifted by its film adds G in proportion to the
    speed to that at rest.
    """
    lip = 1.0 if pressure_a >= pressure_b else effects.cross_back_flow
    conductance = lip * effects.cross_conductance + effects.unworn_conductance
    conductance += effects.lifted_conductance + effects.moving_conductance * abs(velocity)
    if effects.worn_conductance > 0.0:
        away = (displacement / stroke - effects.worn_centre) / effects.worn_width
        conductance += effects.worn_conductance * math.exp(-away * away)
    if conductance == 0.0:
        return 0.0
    if effects.cross_hole == 0.0:
        return laminar_leak(pressure_a, pressure_b, temperature, conductance)
    area, gap = gap_as_area(conductance, gas), 1.0 - effects.cross_hole
    high, low = max(pressure_a, pressure_b), min(pressure_a, pressure_b)
    flow = mixed_leak(high, low, area, gap, temperature, gas)
    return flow if pressure_a >= pressure_b else -flow


@compiled
def outward_leak(pressure, ambient, area, laminar, coefficient, exponent, temperature, gas):
    """Return the mass flow from a chamber to the outside [kg/s].

    Parameters
    ----------
    pressure, ambient : float
        Absolute [Pa].
    area : float
        Effective area of a leak [m^2].
    laminar : float
        Share of it that is a narrow gap [-].
    coefficient, exponent : float
        Flow at 1 bar gauge [kg/s] and power of a leak that opens under pressure.
    temperature : float
        Of the gas in the chamber [K].
    gas : Gas
        The gas.
    """
    flow = 0.0
    if area > 0.0:
        flow += mixed_leak(pressure, ambient, area, laminar, temperature, gas)
    if coefficient > 0.0:
        thinner = math.sqrt(gas.temperature / temperature)
        flow += thinner * power_leak(pressure, ambient, coefficient, exponent)
    return flow
