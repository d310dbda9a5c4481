"""``pneuservo catalogue`` as a user types it."""

import json

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.effects import effects_of


def run(*words: str):
    return CliRunner().invoke(main, ["catalogue", *words])


def test_every_effect_of_a_rig_is_listed():
    answer = run("--json")
    assert answer.exit_code == 0
    entries = json.loads(answer.output)
    assert [entry["id"] for entry in entries] == [e.id for e in effects_of("single-axis")]
    assert all(entry["equation"] and entry["source"] for entry in entries)


def test_one_effect_is_told_in_full():
    answer = run("friction.stribeck")
    assert answer.exit_code == 0
    assert "excess" in answer.output
    assert "source:" in answer.output


def test_an_unknown_effect_is_refused_with_the_nearest_name():
    answer = run("friction.stribek")
    assert answer.exit_code == 2
    assert "friction.stribeck" in answer.output


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (("--plot", "all.svg"), "--pictures FOLDER"),
        (("friction.stribeck", "--pictures", "folder"), "--plot FILE"),
        (("friction.stribeck", "--plot", "stribeck.bmp"), ".svg"),
    ],
)
def test_pictures_that_cannot_be_drawn_are_refused(words, hint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    answer = run(*words)
    assert answer.exit_code == 2
    assert hint in answer.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [("friction.stribeck", "--plot"), ("--pictures",)])
def test_a_folder_that_cannot_be_made_is_refused(words, tmp_path):
    (tmp_path / "file").write_text("in the way")
    answer = run("--rig", "seal-tester", *words, str(tmp_path / "file" / "picture.svg"))
    assert answer.exit_code == 2
    assert "choose another folder" in answer.output


def test_one_effect_is_drawn(tmp_path):
    file = tmp_path / "stribeck.svg"
    answer = run("friction.stribeck", "--plot", str(file), "--json")
    assert answer.exit_code == 0
    assert [entry["id"] for entry in json.loads(answer.stdout)] == ["friction.stribeck"]
    drawn = file.read_text()
    assert "changes [µm]" in drawn
    assert "changes [kPa]" in drawn


def test_a_catalogue_is_drawn_with_a_page_that_shows_every_effect(tmp_path):
    folder = tmp_path / "catalogue"
    answer = run("--rig", "circuit", "--pictures", str(folder))
    assert answer.exit_code == 0
    assert f"written: {folder / 'index.html'}" in answer.output.replace("\n", "")
    page = (folder / "index.html").read_text()
    effects = effects_of("circuit")
    for effect in effects:
        assert f'src="{effect.id}.svg"' in page
        assert "<svg" in (folder / f"{effect.id}.svg").read_text()
    assert len(list(folder.iterdir())) == len(effects) + 1
