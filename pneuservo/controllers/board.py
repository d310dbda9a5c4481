"""The converters between a plant and a controller that samples it."""

import math
from dataclasses import dataclass

from pneuservo.controllers.requirements import require


@dataclass(frozen=True)
class Board:
    """Analogue inputs and one analogue output: resolution, ranges, noise and delay.

    Parameters
    ----------
    bits : int, optional
        Of every converter.
    input_noise : float, optional
        Root mean square at an input, as a share of its range [-].
    output_low, output_high : float, optional
        Range of the output [V].
    conversion_time : float, optional
        For one input after the other [s].
    output_settling_time : float, optional
        From the last input to the new output voltage, computing included [s].

    Notes
    -----
    The defaults are the DT2812A, table 3.10 of the thesis. Its noise is not stated: an error of
    0.03 % of the range is, taken here as three standard deviations. The time for computing is
    not stated either, and left out. Every input has the whole range of its converter, as
    equations (9.1) and (9.2) have it.
    """

    bits: int = 12
    input_noise: float = 1e-4
    output_low: float = -5.0
    output_high: float = 5.0
    conversion_time: float = 8e-6
    output_settling_time: float = 10e-6

    def __post_init__(self) -> None:
        """Refuse values that make no board."""
        require("board", "bits", self.bits, at_least=1.0)
        for name in ("input_noise", "conversion_time", "output_settling_time"):
            require("board", name, getattr(self, name), at_least=0.0)
        require("board", "output_high", self.output_high, above=self.output_low)

    def delay(self, inputs: int) -> float:
        """Return the time from a sampling instant to the new output voltage [s].

        Parameters
        ----------
        inputs : int
            How many are converted.

        Examples
        --------
        >>> round(1e6 * DT2812A.delay(2))
        26
        """
        return inputs * self.conversion_time + self.output_settling_time

    def read(self, value: float, low: float, high: float, noise: float = 0.0) -> float:
        """Return what an input makes of a value.

        Parameters
        ----------
        value : float
            In any unit.
        low, high : float
            Range of the input, in that unit.
        noise : float, optional
            Drawn from a standard normal distribution [-].

        Examples
        --------
        >>> 1e6 * DT2812A.read(10e-6, 0.0, 30e-3)  # the nearest step, 7.3 um
        7.32421875
        """
        return self._quantised(value + noise * self.input_noise * (high - low), low, high)

    def write(self, voltage: float) -> float:
        """Return the output voltage for a wanted one [V].

        Parameters
        ----------
        voltage : float
            [V].
        """
        return self._quantised(voltage, self.output_low, self.output_high)

    def _quantised(self, value: float, low: float, high: float) -> float:
        codes = 2**self.bits
        step = (high - low) / codes
        code = min(max(math.floor((value - low) / step + 0.5), 0), codes - 1)
        return low + code * step


DT2812A = Board()
