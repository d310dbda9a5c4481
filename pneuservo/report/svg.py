"""Figures as SVG text that can stand inside a page."""

import io
from collections.abc import Callable
from typing import Any

MEASURED, BASELINE, REPAIRED, GUILTY = "#1b1b1b", "#d1761b", "#1f6fb4", "#c8372d"
"""One colour each, in every picture."""

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "pneuservo",
    "font.family": "sans-serif",
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    # Names of recordings may hold dollar signs.
    "text.parse_math": False,
}


def draw(
    paint: Callable[..., Any],
    *content: Any,
    size: tuple[float, float],
    shape: tuple[int, int] = (1, 1),
    ratios: tuple[float, ...] | None = None,
) -> str:
    """Return a picture as the text of one ``<svg>`` element.

    Parameters
    ----------
    paint : callable
        Draws on the axes it is given; called as ``paint(axes, *content)``.
    *content
        What it draws.
    size : (width, height)
        In inches.
    shape : (rows, columns), optional
        Number of axes; one is passed as it is, several as a list.
    ratios : tuple of float, optional
        Relative heights of the rows.

    Returns
    -------
    str
        An ``<svg>`` element without XML header, free of references to other files.
    """
    import matplotlib

    with matplotlib.rc_context(_STYLE):
        from matplotlib.figure import Figure

        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots(*shape, squeeze=False, height_ratios=ratios).ravel().tolist()
        paint(axes[0] if len(axes) == 1 else axes, *content)
        for each in figure.axes:
            for axis in (each.xaxis, each.yaxis):
                if axis.get_scale() == "log":
                    # Powers of ten as they are else would be marked up, and dollar signs are text.
                    axis.set_major_formatter("{x:g}")
                    axis.set_minor_formatter("")
        stream = io.StringIO()
        bare = {"Date": None, "Creator": None}
        figure.savefig(stream, format="svg", bbox_inches="tight", metadata=bare)
    text = stream.getvalue()
    return text[text.index("<svg") :]
