"""Drawing circuit symbols at given places, with schemdraw."""

from itertools import pairwise
from typing import Any

from analog_card.quantities import as_text

Point = tuple[float, float]

_NORMAL, _LARGE = 10, 12
_NET = "#1f4e9c"
# Length of a potentiometer on the sheet.
_TRACK = 3.0
_AMPLIFIER = 2.166  # length of schemdraw's op-amp from its inputs to its output


class Sheet:
    """A drawing in which everything is put at a place.

    Notes
    -----
    Points are in units of the drawing; the inputs of an op-amp are 1.25 apart.
    """

    def __init__(self) -> None:
        import schemdraw
        import schemdraw.elements as elements

        self._elements = elements
        self._drawing = schemdraw.Drawing(show=False, canvas="matplotlib")
        self._drawing.config(fontsize=_NORMAL, lw=1.2, font="DejaVu Sans")

    def draw(self, ax: Any) -> None:
        """Put the drawing on matplotlib axes."""
        import matplotlib

        # Titles and names of nodes may hold dollar signs.
        with matplotlib.rc_context({"text.parse_math": False}):
            self._drawing.draw(show=False, canvas=ax)
        ax.set_aspect("equal")
        ax.axis("off")

    def line(self, *points: Point, dots: bool = False) -> None:
        """Connect points, with a dot at both ends if wanted."""
        for start, end in pairwise(points):
            self._drawing += self._elements.Line().at(start).to(end)
        if dots:
            self.dot(points[0])
            self.dot(points[-1])

    def dot(self, at: Point) -> None:
        """Mark a connection."""
        self._drawing += self._elements.Dot(radius=0.07).at(at)

    def ground(self, at: Point) -> None:
        """Connect to ground."""
        self._drawing += self._elements.Ground().at(at)

    def part(
        self,
        kind: str,
        start: Point,
        end: Point,
        name: str,
        value: float,
        side: str,
        note: str = "",
    ) -> None:
        """Draw a resistor (R) or capacitor (C) with name and value on one side of it."""
        unit = {"R": "ohm", "C": "F"}[kind]
        symbol = {"R": self._elements.ResistorIEC, "C": self._elements.Capacitor}[kind]
        self._drawing += symbol().at(start).to(end)
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        gap = 0.5
        text = as_text(value, unit, 3)
        if side in ("top", "bottom"):
            shift = gap if side == "top" else -gap
            self.text(
                (middle[0], middle[1] + shift),
                f"{name} {text}{note}",
                "center",
                "bottom" if side == "top" else "top",
            )
        else:
            shift = gap if side == "right" else -gap
            self.text(
                (middle[0] + shift, middle[1]),
                f"{name}\n{text}{note}",
                "left" if side == "right" else "right",
                "center",
            )

    def two(self, *parts: tuple[str, Point, Point, str, float]) -> Point:
        """Draw parts in a row, labels above, and return where the last ends."""
        for kind, start, end, name, value in parts:
            self.part(kind, start, end, name, value, "top")
        return parts[-1][2]

    def amplifier(self, at: Point, name: str, plus_on_top: bool = False) -> Point:
        """Draw an op-amp by the middle of its inputs; return where its output is."""
        symbol: Any = self._elements.Opamp()
        if plus_on_top:
            symbol = symbol.flip()
        anchor, upper = ("in2", at[1] + 0.625) if plus_on_top else ("in1", at[1] + 0.625)
        self._drawing += symbol.right().at((at[0], upper)).anchor(anchor)
        self.text((at[0] + 0.85, at[1]), name, "center", "center")
        return (at[0] + _AMPLIFIER, at[1])

    def feedback(
        self, minus: Point, out: Point, height: float, part: tuple[str, str, float]
    ) -> None:
        """Draw a part from the output back to the input, so high above the output's row."""
        level = out[1] + height if out[1] < minus[1] else out[1] + (height - 2.3)
        kind, name, value = part
        self.line(minus, (minus[0], level))
        self.line(out, (out[0], level))
        middle = (minus[0] + out[0]) / 2
        self.line((minus[0], level), (middle - 1.1, level))
        self.line((middle + 1.1, level), (out[0], level))
        self.part(kind, (middle - 1.1, level), (middle + 1.1, level), name, value, "top")
        self.dot(minus)
        self.dot(out)

    def potentiometer(self, top: Point, name: str, track: float, travel: float) -> Point:
        """Draw a potentiometer downwards from its top; return where its wiper ends."""
        symbol = self._elements.PotentiometerIEC()
        self._drawing += symbol.at(top).to((top[0], top[1] - _TRACK))
        wiper = self._drawing.elements[-1].absanchors["tap"]
        self.text(
            (top[0] - 0.45, top[1] - _TRACK / 2),
            f"{name}\n{as_text(track, 'ohm', 3)}\n{100 * travel:.1f} %",
            "right",
            "center",
        )
        return (float(wiper[0]), float(wiper[1]))

    def rheostat(self, start: Point, name: str, track: float, travel: float) -> Point:
        """Draw a variable resistor to the right, its wiper tied to the far end; return that end."""
        end = (start[0] + _TRACK, start[1])
        self._drawing += self._elements.PotentiometerIEC().at(start).to(end)
        wiper = self._drawing.elements[-1].absanchors["tap"]
        self.line(
            (float(wiper[0]), float(wiper[1])),
            (end[0] - 0.2, float(wiper[1])),
            (end[0] - 0.2, end[1]),
        )
        self.dot((end[0] - 0.2, end[1]))
        self.text(
            (start[0] + _TRACK / 2, start[1] - 0.5),
            f"{name}  {as_text(track, 'ohm', 3)}\n{100 * travel:.1f} %",
            "center",
            "top",
        )
        return end

    def zeners(self, top: Point, level: float) -> None:
        """Draw two zeners back to back downwards, with the level they clamp at."""
        x, y = top
        self._drawing += self._elements.Zener().at((x, y - 1.8)).to((x, y))
        self._drawing += self._elements.Zener().at((x, y - 1.8)).to((x, y - 3.6))
        self.text((x - 0.5, y - 1.8), f"D1, D2\n±{level:g} V", "right", "center")

    def link(self, start: Point, end: Point, name: str) -> None:
        """Draw a link that can be opened."""
        middle = ((start[0] + end[0]) / 2, start[1])
        left, right = (middle[0] - 0.45, middle[1]), (middle[0] + 0.45, middle[1])
        self.line(start, left)
        self.line(right, end)
        self.line(left, right)
        for at in (left, right):
            self._drawing += self._elements.Dot(open=True, radius=0.1).at(at)
        self.text((middle[0], middle[1] - 0.5), name, "center", "top")

    def terminal(self, at: Point, name: str, side: str = "left") -> None:
        """Draw a connector with its name beside it."""
        self._drawing += self._elements.Dot(open=True, radius=0.12).at(at)
        self._beside(at, name, side, 0.4, weight="bold")

    def net(self, at: Point, name: str, side: str) -> None:
        """Name a connection that goes on elsewhere on the sheet."""
        x, y = at
        if side == "on":
            self.dot(at)
            self.text((x + 0.25, y - 0.2), name, "left", "top", _NET)
            return
        if side == "below":
            self.line(at, (x, y - 0.8))
            self.text((x, y - 0.95), name, "center", "top", _NET)
            return
        self._beside(at, name, side, 0.15, colour=_NET)

    def heading(self, at: Point, text: str) -> None:
        """Write the name of a part of the circuit."""
        self.text(at, text, "left", "bottom", "#555555", _LARGE)

    def notes(self, at: Point, lines: tuple[str, ...]) -> None:
        """Write lines below one another, the first one large."""
        self.text(at, lines[0], "left", "bottom", size=_LARGE + 3)
        for number, line in enumerate(lines[1:], 1):
            self.text((at[0], at[1] - 0.9 * number), line, "left", "bottom", size=_LARGE)

    def text(
        self,
        at: Point,
        text: str,
        across: Any,
        along: Any,
        colour: str = "black",
        size: int = _NORMAL,
    ) -> None:
        """Write text at a place."""
        self._drawing += (
            self._elements.Label()
            .at(at)
            .label(text, halign=across, valign=along, color=colour, fontsize=size, ofst=0)
        )

    def _beside(
        self, at: Point, name: str, side: str, gap: float, colour: str = "black", weight: str = ""
    ) -> None:
        x, y = at
        shift = {
            "left": ((x - gap, y), "right", "center"),
            "right": ((x + gap, y), "left", "center"),
            "down": ((x, y - gap), "center", "top"),
        }
        place, across, along = shift[side]
        self.text(place, name, across, along, colour, _LARGE if weight else _NORMAL)
