"""Mains hum: nothing is made of readings that are missing in a pattern."""

import numpy as np
import pytest

from pneuservo.diagnosis.hum import hum_in

SAMPLES = 4000
TIME = np.arange(SAMPLES) * 1e-3


@pytest.mark.parametrize("first", range(5))
def test_a_channel_read_every_fifth_time_has_no_line_of_noise(first):
    # At twice the mains sine and cosine are one wave on these samples.
    seen = (np.arange(SAMPLES) % 5 == first).astype(float)
    noise = seen * np.random.default_rng(first).standard_normal(SAMPLES)
    assert not np.any(hum_in([noise], [seen], TIME)[0])


@pytest.mark.filterwarnings("error")
def test_a_recording_too_short_to_tell_a_line_has_none():
    short = TIME[:30]
    line = np.sin(2.0 * np.pi * 50.0 * short)
    assert not np.any(hum_in([line], [np.ones(len(short))], short)[0])


@pytest.mark.parametrize("seed", range(5))
def test_what_comes_back_with_every_step_of_a_command_is_no_hum(seed):
    # Every 0.4 s, whose multiples of 2.5 Hz fall on both mains.
    rng = np.random.default_rng(seed)
    left = 3.0 * np.exp(-np.mod(TIME, 0.4) / 2e-3) + rng.standard_normal(SAMPLES)
    hum = np.cos(2.0 * np.pi * 50.03 * TIME)
    assert not np.any(hum_in([left], [np.ones(SAMPLES)], TIME)[0])
    found = hum_in([left + hum], [np.ones(SAMPLES)], TIME)[0]
    assert np.std(found - hum) < 0.2
