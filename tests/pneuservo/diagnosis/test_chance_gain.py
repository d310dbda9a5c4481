"""How much seems explained when there is only noise, against chi-square quantiles."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import chi2

from pneuservo.diagnosis.chance import chance_gain

SAMPLES = 4000
TIME = np.linspace(0.0, 1.0, SAMPLES)
# The 95 % point of 100 draws is off by sqrt(0.05 x 0.95 / 100) / density: 0.7 where the
# chi-square density is 0.03 (one direction), 0.9 at 0.024 (twenty). Three times that.
ONE, TWENTY = 2.2, 2.7


def columns(*series):
    return np.column_stack(series)


MEAN = columns(np.ones(SAMPLES))


def waves(count, fastest=200):
    frequencies = np.linspace(3, fastest, count).round()
    return [np.sin(2.0 * np.pi * f * TIME) for f in frequencies]


def white(seed=0, rms=1.0):
    return rms * np.random.default_rng(seed).standard_normal(SAMPLES)


def test_one_parameter_gains_what_chi_square_says():
    # A random direction meets many frequencies, so that each draw is one Gaussian number.
    gain = chance_gain(MEAN, [columns(white(1))], [white(rms=0.5)]) / 0.25
    assert gain == pytest.approx(chi2.ppf(0.95, 1), abs=ONE)


def test_two_parameters_gain_more():
    gain = chance_gain(MEAN, [columns(white(1), white(2))], [white()])
    # The density of two degrees of freedom is 0.025 there.
    assert gain == pytest.approx(chi2.ppf(0.95, 2), abs=TWENTY)


def test_the_best_of_many_candidates_gains_more():
    candidates = [columns(white(seed)) for seed in range(20, 40)]
    gain = chance_gain(MEAN, candidates, [white()])
    assert gain == pytest.approx(chi2.ppf(0.95 ** (1 / 20), 1), abs=TWENTY)


def test_serial_correlation_counts():
    coefficient = 0.8
    noise = np.sqrt(1.0 - coefficient**2) * lfilter([1.0], [1.0, -coefficient], white(3))
    slow = columns(np.exp(-(((TIME - 0.5) / 0.02) ** 2)))
    # A bump over 80 samples meets the power at frequency 0, (1 + a)/(1 - a) times the mean. That
    # power itself is an estimate over the bump's twenty or so frequencies.
    ratio = chance_gain(MEAN, [slow], [noise]) / chance_gain(MEAN, [slow], [white(4)])
    assert ratio == pytest.approx(9.0, rel=0.6)


def test_what_a_refit_absorbs_gains_nothing():
    known = waves(3)
    combination = known[0] - 2.0 * known[1] + 0.5 * known[2]
    assert chance_gain(columns(*known), [columns(combination)], [white()]) == 0.0
    half_known = known[0] + waves(5)[1]
    assert chance_gain(columns(*known), [columns(half_known)], [white()]) > 0.0


def test_the_scale_of_a_sensitivity_does_not_matter():
    candidate = columns(white(5), waves(1)[0])
    once = chance_gain(MEAN, [candidate], [white()])
    scaled = chance_gain(MEAN, [candidate * [1e-6, 1e6]], [white()])
    assert scaled == pytest.approx(once, rel=1e-6)


def test_dead_columns_are_no_obstacle():
    dead = np.zeros(SAMPLES)
    once = chance_gain(MEAN, [columns(white(6))], [white()])
    assert chance_gain(
        columns(np.ones(SAMPLES), dead), [columns(white(6), dead)], [white()]
    ) == pytest.approx(once, rel=1e-9)
    assert chance_gain(MEAN, [columns(dead)], [white()]) == 0.0
    assert chance_gain(MEAN, [], [white()]) == 0.0


def test_recordings_draw_their_noise_apart():
    quiet, loud = white(7, 0.1)[:2000], white(8, 10.0)[:2000]
    in_the_quiet_one = columns(np.r_[white(9)[:2000], np.zeros(2000)])
    mean_of_the_loud_one = columns(np.r_[np.zeros(2000), np.ones(2000)])
    gain = chance_gain(mean_of_the_loud_one, [in_the_quiet_one], [quiet, loud])
    assert gain / 0.01 == pytest.approx(chi2.ppf(0.95, 1), abs=ONE)


def test_a_seed_gives_one_answer():
    arguments = MEAN, [columns(white(1))], [white()]
    assert chance_gain(*arguments, seed=3) == chance_gain(*arguments, seed=3)
    assert chance_gain(*arguments, seed=3) != chance_gain(*arguments, seed=4)
