"""A closed test volume behind one port of the valve, charged or discharged with the spool held."""

from typing import NamedTuple

import numpy as np

from pneuservo.plant.chamber import pressure_rate
from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import limited
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.gas import Gas
from pneuservo.plant.valve import Valve, chamber_a_mass_flow, chamber_b_mass_flow

PORT_A, PORT_B = range(2)


class DeadVolume(NamedTuple):
    """The numbers of the test volume."""

    supply_pressure: float
    """Absolute pressure at the supply port [Pa]."""
    ambient_pressure: float
    """Absolute pressure at the exhaust port [Pa]."""
    volume: float
    """[m^3]."""
    polytropic_index: float
    """[-]."""
    gas: Gas
    valve: Valve


@compiled
def flow_through_port(opening, pressure, port, plant, grid):
    """Return the mass flow from the valve into the test volume [kg/s].

    Parameters
    ----------
    opening, pressure, port, plant, grid
        As in `dead_volume_rate`.
    """
    valve, gas = plant.valve, plant.gas
    supply, ambient = plant.supply_pressure, plant.ambient_pressure
    if port == PORT_A:
        return chamber_a_mass_flow(opening, pressure, supply, ambient, valve, gas, grid)
    return chamber_b_mass_flow(opening, pressure, supply, ambient, valve, gas, grid)


@compiled
def dead_volume_rate(pressure, opening, port, plant, grid):
    """Return the rate of the pressure in the test volume [Pa/s].

    Parameters
    ----------
    pressure : float
        Absolute pressure [Pa].
    opening : float
        Spool position as a fraction of full opening [-].
    port : int
        `PORT_A`: a positive opening charges; `PORT_B`: it discharges.
    plant : DeadVolume
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients, from `pneuservo.plant.valve.discharge_grid`.

    Notes
    -----
    p' = (n/V) R T m_dot, equation (4.12) at constant volume; (4.34) is the same, solved for the
    discharge coefficient.
    """
    flow = flow_through_port(opening, pressure, port, plant, grid)
    return pressure_rate(flow, pressure, plant.volume, 0.0, plant.polytropic_index, plant.gas)


@compiled
def run_dead_volume(time, voltage, initial_pressure, port, plant, grid, largest_step):
    """Return the pressure in the test volume at every time of a run.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    voltage : (n,) array
        Command; each value holds until the next time, and so does the spool [V].
    initial_pressure : float
        Absolute pressure at the first time [Pa].
    port, plant, grid
        As in `dead_volume_rate`.
    largest_step : float
        The intervals are divided into equal Runge-Kutta steps no longer than this [s].

    Returns
    -------
    (n,) array
        Absolute pressure [Pa].
    """
    pressures = np.empty(time.shape[0])
    pressure = initial_pressure
    full = plant.valve.full_voltage
    for k in range(time.shape[0]):
        pressures[k] = pressure
        if k + 1 == time.shape[0]:
            break
        opening = limited(voltage[k], full) / full
        steps, h = steps_between(time[k], time[k + 1], largest_step)
        for _ in range(steps):
            k1 = dead_volume_rate(pressure, opening, port, plant, grid)
            k2 = dead_volume_rate(pressure + 0.5 * h * k1, opening, port, plant, grid)
            k3 = dead_volume_rate(pressure + 0.5 * h * k2, opening, port, plant, grid)
            k4 = dead_volume_rate(pressure + h * k3, opening, port, plant, grid)
            pressure += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return pressures
