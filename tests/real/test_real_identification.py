"""Friction of real seals by least squares.

None of the recordings was made by this project; see the README beside them.
"""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.identification import identify_seal_friction
from pneuservo.recordings import read_recording

pytestmark = pytest.mark.real

AREA = 0.25 * np.pi * 0.025**2


@pytest.mark.parametrize("name", ["circle-1-bar", "kdn-3-bar"])
def test_the_friction_at_the_usual_speed_is_half_the_loop(real_recordings, name):
    recording = read_recording(real_recordings / "seal-friction" / f"{name}.csv")
    found = identify_seal_friction([recording])
    velocity = np.gradient(recording["displacement"], recording.time)
    smooth = np.convolve(velocity, np.ones(50) / 50, mode="same")
    usual = float(np.percentile(np.abs(smooth), 75.0))
    ways = [smooth > 0.5 * usual, smooth < -0.5 * usual]
    # The regulator lets the pressure differ between the directions.
    short = (recording["pressure_a"] - 1.013e5) * AREA - recording["force"]
    forwards, backwards = (float(np.median(short[way])) for way in ways)
    speed = float(np.mean([np.median(np.abs(smooth[way])) for way in ways]))
    friction = found.parameters["piston.viscous_friction"] * speed
    friction += found.parameters["piston.coulomb_friction"]
    by_hand = 0.5 * (forwards - backwards)
    # Medians against means: friction varies along the stroke by some 10 %.
    assert friction == pytest.approx(by_hand, rel=0.1)


def test_one_speed_does_not_tell_viscous_from_coulomb_friction(real_recordings, tmp_path):
    recording = real_recordings / "seal-friction" / "circle-3-bar.csv"
    done = CliRunner().invoke(main, ["identify", str(recording), "--out", str(tmp_path), "--json"])
    assert done.exit_code == 0, done.output
    answer = json.loads(done.stdout)
    assert answer["method"] == "least-squares"
    assert "cannot be told apart" in answer["cannot_tell_apart"][0]
