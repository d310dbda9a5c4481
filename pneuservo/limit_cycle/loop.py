"""A sliding-mode loop cut open at its relay: what lies between valve voltage and surface."""

import math
from dataclasses import dataclass, field

import control
import numpy as np
from numpy.typing import NDArray

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.linear.models import state_space
from pneuservo.sliding_mode.boundary_layer import WIDTHS

# How velocity and acceleration come about.
MEASURED, BACKWARD, BILINEAR, ANALOGUE = "measured", "backward", "bilinear", "analogue"
DIFFERENTIATIONS = (MEASURED, BACKWARD, BILINEAR, ANALOGUE)
# Lowest and highest value by SI unit, a few orders of magnitude round what a servo can have: beyond
# them its matrices are rounding. A controller that samples more often is analogue for all that a
# valve can tell; one that samples less often takes no part in the motion.
_LIMITS = {"s": (1e-6, 0.1), "Hz": (1e-2, 5e4), "V": (1e-3, 1e3), "m/s2": WIDTHS}
# Which states a Butterworth filter acts on.
NO_STATES, ALL_STATES, SOME_STATES = "none", "all", "displacement-velocity"
FILTERED = (NO_STATES, ALL_STATES, SOME_STATES)


@dataclass(frozen=True)
class Signals:
    """How displacement, velocity and acceleration reach the switching function.

    Parameters
    ----------
    differentiation : str, optional
        ``measured``: each state has its own transducer; ``backward`` or ``bilinear`` differences
        of the sampled displacement; ``analogue`` differentiators.
    sampling_time : float, optional
        Of a digital controller behind a zero-order hold; 0 for an analogue one [s].
    filtered : str, optional
        States behind a Butterworth filter of second order: ``none``, ``all`` or
        ``displacement-velocity``.
    filter_frequency : float, optional
        Its cut-off [Hz].
    velocity_breaks, acceleration_breaks : tuple of float, optional
        Two breaks of each analogue differentiator [Hz].

    Raises
    ------
    InputError
        When differences are asked for without a sampling time, or a value is impossible.
    """

    differentiation: str = MEASURED
    sampling_time: float = 0.0
    filtered: str = NO_STATES
    filter_frequency: float = 500.0
    velocity_breaks: tuple[float, float] = (5000.0, 5000.0)
    acceleration_breaks: tuple[float, float] = (5000.0, 5000.0)

    def __post_init__(self) -> None:
        """Refuse signals that no loop can have."""
        for name, value, known in (
            ("differentiation", self.differentiation, DIFFERENTIATIONS),
            ("filtered", self.filtered, FILTERED),
        ):
            if value not in known:
                raise InputError(f"{name} is {value!r}; allowed are: {', '.join(known)}")
        _require_within_limits(
            "sampling time", self.sampling_time, "s", "0, for an analogue controller, or "
        )
        if self.differentiation in (BACKWARD, BILINEAR) and not self.sampled:
            raise InputError(
                f"{self.differentiation} differences need a sampling time greater than 0"
            )
        _require_within_limits("filter frequency", self.filter_frequency, "Hz")
        for frequency in (*self.velocity_breaks, *self.acceleration_breaks):
            _require_within_limits("break frequency", frequency, "Hz")

    @property
    def sampled(self) -> bool:
        """Return whether the controller is digital."""
        return self.sampling_time > 0.0


@dataclass(frozen=True)
class Loop:
    """A linear servo under a relay that switches with the sign of the sliding surface.

    Parameters
    ----------
    servo : LinearServo
        Displacement over voltage; an infinite valve frequency leaves the valve's dynamics out.
    weights : tuple of float
        c1 [1/s2], c2 [1/s] and c3 [-] of the surface.
    level : float, optional
        Largest voltage [V].
    boundary_layer : float, optional
        Surface value at which the voltage reaches its level; 0 for a relay [m/s2].
    asymmetry : float, optional
        Share by which a positive voltage acts more strongly, a negative one less, than the
        servo's b0 says [-].
    signals : Signals, optional
        By default every state is measured, without delay.

    Raises
    ------
    InputError
        When a value is impossible.

    Notes
    -----
    sigma = -c1 (x - xd) - c2 v - c3 a and u = +level sgn(sigma): chapters 6.5 and 7.4 of the
    thesis print a minus there, which would be positive feedback.
    """

    servo: LinearServo
    weights: tuple[float, float, float]
    level: float = 5.0
    boundary_layer: float = 0.0
    asymmetry: float = 0.0
    signals: Signals = field(default_factory=Signals)

    def __post_init__(self) -> None:
        """Refuse a loop that cannot be built."""
        if not all(0.0 <= weight < math.inf for weight in self.weights) or not self.weights[0]:
            raise InputError(
                f"weights are {self.weights}; c1 has to be greater than 0, c2 and c3 0 or more"
            )
        _require_within_limits("level", self.level, "V")
        _require_within_limits("boundary layer", self.boundary_layer, "m/s2", "0, for a relay, or ")
        if not -1.0 < self.asymmetry < 1.0:
            raise InputError(f"asymmetry is {self.asymmetry:g}; it has to be between -1 and 1")

    @property
    def levels(self) -> tuple[float, float]:
        """Return the voltages that act, positive and negative, both as magnitudes [V]."""
        return self.level * (1.0 + self.asymmetry), self.level * (1.0 - self.asymmetry)

    @property
    def highest_frequency(self) -> float:
        """Return the highest frequency at which the loop can cycle; infinite unsampled [Hz]."""
        if not self.signals.sampled:
            return math.inf
        return 0.5 / self.signals.sampling_time


def _require_within_limits(what: str, value: float, unit: str, zero: str = "") -> None:
    """Refuse a value that no servo can have; what 0 stands for, where it may be that."""
    lowest, highest = _LIMITS[unit]
    if not (lowest <= value <= highest or (zero and value == 0.0)):
        raise InputError(
            f"{what} is {value:g} {unit}; it has to be {zero}from {lowest:g} to {highest:g} {unit}"
        )


def loop_system(loop: Loop) -> control.StateSpace:
    """Return the open loop: from valve voltage to the surface with its sign turned, and error.

    Parameters
    ----------
    loop : Loop
        The loop.

    Returns
    -------
    control.StateSpace
        One input [V]; outputs c1 e + c2 v + c3 a as the controller sees them [m/s2], and the true
        displacement error e = x - xd [m]. Discrete, with a zero-order hold, when sampled.

    Notes
    -----
    Equations (8.1), (8.2), (8.4), (8.5) and, sampled, (8.6) to (8.8) of the thesis.

    Examples
    --------
    >>> loop = Loop(LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0))
    >>> loop_system(loop).nstates
    5
    """
    plant = state_space(loop.servo)
    path = signal_path(loop.signals)
    # The true displacement passes beside the signal path.
    split = control.append(path, _gain(np.eye(1)))
    spread = _gain(np.vstack((np.eye(3), [[1.0, 0.0, 0.0]])))
    continuous = control.series(plant, spread, split)
    signals = loop.signals
    if signals.sampled:
        continuous = control.sample_system(continuous, signals.sampling_time, method="zoh")
    surface = control.append(surface_filter(loop), _gain(np.eye(1), signals.sampling_time))
    return control.series(continuous, surface)


def loop_response(loop: Loop, frequency: Array) -> NDArray[np.complex128]:
    """Return the open loop from valve voltage to the surface with its sign turned.

    Parameters
    ----------
    loop : Loop
        The loop.
    frequency : (n,) array
        Not 0, where the servo integrates [Hz].

    Returns
    -------
    (n,) array
        [m/(s2 V)].
    """
    s = 2j * math.pi * np.asarray(frequency, dtype=float)
    signals = loop.signals
    argument = np.exp(s * signals.sampling_time) if signals.sampled else s
    values: NDArray[np.complex128] = loop_system(loop)(argument)[0, 0]
    return values


def signal_path(signals: Signals) -> control.StateSpace:
    """Return the analogue part of the signals: from x, v and a to what the controller gets.

    Parameters
    ----------
    signals : Signals
        How the states reach the switching function.

    Returns
    -------
    control.StateSpace
        Continuous; three inputs, three outputs. Behind digital differences all three outputs
        are displacements, each with its own filter.

    Notes
    -----
    Analogue differentiators as equation (9.3) of the thesis, s/((1 + s/w1)(1 + s/w2)) each.
    """
    from_displacement = signals.differentiation != MEASURED
    source = np.array([[1.0, 0.0, 0.0]] * 3) if from_displacement else np.eye(3)
    parts = [_gain(np.eye(1)), _gain(np.eye(1)), _gain(np.eye(1))]
    if signals.differentiation == ANALOGUE:
        velocity = _differentiator(signals.velocity_breaks)
        parts[1] = velocity
        parts[2] = control.series(velocity, _differentiator(signals.acceleration_breaks))
    if signals.filtered != NO_STATES:
        count = 3 if signals.filtered == ALL_STATES else 2
        low_pass = butterworth(signals.filter_frequency)
        for i in range(count):
            parts[i] = control.series(low_pass, parts[i])
    return control.series(_gain(source), control.append(*parts))


def surface_filter(loop: Loop) -> control.StateSpace:
    """Return what forms the surface: weights, and digital differences where they are used.

    Parameters
    ----------
    loop : Loop
        The loop.

    Returns
    -------
    control.StateSpace
        Three inputs; discrete when sampled.

    Notes
    -----
    Equations (6.53) to (6.56) of the thesis.
    """
    signals, period = loop.signals, loop.signals.sampling_time
    weights = [_gain(np.array([[weight]]), period) for weight in loop.weights]
    if signals.differentiation in (BACKWARD, BILINEAR):
        if signals.differentiation == BACKWARD:
            top, bottom = np.array([1.0, -1.0]) / period, np.array([1.0, 0.0])
        else:
            top, bottom = np.array([2.0, -2.0]) / period, np.array([1.0, 1.0])
        first = control.tf2ss(control.tf(top, bottom, period))
        second = control.tf2ss(control.tf(np.polymul(top, top), np.polymul(bottom, bottom), period))
        weights[1] = control.series(first, weights[1])
        weights[2] = control.series(second, weights[2])
    summed = _gain(np.ones((1, 3)), period)
    return control.series(control.append(*weights), summed)


def butterworth(frequency: float) -> control.StateSpace:
    """Return a low-pass filter of second order, maximally flat.

    Parameters
    ----------
    frequency : float
        Cut-off [Hz].
    """
    w = 2.0 * math.pi * frequency
    return control.tf2ss(control.tf([w * w], [1.0, math.sqrt(2.0) * w, w * w]))


def _differentiator(breaks: tuple[float, float]) -> control.StateSpace:
    first, second = (1.0 / (2.0 * math.pi * frequency) for frequency in breaks)
    return control.tf2ss(control.tf([1.0, 0.0], np.polymul([first, 1.0], [second, 1.0])))


def _gain(matrix: Array, period: float = 0.0) -> control.StateSpace:
    return control.ss([], [], [], matrix, period)
