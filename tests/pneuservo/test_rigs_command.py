"""``pneuservo rigs`` as a user types it."""

import json

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, load_rig


def run(*words: str):
    return CliRunner().invoke(main, ["rigs", *words])


def test_every_rig_is_listed_with_what_a_diagnosis_needs():
    listed = {entry["name"]: entry for entry in json.loads(run("--json").output)}
    assert tuple(listed) == (*BUILT_IN_RIGS, *VARIANTS)
    assert listed["single-axis"]["diagnosis_needs"] == ["valve_voltage", "displacement"]
    assert listed["figure-arm"]["diagnosis_needs"] is None
    text = run().output
    assert all(name in text for name in listed)
    assert "not diagnosed" in text


@pytest.mark.parametrize("name", [*BUILT_IN_RIGS, *VARIANTS])
def test_a_rig_written_out_is_the_rig(tmp_path, name):
    answer = run(name, "--out", str(tmp_path / "mine.toml"))
    assert answer.exit_code == 0, answer.output
    mine, own = load_rig(tmp_path / "mine.toml"), load_rig(name)
    assert (mine.kind, mine.title, mine.valve) == (own.kind, own.title, own.valve)
    assert mine.parameters == own.parameters
    assert run(name).output == (tmp_path / "mine.toml").read_text(encoding="utf-8")


def test_parameters_are_told_in_si():
    found = json.loads(run("figure-linear-axis", "--json").output)
    assert found["chamber.a.dead_volume"]["value"] == pytest.approx(4.5e-6)
    assert found["chamber.a.dead_volume"]["unit"] == "m**3"


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("single-axes",), "single-axis"),
        (("--out", "mine.toml"), "name it before"),
        (("single-axis", "--out", "."), "is a folder; name a file in it"),
    ],
)
def test_what_cannot_be_is_refused(words, hint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = run(*words)
    assert answer.exit_code == 2
    assert hint in answer.output
