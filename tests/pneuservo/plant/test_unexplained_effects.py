"""Tables that stand for physics without a name do what they say, and nothing while empty."""

import numpy as np
import pytest
from swinging_servo import BASELINE, RIG, TIME, assert_same, run

from pneuservo.effects.servo import servo_effects
from pneuservo.errors import InputError
from pneuservo.plant.gas import gas_mass_flow
from pneuservo.plant.servo import unexplained_effects as tables
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.starting import resting_force
from pneuservo.plant.servo.unexplained_effects import (
    QUANTITIES,
    Table,
    tabulated,
    unexplained_force,
)
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState

PLANT = plant_numbers.single_axis(RIG)
STROKE = PLANT.piston.stroke
# Displacement, velocity, both pressures, spool, time; each over its own range.
STATE = (0.012, 0.2, 4.2e5, 5.1e5, -0.3, 1.7)


def knots(low, high):
    return np.linspace(low, high, tables.INTERVALS + 1)


def table(over, low, high, values):
    return {"over": over, "low": low, "high": high} | {f"v{k}": v for k, v in enumerate(values)}


@pytest.mark.parametrize(
    ("over", "quantity"),
    [
        (tables.DISPLACEMENT, 0.012),
        (tables.VELOCITY, 0.2),
        (tables.PRESSURE_A, 4.2e5),
        (tables.PRESSURE_B, 5.1e5),
        (tables.SPOOL, -0.3),
        (tables.TIME, 1.7),
        (tables.PRESSURE_DIFFERENCE, -0.9e5),
    ],
    ids=lambda value: QUANTITIES[value] if isinstance(value, int) else str(value),
)
def test_a_table_is_linear_between_its_knots_and_constant_beyond(over, quantity):
    rng = np.random.default_rng(3)
    values = rng.normal(size=tables.INTERVALS + 1)
    for share in (-0.4, 0.0, 0.2, 0.5, 0.51, 0.93, 1.0, 3.0):
        # The range is laid so that the quantity stands at this share of it.
        width = abs(quantity)
        low = quantity - share * width
        filled = Table(float(over), low, low + width, *values)
        expected = np.interp(quantity, knots(low, low + width), values)
        # Rounding of the place between two knots, 8 of them, times a step between two values.
        assert tabulated(*STATE, filled) == pytest.approx(expected, abs=1e-12)


def test_a_table_for_one_direction_counts_in_that_direction_only():
    rising = Table(0.0, 0.0, STROKE, *knots(0.0, 80.0))
    extending, retracting = (
        rising._replace(over=float(over))
        for over in (tables.DISPLACEMENT_EXTENDING, tables.DISPLACEMENT_RETRACTING)
    )
    both = 80.0 * 0.012 / STROKE
    for velocity in (-1.0, -5e-3, 0.0, 2e-3, 1.0):
        state = (0.012, velocity, *STATE[2:])
        share = np.tanh(velocity / 5e-3)
        assert tabulated(*state, extending) == pytest.approx(both * max(share, 0.0))
        assert tabulated(*state, retracting) == pytest.approx(both * max(-share, 0.0))


def test_without_a_range_there_is_no_table():
    assert tabulated(*STATE, Table(v0=1.0, v8=1.0)) == 0.0


@pytest.mark.parametrize("name", ["force", "flow-a", "flow-b"])
def test_a_table_of_zeros_is_the_baseline(name):
    zeros = table(tables.DISPLACEMENT, 0.0, STROKE, np.zeros(9))
    assert_same(run({f"unexplained.{name}": zeros}), run(BASELINE), 1e-12)


def test_a_force_linear_in_displacement_is_a_spring():
    stiffness = 300.0
    pull = stiffness * (0.5 * STROKE - knots(0.0, STROKE))
    sprung = run({"load.spring": {"stiffness": stiffness}})
    tabled = run({"unexplained.force": table(tables.DISPLACEMENT, 0.0, STROKE, pull)})
    # A straight table is the spring but for rounding, that grows with the events of a run; the
    # spring itself moves the pressures by some hundredths of their range.
    assert_same(tabled, sprung, 1e-9)
    assert np.abs(sprung["pressure_a"] - run(BASELINE)["pressure_a"]).max() > 1e3


def test_a_force_linear_in_velocity_is_viscous_friction():
    damping = 60.0
    brake = table(tables.VELOCITY, -2.0, 2.0, -damping * knots(-2.0, 2.0))
    name = "piston.viscous_friction"
    more = {name: RIG.parameters[name].value + damping}
    expected = run(BASELINE, rig=RIG.with_values(more))
    found = run({"unexplained.force": brake})
    assert np.abs(found["velocity"]).max() < 2.0
    assert_same(found, expected, 1e-9)


def test_a_resting_piston_is_started_in_balance_with_the_force():
    push = Table(float(tables.DISPLACEMENT), 0.0, STROKE, *knots(-40.0, 40.0))
    effects = NEUTRAL._replace(unexplained_force=push)
    assert resting_force(0.75 * STROKE, PLANT, effects) == pytest.approx(-20.0)
    assert unexplained_force(0.75 * STROKE, *STATE[1:], effects) == pytest.approx(20.0)
    still = np.zeros_like(TIME)
    held = run({"unexplained.force": push._asdict()}, command=still)
    # Leaking nothing and held by friction it has no reason to move at all.
    assert np.ptp(held["displacement"]) == 0.0


@pytest.mark.parametrize(("side", "pressure"), [("a", "pressure_a"), ("b", "pressure_b")])
def test_a_constant_flow_fills_a_chamber_by_its_mass(side, pressure):
    # The spool shut and the piston at the stop that the filled chamber presses it to, by hand:
    # dp/dt = n R T m / V.
    place = STROKE if side == "a" else 0.0
    flow = 2e-6
    filled = {f"unexplained.flow-{side}": table(tables.TIME, 0.0, 1.0, np.full(9, flow))}
    shut = np.zeros_like(TIME)
    found, still = (
        run(effects, command=shut, start=InitialState(place)) for effects in (filled, BASELINE)
    )
    piston = PLANT.piston
    area, dead = (
        (piston.area_a, PLANT.dead_volume_a)
        if side == "a"
        else (piston.area_b, PLANT.dead_volume_b)
    )
    gas = PLANT.gas
    rise = PLANT.polytropic_index * gas.gas_constant * gas.temperature * flow * TIME
    assert np.ptp(found["displacement"]) == 0.0
    assert found[pressure] - still[pressure] == pytest.approx(
        rise / (area * STROKE + dead), rel=1e-9, abs=1e-6
    )


def test_a_flow_over_the_pressure_drains_like_a_choked_hole():
    # Choked the whole way, the flow through a hole is straight in the pressure.
    area = 2e-8
    hole = {"leakage.chamber-a": {"area": area}}
    low, high = 2.5e5, 6.5e5
    flow = [-gas_mass_flow(p, PLANT.ambient_pressure, area, 1.0, PLANT.gas) for p in (low, high)]
    tabled = {"unexplained.flow-a": table(tables.PRESSURE_A, low, high, np.linspace(*flow, 9))}
    leaky, found, tight = (run(effects) for effects in (hole, tabled, BASELINE))
    assert low < tight["pressure_a"].min()
    assert np.abs(leaky["pressure_a"] - tight["pressure_a"]).max() > 1e3
    assert_same(found, leaky, 1e-9)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"v3": 1.0}, r"unexplained\.force: low is 0 and high is 0; low has to be below high"),
        ({"v3": 1.0, "low": 0.02, "high": 0.01}, "low is 0.02 and high is 0.01"),
        ({"v3": 1.0, "high": 1.0, "over": 2.5}, "over is 2.5; it has to be one of: 0 displacement"),
        ({"v3": 1.0, "high": 1.0, "over": 9.0}, "over is 9"),
    ],
)
def test_a_table_that_cannot_be_looked_up_is_refused(values, message, tmp_path):
    with pytest.raises(InputError, match=message):
        servo_effects({f"unexplained.force:{name}": value for name, value in values.items()})
    path = tmp_path / "model.toml"
    entry = ", ".join(f"{name} = {value}" for name, value in values.items())
    path.write_text(
        f'[rig]\nkind = "single-axis"\n[effects]\n"unexplained.force" = {{ {entry} }}\n'
    )
    with pytest.raises(InputError, match=message) as refused:
        load_rig(path)
    assert str(path) in str(refused.value)


def test_a_rig_file_may_hold_a_table(tmp_path):
    path = tmp_path / "model.toml"
    values = table(tables.VELOCITY, -1.0, 1.0, knots(10.0, -10.0))
    entry = ", ".join(f"{name} = {float(value)!r}" for name, value in values.items())
    path.write_text(
        f'[rig]\nkind = "single-axis"\n[effects]\n"unexplained.force" = {{ {entry} }}\n'
    )
    rig = load_rig(path)
    assert servo_effects(rig.effect_values).unexplained_force == Table(**values)
    assert_same(run(rig.effects, rig=rig), run({"unexplained.force": values}), 0.0)
