"""A servo of which only pressures and the card's taps were recorded."""

from dataclasses import replace

import numpy as np
import pytest

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.controllers import AnalogueCard
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

CARD = AnalogueCard(card_figures(load_design()))
RIG = load_rig("single-axis")
TIME = np.arange(0.0, 0.5, 1e-3)
NOISE = {"card_sensor": 2e-3, "displacement": 7e-6}


@pytest.fixture(scope="module")
def recorded():
    run = simulate(RIG, time=TIME, controller=CARD, demand=np.full_like(TIME, 0.02))
    return Recording("run", TIME, run.channels, noise_rms=NOISE)


def without(recording, *names):
    kept = {name: samples for name, samples in recording.channels.items() if name not in names}
    noise = {name: size for name, size in recording.noise_rms.items() if name not in names}
    return replace(recording, channels=kept, noise_rms=noise)


def test_taps_stand_for_what_was_not_recorded(recorded):
    taps = without(recorded, "displacement", "valve_voltage")
    found = ServoModel().completed(taps, RIG)
    for name in ("displacement", "valve_voltage"):
        np.testing.assert_allclose(found[name], recorded[name], rtol=1e-12, atol=1e-15)
    assert found.noise_rms["displacement"] == pytest.approx(2e-3 * 0.03 / 10.0)
    assert len(found.warnings) == 2
    assert "card_sensor" in found.warnings[1]
    judged = {case.channel for case in ServoModel().cases(found, RIG)}
    assert {"pressure_a", "pressure_b"} <= judged


def test_what_was_recorded_is_left_alone(recorded):
    assert ServoModel().completed(recorded, RIG) is recorded
    other = replace(recorded, channels={**recorded.channels, "card_sensor": np.zeros_like(TIME)})
    kept = ServoModel().completed(other, RIG)["displacement"]
    assert np.shares_memory(kept, recorded["displacement"])
