"""The closed, leaking volume against analytic solutions."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.leaking_volume import Leak, run_leaking_volume
from pneuservo.plant.dead_volume import PORT_A
from pneuservo.rigs import load_rig
from pneuservo.rigs.plant_numbers import dead_volume, valve_grid

RIG = load_rig("dead-volume").with_values({"dead-volume.polytropic_index": 1.0})
AMBIENT, WALL, R = RIG["ambient.pressure"], RIG["temperature"], RIG["gas.constant"]
VOLUME = RIG["dead-volume.volume"]
START = AMBIENT + 7e5
TIME = np.linspace(0.0, 20.0, 101)
TIGHT = Leak(0.0, 0.0, 0.0, 1.0)


def run(leak=TIGHT, rig=RIG, time=TIME, start=0.0, excess=0.0, settling=0.0, step=0.02):
    return run_leaking_volume(
        time,
        np.zeros(len(time)),
        start,
        START,
        PORT_A,
        dead_volume(rig),
        valve_grid(rig.valve),
        leak,
        excess,
        settling,
        step,
    )


def laminar(time, conductance, index=1.0):
    """dp/dt = -k (p^2 - p_atm^2) by separation of variables."""
    rate = 2.0 * AMBIENT * index * R * WALL / VOLUME * conductance
    share = (START - AMBIENT) / (START + AMBIENT) * np.exp(-rate * time)
    return AMBIENT * (1.0 + share) / (1.0 - share)


def test_a_tight_volume_keeps_its_pressure():
    assert np.array_equal(run(), np.full(len(TIME), START))


def test_a_laminar_leak():
    conductance = 2e-17
    # Steps of 0.02 s are 1 % of the fastest decay here, 3.2 s: 0.006^4 / 120 per step.
    assert run(Leak(0.0, conductance, 0.0, 1.0)) == pytest.approx(
        laminar(TIME, conductance), rel=1e-10
    )


def test_the_polytropic_index_speeds_it_up():
    conductance = 2e-17
    rig = RIG.with_values({"dead-volume.polytropic_index": 1.4})
    assert run(Leak(0.0, conductance, 0.0, 1.0), rig) == pytest.approx(
        laminar(TIME, conductance, 1.4), rel=1e-10
    )


def test_a_leak_in_proportion_to_gauge_pressure_is_an_exponential():
    at_one_bar = 4e-6
    decay = R * WALL / VOLUME * at_one_bar / 1e5
    expected = AMBIENT + (START - AMBIENT) * np.exp(-decay * TIME)
    assert run(Leak(0.0, 0.0, at_one_bar, 1.0)) == pytest.approx(expected, rel=1e-10)


def test_other_powers_by_separation_of_variables():
    at_one_bar, exponent = 4e-6, 1.5
    decay = R * WALL / VOLUME * at_one_bar / 1e5
    gauge = ((7.0) ** (1.0 - exponent) + (exponent - 1.0) * decay * TIME) ** (
        1.0 / (1.0 - exponent)
    )
    expected = AMBIENT + 1e5 * gauge
    assert run(Leak(0.0, 0.0, at_one_bar, exponent)) == pytest.approx(expected, rel=1e-9)


def test_a_choked_orifice_is_an_exponential_of_absolute_pressure():
    area = 2e-8
    g = RIG["gas.isentropic_exponent"]
    factor = np.sqrt(g / R) * (2.0 / (g + 1.0)) ** ((g + 1.0) / (2.0 * (g - 1.0)))
    decay = R * WALL / VOLUME * area * factor / np.sqrt(WALL)
    expected = START * np.exp(-decay * TIME)
    choked = expected > AMBIENT / 0.528
    assert choked[10]
    assert not choked[-1]
    assert run(Leak(area, 0.0, 0.0, 1.0))[choked] == pytest.approx(expected[choked], rel=1e-9)


def test_the_steps_are_of_fourth_order():
    leak = Leak(0.0, 5e-15, 0.0, 1.0)  # gone in 15 ms, so that 1 ms steps err
    time = np.linspace(0.0, 0.02, 3)
    errors = [
        np.max(np.abs(run(leak, time=time, step=h) - laminar(time, 5e-15))) for h in (1e-3, 5e-4)
    ]
    assert errors[0] / errors[1] == pytest.approx(2.0**4, rel=0.05)  # the next order adds 0.1 %


def test_the_recorder_may_sample_as_it_likes():
    leak = Leak(3e-9, 2e-17, 0.0, 1.0)
    often, seldom = np.linspace(0.0, 20.0, 1001), np.linspace(0.0, 20.0, 11)
    assert run(leak, time=seldom) == pytest.approx(run(leak, time=often)[::100], rel=1e-9)


def test_it_is_held_until_it_is_left_alone_between_two_samples():
    conductance, start = 2e-17, 7.13
    pressure = run(Leak(0.0, conductance, 0.0, 1.0), start=start)
    held = start >= TIME
    assert np.all(pressure[held] == START)
    assert pressure[~held] == pytest.approx(laminar(TIME[~held] - start, conductance), rel=1e-10)


def test_warm_gas_settles_to_the_wall():
    excess, settling = 20.0, 3.0
    warmth = 1.0 + excess / WALL * np.exp(-TIME / settling)
    expected = START * warmth / warmth[0]
    assert run(excess=excess, settling=settling) == pytest.approx(expected, rel=1e-10)


def test_without_heat_a_leak_cools_the_gas_adiabatically():
    leak = Leak(0.0, 0.0, 4e-6, 1.0)
    g = RIG["gas.isentropic_exponent"]
    # So slow a settling that none takes place in 20 s.
    insulated = run(leak, settling=1e9)
    # For a flow that depends on pressure alone: p' = -(g R T / V) m', T = T0 (p/p0)^((g-1)/g).
    time = np.linspace(0.0, 20.0, 20001)
    pressure = np.empty_like(time)
    pressure[0] = START

    def rate(p):
        temperature = WALL * (p / START) ** ((g - 1.0) / g)
        return -g * R * temperature / VOLUME * 4e-6 * (p - AMBIENT) / 1e5

    h = time[1]
    for k in range(len(time) - 1):
        middle = pressure[k] + 0.5 * h * rate(pressure[k])
        pressure[k + 1] = pressure[k] + h * rate(middle)
    # The midpoint rule with 1 ms: (h / 3 s)^2 / 6 of the pressure.
    assert insulated == pytest.approx(pressure[::200], rel=1e-7)
    with_heat = run(leak, settling=1e-2, step=1e-3)
    isothermal = run(leak)
    # Heat that comes at once makes it isothermal, but for T - T_wall of order settling x rate.
    assert with_heat == pytest.approx(isothermal, rel=5e-3)
