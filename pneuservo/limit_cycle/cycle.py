"""A limit cycle, however it was found."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Cycle:
    """A limit cycle of the switching function.

    Attributes
    ----------
    frequency : float
        [Hz].
    high, low : float
        Extremes of the switching function [m/s2].
    stable : bool
        Whether the loop returns to it from nearby.
    mean_error : float
        Demand less displacement, mean over the cycle [m].
    """

    frequency: float
    high: float
    low: float
    stable: bool
    mean_error: float

    @property
    def amplitude(self) -> float:
        """Return half the range of the switching function [m/s2]."""
        return 0.5 * (self.high - self.low)

    @property
    def asymmetry(self) -> float:
        """Return the mean of the extremes over the amplitude: 0 when symmetric [-]."""
        return 0.5 * (self.high + self.low) / self.amplitude


def dominant(cycles: list[Cycle], near: float | None = None) -> Cycle | None:
    """Return the cycle that a loop is expected to show, None without a stable one.

    Parameters
    ----------
    cycles : list of Cycle
        All that were found.
    near : float, optional
        A frequency known from elsewhere; by default the slowest stable cycle is taken, as a loop
        that comes from a large error meets it first [Hz].

    Examples
    --------
    >>> cycles = [Cycle(100.0, 1.0, -1.0, False, 0.0), Cycle(200.0, 1.0, -1.0, True, 0.0)]
    >>> dominant(cycles).frequency
    200.0
    """
    stable = [cycle for cycle in cycles if cycle.stable]
    if not stable:
        return None
    if near is None:
        return min(stable, key=lambda cycle: cycle.frequency)
    return min(stable, key=lambda cycle: abs(cycle.frequency - near))
