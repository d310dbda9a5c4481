"""``pneuservo diagnose`` as typed."""

import json
import re
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.examples.leaking_volume import leaking_volume
from pneuservo.recordings import Recording, write_recording

WRITTEN = {"diagnosis.json", "model.toml", "report.html"}


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Paths of some recordings in one folder."""
    folder = tmp_path_factory.mktemp("recordings")
    paths = {}
    for seed in (1, 2, 3):
        recording = leaking_volume(seed, duration=20.0)
        paths[f"leak{seed}"] = str(write_recording(recording, folder / f"leak{seed}.csv"))
    time = np.arange(200) / 100.0
    rng = np.random.default_rng(0)
    channels = {"circuit_input": np.sin(time), "circuit_output": rng.standard_normal(200)}
    circuit = Recording("circuit", time, channels, "circuit")
    paths["circuit"] = str(write_recording(circuit, folder / "circuit.csv"))
    deaf = Recording("deaf", time, {"circuit_input": np.sin(time)}, "circuit")
    paths["deaf"] = str(write_recording(deaf, folder / "deaf.csv"))
    axis = Recording("axis", time, {"displacement": 1e-3 * np.sin(time)}, "single-axis")
    paths["axis"] = str(write_recording(axis, folder / "axis.csv"))
    return paths


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run the command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        return CliRunner().invoke(main, ["diagnose", *arguments])

    return invoke


def content(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.*")}


def assert_refused(done, tmp_path, before, *words):
    """Exit status 2, one message, no traceback, nothing written."""
    assert done.exit_code == 2, (done.exit_code, done.exception, done.output)
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    messages = [line for line in done.stderr.splitlines() if line.startswith("Error: ")]
    assert len(messages) == 1, done.stderr
    for word in words:
        assert word in messages[0], messages[0]
    assert content(tmp_path) == before


@pytest.fixture(scope="module")
def answered(recordings, tmp_path_factory):
    """What is printed and written for the first recording."""
    folder = tmp_path_factory.mktemp("answered") / "answer"
    inputs = Path(recordings["leak1"]).parent
    before = content(inputs)
    done = CliRunner().invoke(
        main, ["diagnose", recordings["leak1"], "--json", "--out", str(folder)]
    )
    assert done.exit_code == 0, done.output
    assert content(inputs) == before, "an input was touched"
    return done, folder


def test_a_column_that_is_no_channel_is_said_to_be_left_out(run, tmp_path):
    path = tmp_path / "mistyped.csv"
    rows = "".join(f"{k / 100},0.015,0\n" for k in range(200))
    path.write_text("time,displacement,forse\n" + rows)
    done = run(str(path))
    assert "Warning: " in done.stderr
    assert "mistyped.csv: columns that are no channels were left out: 'forse'" in done.stderr


def test_json_is_all_that_is_printed(answered):
    done, folder = answered
    assert json.loads(done.stdout) == json.loads((folder / "diagnosis.json").read_text())
    assert done.stderr == ""


def test_three_files_are_written(answered):
    done, folder = answered
    assert {path.name for path in folder.iterdir()} == WRITTEN
    answer = json.loads(done.stdout)
    effects = [entry["effect"] for entry in answer["missing"]]
    # The example leaks, and its wall gives heat back.
    assert any(effect.startswith("leakage.") for effect in effects)
    model = tomllib.loads((folder / "model.toml").read_text())
    # What has no name cannot be repaired.
    assert set(model["effects"]) == set(effects) - {"unexplained"}
    page = (folder / "report.html").read_text()
    assert page.lstrip().lower().startswith("<!doctype html>")
    assert "<svg" in page
    # Self-contained: names of XML vocabularies are not fetched, these would be.
    assert not re.search(r"(src|href)\s*=\s*[\"']?(https?:)?//|url\(\s*[\"']?(https?:)?//", page)


def test_without_validate_nothing_is_held_back(answered):
    (channel,) = json.loads(answered[0].stdout)["fit"]["channels"].values()
    assert channel["before"]["held_back"] is None
    assert channel["after"]["held_back"] is None


def test_people_are_told_in_two_lines(run, recordings, tmp_path):
    done = run(recordings["leak1"], "--out", "answer")
    assert done.exit_code == 0, done.output
    assert done.stderr == ""
    first, second = done.stdout.splitlines()
    assert first.startswith("missing-physics: ")
    assert "Air leaks to the atmosphere" in first
    assert second == "report: answer/report.html"
    assert {path.name for path in (tmp_path / "answer").iterdir()} == WRITTEN


def test_several_files_after_one_validate(run, recordings):
    held_back = [recordings["leak2"], recordings["leak3"]]
    done = run(recordings["leak1"], "--validate", *held_back, "--json")
    assert done.exit_code == 0, done.output
    (channel,) = json.loads(done.stdout)["fit"]["channels"].values()
    # The same volume with other noise, 200 samples: their rms is known to 5 % each.
    after = channel["after"]
    assert after["held_back"] == pytest.approx(after["used"], rel=0.2)
    assert channel["before"]["held_back"] > 10.0 * after["held_back"]
    one_by_one = [word for path in held_back for word in ("--validate", path)]
    assert run(*one_by_one, "--json", recordings["leak1"]).stdout == done.stdout


def test_an_open_window_and_the_seed_of_old_change_nothing(run, recordings, answered):
    again = run(recordings["leak1"], "--window", ":", "--seed", "0", "--json")
    assert again.stdout == answered[0].stdout


def test_a_window_takes_part_of_the_recording(run, recordings):
    done = run(recordings["leak1"], "--window", "6s : 0.3 min", "--json")
    assert done.exit_code == 0, done.output
    # The volume was held until 4 s, so that in this window nothing begins.
    for entry in json.loads(done.stdout)["missing"]:
        assert "start" not in entry["parameters"]


def test_the_repaired_model_is_a_rig(run, recordings, answered):
    model = str(answered[1] / "model.toml")
    again = run(recordings["leak2"], "--rig", model, "--json")
    assert again.exit_code == 0, again.output
    answer = json.loads(again.stdout)
    assert answer["verdict"] == "consistent"
    assert answer["missing"] == []


def test_help_shows_examples(run):
    done = run("--help")
    assert done.exit_code == 0
    for option in ("--validate", "--rig", "--window", "--out", "--json"):
        assert option in done.output
    assert "pneuservo diagnose out/demo" in done.output


def test_as_a_program(recordings, tmp_path):
    program = Path(sys.executable).parent / "pneuservo"
    done = subprocess.run(
        [program, "diagnose", recordings["leak1"], "--json"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["verdict"] == "missing-physics"
    # No terminal, no progress.
    assert done.stderr == ""


REFUSED = {
    "no such file": (["nowhere.csv"], ["nowhere.csv", "no such file"]),
    "no such file to validate": (
        ["{leak1}", "--validate", "nowhere.csv"],
        ["nowhere.csv", "no such file"],
    ),
    "two rigs": (["{leak1}", "{circuit}"], ["different rigs", "circuit", "dead-volume", "--rig"]),
    "two rigs over both lists": (["{leak1}", "--validate", "{circuit}"], ["different rigs"]),
    "channel missing": (["{deaf}"], ["deaf.csv", "circuit_output", "circuit_input"]),
    "wrong rig for the channels": (
        ["{leak1}", "--rig", "seal-tester"],
        ["leak1.csv", "displacement", "pressure_a", "force", "--rig"],
    ),
    "rig not covered": (
        ["{axis}", "--rig", "figure-arm"],
        ["figure-arm", "covers", "dead-volume", "single-axis"],
    ),
    "channels missing": (["{axis}"], ["single-axis", "valve_voltage", "--rig"]),
    "rig unknown": (["{leak1}", "--rig", "dead-volum"], ["dead-volum", "Did you mean"]),
    "rig file missing": (["{leak1}", "--rig", "gone.toml"], ["gone.toml", "a rig file is needed"]),
    "window outside": (["{leak1}", "--window", "100:200"], ["100", "200", "20"]),
    "window backwards": (["{leak1}", "--window", "5:2"], ["--window", "5:2"]),
    "window without a colon": (["{leak1}", "--window", "5"], ["--window", "1.5:4"]),
    "window in kilograms": (["{leak1}", "--window", "1kg:3"], ["--window", "kg"]),
    "validate window outside": (
        ["{leak1}", "--validate", "{leak2}", "--validate-window", "100:200"],
        ["100", "200"],
    ),
}


@pytest.mark.parametrize(("arguments", "words"), REFUSED.values(), ids=REFUSED)
def test_unusable_input_is_refused(run, recordings, tmp_path, arguments, words):
    before = content(tmp_path)
    done = run(*(word.format(**recordings) for word in arguments), "--out", "answer")
    assert_refused(done, tmp_path, before, *words)
    assert not (tmp_path / "answer").exists()


@pytest.mark.parametrize("window", ["1:1.3", "1:2.45"])
def test_too_few_samples_are_refused(run, recordings, tmp_path, window):
    done = run(recordings["leak1"], "--window", window, "--out", "answer")
    assert_refused(done, tmp_path, {}, "16")


def test_samples_that_would_count_twice_are_refused(run, recordings, tmp_path):
    leak = recordings["leak1"]
    for arguments in ([leak, leak], [leak, "--validate", leak]):
        done = run(*arguments)
        assert_refused(done, tmp_path, {}, leak, "given twice", "--window")


def test_a_slip_in_the_unit_of_the_time_is_refused(run, tmp_path):
    time = np.arange(200) * 1e-9
    channels = {"valve_voltage": np.sin(time), "displacement": 0.01 + 1e-3 * np.sin(1e9 * time)}
    path = str(write_recording(Recording("axis", time, channels), tmp_path / "axis.csv"))
    before = content(tmp_path)
    assert_refused(run(path), tmp_path, before, path, "one sample in 1e-09 s", "[time]")
    long = leaking_volume(1, duration=20.0)
    path = str(write_recording(replace(long, time=1e4 * long.time), tmp_path / "long.csv"))
    before = content(tmp_path)
    assert_refused(run(path), tmp_path, before, path, "2e+05 s in all", "[time]")


def test_next_to_no_numbers_are_refused(run, tmp_path):
    leak = leaking_volume(1, duration=20.0)
    few = np.full(len(leak), np.nan)
    few[::800] = leak["dead_volume_pressure"][::800]
    channels = {**leak.channels, "dead_volume_pressure": few}
    path = str(write_recording(replace(leak, channels=channels), tmp_path / "few.csv"))
    before = content(tmp_path)
    assert_refused(
        run(path), tmp_path, before, path, "dead_volume_pressure", "numbers", "8 are needed"
    )


def test_no_recording_is_refused(run, tmp_path):
    done = run("--out", "answer")
    assert_refused(done, tmp_path, {}, "REC")


@pytest.mark.parametrize("out", ["taken", "taken/answer"])
def test_a_file_in_the_way_is_refused(run, recordings, tmp_path, out):
    (tmp_path / "taken").write_text("mine")
    done = run(recordings["leak1"], "--out", out)
    assert_refused(done, tmp_path, {}, "taken")
    assert (tmp_path / "taken").read_text() == "mine"


BROKEN = {
    "not TOML": ("[rig\nkind = ", ["model.toml", "not valid TOML"]),
    "no kind": ("[parameters]\n", ["model.toml", "kind"]),
    "unknown parameter": (
        '[rig]\nkind = "dead-volume"\n[parameters]\n"dead-volume.volum" = { value = 1e-5 }\n',
        ["dead-volume.volum", "Did you mean 'dead-volume.volume'"],
    ),
    "wrong dimension": (
        '[rig]\nkind = "dead-volume"\n[parameters]\n"dead-volume.volume" = { value = "1 kg" }\n',
        ["dead-volume.volume", "kg"],
    ),
    "negative volume": (
        '[rig]\nkind = "dead-volume"\n[parameters]\n"dead-volume.volume" = { value = -1e-5 }\n',
        ["dead-volume.volume", "greater than 0"],
    ),
    "effect is text": (
        '[rig]\nkind = "dead-volume"\n[effects."leakage.orifice"]\narea = "wide"\n',
        ["leakage.orifice", "area", "number"],
    ),
    "effect misspelt": (
        '[rig]\nkind = "dead-volume"\n[effects."leakage.orfice"]\narea = { value = 1e-9 }\n',
        ["leakage.orfice", "leakage.orifice"],
    ),
    "effect parameter misspelt": (
        '[rig]\nkind = "dead-volume"\n[effects."leakage.orifice"]\naera = { value = 1e-9 }\n',
        ["leakage.orifice", "aera", "area"],
    ),
    "effect of another rig": (
        '[rig]\nkind = "dead-volume"\n[effects."friction.pressure"]\nslope = { value = 1e-6 }\n',
        ["friction.pressure", "dead-volume"],
    ),
    "effect not a number": (
        '[rig]\nkind = "dead-volume"\n[effects."leakage.orifice"]\narea = { value = nan }\n',
        ["leakage.orifice", "area"],
    ),
    "unknown table": (
        '[rig]\nkind = "dead-volume"\n[effect."leakage.orifice"]\narea = { value = 1e-9 }\n',
        ["model.toml", "effect"],
    ),
}


@pytest.mark.parametrize(
    ("text", "words"),
    [pytest.param(*broken, id=name) for name, broken in BROKEN.items()],
)
def test_a_broken_model_is_refused(run, recordings, tmp_path, text, words):
    (tmp_path / "model.toml").write_text(text, encoding="utf-8")
    before = content(tmp_path)
    done = run(recordings["leak1"], "--rig", "model.toml", "--out", "answer")
    assert_refused(done, tmp_path, before, *words)
