"""Redraw the README's pictures: python docs/pictures.py."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pneuservo.demo import run_demo
from pneuservo.diagnosis import document
from pneuservo.report.demo_page import loop_picture
from pneuservo.report.diagnosis_figures import diagnosis_figures
from pneuservo.report.svg import draw
from pneuservo.simulation import Simulation
from pneuservo.simulation.phase_plane import draw_edge_view, draw_phase_plane

FOLDER = Path(__file__).parent


def main() -> None:
    """Write the pictures beside this file."""
    with tempfile.TemporaryDirectory() as scratch:
        demo = run_demo(Path(scratch))
    figures = diagnosis_figures(demo.diagnosis, document(demo.diagnosis))
    (FOLDER / "closed-loop.svg").write_text(loop_picture(demo), encoding="utf-8")
    (FOLDER / "diagnosis.svg").write_text(figures["curves"][0][1], encoding="utf-8")
    phase = draw(_phase_plane, demo.loop, size=(9.0, 4.2), shape=(1, 2))
    (FOLDER / "phase-plane.svg").write_text(phase, encoding="utf-8")


def _phase_plane(axes: Sequence[Any], loop: Simulation) -> None:
    draw_phase_plane(loop, axes[0])
    draw_edge_view(loop, axes[1])
    axes[0].legend(loc="upper right", fontsize="small")


if __name__ == "__main__":
    main()
