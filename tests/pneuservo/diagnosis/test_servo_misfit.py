"""What is left of a servo and is no noise: told from noise, hum, chatter and what moves."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from pneuservo.diagnosis.models.servo.feed import AT_REST
from pneuservo.diagnosis.models.servo.misfit import misfit_of
from pneuservo.rigs import load_rig

SAMPLES = 10000
TIME = np.arange(SAMPLES) * 1e-3
CHANNELS = ("displacement", "pressure_a", "pressure_b", "supply_pressure")
RIG = load_rig("single-axis")
SEEDS = range(5)


def line(frequency, size=1.0):
    return size * np.sin(2.0 * np.pi * frequency * TIME + 0.3)


def feed_of(voltage, moments_of_rest=None, displacement_noise=1e-6):
    """Return a feed of a piston in the middle, both chambers at 4 bar."""
    samples = len(voltage)
    return SimpleNamespace(
        voltage=voltage,
        interval=1e-3,
        moments_of_rest=moments_of_rest,
        breaks_away=np.empty(0, dtype=int),
        pressures=np.full((2, samples), 4e5),
        motion=np.full((3, samples), 0.5 * RIG["piston.stroke"]),
        noise={"displacement": displacement_noise, "pressure_a": 200.0, "pressure_b": 200.0},
    )


def case_of(feed, channel, usable, recorded=True):
    return SimpleNamespace(
        inputs={"feed": feed}, recorded=recorded, channel=channel, usable=usable, rig=RIG
    )


def misfit(
    seed, adds, command=0.0, at_rest=None, recordings=2, samples=SAMPLES, displacement_noise=1e-6
):
    """Return what is found in white noise with something added to some channels."""
    rng = np.random.default_rng(seed)
    cases, residuals = [], []
    for _ in range(recordings):
        voltage = (command + 0.01 * rng.standard_normal(SAMPLES))[:samples]
        # Ten rests, each judged at three moments.
        moments = np.full(samples, 3.0)
        feed = feed_of(voltage, moments, displacement_noise)
        for channel in CHANNELS:
            cases.append(case_of(feed, channel, np.ones(samples, dtype=bool)))
            residuals.append((rng.standard_normal(SAMPLES) + adds.get(channel, 0.0))[:samples])
        if at_rest is not None:
            cases.append(case_of(feed, AT_REST, np.arange(samples) < 30, recorded=False))
            residuals.append(at_rest / np.sqrt(3.0) * np.ones(30))
    return misfit_of(cases, residuals)


@pytest.mark.parametrize("seed", SEEDS)
def test_noise_is_no_misfit(seed):
    assert misfit(seed, {}, at_rest=0.9) is None


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("samples", [1000, SAMPLES])
@pytest.mark.parametrize("pole", [0.9, 0.99])
def test_neither_is_noise_of_a_transducer_that_is_not_white(seed, pole, samples):
    drive = np.random.default_rng(100 + seed).standard_normal((2, SAMPLES))
    coloured = 2.0 * np.sqrt(1.0 - pole**2) * lfilter([1.0], [1.0, -pole], drive)
    adds = {"pressure_a": coloured[0], "pressure_b": coloured[1]}
    assert misfit(seed, adds, samples=samples) is None


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("channel", "words"), [("pressure_a", "pressure a"), ("pressure_b", "pressure b")]
)
def test_a_line_in_one_reading_is_that_of_its_transducer(seed, channel, words):
    found = misfit(seed, {channel: line(37.3)})
    assert found.block == "sensor.pressure"
    assert words in found.words
    assert "37.3 Hz" in found.words
    # Half of the squared amplitude at each sample of both recordings.
    assert found.energy == pytest.approx(SAMPLES, rel=0.1)


@pytest.mark.parametrize(("size", "found"), [(0.4, True), (0.0, False)])
def test_it_may_be_weaker_in_one_of_the_recordings(size, found):
    # Seen in the second at once; in the first with 400 times the power beside it, or not at all.
    rng = np.random.default_rng(1)
    cases, residuals = [], []
    for adds in (line(1.7, size), line(1.7, 2.0)):
        feed = feed_of(0.01 * rng.standard_normal(SAMPLES))
        for channel in CHANNELS:
            cases.append(case_of(feed, channel, np.ones(SAMPLES, dtype=bool)))
            here = adds if channel == "pressure_a" else 0.0
            residuals.append(rng.standard_normal(SAMPLES) + here)
    told = misfit_of(cases, residuals)
    assert (told is not None and told.block == "sensor.pressure") == found


@pytest.mark.parametrize("frequency", [50.0, 59.8, 150.0, 299.5])
def test_the_mains_are_no_misfit(frequency):
    assert misfit(1, {"pressure_a": line(frequency)}) is None


def test_neither_is_what_the_command_swings_with():
    assert misfit(1, {"pressure_a": line(3.7)}, command=line(3.7)) is None


@pytest.mark.parametrize("multiple", [1, 2, 3])
def test_neither_is_how_a_periodic_command_is_bent(multiple):
    bent = {"pressure_a": line(1.3 * multiple)}
    assert misfit(1, bent, command=5.0 + line(1.3)) is None
    # Between two multiples it is no answer to the command.
    assert misfit(1, {"pressure_a": line(1.3 * multiple + 0.6)}, command=line(1.3)) is not None


def test_a_channel_without_anything_left_says_nothing():
    rng = np.random.default_rng(1)
    feed = feed_of(rng.standard_normal(SAMPLES))
    usable = np.ones(SAMPLES, dtype=bool)
    cases = [case_of(feed, channel, usable) for channel in ("pressure_a", "pressure_b")]
    assert misfit_of(cases, [np.zeros(SAMPLES), rng.standard_normal(SAMPLES)]) is None


def test_a_line_that_several_channels_have_is_of_no_transducer():
    adds = {channel: line(37.3, 0.6) for channel in CHANNELS}
    assert misfit(1, adds) is None


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("size", [1.5, 0.7])
def test_pressures_that_swing_together_are_pushed_by_something(seed, size):
    drive = np.random.default_rng(200 + seed).standard_normal(SAMPLES)
    slow = lfilter([1.0], [1.0, -0.98], drive)
    slow *= size / np.std(slow)
    found = misfit(seed, {"pressure_a": slow, "pressure_b": -slow, "displacement": slow})
    assert found.block == "load"
    assert "pressure a and the pressure b swing" in found.words


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("displacement_noise", "told"), [(2e-6, True), (2e-5, False)])
def test_pressures_swing_with_a_motion_that_is_lost_in_its_noise(seed, displacement_noise, told):
    # 20 um raise a chamber's pressure by 600 Pa, three times its noise.
    drive = np.random.default_rng(400 + seed).standard_normal(SAMPLES)
    slow = lfilter([1.0], [1.0, -0.98], drive)
    slow *= 0.5 / np.std(slow)
    adds = {"pressure_a": slow, "pressure_b": -slow}
    found = misfit(seed, adds, displacement_noise=displacement_noise)
    assert (found is not None) == told


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("size", "found"), [(1.5, True), (0.3, False)])
def test_a_supply_that_swings_by_itself_is_told(seed, size, found):
    drive = np.random.default_rng(300 + seed).standard_normal(SAMPLES)
    slow = lfilter([1.0], [1.0, -0.98], drive)
    told = misfit(seed, {"supply_pressure": slow * size / np.std(slow)})
    assert (told is not None) == found
    assert not found or told.block == "supply"


def test_a_piston_that_rests_under_more_than_friction_holds_is_pushed_by_something():
    found = misfit(1, {}, at_rest=5.0)
    assert found.block == "load"
    assert found.energy == pytest.approx(2 * 10 * 25.0)
