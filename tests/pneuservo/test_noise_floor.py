"""Noise floor, effective samples and surrogates against what is known of random series."""

import numpy as np
import pytest
from scipy.signal import lfilter

from pneuservo.noise import effective_samples, noise_floor, noise_level, surrogate


def autoregressive(coefficient, samples, seed):
    """Series of unit variance whose neighbours correlate by the coefficient."""
    shocks = np.random.default_rng(seed).standard_normal(samples + 500)
    return np.sqrt(1.0 - coefficient**2) * lfilter([1.0], [1.0, -coefficient], shocks)[500:]


@pytest.mark.parametrize("seed", range(4))
def test_white_noise_is_recovered(seed):
    time = np.arange(20000) * 1e-3
    noise = 0.3 * np.random.default_rng(seed).standard_normal(len(time))
    # 155 windows of 256 and some 12 frequencies per band, both about half as many when the
    # overlap of windows and of Blackman's lobes counts: 900 independent values, 3.3 % of power,
    # 1.7 % of rms. The lowest of eight bands lies 1.4 of these below, 4 at most: -7 to +1.7 %.
    assert 0.93 * 0.3 < noise_floor(noise, time) < 1.02 * 0.3


@pytest.mark.parametrize("samples", [500, 2000, 10_000])
def test_white_noise_is_known_without_bias(samples):
    rng, time = np.random.default_rng(samples), np.arange(samples) * 1e-3
    found = [noise_level(rng.standard_normal(samples), time) ** 2 for _ in range(100)]
    # The lowest of eight bands alone is too low by 31, 16 and 7 % of the power.
    assert np.mean(found) == pytest.approx(1.0, abs=4.0 * np.std(found) / 10.0)
    assert np.mean(found) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("rate", [10.0, 600.0])
def test_the_unit_of_time_does_not_matter(rate):
    noise = np.random.default_rng(0).standard_normal(4000)
    assert noise_floor(noise, np.arange(4000) / rate) == pytest.approx(
        noise_floor(noise, np.arange(4000)), rel=1e-9
    )


def test_slow_signals_do_not_count_as_noise():
    time = np.arange(20000) * 1e-3
    noise = 0.01 * np.random.default_rng(1).standard_normal(len(time))
    slow = 3.0 * np.sin(7.0 * time) + 50.0 * np.exp(-time / 5.0) - 0.4 * time
    alone = noise_floor(noise, time)
    # A signal 1 % of the noise in power would do; Blackman's side lobes fall below 1e-9.
    assert noise_floor(noise + slow, time) == pytest.approx(alone, rel=0.01)


def test_a_tone_in_one_band_does_not_count_as_noise():
    time = np.arange(20000) * 1e-3
    noise = 0.01 * np.random.default_rng(2).standard_normal(len(time))
    tone = 0.5 * np.sin(2.0 * np.pi * 230.0 * time)
    # The lowest band may have been the one with the tone: then the next is taken.
    assert noise_floor(noise + tone, time) == pytest.approx(0.01, rel=0.08)


def test_missing_samples_are_passed_over():
    time = np.arange(20000) * 1e-3
    noise = np.random.default_rng(3).standard_normal(len(time))
    holes = noise.copy()
    holes[::100] = np.nan
    # One sample in a hundred becomes a mean of two: half its power is gone at most.
    assert noise_floor(holes, time) == pytest.approx(noise_floor(noise, time), rel=0.02)


@pytest.mark.parametrize("coefficient", [0.0, 0.5, 0.8])
def test_correlated_samples_count_less(coefficient):
    samples = 50000
    worth = effective_samples(autoregressive(coefficient, samples, 4))
    expected = samples * (1.0 - coefficient) / (1.0 + coefficient)
    # The sum ends at the first correlation below 0.05, which leaves out at most
    # 2 x 0.05 / (1 - a) of (1 + a)/(1 - a): 6 % for 0.8. Each of the 13 estimates is off by
    # sqrt((1 + a^2)/(1 - a^2)/n) = 1 %, most of them together: 3 % of the sum, three times.
    assert worth == pytest.approx(expected, rel=0.06 + 3 * 0.03)
    assert worth <= samples


def test_a_slow_wave_is_worth_a_handful_of_samples():
    assert effective_samples(np.sin(np.linspace(0.0, 6.0, 5000))) < 10.0


def test_a_constant_residual_is_not_divided_by_zero():
    assert effective_samples(np.full(100, 2.5)) == 100.0


def test_missing_residuals_are_passed_over():
    series = autoregressive(0.8, 5000, 5)
    holes = np.insert(series, 1000, [np.nan] * 30)
    assert effective_samples(holes) == effective_samples(series)


@pytest.mark.parametrize("samples", [999, 1000])
def test_surrogates_keep_the_spectrum_and_nothing_else(samples):
    residual = autoregressive(0.8, samples, 6) + 0.4
    rng = np.random.default_rng(7)
    one, other = surrogate(residual, rng), surrogate(residual, rng)
    # Of an even number of samples the highest frequency has a sign in place of a phase.
    kept = np.abs(np.fft.rfft(residual))[: (samples + 1) // 2]
    for draw in (one, other):
        assert draw.shape == residual.shape
        assert np.abs(np.fft.rfft(draw))[: len(kept)] == pytest.approx(kept, rel=1e-9, abs=1e-9)
    # Without their common mean two draws are as unlike as two series of that many samples.
    likeness = np.corrcoef(one, other)[0, 1]
    assert abs(likeness) < 4.0 / np.sqrt(effective_samples(residual))
