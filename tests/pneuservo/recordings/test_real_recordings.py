"""Every real recording reads, with the facts that are known about it."""

from pathlib import Path

import numpy as np
import pytest

from pneuservo.recordings import Recording, read_recording

pytestmark = pytest.mark.real

SEAL_SAMPLES = {
    "circle-1-bar": 7139,
    "circle-2-bar": 3806,
    "circle-3-bar": 7834,
    "circle-4-bar": 4183,
    "circle-5-bar": 10321,
    "circle-7-bar": 8720,
    "kdn-1-bar": 6857,
    "kdn-3-bar": 7792,
    "kdn-5-bar": 9705,
    "kdn-7-bar": 8145,
}


def read_untouched(path: Path) -> Recording:
    files = [path, path.with_suffix(".toml")]
    before = [(file.read_bytes(), file.stat().st_mtime_ns) for file in files]
    recording = read_recording(path)
    assert [(file.read_bytes(), file.stat().st_mtime_ns) for file in files] == before
    return recording


def test_every_recording_is_known_here(real_recordings):
    found = {
        path.relative_to(real_recordings).as_posix() for path in real_recordings.rglob("*.csv")
    }
    expected = {f"seal-friction/{name}.csv" for name in SEAL_SAMPLES}
    expected |= {"leak-down/aluminium.csv", "leak-down/ultimaker_015.csv", "silverbox/snls80mv.csv"}
    assert expected <= found
    for name in found - expected:  # more of them may be put there
        assert len(read_untouched(real_recordings / name)) >= 16


@pytest.mark.parametrize(
    ("name", "samples", "first", "last", "duration"),
    [
        ("aluminium", 1508, 7.315, 7.284, 151.303),
        ("ultimaker_015", 1426, 7.652, 0.072, 143.863),
    ],
)
def test_leak_down(real_recordings, name, samples, first, last, duration):
    recording = read_untouched(real_recordings / "leak-down" / f"{name}.csv")
    assert recording.rig == "dead-volume"
    assert len(recording) == samples
    pressure = recording["dead_volume_pressure"]
    # Gauge in the file: 1.013 bar is added.
    assert pressure[0] == pytest.approx(first * 1e5 + 1.013e5, rel=1e-12)
    assert pressure[-1] == pytest.approx(last * 1e5 + 1.013e5, rel=1e-12)
    assert recording.time[0] == 0.0
    assert recording.time[-1] == pytest.approx(duration, rel=1e-12)
    assert recording.sampling_interval == pytest.approx(0.1, rel=1e-9)
    assert not any("clipped" in text or "missing" in text for text in recording.warnings)


@pytest.mark.parametrize(("name", "samples"), SEAL_SAMPLES.items())
def test_seal_friction(real_recordings, name, samples):
    recording = read_untouched(real_recordings / "seal-friction" / f"{name}.csv")
    assert recording.rig == "seal-tester"
    assert len(recording) == samples
    assert recording.conditions == {"piston_diameter": pytest.approx(0.025)}
    held = float(name.split("-")[1])
    # Held at its nominal gauge pressure to within 10 %.
    assert np.median(recording["pressure_a"]) == pytest.approx(held * 1e5 + 1.013e5, rel=0.1)
    # The laser's zero is the start: 40 mm of extension, counted inwards.
    assert recording["displacement"][0] == pytest.approx(0.040, abs=2e-5)
    # The chamber's force on a 25 mm piston, and what the seal adds to or takes from it.
    nominal = held * 1e5 * np.pi / 4.0 * 0.025**2
    assert np.median(recording["force"]) == pytest.approx(nominal, rel=0.2)
    assert not any("clipped" in text or "missing" in text for text in recording.warnings)


def test_a_gap_in_a_real_recording_is_told(real_recordings):
    recording = read_recording(real_recordings / "seal-friction" / "circle-3-bar.csv")
    assert any("4 gaps in the time, the longest of 2.66 s" in text for text in recording.warnings)


def test_silverbox(real_recordings):
    recording = read_untouched(real_recordings / "silverbox" / "snls80mv.csv")
    assert recording.rig == "circuit"
    assert len(recording) == 131_072
    assert recording["circuit_input"][0] == 0.0057756
    assert recording["circuit_output"][-1] == -0.0072247
    assert recording.sampling_interval == pytest.approx(1.0 / 610.3515625, rel=1e-9)
    assert recording.warnings == ()
