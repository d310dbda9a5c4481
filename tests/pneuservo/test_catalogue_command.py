"""``pneuservo catalogue`` as a user types it."""

import json

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
