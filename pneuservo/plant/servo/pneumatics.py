"""Air through hoses and chambers with every effect: what drives the pressures."""

from pneuservo.plant.servo.chamber_effects import gas_rates, port_share, wall_area_share
from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.servo.drive import given, past
from pneuservo.plant.servo.layout import (
    FLOWED_A,
    FLOWED_B,
    HOSE_FLOW_A,
    HOSE_FLOW_B,
    PORT_PRESSURE_A,
    PORT_PRESSURE_B,
    RESERVOIR,
    SUPPLY,
    TEMPERATURE_A,
    TEMPERATURE_B,
    TIME,
    WALL_A,
    WALL_B,
)
from pneuservo.plant.servo.leakage_effects import cross_leak, outward_leak
from pneuservo.plant.servo.line_effects import compliant_volume, hose_rates, hose_volume
from pneuservo.plant.servo.supply_effects import has_reservoir, reservoir_rate, source_pressure
from pneuservo.plant.servo.unexplained_effects import tabulated
from pneuservo.plant.servo.valve_side import supply_at_valve, temperature_of, valve_flows
from pneuservo.plant.single_axis import DISPLACEMENT, PLANT_STATES, PRESSURE_A, PRESSURE_B, SPOOL


@compiled
def flows_at_cylinder(flow_a, flow_b, state, memory, rows, now, servo):
    """Return the mass flows that reach chambers a and b through hoses and ports [kg/s].

    Parameters
    ----------
    flow_a, flow_b : float
        At the valve [kg/s].
    state, memory, rows, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    now : float
        Time since the start of the run [s].
    """
    line, chamber = servo.effects.line, servo.effects.chamber
    if line.delay > 0.0:
        flow_a = past(rows, memory, FLOWED_A, now - line.delay, now, flow_a)
        flow_b = past(rows, memory, FLOWED_B, now - line.delay, now, flow_b)
    if line.frequency > 0.0:
        flow_a, flow_b = state[HOSE_FLOW_A], state[HOSE_FLOW_B]
    if chamber.port_loss != 0.0:
        flow_a *= port_share(state[DISPLACEMENT], chamber)
        flow_b *= port_share(servo.plant.piston.stroke - state[DISPLACEMENT], chamber)
    return flow_a, flow_b


@compiled
def _chamber_rates(
    valve_flow, across, outside, pressure, distance, opening, area, dead_volume, warm, wall, servo
):
    """Return the rates of pressure, gas and wall temperature of one chamber.

    The three flows count into the chamber; distance and opening speed are those of the piston
    from the chamber's end.
    """
    plant, effects = servo.plant, servo.effects
    inflow = max(valve_flow, 0.0) + max(across, 0.0) + max(outside, 0.0)
    outflow = max(-valve_flow, 0.0) + max(-across, 0.0) + max(-outside, 0.0)
    n, gas = plant.polytropic_index, plant.gas
    volume = area * distance + dead_volume - hose_volume(dead_volume, effects.line)
    conductance = effects.chamber.heat_conductance
    if conductance > 0.0:
        conductance *= wall_area_share(distance, dead_volume, area, plant.piston.stroke)
    return gas_rates(
        inflow,
        outflow,
        pressure,
        warm,
        wall,
        compliant_volume(volume, pressure, dead_volume, n, effects.line),
        area * opening,
        conductance,
        n,
        gas.temperature + effects.valve.supply_warmth,
        gas,
        effects.chamber,
    )


@compiled
def _hose_rates(valve_flow, flow, port_pressure, pressure, area, dead_volume, servo):
    plant = servo.plant
    return hose_rates(
        valve_flow,
        flow,
        port_pressure,
        pressure,
        dead_volume,
        0.5 * area * plant.piston.stroke + dead_volume,
        plant.polytropic_index,
        plant.gas,
        servo.effects.line,
    )


@compiled
def _leaks(state, velocity, warm_a, warm_b, servo):
    """Return the leaks from a to b, and from each chamber to ambient [kg/s]."""
    plant, leak = servo.plant, servo.effects.leakage
    pa, pb, ambient, gas = state[PRESSURE_A], state[PRESSURE_B], plant.ambient_pressure, plant.gas
    passing = warm_a if pa >= pb else warm_b
    stroke = plant.piston.stroke
    across = cross_leak(pa, pb, state[DISPLACEMENT], velocity, stroke, passing, gas, leak)
    out_a = outward_leak(
        pa,
        ambient,
        leak.chamber_a_area,
        leak.chamber_a_laminar,
        leak.opening_a_coefficient,
        leak.opening_a_exponent,
        warm_a,
        gas,
    )
    out_b = outward_leak(
        pb,
        ambient,
        leak.rod_seal_area,
        leak.rod_seal_laminar,
        leak.opening_b_coefficient,
        leak.opening_b_exponent,
        warm_b,
        gas,
    )
    return across, out_a, out_b


@compiled
def _unexplained(state, velocity, now, table):
    """Return a flow into a chamber that only a table is known for [kg/s]."""
    pa, pb = state[PRESSURE_A], state[PRESSURE_B]
    return tabulated(state[DISPLACEMENT], velocity, pa, pb, state[SPOOL], now, table)


@compiled
def _write_chamber_rates(state, velocity, flow_a, flow_b, now, servo, rate):
    """Write the rates of both chambers from the flows that reach them."""
    plant = servo.plant
    piston, x = plant.piston, state[DISPLACEMENT]
    warm_a = temperature_of(state, TEMPERATURE_A, servo)
    warm_b = temperature_of(state, TEMPERATURE_B, servo)
    across, out_a, out_b = _leaks(state, velocity, warm_a, warm_b, servo)
    rate[PRESSURE_A], warming_a, wall_rate_a = _chamber_rates(
        flow_a,
        -across,
        _unexplained(state, velocity, now, servo.effects.unexplained_flow_a) - out_a,
        state[PRESSURE_A],
        x,
        velocity,
        piston.area_a,
        plant.dead_volume_a,
        warm_a,
        temperature_of(state, WALL_A, servo),
        servo,
    )
    rate[PRESSURE_B], warming_b, wall_rate_b = _chamber_rates(
        flow_b,
        across,
        _unexplained(state, velocity, now, servo.effects.unexplained_flow_b) - out_b,
        state[PRESSURE_B],
        piston.stroke - x,
        -velocity,
        piston.area_b,
        plant.dead_volume_b,
        warm_b,
        temperature_of(state, WALL_B, servo),
        servo,
    )
    if state.shape[0] > PLANT_STATES:
        rate[TEMPERATURE_A], rate[WALL_A] = warming_a, wall_rate_a
        rate[TEMPERATURE_B], rate[WALL_B] = warming_b, wall_rate_b


@compiled
def _write_hose_rates(state, at_valve_a, at_valve_b, servo, rate):
    """Write the rates of flow and pressure at the valve's end of both hoses."""
    plant = servo.plant
    rate[HOSE_FLOW_A], rate[PORT_PRESSURE_A] = _hose_rates(
        at_valve_a,
        state[HOSE_FLOW_A],
        state[PORT_PRESSURE_A],
        state[PRESSURE_A],
        plant.piston.area_a,
        plant.dead_volume_a,
        servo,
    )
    rate[HOSE_FLOW_B], rate[PORT_PRESSURE_B] = _hose_rates(
        at_valve_b,
        state[HOSE_FLOW_B],
        state[PORT_PRESSURE_B],
        state[PRESSURE_B],
        plant.piston.area_b,
        plant.dead_volume_b,
        servo,
    )


@compiled
def pneumatic_rates(state, velocity, memory, rows, drive, elapsed, servo, grid, rate):
    """Write the rates of both chambers and of what belongs to them.

    Parameters
    ----------
    state, memory, rows, drive, elapsed, servo, grid, rate
        As in `pneuservo.plant.servo.chain.derivative`.
    velocity : float
        Of the piston; 0 while it rests [m/s].
    """
    plant, effects, now = servo.plant, servo.effects, given(drive, TIME, elapsed)
    supply = supply_at_valve(state, drive, elapsed, servo)
    at_valve_a, at_valve_b, drawn = valve_flows(state[SPOOL], state, memory, supply, servo, grid)
    flow_a, flow_b = flows_at_cylinder(at_valve_a, at_valve_b, state, memory, rows, now, servo)
    _write_chamber_rates(state, velocity, flow_a, flow_b, now, servo, rate)
    if state.shape[0] == PLANT_STATES:
        return
    if has_reservoir(effects.supply):
        source = source_pressure(given(drive, SUPPLY, elapsed), now, effects.supply)
        rate[RESERVOIR] = reservoir_rate(
            state[RESERVOIR], source, drawn, plant.polytropic_index, plant.gas, effects.supply
        )
    if effects.line.frequency > 0.0:
        _write_hose_rates(state, at_valve_a, at_valve_b, servo, rate)
