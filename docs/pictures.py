"""Redraw the README's pictures: python docs/pictures.py."""

import tempfile
from pathlib import Path

from pneuservo.demo import run_demo
from pneuservo.diagnosis import document
from pneuservo.report.demo_page import loop_picture
from pneuservo.report.diagnosis_figures import diagnosis_figures

FOLDER = Path(__file__).parent


def main() -> None:
    """Write the pictures beside this file."""
    with tempfile.TemporaryDirectory() as scratch:
        demo = run_demo(Path(scratch))
    figures = diagnosis_figures(demo.diagnosis, document(demo.diagnosis))
    (FOLDER / "closed-loop.svg").write_text(loop_picture(demo), encoding="utf-8")
    (FOLDER / "diagnosis.svg").write_text(figures["curves"][0][1], encoding="utf-8")


if __name__ == "__main__":
    main()
