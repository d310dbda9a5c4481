"""What is missing from a recording is not judged, and does not show in what is."""

from dataclasses import replace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.errors import InputError
from pneuservo.rigs import load_rig

MODEL = ServoModel()
# The set point jumps at sample 1200: the piston moves, and 30 ms earlier it rests.
MOVING, JUMPING, BEGINNING = slice(1203, 1263), slice(1190, 1220), slice(1210, 1240)


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


@pytest.fixture(scope="module")
def run(rig):
    return recorded(rig, Proportional(), 5, duration=2.0)


def beyond_noise(recording, rig):
    """Return the sum of squares beyond noise of each channel, and how many samples are judged."""
    cases = MODEL.cases(MODEL.completed(recording, rig), rig)
    left = {case.channel: (case.measured - MODEL.predict(case, {}))[case.usable] for case in cases}
    return {name: float(np.sum(part**2)) - len(part) for name, part in left.items()}, left


def without(recording, names, part):
    channels = {name: values.copy() for name, values in recording.channels.items()}
    for name in names:
        channels[name][part] = np.nan
    return replace(recording, channels=channels)


@pytest.mark.parametrize("part", [MOVING, JUMPING, BEGINNING, slice(0, 30), slice(1960, 2000)])
@pytest.mark.parametrize("names", [["valve_voltage"], ["displacement"], ["pressure_a"], None])
def test_what_is_missing_does_not_show(run, rig, names, part):
    clean, _ = beyond_noise(run, rig)
    found, left = beyond_noise(without(run, names or list(run.channels), part), rig)
    for name, value in found.items():
        # Their sums of squares scatter by 60; left unmasked, 5 samples were worth 4,000.
        assert value < clean[name] + 120.0, name
        assert np.abs(left[name]).max() < 4.0, name
    # From it on nothing is judged for 60 ms, everything else is.
    assert len(left["pressure_b"]) >= len(run.time) - (part.stop - part.start) - 61


@pytest.mark.parametrize("part", [MOVING, JUMPING])
def test_a_gap_in_time_is_samples_that_are_missing(run, rig, part):
    kept = np.ones(len(run.time), dtype=bool)
    kept[part] = False
    channels = {name: values[kept] for name, values in run.channels.items()}
    gap = replace(run, time=run.time[kept], channels=channels)
    found, _ = beyond_noise(gap, rig)
    missing, _ = beyond_noise(without(run, list(run.channels), part), rig)
    assert found == pytest.approx(missing, rel=0.02, abs=2.0)


def test_more_gap_than_recording_is_refused(run, rig):
    late = replace(run, time=run.time + np.where(run.time < 1.0, 0.0, 10.0))
    with pytest.raises(InputError, match=r"0\.999 to 11"):
        MODEL.completed(late, rig)


def test_gaps_raise_no_alarm(rig):
    # Closed by straight lines, the pressures at the beginning of a move were friction at low speed.
    run = recorded(rig, Proportional(), 5, duration=3.0)
    kept = np.ones(len(run.time), dtype=bool)
    kept[2010:2040] = kept[1203:1263] = False
    channels = {name: values[kept] for name, values in run.channels.items()}
    gappy = without(
        replace(run, time=run.time[kept], channels=channels), ["pressure_a"], slice(810, 840)
    )
    found = diagnose([gappy])
    assert found.verdict == "consistent", document(found)["missing"]
