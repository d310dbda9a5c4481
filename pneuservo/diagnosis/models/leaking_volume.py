"""The closed test volume with everything the catalogue knows of it, compiled."""

from typing import NamedTuple

import numpy as np

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.compilation import compiled
from pneuservo.plant.dead_volume import flow_through_port
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.leak_laws import laminar_leak, orifice_leak, power_leak


class Leak(NamedTuple):
    """The parameters of all leaks; all sizes at 0 is a tight volume."""

    area: float
    """Effective area of a hole [m^2]."""
    conductance: float
    """Laminar conductance [kg/(s Pa^2)]."""
    coefficient: float
    """Flow of the power law at 1 bar gauge [kg/s]."""
    exponent: float
    """Exponent of the power law [-]."""


@compiled
def _rates(pressure, temperature, opening, port, plant, grid, leak, time_constant):
    """Return the rates of pressure and temperature [Pa/s], [K/s].

    With no thermal time constant the gas follows the baseline's polytropic law at constant
    temperature; with one, the energy balance, equation (4.10) of the thesis.
    """
    gas, ambient = plant.gas, plant.ambient_pressure
    wall = gas.temperature
    out = orifice_leak(
        pressure, ambient, wall, gas.gas_constant, gas.isentropic_exponent, leak.area
    )
    out += laminar_leak(pressure, ambient, wall, leak.conductance)
    out += power_leak(pressure, ambient, leak.coefficient, leak.exponent)
    through = 0.0
    if opening != 0.0:
        through = flow_through_port(opening, pressure, port, plant, grid)
    if time_constant <= 0.0:
        net = through - out
        return pressure_rate(net, pressure, plant.volume, 0.0, plant.polytropic_index, gas), 0.0
    inflow = max(through, 0.0) + max(-out, 0.0)
    outflow = max(-through, 0.0) + max(out, 0.0)
    g = gas.isentropic_exponent
    per_mass = gas.gas_constant * temperature / (pressure * plant.volume)
    settling = (temperature - wall) / time_constant
    warming = per_mass * ((g * wall - temperature) * inflow - (g - 1.0) * temperature * outflow)
    rate = g * gas.gas_constant / plant.volume * (wall * inflow - temperature * outflow)
    return rate - pressure / temperature * settling, warming - settling


@compiled
def run_leaking_volume(
    time, opening, start, initial_pressure, port, plant, grid, leak, excess, time_constant,
    largest_step,
):  # fmt: skip
    """Return the pressure of a test volume that is held until `start` and alone from then on.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    opening : (n,) array
        Spool position as a fraction of full opening, held to the next sample [-].
    start : float
        When the volume is left alone [s].
    initial_pressure : float
        Absolute pressure until then [Pa].
    port : int
        `PORT_A` or `PORT_B` of the valve.
    plant : DeadVolume
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients.
    leak : Leak
        The leaks.
    excess : float
        Gas above wall temperature at `start` [K].
    time_constant : float
        Thermal settling time; 0 for the polytropic law [s].
    largest_step : float
        The intervals are divided into equal Runge-Kutta steps no longer than this [s].

    Returns
    -------
    (n,) array
        Absolute pressure [Pa].
    """
    pressures = np.empty(time.size)
    p, t = initial_pressure, plant.gas.temperature + excess
    pressures[0] = p
    for k in range(1, time.size):
        span = time[k] - max(time[k - 1], start)
        if span > 0.0:
            steps, h = steps_between(0.0, span, largest_step)
            s = opening[k - 1]
            for _ in range(steps):
                p1, t1 = _rates(p, t, s, port, plant, grid, leak, time_constant)
                p2, t2 = _rates(p + h / 2 * p1, t + h / 2 * t1, s, port, plant, grid, leak,
                                time_constant)  # fmt: skip
                p3, t3 = _rates(p + h / 2 * p2, t + h / 2 * t2, s, port, plant, grid, leak,
                                time_constant)  # fmt: skip
                p4, t4 = _rates(p + h * p3, t + h * t3, s, port, plant, grid, leak,
                                time_constant)  # fmt: skip
                p = max(p + h / 6 * (p1 + 2 * p2 + 2 * p3 + p4), 1.0)
                t = max(t + h / 6 * (t1 + 2 * t2 + 2 * t3 + t4), 1.0)
        pressures[k] = p
    return pressures
