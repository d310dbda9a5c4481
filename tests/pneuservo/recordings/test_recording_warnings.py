"""What can be used is used, and the recording says what was found; what is sound stays quiet."""

import numpy as np
import pytest

from pneuservo.recordings import read_recording
from pneuservo.recordings.channels import CHANNELS
from pneuservo.recordings.sample_checks import check_samples

COUNT = 2000
TIME = np.arange(COUNT) * 1e-3
RNG = np.random.default_rng(7)
NOISE = RNG.normal(0.0, 0.03, COUNT)  # mm
SINE = 15.0 + 9.0 * np.sin(2.0 * np.pi * 2.0 * TIME)  # mm, four periods
NOISY = SINE + NOISE


def warnings_about(recording, word):
    return [text for text in recording.warnings if word in text]


def test_a_sound_recording_has_no_warnings(save_columns):
    assert read_recording(save_columns(TIME, NOISY)).warnings == ()
    assert read_recording(save_columns(TIME, SINE)).warnings == ()


def test_gaps_are_counted_and_the_longest_is_found(save_columns):
    keep = np.ones(COUNT, dtype=bool)
    keep[500:510] = keep[1200:1250] = False
    recording = read_recording(save_columns(TIME[keep], NOISY[keep]))
    assert len(recording) == COUNT - 60
    # The longest runs from sample 1199 to 1250.
    assert recording.warnings == (
        "2 gaps in the time, the longest of 0.051 s after 1.199 s (the usual step is 0.001 s)",
    )


def test_a_step_of_three_times_the_usual_is_no_gap_yet(save_columns):
    keep = np.ones(COUNT, dtype=bool)
    keep[500:502] = False
    assert not warnings_about(read_recording(save_columns(TIME[keep], NOISY[keep])), "gap")


def test_jitter_is_measured(save_columns):
    jittered = TIME + RNG.normal(0.0, 1e-4, COUNT).clip(-3e-4, 3e-4)
    (text,) = read_recording(save_columns(jittered, NOISY)).warnings
    # A step is the difference of two independent deviations: 0.1 ms times the root of two.
    assert "the time step varies by 0.00014 s rms" in text


def test_rounding_of_the_time_stamps_is_no_jitter(save_columns):
    # Rounded to 1 us of a step of 1 ms: 0.03 % rms.
    assert read_recording(save_columns(np.round(TIME * 1.0003, 6), NOISY)).warnings == ()


def test_repeated_time_stamps_leave_the_first_sample(save_columns):
    time = np.insert(TIME, [100, 700, 700], [TIME[99], TIME[699], TIME[699]])
    samples = np.insert(NOISY, [100, 700, 700], [99.0, 99.0, 99.0])
    recording = read_recording(save_columns(time, samples))
    assert np.array_equal(recording["displacement"], NOISY * 0.001)
    # The header is line 1, sample 100 in the file line 102.
    assert recording.warnings == (
        "3 samples with a repeated time stamp were left out, the first at line 102",
    )


def test_samples_without_a_time_are_left_out(save):
    rows = [f"{i},{i * i}" for i in range(20)]
    rows[5] = ",25"
    recording = read_recording(save("\n".join(["time,force", *rows, ""])))
    assert len(recording) == 19
    assert "1 sample without a time was left out, the first at line 7" in recording.warnings


def test_isolated_missing_samples_are_interpolated_and_long_runs_stay(save_columns):
    samples = NOISY.copy()
    samples[10] = samples[500:503] = np.nan
    samples[800:804] = np.nan
    samples[0] = samples[-2:] = np.nan
    recording = read_recording(save_columns(TIME, samples))
    displacement = recording["displacement"]
    assert displacement[10] == pytest.approx(0.0005 * (NOISY[9] + NOISY[11]), rel=1e-12)
    assert displacement[502] == pytest.approx(
        0.001 * (0.25 * NOISY[499] + 0.75 * NOISY[503]), rel=1e-12
    )
    assert np.array_equal(np.flatnonzero(np.isnan(displacement)), [0, *range(800, 804), 1998, 1999])
    assert recording.warnings == (
        "displacement: 4 missing samples were interpolated",
        "displacement: 7 samples are missing",
    )


@pytest.mark.parametrize("samples", [SINE, NOISY])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_clipped_samples_are_counted(save_columns, samples, sign):
    clipped = sign * np.minimum(samples, 22.0)
    count = np.count_nonzero(samples > 22.0)
    recording = read_recording(save_columns(TIME, clipped))
    (text,) = warnings_about(recording, "clipped")
    which, value = ("highest", "0.022 m") if sign > 0 else ("lowest", "-0.022 m")
    assert f"clipped or at a stop at its {which} value, {value}" in text
    found = int(text.split()[1])
    # Noise near the limit makes some stretches shorter than the five samples that count.
    assert 0.9 * count <= found <= count


def test_a_clipped_channel_that_is_quantised_is_found(save_columns):
    coarse = np.round(np.minimum(NOISY, 22.0) / 0.05) * 0.05
    assert warnings_about(read_recording(save_columns(TIME, coarse)), "clipped")


def test_a_channel_that_ends_clipped_is_found(save_columns):
    ramp = np.minimum(20.0 * TIME + NOISE, 30.0)
    assert warnings_about(read_recording(save_columns(TIME, ramp)), "stop at its highest")


STILL = np.where(
    TIME < 0.5, 15.0, 15.0 + 9.0 * (1.0 - np.exp(-(((TIME - 0.5).clip(0) / 0.05) ** 2)))
)


# Slowed down evenly from 48 mm/s, as by friction alone, then stuck, then away again likewise.
STUCK = 15.0 - 30.0 * (np.abs(TIME - 1.0) - 0.2).clip(0.0) ** 2


@pytest.mark.parametrize(
    "samples",
    [
        pytest.param(STUCK, id="stuck for a while"),
        pytest.param(np.round(STUCK, 3), id="stuck for a while in steps of 1 um"),
        pytest.param(np.full(COUNT, 15.0), id="constant"),
        pytest.param(STILL, id="a rest, a move and a rest without noise"),
        pytest.param(np.round(STILL, 2), id="the same in steps of 0.01 mm"),
        pytest.param(np.round(SINE, 1), id="a rounded peak in steps of 0.1 mm"),
        pytest.param(np.round(SINE, 2), id="a rounded peak in steps of 0.01 mm"),
        pytest.param(np.round(NOISY, 2), id="noise in steps of 0.01 mm"),
        pytest.param(np.where(SINE > 15.0, 24.0, 15.0), id="switched"),
    ],
)
def test_holds_and_rounded_peaks_are_not_clipped(save_columns, samples):
    assert not warnings_about(read_recording(save_columns(TIME, samples)), "clipped")


def test_a_command_at_its_limit_is_not_clipped():
    saturated = np.clip(SINE - 15.0 + NOISE, -5.0, 5.0)
    assert check_samples(saturated, CHANNELS["valve_voltage"]) == []
    assert len(check_samples(saturated, CHANNELS["force"])) == 2


def test_quantisation_is_measured(save_columns):
    step = 18.6 / 2**8
    recording = read_recording(save_columns(TIME, np.round(NOISY / step) * step))
    (text,) = recording.warnings
    # 18.6 mm is the range of sine and noise: 256 steps of it, but for the rounding at its ends.
    assert "quantised in steps of 7.27e-05 m, 8.0 bits over its range" in text


def test_a_fine_quantisation_is_not_worth_a_word(save_columns):
    assert read_recording(save_columns(TIME, np.round(NOISY, 3))).warnings == ()


def test_an_even_ramp_is_not_quantised(save_columns):
    assert read_recording(save_columns(TIME, np.arange(COUNT) * 0.25)).warnings == ()


def test_a_pressure_that_cannot_be_absolute_is_told(save):
    rows = [f"{i},{float(1000.0 * np.sin(i))!r}" for i in range(40)]
    recording = read_recording(save("\n".join(["time,pressure_a", *rows, ""])))
    (text,) = recording.warnings
    assert "Pa absolute, which cannot be" in text
    assert "gauge = true" in text
