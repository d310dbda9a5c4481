"""Rows of chapter 9 on the arm of the figure."""

from pneuservo.thesis.chapter_9_arm import arm_rows
from pneuservo.thesis.rows import REPRODUCED


def test_the_card_takes_the_coupling_out_of_the_arm():
    verdicts = {row.id: row.verdict for row in arm_rows()}
    assert verdicts == dict.fromkeys(
        ("9.21-ripple-1", "9.21-ripple-2", "9.21-vibration", "9.21-omitted"), REPRODUCED
    )
