"""What one concealed effect is: where it acts, and the forms the truth has for it."""

from collections.abc import Callable
from dataclasses import dataclass

from pneuservo.challenge.truth.parameters import Truth

PHYSICS, SENSOR, PARAMETER, OUTSIDE, NONE = "physics", "sensor", "parameter", "outside", "none"


@dataclass(frozen=True)
class Form:
    """One form the truth has for an effect.

    Parameters
    ----------
    name : str
        What the form is, in words.
    apply : callable
        Puts an effect of a size into a truth.
    shared : bool, optional
        Whether a catalogue would write the same formula; such cases are reported apart.
    """

    name: str
    apply: Callable[[Truth, float], Truth]
    shared: bool = False


@dataclass(frozen=True)
class ConcealedEffect:
    """An effect that a case may conceal.

    Parameters
    ----------
    id : str
        As in the catalogue; effects outside it have ids of their own.
    kind : str
        ``physics``, ``sensor``, ``parameter``, ``outside`` or ``none``.
    blocks : tuple of str
        Blocks that are a right answer, the block of the equation first.
    low, high : float
        Smallest and largest size [unit].
    unit : str
        Unit of the size.
    forms : tuple of Form
        At least one.
    shown_by : tuple of str
        Kinds of experiment that show it; empty when all do.
    floor : float, optional
        Smallest size that can be simulated in good time, over `low`.
    scales : bool, optional
        Whether it grows from nothing with its size; otherwise the size is a property of the rig.
    """

    id: str
    kind: str
    blocks: tuple[str, ...]
    low: float
    high: float
    unit: str
    forms: tuple[Form, ...]
    shown_by: tuple[str, ...] = ()
    floor: float = 0.01
    scales: bool = True

    @property
    def smallest(self) -> float:
        """Return the smallest size that is tried; hidden effects may be smaller than matters."""
        return self.floor * self.low
