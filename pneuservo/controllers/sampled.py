"""What every controller that samples the plant has, and what it gets to read."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

from analog_card.figures import CardFigures
from pneuservo.controllers.board import Board
from pneuservo.rigs import Rig


class Reading(NamedTuple):
    """What the converters have at a sampling time; NaN for what is not converted."""

    time: float
    """[s]."""
    demand: float
    """[m]; known exactly."""
    displacement: float = math.nan
    """[m]."""
    acceleration: float = math.nan
    """Of an accelerometer on the piston [m/s^2]."""
    pressure_a: float = math.nan
    pressure_b: float = math.nan
    """Absolute [Pa]."""
    card_velocity: float = math.nan
    card_acceleration: float = math.nan
    """Taps of a card's differentiators [V]."""


INPUTS = Reading._fields[2:]
"""What can be converted."""

Voltage = Callable[[Reading], float]


class SampledController(ABC):
    """A controller that is asked for a voltage at every sampling time.

    Attributes
    ----------
    kind : str
        What it is called.
    sampling_time : float
        [s].
    inputs : tuple of str
        What it reads, names of `INPUTS`; each one converted costs time.
    board : Board or None
        The converters; without it they are exact and take no time.
    differentiators : CardFigures or None
        A card whose taps it reads; only its differentiators are used.
    transducer_noise : float
        Of the displacement transducer before the differentiators, root mean square up to
        half the integration's steps [V].
    """

    kind: ClassVar[str] = "custom"
    sampling_time: float = 1e-3
    inputs: tuple[str, ...] = ("displacement",)
    board: Board | None = None
    differentiators: CardFigures | None = None
    transducer_noise: float = 0.0

    @abstractmethod
    def start(self, rig: Rig) -> Voltage:
        """Return what gives the voltage for each reading; its memory is that of one run.

        Parameters
        ----------
        rig : Rig
            What is controlled.

        Returns
        -------
        callable
            From `Reading` to a voltage, held until the next [V].
        """
