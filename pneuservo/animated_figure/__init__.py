"""The animated figure: members driven by pneumatic axes, on one compliant frame."""

from pneuservo.animated_figure.figure import BUILT_IN_FIGURES, AnimatedFigure, Axis, Frame
from pneuservo.animated_figure.figure_file import load_figure
from pneuservo.animated_figure.result import FigureRun
from pneuservo.animated_figure.run import simulate_figure

__all__ = [
    "BUILT_IN_FIGURES",
    "AnimatedFigure",
    "Axis",
    "FigureRun",
    "Frame",
    "load_figure",
    "simulate_figure",
]
