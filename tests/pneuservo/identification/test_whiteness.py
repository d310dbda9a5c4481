"""Whether residuals are judged rightly."""

import numpy as np
import pytest

from pneuservo.identification.whiteness import whiteness


def noise(seed, count=1000):
    return np.random.default_rng(seed).standard_normal(count)


def test_white_noise_is_rarely_called_coloured():
    called = sum(not whiteness(noise(seed)).white for seed in range(200))
    # 1 % of 200; more than 7 has a chance of 0.1 %.
    assert called <= 7


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_noise_that_remembers_is_called_coloured(share):
    coloured = noise(1)
    for k in range(1, len(coloured)):
        coloured[k] += share * coloured[k - 1]
    judged = whiteness(coloured)
    assert not judged.white
    # The first autocorrelation of such noise is the share; its error 1/sqrt(1000), three times.
    assert judged.autocorrelation[0] == pytest.approx(share, abs=0.1)
    assert "leaves something out" in judged.sentence()


def test_missing_samples_are_passed_over():
    samples = noise(2)
    samples[::7] = np.nan
    assert whiteness(samples).white


def test_nothing_left_is_white():
    assert whiteness(np.zeros(100)).white
