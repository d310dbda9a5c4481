"""The command ``pneuservo tune``: what it prints and keeps, in processes, and after a kill."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from distributed import LocalCluster
from small_tuning import ARGUMENTS, small_tuning

from analog_card.design_file import load_design
from pneuservo.command_line import main
from pneuservo.tuning.search import GENERATIONS
from pneuservo.tuning.summary import summary

PROGRAM = Path(sys.executable).parent / "pneuservo"


@pytest.fixture(scope="module")
def found():
    return small_tuning()


@pytest.fixture
def run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(main, ["tune", *arguments])


def test_prints_one_document_and_keeps_everything(run, found):
    done = run(*ARGUMENTS, "--out", "kept", "--plot", "front.png", "--json")
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report == json.loads(Path("kept/tuning.json").read_text())
    assert report == json.loads(json.dumps(summary(found)))
    table = pd.read_csv("kept/front.csv")
    pd.testing.assert_frame_equal(table, found.table(), check_exact=True)
    settings = report["recommended"]["settings"]
    assert list(vars(load_design("kept/card.toml").turned).values()) == list(settings.values())
    assert Path("front.png").read_bytes().startswith(b"\x89PNG")
    assert "control effort" in Path("kept/front.svg").read_text()
    text = run(*ARGUMENTS, "--out", "kept").output
    assert "recommended: P1" in text
    assert "chatter is worst" in text
    assert "checked in 4 drawn rigs" in text
    assert "written: kept/card.toml" in text


def test_killed_in_processes_and_gone_on_with(run, found, tmp_path):
    folder = tmp_path / "killed"
    command = [PROGRAM, "tune", *ARGUMENTS, "--jobs", "2", "--out", folder]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    second = folder / GENERATIONS / "0001.jsonl"
    while not second.exists() and process.poll() is None:
        time.sleep(1e-3)
    os.kill(process.pid, signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL
    generations = sorted((folder / GENERATIONS).iterdir())
    assert 2 <= len(generations) < 6
    first = generations[0].read_bytes()
    # A kill in the middle of a line leaves a part of it.
    with generations[-1].open("ab") as stream:
        stream.write(b'{"trial": 15, "fig')
    done = run(*ARGUMENTS, "--out", str(folder), "--json")
    assert done.exit_code == 0, done.output
    assert generations[0].read_bytes() == first
    assert json.loads(done.stdout) == json.loads(json.dumps(summary(found)))


def test_a_file_with_options_in_its_place(run):
    Path("rigs.toml").write_text(
        'demand = "15,24 mm"\nrate = "1 kHz"\n[vary]\n"load.mass" = "1.8, 7 kg"\n'
    )
    short = ("--population", "8", "--generations", "3", "--check", "0", "--overshoot", "10 %")
    done = run("rigs.toml", *short, "--vary", "supply.pressure=7 bar", "--json")
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["rigs"] == [
        {"load.mass": 1.8, "supply.pressure": 7e5},
        {"load.mass": 7.0, "supply.pressure": 7e5},
    ]
    assert report["limits"]["overshoot"] == pytest.approx(0.1)
    assert report["check"] == {"trials": 0, "failed": 0, "figures": []}
    assert np.isclose(report["duration"], 0.999)


@pytest.mark.parametrize(
    ("options", "status", "says"),
    [
        (("--vary", "load.mass"), 2, "write NAME=VALUES"),
        (("--cluster", "tcp://x:1", "--jobs", "2"), 2, "exclude each other"),
        (("--plot", "picture.txt"), 2, "a picture ends in"),
        (("none.toml",), 2, "campaign file is needed"),
        (("--population", "2"), 2, "at least 1 of 4"),
        (("--design", "none.toml"), 2, "none.toml"),
        (("--error", "5 V"), 2, "--error"),
        (
            ("--error", "1 nm", "--population", "4", "--generations", "1", "--rate", "1 kHz"),
            3,
            "not one of 4 settings keeps the limits",
        ),
    ],
)
def test_bad_options_exit_with_a_message(run, options, status, says):
    done = run(*options)
    assert done.exit_code == status, done.output
    assert says in done.output
    assert isinstance(done.exception, SystemExit)


def test_on_a_cluster(run, found):
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp", dashboard_address=None
    ) as local:
        done = run(*ARGUMENTS, "--cluster", local.scheduler_address, "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout) == json.loads(json.dumps(summary(found)))
