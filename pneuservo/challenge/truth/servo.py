"""The rates of every state of the servo."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.chambers import chamber_rates, leaks, uncovered
from pneuservo.challenge.truth.compilation import truth_kernel
from pneuservo.challenge.truth.flow import LINEARISER_AT, clear_opening, edge_flow, leak_flow
from pneuservo.challenge.truth.friction import friction_force
from pneuservo.challenge.truth.load import motion_rates
from pneuservo.challenge.truth.network import hose_rates, main_pressure, reservoir_rates
from pneuservo.challenge.truth.spool import spool_rates
from pneuservo.challenge.truth.transducers import SHORT_LAG

S_A, B_E, S_B, A_E = 0, 1, 2, 3


@truth_kernel
def boundary_pressures(time, y, network):
    """Return the pressures at the valve's supply and exhaust ports [Pa]."""
    supply = y[at.SUPPLY] if network.reservoir > 0.0 else main_pressure(time, network)
    exhaust = y[at.EXHAUST] if network.silencer > 0.0 else network.ambient_pressure
    return supply, exhaust


@truth_kernel
def clearance_flows(y, valve, supply, exhaust, port_a, port_b, temperature):
    """Return what leaks past the four closed edges: S-A, B-E, S-B, A-E [kg/s]."""
    part = y[at.SPOOL] / valve.clearance_reach
    share = 0.7 * valve.clearance / (1.0 + part * part)
    laminar = valve.clearance_laminar
    return (
        leak_flow(share * valve.area_s_a, laminar, supply, port_a, temperature),
        leak_flow(share * valve.area_b_e, laminar, port_b, exhaust, temperature),
        leak_flow(share * valve.area_s_b, laminar, supply, port_b, temperature),
        leak_flow(share * valve.area_a_e, laminar, port_a, exhaust, temperature),
    )


@truth_kernel
def valve_flows(y, kept, truth, supply, exhaust, port_a, port_b, full_voltage):
    """Return the flows through the four edges: S-A, B-E, S-B, A-E [kg/s]."""
    valve, network, chambers = truth.valve, truth.network, truth.chambers
    opening = y[at.SPOOL]
    size = clear_opening(opening, valve)
    volts = full_voltage * size
    bend = size / LINEARISER_AT * math.exp(1.0 - size / LINEARISER_AT)
    charge = size * (1.0 + valve.gain_charge * bend)
    discharge = size * (1.0 + valve.gain_exhaust * bend)
    if valve.icing > 0.0:
        discharge *= math.exp(-valve.icing * y[at.EXHAUSTED])
    warm = network.temperature + valve.warm_supply
    constant = network.gas_constant
    s_a, b_e, s_b, a_e = 0.0, 0.0, 0.0, 0.0
    x = y[at.POSITION]
    port_share_a = uncovered(x, chambers)
    port_share_b = uncovered(chambers.stroke - x, chambers)
    if opening > 0.0:
        area = valve.area_s_a * charge * port_share_a
        s_a = edge_flow(valve, S_A, area, volts, supply, port_a, warm, constant)
        area = valve.area_b_e * discharge * port_share_b
        area *= 1.0 + valve.attached_gain * kept[at.ATTACHED_B]
        b_e = edge_flow(valve, B_E, area, volts, port_b, exhaust, y[at.GAS_B], constant)
    elif opening < 0.0:
        area = valve.area_s_b * charge * port_share_b
        s_b = edge_flow(valve, S_B, area, volts, supply, port_b, warm, constant)
        area = valve.area_a_e * discharge * port_share_a
        area *= 1.0 + valve.attached_gain * kept[at.ATTACHED_A]
        a_e = edge_flow(valve, A_E, area, volts, port_a, exhaust, y[at.GAS_A], constant)
    if valve.clearance > 0.0:
        past = clearance_flows(y, valve, supply, exhaust, port_a, port_b, network.temperature)
        s_a, b_e, s_b, a_e = s_a + past[0], b_e + past[1], s_b + past[2], a_e + past[3]
    return s_a, b_e, s_b, a_e


@truth_kernel
def fill_chambers(y, rates, side, net, truth, leak_out, leak_in, leak_in_temperature):
    """Set the rates of one chamber from its net flow and its leaks [kg/s]."""
    warm = truth.network.temperature + truth.valve.warm_supply
    inflow, outflow = max(net, 0.0), max(-net, 0.0)
    total = inflow + leak_in
    mixed = warm
    if total > 0.0:
        mixed = (inflow * warm + leak_in * leak_in_temperature) / total
    chamber_rates(y, rates, side, total, outflow + leak_out, mixed, truth.chambers, truth.network)


@truth_kernel
def servo_rates(time, share, y, kept, truth, rates, flows):
    """Set the rates of all states for a command [share of full opening]; keep the port flows."""
    network, chambers = truth.network, truth.chambers
    for j in range(len(rates)):
        rates[j] = 0.0
    spool_rates(share, time, truth.spool, y, rates)
    supply, exhaust = boundary_pressures(time, y, network)
    hoses = network.hose_length > 0.0
    port_a = y[at.HOSES] if hoses else y[at.PRESSURE_A]
    port_b = y[at.HOSES + 2 * at.CELLS] if hoses else y[at.PRESSURE_B]
    s_a, b_e, s_b, a_e = valve_flows(
        y, kept, truth, supply, exhaust, port_a, port_b, truth.spool.full_voltage
    )
    reservoir_rates(time, network, s_a + s_b, b_e + a_e, y, rates)
    rates[at.EXHAUSTED] = abs(b_e) + abs(a_e)
    net_a, net_b = s_a - a_e, s_b - b_e
    if hoses:
        index, second = chambers.polytropic, at.HOSES + 2 * at.CELLS
        net_a = hose_rates(at.HOSES, net_a, y[at.PRESSURE_A], index, network, y, rates)
        net_b = hose_rates(second, net_b, y[at.PRESSURE_B], index, network, y, rates)
    flows[0], flows[1] = net_a, net_b
    from_a, from_b, across = leaks(y, network, chambers)
    to_b, to_a = max(across, 0.0), max(-across, 0.0)
    fill_chambers(y, rates, 0, net_a, truth, from_a + to_b, to_a, y[at.GAS_B])
    fill_chambers(y, rates, 1, net_b, truth, from_b + to_a, to_b, y[at.GAS_A])
    gas_force = y[at.PRESSURE_A] * chambers.area_a - y[at.PRESSURE_B] * chambers.area_b
    gas_force -= network.ambient_pressure * (chambers.area_a - chambers.area_b)
    friction = friction_force(y, time, truth.friction, network, rates)
    motion_rates(time, gas_force, friction, y, rates, truth.load, chambers.stroke)
    sensor_rates(y, truth.sensors, rates)


@truth_kernel
def sensor_rates(y, sensors, rates):
    """Set the rates of lagging transducers."""
    if sensors.position_lag >= SHORT_LAG:
        lag = sensors.position_lag / sensors.position_lag_order
        rates[at.LAG_1] = (y[at.POSITION] - y[at.LAG_1]) / lag
        rates[at.LAG_2] = (y[at.LAG_1] - y[at.LAG_2]) / lag
    if sensors.pressure_lag >= SHORT_LAG:
        rates[at.LAG_A] = (y[at.PRESSURE_A] - y[at.LAG_A]) / sensors.pressure_lag
        rates[at.LAG_B] = (y[at.PRESSURE_B] - y[at.LAG_B]) / sensors.pressure_lag
