"""The command ``pneuservo campaign``: what it prints and keeps, in processes, and after a kill."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from click.testing import CliRunner

from pneuservo.campaign.metrics import OF_RECORDED, OF_SET_POINTS
from pneuservo.campaign.run import SAMPLES
from pneuservo.command_line import main

PROGRAM = Path(sys.executable).parent / "pneuservo"


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(main, ["campaign", *arguments])


def kept_samples(folder):
    path = folder / SAMPLES
    return path.read_bytes().count(b"\n") - 1 if path.exists() else 0


def test_prints_one_document_and_keeps_samples(run, arguments, outcome):
    done = run(*arguments, "--out", "kept", "--plot", "picture.png", "--json")
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report == json.loads(Path("kept/summary.json").read_text())
    assert report["samples"] == 40
    table = pd.read_csv("kept/samples.csv", index_col="sample")
    expected = outcome.table()
    pd.testing.assert_frame_equal(table, expected, check_dtype=False, check_exact=True)
    assert Path("picture.png").read_bytes().startswith(b"\x89PNG")
    assert "settling time" in Path("kept/metrics.svg").read_text()
    lines = [json.loads(line) for line in Path("kept", SAMPLES).read_text().splitlines()]
    assert [line["trial"] for line in lines[1:]] == list(range(40))
    text = run(*arguments, "--out", "kept").output
    assert "settling time, ms" in text
    assert "written: kept/samples.csv" in text
    refused = run(*arguments, "--out", "kept", "--seed", "1")
    assert refused.exit_code == 2
    assert "another study" in refused.output


def test_killed_in_processes_and_gone_on_with(run, arguments, outcome, tmp_path):
    folder = tmp_path / "killed"
    command = [PROGRAM, "campaign", *arguments, "--jobs", "2", "--out", folder]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while kept_samples(folder) < 3 and process.poll() is None:
        time.sleep(1e-3)
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    content = (folder / SAMPLES).read_bytes()
    before = kept_samples(folder)
    assert 3 <= before < 40
    # A kill in the middle of a line leaves a part of it.
    with (folder / SAMPLES).open("ab") as stream:
        stream.write(b'{"trial": 39, "fig')
    done = run(*arguments, "--out", str(folder), "--json")
    assert done.exit_code == 0, done.output
    after = (folder / SAMPLES).read_bytes()
    assert after.startswith(content[: content.rfind(b"\n") + 1])
    lines = [json.loads(line) for line in after.splitlines()[1:]]
    assert sorted(line["trial"] for line in lines) == list(range(40))
    found = [line["figures"] for line in sorted(lines, key=lambda line: line["trial"])]
    assert found == outcome.samples


def test_a_file_with_options_in_its_place(run):
    Path("short.toml").write_text(
        'controller = "proportional"\ndemand = "15,16 mm"\nhold = "50 ms"\n'
        'metrics = ["rise_time"]\n[vary]\n"load.mass" = "1, 2 kg"\n'
    )
    done = run("short.toml", "--vary", "controller.gain=1,2", "--hold", "60 ms", "--json")
    report = json.loads(done.stdout)
    assert report["samples"] == 4
    assert report["duration"] == pytest.approx(0.119)
    assert [entry["metric"] for entry in report["metrics"]] == ["rise_time"]
    replaced = run("short.toml", "--vary", "load.mass=3 kg", "--json")
    assert json.loads(replaced.stdout)["samples"] == 1


def test_help_names_what_is_measured_unless_said(run):
    text = run("--help").output
    _, _, metric = text.partition("--metric")
    words, _, _ = metric.partition("--jobs")
    assert all(name in words for name in (*OF_SET_POINTS, *OF_RECORDED))
    assert "chatter" not in words


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ((), "needs a controller"),
        (("--controller", "sliding-mode"), "needs a demand"),
        (("--controller", "sliding-mode", "--demand", "15,24 mm"), "nothing varies"),
        (("--vary", "load.mass"), "write NAME=VALUES"),
        (("--cluster", "tcp://x:1", "--jobs", "2"), "exclude each other"),
        (("--plot", "picture.txt"), "a picture ends in"),
        (("none.toml",), "campaign file is needed"),
        (("--controller", "pid", "--demand", "15 mm", "--vary", "load.mass=1 kg"), "'pid'"),
    ],
)
def test_bad_options_exit_with_status_2(run, options, says):
    done = run(*options)
    assert done.exit_code == 2
    assert says in done.output
    assert isinstance(done.exception, SystemExit)
