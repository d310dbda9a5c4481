"""Hum that a model follows in part is found as large as it is."""

import numpy as np
import pytest

from pneuservo.diagnosis.hum import hum_behind, hum_in

TIME = np.arange(0.0, 8.0, 1e-3)
SHOWN = 0.15 * np.exp(0.8j)


def line(size):
    """Return a line at 50 Hz of a complex size."""
    return (size * np.exp(2j * np.pi * 50.0 * TIME)).real


@pytest.mark.parametrize("seed", range(3))
def test_what_a_model_follows_late_is_found_in_three_passes(seed):
    rng = np.random.default_rng(seed)
    left, noise = 1.0 + 0.0j, rng.standard_normal(len(TIME))
    wave = np.exp(-2j * np.pi * 50.0 * TIME)
    before = taken = np.zeros_like(TIME)
    for _ in range(3):
        (seen,) = hum_in([noise + line(SHOWN * left)], [np.ones_like(TIME)], TIME)
        taken, before = hum_behind(seen, before, taken), seen
        left -= 2.0 * np.mean(taken * wave)
    # What would be left without: 0.85 to the power of three.
    assert abs(left) < 0.2


def test_another_line_is_taken_as_it_is():
    other = np.sin(2.0 * np.pi * 60.0 * TIME)
    assert np.array_equal(hum_behind(other, line(0.3), line(0.3)), other)
