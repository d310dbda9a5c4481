"""What a command does between its samples."""

from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.diagnosis.models.servo.command import (
    followed_by_spool,
    held_command,
    noise_of_command,
    running_command,
    unseen,
)
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.diagnosis.models.servo.set_point import at_once

INTERVAL = 1e-3
TIME = np.arange(0.0, 0.2, INTERVAL)
FULL = 5.0


def means(command):
    """Return the mean of a command over each interval but the last."""
    return np.trapezoid(command, axis=1)[:-1] / (command.shape[1] - 1)


@pytest.mark.parametrize("phase", [0.0, 0.7, 1.9])
def test_a_swing_at_a_fifth_of_the_sampling_rate_keeps_its_size(phase):
    rate = 2.0 * np.pi * 0.2 / INTERVAL

    def swings(time):
        return np.sin(rate * time + phase)

    true = (np.cos(rate * TIME[:-1] + phase) - np.cos(rate * TIME[1:] + phase)) / (rate * INTERVAL)
    inside = slice(5, -5)
    curved = (means(running_command(TIME, swings(TIME), FULL)) - true)[inside]
    straight = 0.5 * (swings(TIME[1:]) + swings(TIME[:-1]))[inside] - true[inside]
    assert np.std(curved) < 0.025 * np.std(true)
    assert np.std(straight) > 6.0 * np.std(curved)
    # What may be off covers what is off.
    assert np.all(np.abs(curved) < unseen(swings(TIME))[:-1][inside] + 0.03)


def test_it_passes_through_its_samples_and_no_farther_than_the_driver():
    rng = np.random.default_rng(2)
    voltage = np.clip(rng.normal(0.0, 6.0, len(TIME)), -FULL, FULL)
    found = running_command(TIME, voltage, FULL)
    assert found[:, 0] == pytest.approx(voltage)
    assert found[:-1, -1] == pytest.approx(voltage[1:])
    assert np.abs(found).max() == FULL


def test_noise_between_samples_is_not_known_and_chatter_is_no_noise():
    rng = np.random.default_rng(4)
    # A loop that lets the noise of its transducer through, ten times as fast as it is sampled.
    finer = rng.normal(0.0, 0.01, (len(TIME), 10))
    off = means(running_command(TIME, finer[:, 0], FULL)) - finer.mean(axis=1)[:-1]
    assert 1.0 < unseen(finer[:, 0]).mean() / np.std(off) < 2.0
    assert noise_of_command(FULL * np.sign(rng.normal(size=len(TIME)))) == 0.0


def test_it_jumps_with_the_set_point_and_stays_until_then():
    demand = np.where(TIME < 0.05 - 1e-9, 0.010, 0.015)
    voltage = 400.0 * (demand - 0.010) * np.exp(-(TIME - 0.05) / 0.03)
    jump = int(np.argmax(demand > 0.012))
    told = at_once(voltage, demand, gain=0.0)
    known = running_command(TIME, voltage, FULL, told)
    assert np.all(known[jump - 1] == voltage[jump - 1])
    assert known[jump, 0] == voltage[jump]
    assert unseen(voltage, told).max() < 0.01
    # Nobody else knows when in that interval it jumped.
    assert unseen(voltage)[jump - 1] > 0.5 * voltage[jump]


def test_over_a_gap_it_runs_straight():
    time = np.concatenate([TIME[:50], TIME[150:]])
    voltage = 0.5 * np.sin(2.0 * np.pi * 40.0 * time)
    found = running_command(time, voltage, FULL)
    assert found[49] == pytest.approx(np.linspace(voltage[49], voltage[50], found.shape[1]))
    assert np.abs(found).max() < 0.51


def test_a_spool_goes_on_with_what_was_unknown_until_it_has_settled():
    off = np.zeros(12)
    off[3] = 1.0
    mean, at_samples = followed_by_spool(off, INTERVAL, 2.0 * np.pi * 200.0, 0.7)
    # All of it passes the spool, which overshoots; at first nothing has shown.
    assert mean.sum() == pytest.approx(1.0, abs=0.1)
    assert not at_samples[:4].any()
    assert at_samples[4] > mean[3]


def test_finer_samples_are_joined_by_straight_lines():
    fine = np.arange(0.0, 0.01, 1e-4)
    assert running_command(fine, fine, FULL).shape == (len(fine), 2)
    assert held_command(fine)[3].tolist() == [fine[3], fine[3]]


@pytest.mark.parametrize(
    ("command", "stored"),
    [
        pytest.param(np.repeat([0.0, 2.0, -1.0, 3.0, 0.5], 40), True, id="steps from a table"),
        pytest.param(np.repeat([-5.0, 5.0], 100), False, id="an ideal relay"),
        pytest.param(
            np.clip(40.0 * np.sin(np.arange(400) / 30.0), -5.0, 5.0),
            False,
            id="a loop at its limit",
        ),
        pytest.param(np.zeros(100), False, id="no command at all"),
    ],
)
def test_only_steps_from_a_table_count_as_stored(command, stored):
    case = SimpleNamespace(inputs={"feed": SimpleNamespace(voltage=command)})
    assert ServoModel().stored(case) is stored
