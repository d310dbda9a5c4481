"""Supply, exhaust and hoses."""

import math

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel

VISCOSITY = 1.8e-5  # of air [Pa s]
LAMINAR_BELOW = 100.0  # pressure drop over a restriction [Pa]


@truth_kernel
def main_pressure(time, network):
    """Return the pressure of the main [Pa]."""
    pressure = network.supply_pressure + network.drift * time
    pressure += network.wander * math.sin(0.9 * time) * math.cos(0.23 * time + 1.0)
    turn = 2.0 * math.pi * network.ripple_frequency * time
    return pressure + network.ripple * math.sin(turn)


@truth_kernel
def restricted_flow(conductance, high, low):
    """Return the flow through a fixed restriction, positive from `high` to `low` [kg/s]."""
    drop = high - low
    # Laminar below some hundred pascal; the root has no slope at zero.
    return conductance * drop / math.sqrt(abs(drop) + LAMINAR_BELOW)


@truth_kernel
def reservoir_rates(time, network, used, exhausted, y, rates):
    """Set the rates of supply reservoir and silencer; the flows used and exhausted in [kg/s]."""
    stiffness = network.gas_constant * network.temperature
    if network.reservoir > 0.0:
        fed = restricted_flow(network.feed, main_pressure(time, network), y[at.SUPPLY])
        lost = network.check_leak * (y[at.SUPPLY] - network.ambient_pressure)
        rates[at.SUPPLY] = stiffness / network.reservoir * (fed - used - lost)
    if network.silencer > 0.0:
        out = restricted_flow(network.silencer, y[at.EXHAUST], network.ambient_pressure)
        rates[at.EXHAUST] = stiffness / network.silencer_volume * (exhausted - out)


@truth_kernel
def hose_rates(first, inflow, chamber_pressure, index, network, y, rates):
    """Set the rates of one hose and return the flow into its chamber [kg/s].

    Cells in a row, each with a pressure and the momentum of the gas towards the next; drag of a
    smooth pipe (Hagen-Poiseuille, Blasius 1913).
    """
    bore = network.hose_bore
    area = 0.25 * math.pi * bore * bore
    length = network.hose_length / at.CELLS
    stiffness = network.gas_constant * network.temperature
    storage = area * length / (index * stiffness)
    into = inflow
    for cell in range(at.CELLS):
        here, flow = first + cell, y[first + at.CELLS + cell]
        beyond = chamber_pressure if cell == at.CELLS - 1 else y[here + 1]
        rates[here] = (into - flow) / storage
        density = 0.5 * (y[here] + beyond) / stiffness
        reynolds = abs(flow) * bore / (area * VISCOSITY) + 1e-6
        factor = 64.0 / reynolds
        if reynolds > 2300.0:
            factor = max(0.316 / reynolds**0.25, 64.0 / 2300.0)
        drag = network.hose_drag * factor * flow * abs(flow) / (2.0 * bore * density * area)
        rates[first + at.CELLS + cell] = area / length * (y[here] - beyond) - drag
        into = flow
    return into
