"""Gas in a chamber: by the rig's index, or by mass and energy with a wall."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel
from pneuservo.challenge.truth.flow import leak_flow, pore_flow

RATIO_OF_HEATS = 1.4
REFERENCE_DENSITY = 5.0  # of air at about 4 bar [kg/m^3]


@truth_kernel
def uncovered(place, chambers):
    """Return which share of a port the piston leaves open, `place` from that port's end [m]."""
    if chambers.port_length == 0.0 or place >= chambers.port_length:
        return 1.0
    part = max(place, 0.0) / chambers.port_length
    return chambers.port_rest + (1.0 - chambers.port_rest) * part * part * (3.0 - 2.0 * part)


@truth_kernel
def leaks(y, network, chambers):
    """Return the leaks: chamber a to the room, b to the room, a to b [kg/s]."""
    p_a, p_b = y[at.PRESSURE_A], y[at.PRESSURE_B]
    ambient = network.ambient_pressure
    if chambers.leak_power > 0.0:
        from_a = pore_flow(chambers.leak_a, chambers.leak_power, p_a, ambient, y[at.GAS_A])
        from_b = pore_flow(chambers.leak_b, chambers.leak_power, p_b, ambient, y[at.GAS_B])
    else:
        laminar = chambers.leak_laminar
        from_a = leak_flow(chambers.leak_a, laminar, p_a, ambient, y[at.GAS_A])
        from_b = leak_flow(chambers.leak_b, laminar, p_b, ambient, y[at.GAS_B])
    area = chambers.leak_cross
    if area > 0.0:
        away = (y[at.POSITION] - chambers.leak_place_at) / chambers.leak_place_width
        area *= 1.0 + chambers.leak_place / (1.0 + away**4)
        area *= 1.0 + chambers.leak_speed * abs(y[at.SPEED])
        if p_b > p_a:
            area *= chambers.leak_return
    return from_a, from_b, leak_flow(area, chambers.leak_laminar, p_a, p_b, network.temperature)


@truth_kernel
def heat_from_wall(mass, volume, piston_area, gas, wall, chambers):
    """Return the heat that the wall gives to the gas [W]; transfer may grow with density."""
    length = volume / piston_area
    surface = 2.0 * piston_area + math.pi * chambers.bore * length
    density = mass / volume / REFERENCE_DENSITY
    transfer = chambers.wall_transfer * density**chambers.wall_exponent
    return transfer * surface * (wall - gas)


@truth_kernel
def chamber_rates(y, rates, side, inflow, outflow, inflow_temperature, chambers, network):
    """Set the rates of one chamber; flows into and out of it in [kg/s].

    Without an energy balance p' V = n (R T0 m' - p V'), the rig's own assumption.
    """
    p = y[at.PRESSURE_A + side]
    if side == 0:
        piston_area, growth = chambers.area_a, chambers.area_a * y[at.SPEED]
        volume = chambers.area_a * y[at.POSITION] + chambers.dead_volume_a
    else:
        piston_area, growth = chambers.area_b, -chambers.area_b * y[at.SPEED]
        volume = chambers.area_b * (chambers.stroke - y[at.POSITION]) + chambers.dead_volume_b
    constant = network.gas_constant
    net = inflow - outflow
    if chambers.energy_balance == 0.0:
        carried = constant * network.temperature * net
        stretch = chambers.polytropic * network.hose_stretch * p * network.hose_volume / volume
        rate = chambers.polytropic / volume * (carried - p * growth) / (1.0 + stretch)
        rates[at.PRESSURE_A + side] = rate
        return
    gas = y[at.GAS_A + side]
    mass = p * volume / (constant * gas)
    heat = heat_from_wall(mass, volume, piston_area, gas, y[at.WALL_A + side], chambers)
    carried = constant * (inflow * inflow_temperature - outflow * gas)
    work = p * growth
    rate = (RATIO_OF_HEATS * (carried - work) + (RATIO_OF_HEATS - 1.0) * heat) / volume
    rates[at.PRESSURE_A + side] = rate
    rates[at.GAS_A + side] = gas * (rate / p + growth / volume - net / mass)
    if chambers.wall_capacity < math.inf:
        lost = chambers.wall_cooling * (y[at.WALL_A + side] - network.temperature)
        rates[at.WALL_A + side] = -(heat + lost) / chambers.wall_capacity
