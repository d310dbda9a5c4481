"""The valve between supply, exhaust and its two ports, with every effect."""

from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.leak_laws import mixed_leak
from pneuservo.plant.servo.chamber_effects import has_energy_balance
from pneuservo.plant.servo.compilation import compiled
from pneuservo.plant.servo.drive import given
from pneuservo.plant.servo.layout import (
    EXHAUST,
    FIRST_JET,
    PORT_PRESSURE_A,
    PORT_PRESSURE_B,
    RESERVOIR,
    SUPPLY,
    TEMPERATURE_A,
    TEMPERATURE_B,
    TIME,
)
from pneuservo.plant.servo.line_effects import throttling_area
from pneuservo.plant.servo.supply_effects import has_reservoir, source_pressure
from pneuservo.plant.servo.valve_effects import (
    area_factor,
    effective_opening,
    flow_factor,
    in_series,
    null_leakage_share,
    pressure_behind,
)
from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B
from pneuservo.plant.valve import (
    A_TO_EXHAUST,
    B_TO_EXHAUST,
    SUPPLY_TO_A,
    SUPPLY_TO_B,
    discharge_coefficient,
)

THROTTLE_PASSES = 3
"""The edge's coefficient depends on the pressure behind it, which depends on the coefficient."""


@compiled
def supply_at_valve(state, drive, elapsed, servo):
    """Return the pressure at the valve's supply port [Pa].

    Parameters
    ----------
    state, drive, elapsed, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    supply = servo.effects.supply
    if has_reservoir(supply):
        return state[RESERVOIR]
    return source_pressure(given(drive, SUPPLY, elapsed), given(drive, TIME, elapsed), supply)


@compiled
def path_flow(
    path,
    opening,
    area,
    upstream,
    downstream,
    exhausts,
    port_b,
    source_temperature,
    attached,
    servo,
    grid,
):
    """Return the mass flow through one path of the valve [kg/s].

    Parameters
    ----------
    path : int
        Which of the four paths.
    opening : float
        Magnitude of the opening [-].
    area : float
        Of the path at full opening, as the rig has it [m^2].
    upstream, downstream : float
        Absolute pressures in the path's own direction of flow [Pa].
    exhausts, port_b : bool
        Whether the path exhausts, and whether it belongs to port b.
    source_temperature : float
        Of the gas that flows [K].
    attached : float
        1 while the jet is attached to the wall.
    servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.

    Notes
    -----
    `pneuservo.plant.valve.path_mass_flow` with effects as factors on the coefficient, and behind
    the edge the pressure that a hose keeps up.
    """
    effects, plant = servo.effects, servo.plant
    valve, gas = plant.valve, plant.gas
    ratio = min(upstream, downstream) / max(upstream, downstream)
    volts, open_area = valve.full_voltage * opening, area * opening
    lost = effects.valve.attached_loss * attached
    factor = 1.0 - (lost if exhausts else effects.valve.attached_at_supply * lost)
    factor *= area_factor(opening, exhausts, port_b, effects.valve)
    coefficient = factor * discharge_coefficient(path, volts, ratio, grid)
    hose = throttling_area(effects.line)
    if hose > 0.0 and upstream > downstream and not exhausts:
        end = downstream
        for _ in range(THROTTLE_PASSES):
            downstream = pressure_behind(upstream, end, coefficient * open_area / hose, gas)
            ratio = downstream / upstream
            coefficient = factor * discharge_coefficient(path, volts, ratio, grid)
    if exhausts or upstream < downstream:
        # Behind the hose the edge starts from less: whatever chokes, it passes that much less.
        coefficient = in_series(coefficient, open_area, hose)
    coefficient *= flow_factor(ratio, gas, effects.valve)
    if source_temperature != gas.temperature:
        coefficient *= (gas.temperature / source_temperature) ** 0.5
    return gas_mass_flow(upstream, downstream, open_area, coefficient, gas)


@compiled
def temperature_of(state, place, servo):
    """Return the temperature of gas or wall of a chamber [K].

    Parameters
    ----------
    state : array
        Of the chain.
    place : int
        `layout.TEMPERATURE_A` or another one.
    servo : Servo
        The numbers.
    """
    if has_energy_balance(servo.effects.chamber):
        return state[place]
    return servo.plant.gas.temperature


@compiled
def port_pressures(state, servo):
    """Return the pressures at ports a and b of the valve [Pa].

    Parameters
    ----------
    state, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    if servo.effects.line.frequency > 0.0:
        return state[PORT_PRESSURE_A], state[PORT_PRESSURE_B]
    return state[PRESSURE_A], state[PRESSURE_B]


@compiled
def _from_supply(path, opening, area, supply, pressure, port_b, warm, memory, servo, grid):
    source = warm
    if supply >= pressure:
        source = servo.plant.gas.temperature + servo.effects.valve.supply_warmth
    attached = memory[FIRST_JET + path]
    return path_flow(
        path, opening, area, supply, pressure, False, port_b, source, attached, servo, grid
    )


@compiled
def exhaust_pressure(memory, servo):
    """Return the pressure at the exhaust port of the valve [Pa].

    Parameters
    ----------
    memory, servo
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    if servo.effects.valve.exhaust_area > 0.0:
        return memory[EXHAUST]
    return servo.plant.ambient_pressure


@compiled
def _to_exhaust(path, opening, area, pressure, port_b, warm, memory, servo, grid):
    end = exhaust_pressure(memory, servo)
    source = warm if pressure >= end else servo.plant.gas.temperature
    attached = memory[FIRST_JET + path]
    return path_flow(
        path, opening, area, pressure, end, True, port_b, source, attached, servo, grid
    )


@compiled
def valve_flows(opening, state, memory, supply, servo, grid):
    """Return the mass flows out of ports a and b, and that out of the supply [kg/s].

    Parameters
    ----------
    opening : float
        Spool position as a fraction of full opening [-].
    state, memory, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    supply : float
        Absolute pressure at the supply port [Pa].
    """
    plant, effects = servo.plant, servo.effects.valve
    valve = plant.valve
    pa, pb = port_pressures(state, servo)
    wide = effective_opening(opening, effects)
    warm_a = temperature_of(state, TEMPERATURE_A, servo)
    warm_b = temperature_of(state, TEMPERATURE_B, servo)
    if wide >= 0.0:
        flow_a = _from_supply(
            SUPPLY_TO_A, wide, valve.area_s_a, supply, pa, False, warm_a, memory, servo, grid
        )
        flow_b = -_to_exhaust(
            B_TO_EXHAUST, wide, valve.area_b_e, pb, True, warm_b, memory, servo, grid
        )
        drawn = flow_a
    else:
        flow_a = -_to_exhaust(
            A_TO_EXHAUST, -wide, valve.area_a_e, pa, False, warm_a, memory, servo, grid
        )
        flow_b = _from_supply(
            SUPPLY_TO_B, -wide, valve.area_s_b, supply, pb, True, warm_b, memory, servo, grid
        )
        drawn = flow_b
    if effects.null_leakage > 0.0:
        share = null_leakage_share(opening, effects)
        end, gas = exhaust_pressure(memory, servo), plant.gas
        gap = effects.null_leakage_laminar
        cold = gas.temperature
        into_a = mixed_leak(supply, pa, share * valve.area_s_a, gap, cold, gas)
        into_b = mixed_leak(supply, pb, share * valve.area_s_b, gap, cold, gas)
        flow_a += into_a - mixed_leak(pa, end, share * valve.area_a_e, gap, warm_a, gas)
        flow_b += into_b - mixed_leak(pb, end, share * valve.area_b_e, gap, warm_b, gas)
        drawn += into_a + into_b
    return flow_a, flow_b, drawn
