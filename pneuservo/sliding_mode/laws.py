"""What switches the valve: the plain law, and laws against its shortcomings."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from analog_card.linear_servo import LinearServo
from pneuservo.controllers.boundary_layer import boundary_layer, smooth_boundary_layer
from pneuservo.errors import InputError
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.surface import Surface


class Law(Protocol):
    """A control law, evaluated once each step with the state it is given."""

    def sigma(self, state: tuple[float, ...]) -> float:
        """Return the switching function of the error and its derivatives."""

    def voltage(self, state: tuple[float, ...], step: float) -> float:
        """Return the voltage for the next step; a law with memory moves on by it [V]."""


@dataclass(frozen=True)
class Switching:
    """The plain law: a surface and a relay, with a boundary layer or without.

    Attributes
    ----------
    surface : Surface
        What is switched on.
    level : float
        Largest voltage when extending [V].
    width : float
        Of the boundary layer; 0 is a relay [unit of sigma].
    smooth : bool
        Whether the layer is the smooth one.
    retracting_level : float or None
        Largest voltage when retracting; None for the same [V].

    Notes
    -----
    Equations (6.43) and (6.44) of the thesis. Two levels are the direction-dependent switching
    gains its chapter 10 asks for: equal jerk either way makes switching symmetric again.
    """

    surface: Surface
    level: float
    width: float = 0.0
    smooth: bool = False
    retracting_level: float | None = None

    def sigma(self, state: tuple[float, ...]) -> float:
        """Return the switching function."""
        return self.surface.value(*state[: self.surface.order + 1])

    def voltage(self, state: tuple[float, ...], step: float) -> float:
        """Return the voltage [V]."""
        sigma = self.sigma(state)
        level = self.level
        if sigma < 0.0 and self.retracting_level is not None:
            level = self.retracting_level
        if self.smooth:
            return smooth_boundary_layer(sigma, level, self.width)
        return boundary_layer(sigma, level, self.width)


def equal_jerk_levels(
    extending: LinearServo, retracting: LinearServo, level: float
) -> tuple[float, float]:
    """Return the levels for extending and retracting that give the same jerk either way.

    Parameters
    ----------
    extending, retracting : LinearServo
        The servo in either direction, with a valve that follows the switching.
    level : float
        What there is; the weaker direction has it in full [V].

    Examples
    --------
    >>> equal_jerk_levels(LinearServo(b0=1000.0), LinearServo(b0=800.0), 5.0)
    (4.0, 5.0)
    """
    weaker = min(extending.b0, retracting.b0)
    return level * weaker / extending.b0, level * weaker / retracting.b0


def balanced_levels(
    extending: LinearServo, retracting: LinearServo, level: float, frequency: float
) -> tuple[float, float]:
    """Return the levels for extending and retracting that balance the jerk behind a slow valve.

    Parameters
    ----------
    extending, retracting : LinearServo
        The servo in either direction, with the dynamics of its valve.
    level : float
        What there is; the weaker direction has it in full [V].
    frequency : float
        Of the chattering [Hz].

    Notes
    -----
    Behind a slow valve the opening is all but a sine about the mean of the two levels, and a
    smaller difference balances the directions than `equal_jerk_levels`: the mean of b0(sign w) w
    over w = W sin - o is zero, with W = (4/pi) M |V|, M the mean level, |V| the gain of the valve
    at the chattering and o half the difference.

    Examples
    --------
    >>> levels = balanced_levels(LinearServo(b0=1000.0), LinearServo(b0=800.0), 5.0, 200.0)
    >>> [round(each, 2) for each in levels]
    [4.39, 5.0]
    """
    r = frequency / extending.valve_frequency
    wave = 4 / math.pi / abs(1 - r * r + 2j * extending.valve_damping * r)
    ratio = min(extending.b0, retracting.b0) / max(extending.b0, retracting.b0)

    def excess(offset: float) -> float:
        # Mean of the opening beyond null in the stronger direction, for M = 1; in the weaker one
        # it is greater by the offset.
        angle = math.asin(offset / wave)
        stronger = wave * math.cos(angle) / math.pi - offset * (0.5 - angle / math.pi)
        return (1 - ratio) * stronger - ratio * offset

    offset = float(brentq(excess, 0.0, wave))
    reduced = level * (1 - offset) / (1 + offset)
    return (reduced, level) if extending.b0 > retracting.b0 else (level, reduced)


@dataclass
class IntegralAction:
    """A plain law whose surface also weighs the integral of the error.

    Attributes
    ----------
    plain : Switching
        The law without.
    rate : float
        The integral has the weight of the displacement's times this [1/s].
    within : float
        The integral only takes in errors smaller than this, so that it does not wind up [m].

    Notes
    -----
    The mean of sigma that asymmetric switching leaves is taken up by the integral, and no longer
    by the error, whose mean over c1 is the steady-state error.
    """

    plain: Switching
    rate: float
    within: float
    _integral: float = field(default=0.0, init=False)

    def sigma(self, state: tuple[float, ...]) -> float:
        """Return the switching function."""
        return self.plain.sigma((state[0] + self.rate * self._integral, *state[1:]))

    def voltage(self, state: tuple[float, ...], step: float) -> float:
        """Return the voltage, and take the error of the step into the integral [V]."""
        shifted = (state[0] + self.rate * self._integral, *state[1:])
        if abs(state[0]) < self.within:
            self._integral += state[0] * step
        return self.plain.voltage(shifted, step)


@dataclass(frozen=True)
class PiecewiseLinear:
    """A plain law whose surface asks for no more than a velocity, however large the error.

    Attributes
    ----------
    plain : Switching
        The law without; its surface of order 2.
    largest_velocity : float
        Along the outer pieces of the surface [m/s].

    Notes
    -----
    Beyond the error at which the inner piece would ask for more, sigma is that of a motion at the
    largest velocity: three planes, which meet without a jump. A surface that cannot be reached at
    large errors, (7.9), can be this way.
    """

    plain: Switching
    largest_velocity: float

    def __post_init__(self) -> None:
        """Refuse a velocity at which the pieces do not meet."""
        if self.largest_velocity <= 0.0:
            raise InputError(
                f"largest velocity is {self.largest_velocity:g} m/s; it has to be greater than 0"
            )

    def sigma(self, state: tuple[float, ...]) -> float:
        """Return the switching function."""
        return self.plain.sigma(self._bent(state))

    def voltage(self, state: tuple[float, ...], step: float) -> float:
        """Return the voltage [V]."""
        return self.plain.voltage(self._bent(state), step)

    def _bent(self, state: tuple[float, ...]) -> tuple[float, ...]:
        c1, c2, *_ = self.plain.surface.weights
        largest = c2 * self.largest_velocity / c1
        return (min(max(state[0], -largest), largest), *state[1:])


@dataclass(frozen=True)
class SwitchedGains:
    """State feedback whose gains switch sign with the surface.

    Attributes
    ----------
    surface : Surface
        What is switched on.
    gains : tuple of float
        Magnitudes for the error and its derivatives, as many as wanted [V/m], [V s/m] ...
    level : float
        Largest voltage [V].

    Notes
    -----
    Equations (6.29) and (6.30) of the thesis with opposite gains: each term acts in the direction
    of sigma, whatever the sign of its state; the voltage shrinks with the states, and with it
    the chattering.
    """

    surface: Surface
    gains: tuple[float, ...]
    level: float

    def sigma(self, state: tuple[float, ...]) -> float:
        """Return the switching function."""
        return self.surface.value(*state[: self.surface.order + 1])

    def voltage(self, state: tuple[float, ...], step: float) -> float:
        """Return the voltage [V]."""
        sigma = self.sigma(state)
        total = sum(k * abs(x) for k, x in zip(self.gains, state, strict=False))
        return math.copysign(min(total, self.level), sigma) if sigma else 0.0


def reaching_gains(
    servos: Sequence[LinearServo], surface: Surface, displacement_gain: float, margin: float = 0.2
) -> tuple[float, float, float]:
    """Return gains for `SwitchedGains` with which a surface is reached from anywhere.

    Parameters
    ----------
    servos : sequence of LinearServo
        What the parameters may be, without the dynamics of their valves.
    surface : Surface
        Of order 2.
    displacement_gain : float
        Of the error; any above 0 brings the piston out of rest [V/m].
    margin : float, optional
        By how much velocity and acceleration gains exceed what is needed [-].

    Returns
    -------
    tuple of float
        Of error [V/m], velocity [V s/m] and acceleration [V s2/m].

    Raises
    ------
    InputError
        When displacement gain or margin are not above 0.

    Notes
    -----
    Section 6.6 of the thesis: from sigma d(sigma)/dt < 0 with the parameters' known ranges, each
    gain above the magnitude of its part of the equivalent control, as far as the level reaches.
    """
    if displacement_gain <= 0.0 or margin <= 0.0:
        raise InputError(
            f"displacement gain is {displacement_gain:g} V/m and margin {margin:g}; both have to "
            "be greater than 0"
        )
    needed = np.max(np.abs([servo_gains(servo, surface) for servo in servos]), axis=0)
    _, velocity, acceleration = (float(gain) for gain in (1.0 + margin) * needed)
    return displacement_gain, velocity, acceleration
