"""Recordings that say next to nothing still get an answer, never a failure of arithmetic."""

import json

import numpy as np
import pytest

from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.dead_volume import DeadVolumeModel
from pneuservo.recordings import Recording
from pneuservo.report.page import diagnosis_page
from pneuservo.rigs import load_rig

pytestmark = pytest.mark.filterwarnings("error::RuntimeWarning")
COUNTS = (16, 40, 200)


def answered(rig, **channels):
    time = np.arange(len(next(iter(channels.values())))) * 0.1
    found = diagnose([Recording("thin", time, channels, rig)])
    answer = document(found)
    json.dumps(answer, allow_nan=False)
    assert "<svg" in diagnosis_page(found, answer)
    return answer["verdict"]


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("noise", [0.0, 200.0], ids=["exactly constant", "noisy"])
@pytest.mark.parametrize("level", [5e5, 0.5e5], ids=["above ambient", "below ambient"])
def test_a_tight_volume(count, noise, level):
    pressure = level + noise * np.random.default_rng(count).standard_normal(count)
    assert answered("dead-volume", dead_volume_pressure=pressure) == "consistent"


@pytest.mark.parametrize("count", COUNTS)
def test_missing_samples(count):
    pressure = 5e5 + 200.0 * np.random.default_rng(count).standard_normal(count)
    pressure[3:9] = np.nan
    assert answered("dead-volume", dead_volume_pressure=pressure) == "consistent"


def test_a_recording_that_begins_with_missing_samples():
    pressure = 5e5 + 200.0 * np.random.default_rng(1).standard_normal(200)
    pressure[:7] = np.nan
    assert answered("dead-volume", dead_volume_pressure=pressure) == "consistent"


def test_a_command_that_is_missing_stays_as_it_was():
    time = np.arange(200) * 0.01
    volts = np.full(200, 5.0)
    volts[[0, 1, *range(50, 60)]] = np.nan
    channels = {"dead_volume_pressure": 5e5 + time, "valve_voltage": volts}
    model = DeadVolumeModel()
    case = model.prepare(
        Recording("filled", time, channels, "dead-volume"), load_rig("dead-volume")
    )
    assert np.all(case.inputs["opening"] == 1.0)


@pytest.mark.parametrize("count", COUNTS)
def test_a_pressure_that_rises_is_no_leak(count):
    pressure = 1.1e5 + 4e5 * (1.0 - np.exp(-np.arange(count) * 0.1 / 3.0))
    assert answered("dead-volume", dead_volume_pressure=pressure) == "unexplained"


@pytest.mark.parametrize("count", COUNTS)
def test_a_piston_that_never_moves(count):
    verdict = answered(
        "seal-tester",
        displacement=np.full(count, 0.02),
        pressure_a=np.full(count, 3e5),
        force=np.full(count, 100.0),
    )
    assert verdict == "consistent"


@pytest.mark.parametrize("count", COUNTS)
def test_a_dead_circuit(count):
    silence = np.zeros(count)
    assert answered("circuit", circuit_input=silence, circuit_output=silence) == "consistent"


@pytest.mark.parametrize("count", COUNTS)
def test_an_output_that_has_nothing_to_do_with_the_input(count):
    rng = np.random.default_rng(count)
    verdict = answered(
        "circuit",
        circuit_input=rng.standard_normal(count),
        circuit_output=rng.standard_normal(count),
    )
    # White noise is what a linear circuit with next to no gain leaves.
    assert verdict == "consistent"
