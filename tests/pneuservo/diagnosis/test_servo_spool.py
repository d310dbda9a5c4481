"""The observer's spool goes its own way between the jumps of its command."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.servo.command import held_command, running_command
from pneuservo.diagnosis.models.servo.spool import ENDED, arriving, follow_spool, move_spool
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo.layout import MEMORY, Servo
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.spool_effects import SpoolEffects
from pneuservo.plant.single_axis import PLANT_STATES, SPOOL
from pneuservo.rigs import load_rig, plant_numbers

PLANT = plant_numbers.single_axis(load_rig("single-axis"))
VALVE = PLANT.valve
TIME = np.arange(0.0, 0.02, 1e-3)
JUMP = 0.006


def openings(effects, command):
    """Return where the spool is at every sample."""
    servo = Servo(PLANT, NEUTRAL._replace(spool=effects), OPEN_LOOP)
    moves = follow_spool(TIME, command, np.ones(len(TIME), np.int64), 0.0, servo)
    return np.append(0.0, moves[:, ENDED])


def step_response(time):
    """Return the reply of a spool of the second order to a step at zero, by its formula."""
    w, damping = VALVE.spool_frequency, VALVE.spool_damping
    swing = w * np.sqrt(1.0 - damping**2)
    t = np.maximum(time, 0.0)
    left = np.exp(-damping * w * t)
    return 1.0 - left * (np.cos(swing * t) + damping * w / swing * np.sin(swing * t))


@pytest.mark.parametrize(("start", "until"), [(-0.3, 1e-3), (-0.3, 0.3e-3), (0.2, 1e-3)])
def test_what_it_opens_is_known_before_and_after_its_null(start, until):
    servo = Servo(PLANT, NEUTRAL, OPEN_LOOP)
    state, memory = np.zeros(PLANT_STATES), np.zeros(MEMORY)
    state[SPOOL] = start
    command = held_command(np.full_like(TIME, 4.0))
    opened, crossed, before = move_spool(state, memory, TIME, command, 0, 0.0, until, 0.0, servo)
    time = np.linspace(0.0, until, 100_001)
    place = start + (4.0 / VALVE.full_voltage - start) * step_response(time)
    assert opened == pytest.approx(np.trapezoid(place, time), abs=1e-8)
    if start * place[-1] > 0.0:
        assert crossed == np.inf
        return
    null = int(np.argmax(place > 0.0))
    assert crossed == pytest.approx(time[null], abs=5e-6)
    assert before == pytest.approx(np.trapezoid(place[:null], time[:null]), abs=1e-6)


def test_a_null_at_the_end_of_a_move_divides_nothing():
    servo = Servo(PLANT, NEUTRAL, OPEN_LOOP)
    state, memory = np.zeros(PLANT_STATES), np.zeros(MEMORY)
    state[SPOOL] = -1e-13
    command = held_command(np.ones_like(TIME))
    moved = move_spool(state, memory, TIME, command, 0, 0.0, 1e-3, 0.0, servo)
    assert state[SPOOL] > 0.0
    assert moved[1] == np.inf


@pytest.mark.parametrize("delay", [0.0, 0.4e-3, 3.7e-3])
def test_a_step_arrives_when_its_delay_has_passed(delay):
    voltage = np.where(TIME > JUMP - 1e-9, 2.0, 0.0)
    found = openings(SpoolEffects(delay=delay), held_command(voltage))
    expected = 2.0 / VALVE.full_voltage * step_response(TIME - JUMP - delay)
    assert found == pytest.approx(expected, abs=1e-5)


def test_a_delayed_ramp_is_a_ramp_that_began_later():
    delay, slope = 1.3e-3, 100.0
    voltage = slope * TIME
    running = running_command(TIME, voltage, VALVE.full_voltage)
    found = openings(SpoolEffects(delay=delay), running)
    lag = 2.0 * VALVE.spool_damping / VALVE.spool_frequency
    settled = TIME > 0.012
    expected = slope / VALVE.full_voltage * (TIME - delay - lag)
    assert found[settled] == pytest.approx(expected[settled], abs=1e-5)


def test_before_the_first_sample_the_command_has_stood():
    command = held_command(np.full(len(TIME), 3.0))
    assert arriving(TIME, command, 0, -1.0) == (3.0, 0.0, 0.0)
    assert openings(SpoolEffects(delay=5e-3), command)[1] > 0.1


def test_the_far_end_of_the_travel_holds_it():
    found = openings(SpoolEffects(extending_stop_loss=0.3), held_command(np.full(len(TIME), 5.0)))
    assert found.max() == found[-1] == pytest.approx(0.7)


def test_a_spool_with_dry_friction_rests_within_it():
    share = 0.02
    voltage = np.where(TIME > JUMP - 1e-9, 2.0, 0.0)
    found = openings(SpoolEffects(stiction=share), held_command(voltage))
    assert found[-1] == found[-2]
    assert abs(found[-1] - 0.4) <= share


def test_hardly_reaching_the_end_is_hardly_more_than_all_but_reaching_it():
    damping = VALVE.spool_damping
    overshoot = np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2))
    grazing = VALVE.full_voltage / (1.0 + overshoot)
    inside, beyond = (
        openings(SpoolEffects(), held_command(np.full(len(TIME), level * grazing)))
        for level in (1.0 - 1e-8, 1.0 + 1e-8)
    )
    # It rests there some microseconds: it comes back by so much later.
    assert np.abs(inside - beyond).max() < 1e-4
    hit = openings(SpoolEffects(), held_command(np.full(len(TIME), 1.02 * grazing)))
    free = 1.02 * grazing / VALVE.full_voltage * step_response(TIME)
    assert free.max() > 1.0 >= hit.max()
    assert np.abs(hit - free).max() > 1e-3
