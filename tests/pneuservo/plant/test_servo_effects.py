"""Every effect of the single axis moves what it should, by as much as its law says."""

import dataclasses

import numpy as np
import pytest

from pneuservo.controllers import Proportional
from pneuservo.effects import effects_of
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.servo.drive import past
from pneuservo.plant.servo.layout import COMMANDED, FLOWED_A, MEMORY, NEWEST, PAST_ROWS, WHEN, Servo
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.spool_effects import (
    SpoolEffects,
    breakaway_of_spool,
    slewed,
    spool_rates,
)
from pneuservo.plant.servo.stop_effects import StopEffects, bumper_force
from pneuservo.plant.servo.transducers import play, read_pressures, true_motion, true_pressures
from pneuservo.plant.servo.valve_effects import ValveEffects, in_series, pressure_behind, silenced
from pneuservo.plant.servo.valve_side import valve_flows
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate

RIG = load_rig("single-axis")
PLANT = plant_numbers.single_axis(RIG)
GRID = plant_numbers.valve_grid("ddv-27a1")
EFFECTS = effects_of("single-axis", tables=True)
TWO_SIGNED = [effect for effect in EFFECTS if effect.parameters[0].low < 0.0]
TIME = np.arange(0.0, 0.5, 1e-3)
# Both directions and both stops at full opening, a rest, a slow ramp from null, a fast swing.
COMMAND = np.select(
    [TIME < 0.12, TIME < 0.16, TIME < 0.3, TIME < 0.33, TIME < 0.39],
    [5.0, 0.0, -5.0, 0.0, TIME - 0.33],
    2.0 * np.sin(150.0 * TIME),
)


def with_effect(effect, factor=1.0, changed=None):
    values = {
        p.name: p.starts[0] * (factor if p.name == changed else 1.0) for p in effect.parameters
    }
    return dataclasses.replace(RIG, effects={effect.id: values})


def outputs(rig):
    start = InitialState(0.015)
    runs = [
        simulate(rig, time=TIME, command=COMMAND, supply_pressure=6.5e5, initial=start),
        simulate(
            rig,
            time=TIME[:60],
            controller=Proportional(),
            demand=0.02,
            initial=start,
            supply_pressure=6.5e5,
        ),
    ]
    return [run[name] for run in runs for name in ("displacement", "pressure_a", "pressure_b")]


@pytest.fixture(scope="module")
def baseline():
    return outputs(RIG)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.id)
def test_every_effect_and_each_of_its_parameters_moves_an_output(effect, baseline):
    planted = outputs(with_effect(effect))
    assert all(np.isfinite(each).all() for each in planted)
    moved = [
        np.abs(one - other).max() / np.ptp(other)
        for one, other in zip(planted, baseline, strict=True)
    ]
    # Far above the rounding of a neutral run, 1e-9.
    assert max(moved) > 1e-7
    for parameter in effect.parameters:
        if parameter.starts[0] == 0.0:
            continue
        changed = outputs(with_effect(effect, 1.2, parameter.name))
        assert any(
            not np.array_equal(one, other) for one, other in zip(changed, planted, strict=True)
        ), parameter.name


@pytest.mark.parametrize("effect", TWO_SIGNED, ids=lambda effect: effect.id)
def test_an_effect_that_may_be_negative_moves_an_output_then_too(effect, baseline):
    size = effect.parameters[0].name
    found = outputs(with_effect(effect, -1.0, size))
    assert any(
        np.abs(one - other).max() > 1e-7 * np.ptp(other)
        for one, other in zip(found, baseline, strict=True)
    )


def flows(effects, opening=0.5, pressure_a=4e5, pressure_b=4e5, supply=6.5e5):
    state = np.array([0.015, 0.0, pressure_a, pressure_b, opening, 0.0])
    servo = Servo(PLANT, NEUTRAL._replace(valve=effects), OPEN_LOOP)
    return valve_flows(opening, state, np.zeros(13), supply, servo, np.full((4, 51, 101), 0.8))


def test_flow_is_choked_below_the_critical_ratio_and_falls_above():
    ratios = np.linspace(0.1, 0.95, 80)
    for effects, critical in ((ValveEffects(), 0.5283), (ValveEffects(critical_ratio=0.3), 0.3)):
        flow = np.array([flows(effects, pressure_a=6.5e5 * ratio)[0] for ratio in ratios])
        plateau = flow[ratios < critical]
        assert np.ptp(plateau) < 1e-12 * plateau[0]
        assert np.all(np.diff(flow[ratios > critical]) < 0.0)
    # ISO 6358 by hand, at ratio 0.65 with b = 0.3: sqrt(1 - 0.5^2).
    flow, choked = (
        flows(ValveEffects(critical_ratio=0.3), pressure_a=6.5e5 * r)[0] for r in (0.65, 0.2)
    )
    assert flow / choked == pytest.approx(np.sqrt(0.75), rel=1e-9)


def test_overlap_takes_the_first_part_of_the_opening():
    assert flows(ValveEffects(overlap=0.02), 0.019)[:2] == (0.0, 0.0)
    assert flows(ValveEffects(overlap=0.02), 0.12) == pytest.approx(flows(ValveEffects(), 0.1))
    assert flows(ValveEffects(overlap=0.02), -0.12) == pytest.approx(flows(ValveEffects(), -0.1))


def test_null_leakage_pulls_both_chambers_to_one_pressure():
    leaky = ValveEffects(null_leakage=0.01)
    low, high = (flows(leaky, 0.0, pressure, pressure)[0] for pressure in (2e5, 6.4e5))
    assert low > 0.0 > high
    # Both paths choked: the supply's 0.87 Ps against the exhaust's 0.795 Pa.
    flow = flows(leaky, 0.0, 3e5, 3e5)[0]
    expected = gas_mass_flow(6.5e5, 3e5, 0.87e-8, 1.0, PLANT.gas)
    assert flow == pytest.approx(expected - gas_mass_flow(3e5, 1.013e5, 0.795e-8, 1.0, PLANT.gas))


def test_a_laminar_leak_goes_with_the_difference_of_the_squares():
    gap = ValveEffects(null_leakage=0.01, null_leakage_laminar=1.0)
    full, less = (flows(gap, 0.0, 6.5e5, pressure)[1] for pressure in (6.5e5, 5.5e5))
    # Of both paths of port b: what one more bar below the supply is worth.
    area = 0.01 * (PLANT.valve.area_s_b + PLANT.valve.area_b_e)
    expected = gas_mass_flow(6e5, 1e-3, area, 1.0, PLANT.gas) * (6.5**2 - 5.5**2) / 6.0**2
    assert less - full == pytest.approx(expected, rel=1e-9)


def test_what_passes_an_edge_passes_the_throttle_behind_it():
    # The edge does not notice while it is choked; then the throttle takes its share.
    behind = [pressure_behind(6e5, 1e5, share, PLANT.gas) for share in (0.0, 0.3, 0.6, 1.0, 3.0)]
    assert behind[0] == 1e5
    assert np.all(np.diff(behind) > 0.0)
    assert behind[1] == pytest.approx(np.hypot(1e5, 1.8e5), rel=1e-12)
    assert behind[-1] < 6e5
    b = PLANT.gas.critical_pressure_ratio
    for share, pressure in ((0.6, behind[2]), (1.0, behind[3]), (3.0, behind[4])):
        edge = share * np.sqrt(6e5**2 - ((pressure - b * 6e5) / (1.0 - b)) ** 2)
        assert edge == pytest.approx(np.sqrt(pressure**2 - 1e10), rel=1e-9)


@pytest.mark.parametrize("sharpness", [2.0, 12.0])
def test_the_laminar_tail_is_a_straight_line_to_equal_pressures(sharpness):
    tail = ValveEffects(laminar_width=0.01, laminar_sharpness=sharpness)
    drops = np.array([0.2, 2e-4, 1e-4])
    flow = [flows(tail, pressure_a=6.5e5 * (1.0 - drop))[0] for drop in drops]
    free = [flows(ValveEffects(), pressure_a=6.5e5 * (1.0 - drop))[0] for drop in drops]
    # The root of the nozzle times that of the drop, but for what is left of the other law.
    assert flow[1] / flow[2] == pytest.approx(2.0, rel=0.01)
    assert flow[1] / free[1] == pytest.approx(np.sqrt(0.02), rel=0.011)
    assert flow[0] == pytest.approx(free[0], rel=0.05 ** (0.5 * sharpness))


@pytest.mark.parametrize("volume", [3e-6, 2e-5, 3e-4])
def test_a_silencer_comes_to_rest_where_as_much_leaves_as_arrives(volume):
    effects = ValveEffects(exhaust_area=2e-6, exhaust_volume=volume)
    ambient, gas, flow = PLANT.ambient_pressure, PLANT.gas, 8e-4
    pressure = ambient
    for _ in range(20000):
        pressure = silenced(pressure, flow, 5e-3, PLANT, effects)
    passes = gas_mass_flow(ambient, 0.0, 2e-6, 1.0, gas) / ambient
    assert passes * np.sqrt(pressure**2 - ambient**2) == pytest.approx(flow, rel=1e-9)
    # Emptied, it comes back to the air outside, from above.
    emptied = [pressure := silenced(pressure, 0.0, 1e-3, PLANT, effects) for _ in range(20000)]
    assert min(emptied) >= ambient
    assert emptied[-1] == pytest.approx(ambient, rel=1e-6)


def test_what_flows_into_a_large_volume_raises_its_pressure():
    effects = ValveEffects(exhaust_area=1e-12, exhaust_volume=3e-4)
    gas, flow, passed = PLANT.gas, 1e-3, 1e-4
    risen = silenced(PLANT.ambient_pressure, flow, passed, PLANT, effects) - PLANT.ambient_pressure
    stiffness = PLANT.polytropic_index * gas.gas_constant * gas.temperature / 3e-4
    assert risen == pytest.approx(stiffness * flow * passed, rel=1e-3)


def test_orifices_in_series_pass_less_than_either():
    assert in_series(0.8, 1e-6, 1e-3) == pytest.approx(0.8, rel=1e-6)
    assert in_series(0.8, 1e-6, 1e-9) * 1e-6 == pytest.approx(1e-9, rel=1e-6)


def test_the_motor_limits_acceleration():
    free = spool_rates(5.0, 0.0, 0.0, 0.0, 0.0, PLANT.valve, SpoolEffects())
    limits = SpoolEffects(acceleration_limit=1e5)
    assert free[1] > 1e6
    assert spool_rates(5.0, 0.0, 0.0, 0.0, 0.0, PLANT.valve, limits) == (0.0, 1e5)
    assert spool_rates(5.0, 0.0, 80.0, 0.0, 1.0, PLANT.valve, limits) == (0.0, 0.0)


def test_the_driver_follows_no_faster_than_its_rate():
    limits = SpoolEffects(rate_limit=50.0)
    # 50 full strokes of 5 V per second, for 2 ms, either way; a slower command is followed.
    assert slewed(5.0, 1.0, 2e-3, 5.0, limits) == pytest.approx(1.5)
    assert slewed(-5.0, 1.0, 2e-3, 5.0, limits) == pytest.approx(0.5)
    assert slewed(1.2, 1.0, 2e-3, 5.0, limits) == 1.2
    assert slewed(5.0, 1.0, 2e-3, 5.0, SpoolEffects()) == 5.0


def test_a_spool_behind_a_slow_driver_runs_at_its_rate():
    rate = 40.0
    time = np.arange(0.0, 0.06, 1e-4)
    command = np.where(time < 0.01, 0.0, 4.0)
    rig = dataclasses.replace(RIG, effects={"spool.slew": {"rate": rate}})
    start = InitialState(0.015)
    run = simulate(rig, time=time, command=command, supply_pressure=6.5e5, initial=start)
    # A ramp of 0.8 in 20 ms, behind which a spool of the second order lags by 2 zeta/w.
    lag = 2.0 * PLANT.valve.spool_damping / PLANT.valve.spool_frequency
    inner = (time > 0.015) & (time < 0.029)
    expected = rate * (time[inner] - 0.01 - lag)
    assert run["spool"][inner] == pytest.approx(expected, abs=2e-3)
    assert run["spool"][-1] == pytest.approx(0.8, abs=1e-6)


def test_dry_friction_stops_a_spool_short_of_its_command():
    share = 0.02
    effects = SpoolEffects(stiction=share)
    moving, back = (
        spool_rates(1.0, 0.1, speed, 0.0, 0.0, PLANT.valve, effects)[1]
        - spool_rates(1.0, 0.1, speed, 0.0, 0.0, PLANT.valve, SpoolEffects())[1]
        for speed in (1.0, -1.0)
    )
    braked = share * PLANT.valve.spool_frequency**2
    assert (moving, back) == (pytest.approx(-braked), pytest.approx(braked))


def test_silt_builds_up_with_the_rest():
    effects = SpoolEffects(stiction=0.02, stiction_time=10.0)
    assert breakaway_of_spool(10.0, effects) == pytest.approx(0.02 * (1.0 - 0.5 * np.exp(-1.0)))
    assert breakaway_of_spool(0.0, effects) == 0.01
    assert breakaway_of_spool(0.0, SpoolEffects(stiction=0.02)) == 0.02


def test_the_past_is_straight_between_its_rows_and_reaches_the_present():
    rows, memory = np.zeros((PAST_ROWS, 4)), np.zeros(MEMORY)
    rows[:, WHEN] = -1e30
    for k in range(5):
        rows[k, WHEN], rows[k, FLOWED_A], rows[k, COMMANDED] = 0.1 * k, k, 1.0
    memory[NEWEST] = 4
    looked = [past(rows, memory, FLOWED_A, moment, 0.5, 5.0) for moment in (0.05, 0.25, 0.4, 0.45)]
    assert looked == pytest.approx([0.5, 2.5, 4.0, 4.5])
    assert past(rows, memory, FLOWED_A, -1.0, 0.5, 5.0) == pytest.approx(0.0, abs=1e-9)


def spool_gain(frequency, amplitude, valve, effects):
    """Amplitude of the spool over that of a sinusoidal command, once it has settled."""
    turning, step = 2.0 * np.pi * frequency, 1.0 / (100.0 * frequency)
    voltage = amplitude * valve.full_voltage
    place, rate, course = 0.0, 0.0, []
    # Thirty periods: a limited motor takes twenty to settle. The midpoint rule, 100 steps each.
    for k in range(30 * 100):
        one, other = voltage * np.sin(turning * step * (k + np.array([0.0, 0.5])))
        first = spool_rates(one, place, rate, 0.0, 0.0, valve, effects)
        middle = (place + 0.5 * step * first[0], rate + 0.5 * step * first[1])
        second = spool_rates(other, *middle, 0.0, 0.0, valve, effects)
        place, rate = place + step * second[0], rate + step * second[1]
        course.append(abs(place))
    return max(course[-100:]) / amplitude


@pytest.mark.parametrize(
    ("frequency", "acceleration", "bandwidth"),
    [(290.0, 9e5, 200.0), (500.0, 4.1e5, 135.0)],
    ids=["measured", "maker's data"],
)
def test_a_limited_motor_gives_the_bandwidths_of_section_3_1_1_2(
    frequency, acceleration, bandwidth
):
    # -3 dB at 2.5 % of the travel and at all of it; a damping ratio of 0.7 is 1/sqrt(2) but for
    # 1 %, and each limit is known to two figures.
    valve = PLANT.valve._replace(spool_frequency=2.0 * np.pi * frequency)
    limited = SpoolEffects(acceleration_limit=acceleration)
    assert spool_gain(frequency, 0.025, valve, limited) == pytest.approx(0.5**0.5, rel=0.03)
    assert spool_gain(bandwidth, 1.0, valve, limited) == pytest.approx(0.5**0.5, rel=0.03)
    assert spool_gain(bandwidth, 1.0, valve, SpoolEffects()) > 0.85


def test_a_bumper_pushes_and_never_pulls():
    bumper = StopEffects(stiffness=1e6, damping=100.0)
    assert bumper_force(0.03, 0.0, 0.03, bumper) == pytest.approx(-200.0)
    assert bumper_force(0.015, 1.0, 0.03, bumper) == 0.0
    assert bumper_force(0.0299, -10.0, 0.03, bumper) == 0.0


def test_a_wiper_with_play_stays_behind_at_a_reversal():
    moved = np.array([0.0, 1.0, 2.0, 1.9, 1.0, 0.0])
    assert play(moved, 0.25) == pytest.approx([0.0, 0.75, 1.75, 1.75, 1.25, 0.25])


def test_readings_can_be_traced_back():
    time = np.arange(0.0, 0.1, 1e-4)
    x, v = 0.015 + 0.01 * np.sin(30.0 * time), 0.3 * np.cos(30.0 * time)
    pressure = 4e5 + 1e5 * np.sin(20.0 * time)
    flow = 1e-3 * np.cos(20.0 * time)
    sensor = NEUTRAL.sensor._replace(
        displacement_gain=0.02,
        displacement_offset=1e-4,
        bow=-7e-5,
        first_harmonic=1e-4,
        pressure_a_gain=0.01,
        pressure_a_offset=2e3,
        pressure_skew=0.0,
        ground_shift_b=-400.0,
    )
    volts = 5.0 * np.sign(np.sin(25.0 * time))
    read_a, read_b = read_pressures(time, pressure, pressure, flow, flow, volts, PLANT.gas, sensor)
    assert np.abs(read_a - pressure).max() > 5e3
    assert read_b - pressure == pytest.approx(-400.0 * volts)
    back_a, back_b = true_pressures(time, read_a, read_b, volts, sensor)
    assert back_a == pytest.approx(pressure, rel=1e-12)
    assert back_b == pytest.approx(pressure, rel=1e-12)
    part = np.pi * x / 0.03
    read = x * 1.02 + 1e-4 - 7e-5 * np.sin(part) + 1e-4 * np.sin(2.0 * part)
    slope = 1.02 + np.pi / 0.03 * (2e-4 * np.cos(2.0 * part) - 7e-5 * np.cos(part))
    true_x, true_v = true_motion(read, slope * v, None, 0.03, sensor)
    # Three rounds with a contraction of 0.04: 0.04^3 of the error of 0.7 mm.
    assert true_x == pytest.approx(x, abs=0.04**3 * 7e-4)
    assert true_v == pytest.approx(v, abs=1e-5)
