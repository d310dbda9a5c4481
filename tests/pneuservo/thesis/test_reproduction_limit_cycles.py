"""Chapters 8 and 9 of the reproduction, as far as no simulation of the plant is needed."""

import json
import re

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.thesis.chapter_8 import figures
from pneuservo.thesis.chapter_8_loops import plants, stated_loop, stated_loops
from pneuservo.thesis.chapter_8_statements import fastest_surface
from pneuservo.thesis.chapter_9_detectability import detectability_rows

# The two that no parameter set brings to 3 %: one fits badly, one is printed with one digit.
EXCEPTIONS = {"8.4-filter": 0.07, "8.9-10kHz": 0.12}
NYQUIST = [loop for loop in stated_loops() if "nyquist" in loop.stated]


def test_there_are_twelve_nyquist_entries():
    assert len(NYQUIST) == 12


@pytest.mark.parametrize("loop", NYQUIST, ids=lambda loop: loop.id)
def test_nyquist_entries_with_the_reconciled_parameters(loop):
    ours, stated = figures("nyquist", loop, plants("reconciled")), loop.stated["nyquist"]
    assert ours["frequency"] == pytest.approx(stated["frequency"], rel=0.01)
    tolerance = EXCEPTIONS.get(loop.id, 0.03)
    assert ours["amplitude"] == pytest.approx(stated["amplitude"], rel=tolerance)
    if loop.id in EXCEPTIONS:
        assert ours["amplitude"] != pytest.approx(stated["amplitude"], rel=0.03)


def test_linear_simulations_of_the_analogue_loops():
    # The thesis' own simulation is 0.3 % above its Nyquist value where a relay lies 1 % below.
    for name in ("8.1", "8.2", "8.3"):
        loop = stated_loop(name)
        ours, stated = figures("linear", loop, plants("reconciled")), loop.stated["linear"]
        assert ours["frequency"] == pytest.approx(stated["frequency"], rel=0.03)
        assert ours["amplitude"] == pytest.approx(stated["amplitude"], rel=0.04)


def test_fastest_surface_is_that_of_sections_8_1_1_and_9_3_5():
    assert round(fastest_surface(plants("printed")), 3) == 0.013


def test_tables_9_1_and_9_2():
    rows = {row.id: row for row in detectability_rows()}
    tables = [row for name, row in rows.items() if re.match(r"9\.[12]-(extend|retract)-\d", name)]
    assert len(tables) == 12
    for row in tables:
        assert row.printed == pytest.approx(row.stated, rel=0.035)
        assert row.reconciled == pytest.approx(row.stated, rel=0.01)
    assert all(row.verdict == "reproduced" for row in rows.values())


def test_command_writes_page_and_pictures(tmp_path):
    arguments = ["thesis", "--chapter", "6", "--out", str(tmp_path / "docs"), "--json"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    assert len(report["rows"]) >= 10
    page = (tmp_path / "docs" / "reproduction.md").read_text(encoding="utf-8")
    for picture in re.findall(r"\]\(([^)#]+\.svg)\)", page):
        assert "<svg" in (tmp_path / "docs" / picture).read_text(encoding="utf-8")
    assert "chapter-6-domain.svg" in page
    again = CliRunner().invoke(main, ["thesis", "--chapter", "6", "--no-page"])
    assert again.exit_code == 0
    assert str(len(report["rows"])) in again.stdout


def test_a_part_does_not_take_the_place_of_the_whole_page(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "docs" / "reproduction.md"
    page.parent.mkdir()
    page.write_text("every chapter", encoding="utf-8")
    done = CliRunner().invoke(main, ["thesis", "--chapter", "6"])
    assert done.exit_code == 0, done.output
    assert "written" not in done.stdout
    assert page.read_text(encoding="utf-8") == "every chapter"


def test_command_refuses_what_is_not_there(tmp_path):
    wrong = CliRunner().invoke(main, ["thesis", "--chapter", "2", "--no-page"])
    assert wrong.exit_code == 2
    assert "chapter 2 is not recomputed" in wrong.stderr
    CliRunner().invoke(main, ["thesis", "--chapter", "99", "--out", str(tmp_path / "docs")])
    assert not (tmp_path / "docs").exists()
    blocked = tmp_path / "file"
    blocked.write_text("", encoding="utf-8")
    nowhere = CliRunner().invoke(main, ["thesis", "--chapter", "9", "--out", str(blocked)])
    assert nowhere.exit_code == 2
    assert "--out" in nowhere.stderr
