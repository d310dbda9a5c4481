"""Rows, parameter sets and the page of the reproduction."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.calibration.experiment import COMMANDS
from pneuservo.errors import InputError
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.thesis import chapter_4_valve
from pneuservo.thesis.chapters import CHAPTERS, Chapter, recompute
from pneuservo.thesis.page import counts, shown, to_dict, write_reproduction
from pneuservo.thesis.parameter_sets import parameter_set, parameter_sets
from pneuservo.thesis.rows import IN_KIND, NOT, REPRODUCED, Row, number_row, verdict
from pneuservo.thesis.statements import Finding, statement_row


@pytest.mark.parametrize(
    ("stated", "ours", "expected"),
    [
        (100.0, (103.0, None), REPRODUCED),
        (100.0, (96.9, 97.0), REPRODUCED),
        (100.0, (96.9, 103.1), NOT),
        (-2.0, (-2.05, None), REPRODUCED),
        (-2.0, (2.0, None), NOT),
        (100.0, (math.nan, None), NOT),
        (100.0, (None, None), NOT),
    ],
)
def test_verdict_of_a_number(stated, ours, expected):
    assert verdict(stated, *ours) == expected
    assert (verdict(stated, *ours, in_kind=True) == IN_KIND) == (expected == NOT)


def test_a_number_that_is_not_reproduced_needs_a_reason():
    with pytest.raises(ValueError, match="needs a reason"):
        number_row("x", "what", "Hz", 100.0, 110.0, None, "Table 1")
    row = number_row("x", "what", "Hz", 100.0, 110.0, 104.0, "Table 1", "because")
    assert row.verdict == NOT
    assert row.printed_difference == pytest.approx(0.1)
    assert row.reconciled_difference == pytest.approx(0.04)
    with pytest.raises(ValueError, match="verdict"):
        Row("x", "what", "Hz", 1.0, 1.0, None, "perhaps", "", "Table 1")


def test_one_printed_and_at_most_one_reconciled_set_for_each_chapter():
    seen = [(s.kind, s.chapter) for s in parameter_sets()]
    assert len(seen) == len(set(seen))
    for kind, chapter in seen:
        if kind == "reconciled":
            assert ("printed", chapter) in seen
            assert parameter_set(kind, chapter).reason
    assert parameter_set("reconciled", 8)["velocity_weight_factor"] == 0.5
    with pytest.raises(KeyError, match="chapter 99"):
        parameter_set("printed", 99)


def test_page_and_values_hold_every_row(tmp_path):
    folder = tmp_path / "reproduction"
    rows = (
        number_row("a", "one | two", "Hz", 100.0, 101.0, None, "Table 1"),
        number_row("b", "three", "m", 1.0, math.nan, 2.0, "Table 2", "a contradiction"),
        statement_row("c", "four", "quiet", Finding(True, "no cycle"), "Figure 3"),
    )
    chapter = Chapter(8, "limit cycles", rows, (folder / "picture.svg",))
    page = write_reproduction([chapter], tmp_path / "reproduction.md")
    lines = [line for line in page.splitlines() if line.startswith("| ")]
    assert "| one \\| two | Hz | 100 | 101 | +1.0 % |  |  | reproduced | Table 1 |  |" in lines
    assert "| three | m | 1 | none |  | 2 | +100.0 % | not | Table 2 | a contradiction |" in lines
    assert any("| quiet | no cycle |" in line for line in lines)
    assert "](reproduction/picture.svg)" in page
    assert "## Chapter 8" in page
    report = to_dict([chapter])
    assert [row["id"] for row in report["rows"]] == ["a", "b", "c"]
    assert {"id", "stated", "printed", "reconciled", "verdict"} <= set(report["rows"][0])
    assert report["rows"][1]["printed"] is None
    assert counts(rows) == report["verdicts"] == {REPRODUCED: 2, IN_KIND: 0, NOT: 1}


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (5.0, "5"), (233.04, "233"), (0.012564, "0.01256"), (4.9e-7, "4.900e-07")],
)
def test_numbers_as_people_read_them(value, text):
    assert shown(value) == text


def test_unknown_chapters_are_refused():
    assert CHAPTERS == (4, 5, 6, 7, 8, 9, "A1")
    with pytest.raises(InputError, match="chapter 3 is not recomputed; there are: 4, 5"):
        recompute([3])


def test_in_parallel_the_rows_are_the_same():
    serial, parallel = (recompute([7, 6], jobs=jobs) for jobs in (1, 2))
    assert [chapter.number for chapter in serial] == [6, 7]
    assert serial == parallel
    assert all(row.id for chapter in serial for row in chapter.rows)


def test_a_volume_that_charges_too_slowly_is_not_reproduced(monkeypatch):
    time = np.linspace(0.0, 100.0, 1001)
    course = SimpleNamespace(time=time, modelled=np.minimum(time, 50.0))
    rows = [
        SimpleNamespace(path=path, command=command, **vars(course))
        for path in FLOW_PATHS
        for command in COMMANDS
    ]
    monkeypatch.setattr(chapter_4_valve, "calibrated", lambda: SimpleNamespace(rows=rows))
    (row,) = chapter_4_valve._duration_rows()
    assert row.verdict == NOT
