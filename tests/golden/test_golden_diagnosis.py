"""The diagnosis on the golden dead volumes: made by an independent implementation."""

from pathlib import Path

import numpy as np
import pandas
import pytest

from pneuservo.diagnosis import diagnose, document
from pneuservo.recordings import Recording

FOLDER = Path(__file__).parent
FILES = sorted(FOLDER.glob("dead-volume-*.csv.xz"))
NOISE = 300.0
VOLUME = 50e-6


def recording(path: Path, believed_volume: float) -> Recording:
    # Every fifth sample: 200 Hz resolve the fastest charge, 0.1 s.
    table = pandas.read_csv(path)[::5]
    noise = NOISE * np.random.default_rng(len(path.name)).standard_normal(len(table))
    return Recording(
        path.name.removesuffix(".csv.xz"),
        table["time"].to_numpy(),
        {
            "valve_voltage": table["valve_voltage"].to_numpy(),
            "dead_volume_pressure": table["dead_volume_pressure"].to_numpy() + noise,
        },
        "dead-volume",
        conditions={"dead_volume_volume": believed_volume},
    )


def test_all_eight_are_there():
    assert len(FILES) == 8


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_the_true_volume_is_consistent(path):
    found = diagnose([recording(path, VOLUME)])
    assert found.verdict == "consistent"
    # 800 or fewer samples of white noise: their rms is known to 1/sqrt(2 n), four times over.
    samples = found.search.chosen.samples
    assert found.search.chosen.rms == pytest.approx(NOISE, rel=4.0 / np.sqrt(2.0 * samples))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_wrong_volume_is_a_parameter_and_no_physics(path):
    answer = document(diagnose([recording(path, 1.4 * VOLUME)]))
    assert answer["verdict"] == "parameter"
    assert answer["missing"] == []
    volume = answer["corrected_parameters"]["dead-volume.volume"]
    # The interval is 95 %; twice it covers all eight files together.
    half = volume["high"] - volume["value"]
    assert volume["value"] == pytest.approx(VOLUME, abs=2.0 * half)
    assert answer["located"][0]["block"] == "dead-volume"
