"""Controllers that have the true velocity and acceleration."""

import math
from dataclasses import dataclass
from typing import ClassVar

from pneuservo.controllers.requirements import require, sensitivity
from pneuservo.controllers.surface import SlidingSurface
from pneuservo.plant.control_law import TRUE_STATES, ControlLaw
from pneuservo.rigs import Rig


@dataclass(frozen=True)
class SlidingMode(SlidingSurface):
    """Sliding mode with the true velocity and acceleration.

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

    Notes
    -----
    Equations (6.43), (7.1), (7.3) and (7.4) of the thesis: c1 = wn^2, c2 = 2 damping wn, c3 = 1.
    The boundary layer is printed there as 5000 m/s^2, which can only be 5000 mm/s^2.

    Examples
    --------
    >>> c1, c2, c3 = SlidingMode(settling_time=0.07, damping=1.0).weights
    >>> round(c1, 1), round(c2, 3), c3
    (3265.3, 114.286, 1.0)
    """

    kind: ClassVar[str] = "sliding-mode"

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        relay = self.boundary_layer == 0.0
        gain = math.inf if relay else self.level / self.boundary_layer
        return _law_of_true_states(self.weights, gain, self.level, rig)


@dataclass(frozen=True)
class Proportional:
    """Proportional control of the displacement, on transducer volts.

    Parameters
    ----------
    gain : float, optional
        Output per transducer voltage; the thesis calls 1 well behaved and 3.4 oscillating [V/V].
    level : float, optional
        Largest output [V].
    """

    kind: ClassVar[str] = "proportional"
    gain: float = 1.0
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        require(self.kind, "level", self.level, above=0.0)
        require(self.kind, "gain", self.gain, at_least=0.0)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        return _law_of_true_states((sensitivity(rig), 0.0, 0.0), self.gain, self.level, rig)


@dataclass(frozen=True)
class StateFeedback:
    """Feedback of displacement, velocity and acceleration, on transducer volts.

    Parameters
    ----------
    gain : float, optional
        Of the displacement error [V/V].
    velocity_gain : float, optional
        Of the velocity; negative feeds it back positively [s].
    acceleration_gain : float, optional
        Of the acceleration [s^2].
    level : float, optional
        Largest output [V].

    Notes
    -----
    u = S (Kp (xd - x) - Kv v - Ka a) with the transducer gain S. The defaults are those of table
    5.5 of the thesis, extension at mid-stroke, settling time 0.4 s and damping 0.4.
    """

    kind: ClassVar[str] = "state-feedback"
    gain: float = 0.2407
    velocity_gain: float = -0.0379
    acceleration_gain: float = 0.0002
    level: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that make no controller."""
        require(self.kind, "level", self.level, above=0.0)
        require(self.kind, "gain", self.gain, at_least=0.0)
        require(self.kind, "velocity_gain", self.velocity_gain)
        require(self.kind, "acceleration_gain", self.acceleration_gain)

    def law(self, rig: Rig) -> ControlLaw:
        """Return the law as the kernels take it."""
        gains = (self.gain, self.velocity_gain, self.acceleration_gain)
        return _law_of_true_states(gains, sensitivity(rig), self.level, rig)


def _law_of_true_states(
    weights: tuple[float, float, float], gain: float, level: float, rig: Rig
) -> ControlLaw:
    return ControlLaw(
        source=TRUE_STATES,
        weight_displacement=float(weights[0]),
        weight_velocity=float(weights[1]),
        weight_acceleration=float(weights[2]),
        surface_limit=math.inf,
        gain=float(gain),
        level=float(level),
        sensitivity=sensitivity(rig),
        velocity_time_constant=0.0,
        velocity_lag_1=1.0,
        velocity_lag_2=1.0,
        acceleration_time_constant=0.0,
        acceleration_lag_1=1.0,
        acceleration_lag_2=1.0,
    )
