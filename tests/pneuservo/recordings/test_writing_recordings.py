"""Writing a recording: what is read back is equal, and what was read is never written over."""

import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.recordings import Recording, read_recording, write_recording
from pneuservo.rigs import load_rig

COUNT = 300
TIME = np.cumsum(np.full(COUNT, 1.0 / 610.3515625))
RNG = np.random.default_rng(3)
FULL = Recording(
    name="full",
    time=TIME,
    channels={
        "displacement": 0.015 + RNG.normal(0.0, 1e-3, COUNT),
        "pressure_a": 5e5 * (1.0 + RNG.normal(0.0, 0.1, COUNT)),
        "acceleration": RNG.normal(0.0, np.pi, COUNT),
        "temperature_a": 293.0 + RNG.normal(0.0, 1.0, COUNT),
        "spool": RNG.uniform(-1.0, 1.0, COUNT),
    },
    conditions={"supply_pressure": 711300.0 / 1.1, "load_mass": 6.82 / 3.0, "temperature": 294.15},
    noise_rms={"displacement": 3e-5 / 7.0, "spool": 1e-3 / 3.0, "temperature_a": 0.1},
    controller={"kind": "analogue-card", "settling_time": 0.07},
    card={"rc_velocity": 0.082 / 3.0, "weight_displacement": 1.2585, "level": 5.0},
    title='a "title" with ümlauts',
    taken="1998-05-12",
    notes="two\nlines",
)


def assert_equal(read: Recording, written: Recording) -> None:
    assert np.array_equal(read.time, written.time)
    assert set(read.channels) == set(written.channels)
    for name, values in written.channels.items():
        assert np.array_equal(read[name], values, equal_nan=True), name
    for field in ("conditions", "noise_rms", "controller", "card", "title", "taken", "notes"):
        assert getattr(read, field) == getattr(written, field), field


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".h5", ".hdf5"])
def test_what_is_written_reads_back_equal(tmp_path, suffix):
    path = write_recording(FULL, tmp_path / "deep" / f"run{suffix}")
    read = read_recording(path)
    assert_equal(read, FULL)
    assert read.rig == "single-axis"
    assert sorted(p.name for p in path.parent.iterdir()) == [path.name, "run.toml"]


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".h5"])
def test_missing_samples_and_a_later_start_survive(tmp_path, suffix):
    holed = FULL.channels["displacement"].copy()
    holed[50:60] = np.nan
    part = dataclasses.replace(FULL, channels={"displacement": holed}, noise_rms={}).slice(0.05)
    read = read_recording(write_recording(part, tmp_path / f"run{suffix}"))
    assert_equal(read, part)
    assert read.time[0] >= 0.05


def test_every_rig_is_written(tmp_path):
    circuit = Recording("c", TIME, {"circuit_input": np.sin(TIME)}, rig="circuit")
    assert read_recording(write_recording(circuit, tmp_path / "c.csv")).rig == "circuit"


def test_rig_and_design_files_go_along(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    rig, design = elsewhere / "mine.toml", elsewhere / "card.toml"
    rig.write_text('[rig]\nkind = "single-axis"\n')
    design.write_text("# a card\n")
    recording = dataclasses.replace(FULL, rig=str(rig), card={"design": str(design)})
    path = write_recording(recording, tmp_path / "out" / "run.csv")
    read = read_recording(path)
    assert Path(read.rig) == tmp_path / "out" / "mine.toml"
    assert Path(read.rig).read_text() == rig.read_text()
    assert read.card == {"design": str(tmp_path / "out" / "card.toml")}
    # Read from there and written beside it, nothing needs copying.
    again = read_recording(write_recording(read, tmp_path / "out" / "again.csv"))
    assert again.rig == read.rig
    (tmp_path / "out" / "mine.toml").write_text("# another\n")
    with pytest.raises(InputError, match="is another file than"):
        write_recording(recording, tmp_path / "out" / "third.csv")


def test_the_valve_file_of_a_rig_goes_with_it(tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "mine.toml").write_text('[rig]\nkind = "single-axis"\nvalve = "valve.toml"\n')
    (elsewhere / "valve.toml").write_text("# its tables\n")
    recording = dataclasses.replace(FULL, rig=str(elsewhere / "mine.toml"))
    read = read_recording(write_recording(recording, tmp_path / "out" / "run.csv"))
    assert Path(load_rig(read.rig).valve) == tmp_path / "out" / "valve.toml"
    assert (tmp_path / "out" / "valve.toml").read_text() == "# its tables\n"


def test_a_variant_of_a_rig_is_named_as_a_built_in_one_is(tmp_path):
    rig = "figure-linear-axis"
    recording = dataclasses.replace(FULL, rig=rig, conditions={}, controller={}, card={})
    assert read_recording(write_recording(recording, tmp_path / "run.csv")).rig == rig


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"channels": {"displacment": TIME}}, "Did you mean 'displacement'"),
        ({"conditions": {"load_mas": 1.0}}, "Did you mean 'load_mass'"),
        ({"controller": {"kind": "analog-card"}}, "Did you mean 'analogue-card'"),
        ({"controller": {"kind": "none", "gain": 1.0}}, "'gain' is not known"),
        ({"card": {"rc": 1.0}}, "'rc' is not known"),
        ({"rig": "missing.toml"}, "cannot be read"),
    ],
)
def test_what_could_not_be_read_back_is_not_written(tmp_path, changes, message):
    with pytest.raises(InputError, match=message):
        write_recording(dataclasses.replace(FULL, **changes), tmp_path / "run.csv")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".mat", ".tdms", ".xlsx", ""])
def test_other_forms_are_not_written(tmp_path, suffix):
    with pytest.raises(InputError, match=r"\.csv, \.parquet, \.h5, \.hdf5"):
        write_recording(FULL, tmp_path / f"run{suffix}")


def test_a_folder_is_refused_before_its_sidecar_is_written(tmp_path):
    (tmp_path / "run.csv").mkdir()
    with pytest.raises(InputError, match=r"run\.csv: is a folder.* such as .*recording\.csv"):
        write_recording(FULL, tmp_path / "run.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["run.csv"]


@pytest.mark.parametrize("name", ["run.csv", "run.parquet"])
def test_the_recording_that_was_read_is_not_written_over(tmp_path, name):
    path = write_recording(FULL, tmp_path / "run.csv")
    before = {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in tmp_path.iterdir()}
    read = read_recording(path)
    # run.parquet would have the sidecar of run.csv.
    with pytest.raises(InputError, match="never written over"):
        write_recording(read, tmp_path / name)
    assert {p: (p.read_bytes(), p.stat().st_mtime_ns) for p in tmp_path.iterdir()} == before


def test_the_sidecar_of_another_form_is_not_written_over(tmp_path):
    write_recording(FULL, tmp_path / "run.csv")
    before = (tmp_path / "run.toml").read_bytes()
    with pytest.raises(InputError, match=r"would take the place of that of .*run\.csv"):
        write_recording(dataclasses.replace(FULL, title="another"), tmp_path / "run.h5")
    assert (tmp_path / "run.toml").read_bytes() == before
    write_recording(FULL, tmp_path / "run.h5")


def test_a_sidecar_does_not_take_the_place_of_the_rig_that_goes_along(tmp_path):
    (tmp_path / "lab").mkdir()
    rig = tmp_path / "lab" / "axis.toml"
    rig.write_text('[rig]\nkind = "single-axis"\n')
    recording = dataclasses.replace(FULL, rig=str(rig), card={})
    with pytest.raises(InputError, match=r"would take the place of axis\.toml"):
        write_recording(recording, tmp_path / "out" / "axis.csv")
    assert [path.name for path in tmp_path.iterdir()] == ["lab"]


def test_a_failed_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = write_recording(FULL, tmp_path / "run.csv")
    before = path.read_bytes()

    def fail(source, target):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="No space left"):
        write_recording(FULL.slice(0.0, 0.2), path)
    assert path.read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv", "run.toml"]
