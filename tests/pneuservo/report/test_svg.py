"""Pictures inside a page say what they show in plain text."""

from pneuservo.report.svg import draw


def test_marks_of_a_logarithmic_axis_are_plain_numbers():
    def paint(axes):
        axes.loglog([1.0, 1e3], [1e-4, 1.0])
        axes.set_title("costs $5 and $6")

    picture = draw(paint, size=(4.0, 3.0))
    assert "mathdefault" not in picture
    assert all(f">{mark}</text>" in picture for mark in ("100", "0.01"))
    assert ">costs $5 and $6</text>" in picture
