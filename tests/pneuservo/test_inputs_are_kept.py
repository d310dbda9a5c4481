"""Nothing that is read is ever written over, whatever --out says."""

import os
import stat
from pathlib import Path

import pytest
from click.testing import CliRunner

from analog_card.command_line import main as card
from analog_card.files import write_whole
from pneuservo.command_line import main
from pneuservo.controllers import Proportional
from pneuservo.recordings import write_recording
from pneuservo.simulation import simulate, step_demand

ONE_RIG = '[vary]\n"load.mass" = "2 kg"\n'
RIG = '[rig]\nkind = "single-axis"\n'


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a rig, a card and a short recording of each name that commands write."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.toml").write_text(RIG)
    words = ["tune", "--settling-time", "0.07", "--out", "card.toml"]
    assert CliRunner().invoke(card, words).exit_code == 0
    time, demand = step_demand([0.015, 0.016], 0.02, 1000.0)
    run = simulate(time=time, demand=demand, controller=Proportional())
    (tmp_path / "volume.toml").write_text('[rig]\nkind = "dead-volume"\nvalve = "valve.toml"\n')
    (tmp_path / "valve.toml").write_text("not looked into before it is written over")
    (tmp_path / "set.toml").write_text(f'design = "card.toml"\n{ONE_RIG}')
    for name in ("model", "loop", "samples"):
        write_recording(run.to_recording(name), f"{name}.csv")
    return tmp_path


@pytest.mark.parametrize(
    ("command", "words", "kept"),
    [
        (main, "diagnose model.csv --out .", "model.toml"),
        (main, "diagnose loop.csv --rig rig.toml --validate model.csv --out .", "model.toml"),
        (main, "identify loop.csv --rig rig.toml --out .", "rig.toml"),
        (main, "bench-tune --design card.toml --out card.toml", "card.toml"),
        (main, "bench-tune --recording loop.csv --out ./loop.toml", "loop.toml"),
        (main, "demo --recording model.csv --out .", "model.toml"),
        (
            main,
            "simulate --rig rig.toml --controller proportional --demand 15mm --out rig.csv",
            "rig.toml",
        ),
        (main, "simulate --controller proportional --demand 15mm --out card.csv", "card.toml"),
        (main, "calibrate --simulate --rig volume.toml --out .", "valve.toml"),
        (main, "tune --design card.toml --vary load.mass=2kg --out .", "card.toml"),
        (main, "tune set.toml --out .", "card.toml"),
        (
            main,
            "campaign --controller proportional --demand samples.csv --vary load.mass=2kg --out .",
            "samples.csv",
        ),
        (card, "tune --settling-time 0.1 --design card.toml --out card.toml", "card.toml"),
    ],
)
def test_what_is_read_is_not_written_over(folder, command, words, kept):
    before = {path: path.read_bytes() for path in folder.iterdir()}
    outcome = CliRunner().invoke(command, words.split())
    assert outcome.exit_code == 2, outcome.output
    assert kept in outcome.output
    assert "choose another" in outcome.output
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("command", ["diagnose", "identify"])
def test_another_valve_file_is_not_written_over(folder, command):
    (folder / "lab").mkdir()
    (folder / "lab" / "valve.toml").write_text("tables of a valve")
    text = '[rig]\nkind = "single-axis"\nvalve = "valve.toml"\n'
    (folder / "lab" / "rig.toml").write_text(text)
    outcome = CliRunner().invoke(main, [command, "loop.csv", "--rig", "lab/rig.toml", "--out", "."])
    assert outcome.exit_code == 2, outcome.output
    assert "valve.toml: the valve file of lab/rig.toml would take its place" in outcome.output
    assert "not looked into" in (folder / "valve.toml").read_text()


def test_a_link_is_followed_and_a_pipe_stays_one(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "target")
    write_whole(tmp_path / "link", "text")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "target").read_text() == "text"
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    reader = os.open(pipe, os.O_RDONLY | os.O_NONBLOCK)
    write_whole(pipe, "text")
    assert os.read(reader, 10) == b"text"
    os.close(reader)
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_a_link_that_leads_back_to_itself_is_refused(tmp_path):
    ring = tmp_path / "ring.csv"
    ring.symlink_to(ring)
    words = ["simulate", "--controller", "proportional", "--demand", "15 mm", "--out", str(ring)]
    outcome = CliRunner().invoke(main, words)
    assert outcome.exit_code == 2, outcome.output
    assert "leads back to itself" in outcome.output
    assert ring.is_symlink()


def test_a_sidecar_that_is_no_file_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("time,displacement\n" + "".join(f"{i},0\n" for i in range(20)))
    os.mkfifo(tmp_path / "a.toml")
    outcome = CliRunner().invoke(main, ["diagnose", str(tmp_path / "a.csv")])
    assert outcome.exit_code == 2
    assert "not a file" in outcome.output
    assert not Path("out").exists()
