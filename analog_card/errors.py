"""Exceptions raised by the card."""

from collections.abc import Sequence
from pathlib import Path


class AnalogCardError(Exception):
    """Base of every exception that this package raises on purpose."""


class InputError(AnalogCardError):
    """Something the user gave cannot be used; the message says what, where and what is allowed."""


class SimulationError(AnalogCardError):
    """The circuit simulator could not do what was asked; the message carries its own words.

    Attributes
    ----------
    words : tuple of str
        What ngspice said, unchanged; empty when it said nothing.
    file : Path or None
        The file that it means, which may be an included one; the netlist when it names no line.
    line : int or None
        Line in that file.
    node : str or None
        The node, or the branch as ``source#branch``, at which it failed.
    """

    def __init__(
        self,
        message: str,
        *,
        words: Sequence[str] = (),
        file: Path | None = None,
        line: int | None = None,
        node: str | None = None,
    ) -> None:
        super().__init__(message)
        self.words = tuple(words)
        self.file = file
        self.line = line
        self.node = node
