"""With every effect at neutral the chain with effects is the baseline."""

from pathlib import Path

import numpy as np
import pandas
import pytest

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard, SlidingMode
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.integrator import run
from pneuservo.plant.servo.layout import OUTPUTS, SERVO_STATES, Servo
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.starting import servo_inputs, servo_state
from pneuservo.plant.single_axis import STATES_WITH_CARD
from pneuservo.rigs import load_rig, plant_numbers
from pneuservo.simulation import InitialState, simulate

GOLDEN = Path(__file__).parents[2] / "golden"
RIG = load_rig("single-axis")
PLANT = plant_numbers.single_axis(RIG)
CARD = AnalogueCard(card_figures(load_design()))
GRID = plant_numbers.valve_grid("ddv-27a1")
# Both integrate the same equations by the same steps and locate the same events; rounding grows
# with the 100 or so events of a run.
ROUNDING = 1e-9


def neutral_run(time, command, state, law):
    servo = Servo(PLANT, NEUTRAL, law)
    inputs = servo_inputs(time, PLANT.supply_pressure, command=command)
    start = servo_state(state, servo, PLANT.supply_pressure)
    return run_servo(inputs, start, servo, GRID, 20e-6)


def assert_same(found, expected, tolerance):
    for name in ("displacement", "velocity", "pressure_a", "pressure_b", "spool"):
        place = OUTPUTS.index(name)
        one, other = found[:, place], expected[:, place]
        assert np.abs(one - other).max() < tolerance * np.ptp(other), name


@pytest.mark.parametrize(
    "law",
    [
        OPEN_LOOP,
        SlidingMode(boundary_layer=5.0).law(RIG),
        AnalogueCard(card_figures(load_design())).law(RIG),
    ],
    ids=["open loop", "boundary layer", "card"],
)
def test_it_runs_like_the_baseline(law):
    time = np.arange(0.0, 0.5, 1e-3)
    values = np.random.default_rng(0).uniform(-5.0, 5.0, 25)
    if law is not OPEN_LOOP:
        values = 0.015 + 2e-3 * values
    command = np.repeat(values, 20)
    state = InitialState().state(PLANT, 0.015, 0.0)
    found = neutral_run(time, command, state, law)
    # The card's states follow those of the plant in both.
    start = servo_state(state, Servo(PLANT, NEUTRAL, law), 0.0)[:STATES_WITH_CARD]
    inputs = np.column_stack((command, np.zeros_like(command)))
    expected = run(time, inputs, start, law, PLANT, GRID, 20e-6)
    assert_same(found, expected, ROUNDING)


def test_more_states_change_nothing():
    time = np.arange(0.0, 0.2, 1e-3)
    command = 3.0 * np.sign(np.sin(60.0 * time))
    state = InitialState().state(PLANT, 0.015, 0.0)
    servo = Servo(PLANT, NEUTRAL, OPEN_LOOP)
    inputs = servo_inputs(time, PLANT.supply_pressure, command=command)
    # Whatever the other states are: 300 is a possible temperature, and nothing else is used.
    long = np.concatenate([state, np.full(SERVO_STATES - len(state), 300.0)])
    runs = [run_servo(inputs, start, servo, GRID, 20e-6) for start in (state, long)]
    assert_same(runs[1], runs[0], ROUNDING)


@pytest.mark.parametrize("name", ["open-loop", "open-loop-stops"])
def test_it_follows_the_golden_files(name):
    golden = pandas.read_csv(GOLDEN / f"{name}.csv.xz")
    start = InitialState(
        **{
            key: float(golden[key][0])
            for key in ("displacement", "velocity", "pressure_a", "pressure_b", "spool")
        }
    )
    result = simulate(
        time=golden["time"].to_numpy(),
        command=golden["valve_voltage"].to_numpy(),
        supply_pressure=PLANT.supply_pressure,
        initial=start,
    )
    for key in ("displacement", "velocity", "pressure_a", "pressure_b", "spool"):
        # As tests/golden: 1e-4 is asked, steps of 20 us over the kinks of the tables cost 3e-6.
        assert np.abs(result[key] - golden[key]).max() < 1e-5 * np.ptp(golden[key]), key


def test_fourth_order_on_a_smooth_stretch():
    # One discharge coefficient, one direction, one side of the critical ratio: no kinks.
    grid = np.full((4, 51, 101), 0.7)
    start = np.array([0.012, 0.05, 4.6e5, 5.5e5, 0.3, 0.0])
    time = np.array([0.0, 0.02])
    servo = Servo(PLANT, NEUTRAL, OPEN_LOOP)
    inputs = servo_inputs(time, PLANT.supply_pressure, command=2.0)

    def end(step):
        return run_servo(inputs, start, servo, grid, step)[-1, 3]

    errors = [abs(end(step) - end(5e-6)) for step in (1e-3, 0.5e-3, 0.25e-3)]
    orders = np.log2(errors[:-1]) - np.log2(errors[1:])
    # Fifth-order terms still show at 1 ms, a tenth of the fastest period.
    assert orders == pytest.approx([4.0, 4.0], abs=0.3), errors
