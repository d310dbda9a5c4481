"""Each half of the servo, fed with what the whole one did, does the same again."""

import dataclasses

import numpy as np
import pytest

from pneuservo.effects.servo import servo_effects
from pneuservo.plant import from_rig
from pneuservo.plant.servo.fed_chambers import fed_chambers
from pneuservo.plant.servo.fed_piston import fed_piston, piston_balance
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

RIG = load_rig("single-axis")
PLANT = from_rig.single_axis(RIG)
GRID = from_rig.valve_grid("ddv-27a1")
TIME = np.arange(0.0, 1.5, 1e-3)
COMMAND = np.concatenate(
    [
        np.repeat(np.random.default_rng(1).uniform(-4.0, 4.0, 35), 20),
        1.5 * np.sin(2.0 * np.pi * np.cumsum(np.linspace(1.0, 20.0, 500)) * 1e-3),
        np.repeat(np.random.default_rng(2).uniform(-0.3, 0.3, 6), 50),
    ]
)
IN_CHAMBERS = {
    "spool.null-bias": {"bias": 0.005},
    "spool.hysteresis": {"half_width": 0.006},
    "spool.amplitude-bandwidth": {"acceleration": 4e5},
    "spool.slew": {"rate": 100.0},
    "spool.delay": {"time": 5e-4},
    "valve.overlap": {"lap": 0.01},
    "valve.null-leakage": {"share": 0.01, "width": 0.02},
    "valve.critical-ratio": {"ratio": 0.3},
    "supply.ripple": {"amplitude": 1e4, "frequency": 20.0, "phase": 0.0},
    "line.restriction": {"area": 2e-6},
    "line.delay": {"time": 1e-3},
    "line.resonance": {"frequency": 32.0, "damping": 0.2},
    "leakage.cross-piston": {"conductance": 3e-17},
    "leakage.rod-seal": {"area": 1e-8},
    "chamber.heat-transfer": {"conductance": 0.1},
    "sensor.position-offset": {"offset": 3e-4},
    "sensor.pressure-offset-b": {"offset": 2e3},
    "sensor.pressure-lag": {"time": 2e-3},
}
ON_PISTON = {
    "friction.pressure": {"sum": 2e-6, "difference": 2e-6},
    "friction.asymmetric": {"difference": 0.5, "viscous": 5.0},
    "friction.lag": {"time": 5e-3},
    "friction.speed-curve": {"quadratic": 50.0},
    "friction.side-load": {"force": 1.0},
    "load.spring": {"stiffness": 200.0},
    "load.transverse-mode": {"share": 0.06, "frequency": 12.0, "damping": 0.02},
    "load.compliance": {"share": 0.5, "stiffness": 3e5, "damping": 30.0},
    "load.gravity-angle": {"angle": 0.3},
    "endstop.contact": {"stiffness": 1e6, "damping": 200.0},
    "sensor.pressure-gain-a": {"gain": 0.005},
    "sensor.position-gain": {"gain": 0.01},
}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def chamber_residual(run, effects):
    fed = fed_chambers(
        TIME,
        COMMAND,
        run["displacement"],
        run["velocity"],
        run["pressure_a"],
        run["pressure_b"],
        PLANT,
        GRID,
        effects,
        acceleration=run["acceleration"],
        restarts=range(0, len(TIME), 250),
    )
    return max(rms(fed.pressure_a - run["pressure_a"]), rms(fed.pressure_b - run["pressure_b"]))


def piston_residual(run, effects):
    fed = fed_piston(
        TIME,
        run["pressure_a"],
        run["pressure_b"],
        run["displacement"],
        run["velocity"],
        PLANT,
        effects,
        acceleration=run["acceleration"],
        restarts=range(0, len(TIME), 100),
    )
    return rms(fed.displacement - run["displacement"])


def planted(effect, values):
    rig = dataclasses.replace(RIG, effects={effect: values})
    run = simulate(rig, time=TIME, command=COMMAND, initial=InitialState(0.015))
    return run, servo_effects(rig.effect_values)


@pytest.fixture(scope="module")
def plain():
    return simulate(time=TIME, command=COMMAND, initial=InitialState(0.015))


def test_the_fed_baseline_repeats_the_baseline(plain):
    # Steps of 0.5 ms through table kinks, and motion known at 1 kHz; a transducer's noise is
    # 500 Pa, the resolution of the displacement 7 um.
    assert chamber_residual(plain, NEUTRAL) < 150.0
    assert piston_residual(plain, NEUTRAL) < 20e-6


@pytest.mark.parametrize("effect", IN_CHAMBERS)
def test_fed_chambers_need_the_effect_that_was_there(effect):
    run, effects = planted(effect, IN_CHAMBERS[effect])
    assert chamber_residual(run, effects) < 0.15 * chamber_residual(run, NEUTRAL)


@pytest.mark.parametrize("effect", ON_PISTON)
def test_the_fed_piston_needs_the_effect_that_was_there(effect):
    run, effects = planted(effect, ON_PISTON[effect])
    assert piston_residual(run, effects) < 0.3 * piston_residual(run, NEUTRAL)


def test_the_balance_of_forces_closes_and_shows_what_is_missing():
    run, effects = planted("friction.asymmetric", {"difference": 0.5, "viscous": 0.0})
    moving = np.abs(run["velocity"]) > 2e-3
    balances = [
        piston_balance(
            TIME,
            run["pressure_a"],
            run["pressure_b"],
            run["displacement"],
            run["velocity"],
            run["acceleration"],
            PLANT,
            each,
        ).residual[moving]
        for each in (effects, NEUTRAL)
    ]
    # Forces of 200 N that cancel to rounding.
    assert np.abs(balances[0]).max() < 1e-10
    assert balances[1] == pytest.approx(-0.5, abs=1e-10)


def test_a_measured_spool_replaces_the_spool(plain):
    spool = plain["spool"]
    arguments = (
        TIME,
        0.0 * COMMAND,
        plain["displacement"],
        plain["velocity"],
        plain["pressure_a"],
        plain["pressure_b"],
        PLANT,
        GRID,
    )
    fed = fed_chambers(*arguments, spool=spool, restarts=range(0, len(TIME), 250))
    assert np.array_equal(fed.spool, spool)
    # A spool of 200 Hz known at 1 kHz, straight between: (1 ms x 1257/s)^2/8 of a step's share.
    assert rms(fed.pressure_a - plain["pressure_a"]) < 3e3


def test_restarts_begin_from_what_was_read(plain):
    wrong = plain["pressure_a"].copy()
    wrong[0] += 3e4
    fed = fed_chambers(
        TIME, COMMAND, plain["displacement"], plain["velocity"], wrong, plain["pressure_b"],
        PLANT, GRID, restarts=[700],
    )  # fmt: skip
    off = fed.pressure_a - plain["pressure_a"]
    assert off[0] == pytest.approx(3e4)
    assert abs(off[700]) < 1e-6
