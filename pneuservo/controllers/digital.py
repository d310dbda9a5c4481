"""Digital controllers: velocity by differences, acceleration by differences or an accelerometer."""

import math
from dataclasses import dataclass
from typing import ClassVar

from pneuservo.controllers.board import DT2812A, Board
from pneuservo.controllers.boundary_layer import boundary_layer
from pneuservo.controllers.requirements import require, sensitivity
from pneuservo.controllers.sampled import Reading, SampledController, Voltage
from pneuservo.controllers.surface import SlidingSurface
from pneuservo.controllers.true_states import StateFeedback
from pneuservo.plant.control_law import limited
from pneuservo.rigs import Rig


class BackwardDifference:
    """The rate of a sampled signal, at rest before the first sample."""

    def __init__(self, sampling_time: float) -> None:
        """Take the sampling time [s]."""
        self._sampling_time = sampling_time
        self._last = math.nan

    def __call__(self, value: float) -> float:
        """Return the rate up to this sample, equation (6.53) of the thesis."""
        change = 0.0 if math.isnan(self._last) else value - self._last
        self._last = value
        return change / self._sampling_time


class DifferencedStates:
    """Displacement error, velocity and acceleration from what is read.

    Notes
    -----
    Equations (6.53) and (6.54) of the thesis; the acceleration is the accelerometer's if it is
    converted.
    """

    def __init__(self, sampling_time: float) -> None:
        """Take the sampling time [s]."""
        self._velocity = BackwardDifference(sampling_time)
        self._acceleration = BackwardDifference(sampling_time)

    def __call__(self, reading: Reading) -> tuple[float, float, float]:
        """Return displacement less demand [m], velocity [m/s], acceleration [m/s^2]."""
        velocity = self._velocity(reading.displacement)
        acceleration = self._acceleration(velocity)
        if not math.isnan(reading.acceleration):
            acceleration = reading.acceleration
        return reading.displacement - reading.demand, velocity, acceleration


@dataclass(frozen=True)
class SampledSlidingMode(SlidingSurface, SampledController):
    """What every sampled sliding mode controller is set by.

    Parameters
    ----------
    settling_time : float, optional
        4/(damping wn) of the sliding surface [s].
    damping : float, optional
        Damping ratio of the sliding surface [-].
    boundary_layer : float, optional
        Half width of the boundary layer; 0 gives an ideal relay [m/s^2].
    level : float, optional
        Largest output [V].
    sampling_time : float, optional
        [s].
    board : Board or None, optional
        The converters; None for exact ones without delay.
    """

    sampling_time: float = 1e-3
    board: Board | None = DT2812A

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        super().__post_init__()
        require(self.kind, "sampling_time", self.sampling_time, above=0.0)

    def switching_function(self, states: tuple[float, float, float]) -> float:
        """Return sigma of displacement error, velocity and acceleration [m/s^2].

        Parameters
        ----------
        states : tuple of float
            [m], [m/s], [m/s^2].
        """
        return -sum(weight * state for weight, state in zip(self.weights, states, strict=True))

    def switched(self, sigma: float) -> float:
        """Return the voltage of relay or boundary layer [V].

        Parameters
        ----------
        sigma : float
            Switching function [m/s^2].
        """
        return boundary_layer(sigma, self.level, self.boundary_layer)


@dataclass(frozen=True)
class DigitalSlidingMode(SampledSlidingMode):
    """Sliding mode on a computer: velocity by differences, acceleration too or measured.

    Parameters
    ----------
    accelerometer : bool, optional
        Whether the acceleration is measured.

    Notes
    -----
    Set-ups of figures 9.7 (without) and 9.8 (with an accelerometer) of the thesis.

    Examples
    --------
    >>> DigitalSlidingMode(sampling_time=1e-4, accelerometer=True).inputs
    ('displacement', 'acceleration')
    """

    kind: ClassVar[str] = "digital-sliding-mode"
    accelerometer: bool = False

    @property
    def inputs(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return what is converted."""
        return ("displacement", "acceleration") if self.accelerometer else ("displacement",)

    def start(self, rig: Rig) -> Voltage:
        """Return what gives the voltage for each reading."""
        states = DifferencedStates(self.sampling_time)
        return lambda reading: self.switched(self.switching_function(states(reading)))


@dataclass(frozen=True)
class DigitalStateFeedback(SampledController):
    """State feedback on a computer, velocity and acceleration by differences.

    Parameters
    ----------
    gain, velocity_gain, acceleration_gain, level : float, optional
        As in `pneuservo.controllers.StateFeedback`.
    sampling_time : float, optional
        [s].
    accelerometer : bool, optional
        Whether the acceleration is measured.
    board : Board or None, optional
        The converters; None for exact ones without delay.

    Notes
    -----
    Figure 5.12 of the thesis, as it was run in chapter 9.
    """

    kind: ClassVar[str] = "digital-state-feedback"
    gain: float = StateFeedback.gain
    velocity_gain: float = StateFeedback.velocity_gain
    acceleration_gain: float = StateFeedback.acceleration_gain
    level: float = StateFeedback.level
    sampling_time: float = 1e-3
    accelerometer: bool = False
    board: Board | None = DT2812A

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        for name in ("level", "sampling_time"):
            require(self.kind, name, getattr(self, name), above=0.0)
        require(self.kind, "gain", self.gain, at_least=0.0)
        for name in ("velocity_gain", "acceleration_gain"):
            require(self.kind, name, getattr(self, name))

    @property
    def inputs(self) -> tuple[str, ...]:  # type: ignore[override]
        """Return what is converted."""
        return ("displacement", "acceleration") if self.accelerometer else ("displacement",)

    def start(self, rig: Rig) -> Voltage:
        """Return what gives the voltage for each reading."""
        states = DifferencedStates(self.sampling_time)
        gains = (self.gain, self.velocity_gain, self.acceleration_gain)
        volts = sensitivity(rig)

        def voltage(reading: Reading) -> float:
            wanted = sum(k * state for k, state in zip(gains, states(reading), strict=True))
            return float(limited(-volts * wanted, self.level))

        return voltage
