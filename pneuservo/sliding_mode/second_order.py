"""The textbook plant of second order: structures, phase plane and sliding domain."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

from pneuservo.arrays import Array
from pneuservo.errors import InputError

# Longest distance between two points of a trajectory, and switchings before it counts as sliding.
_STEP, _MOST_SWITCHINGS = 1e-3, 200


@dataclass(frozen=True)
class SecondOrderPlant:
    """x'' + 2 damping wn x' + wn^2 x = gain u; a stiffness of 0 is the plant (6.1).

    Attributes
    ----------
    friction : float
        2 damping wn, the a of (6.1) [1/s].
    stiffness : float
        wn^2 [1/s2].
    gain : float
        b [m/(s2 V)].
    """

    friction: float
    stiffness: float
    gain: float

    def acceleration(self, x: float, v: float, u: float) -> float:
        """Return the acceleration [m/s2]."""
        return self.gain * u - self.friction * v - self.stiffness * x


@dataclass(frozen=True)
class PhaseTrajectory:
    """A trajectory under a relay.

    Attributes
    ----------
    time, displacement, velocity : (n,) array
        [s], [m], [m/s].
    sliding_from : float
        When sliding begins; NaN when it does not [s].
    switchings : int
        Crossings of the line before that.
    """

    time: Array
    displacement: Array
    velocity: Array
    sliding_from: float
    switchings: int


def sliding_displacement(plant: SecondOrderPlant, slope: float, level: float) -> float:
    """Return the largest displacement of the sliding domain; infinite when all slides [m].

    Parameters
    ----------
    plant : SecondOrderPlant
        The plant.
    slope : float
        c1 of the line sigma = -(c1 x + x') [1/s].
    level : float
        Of the relay [V].

    Notes
    -----
    Equations (6.31) and (6.32) of the thesis: |x| <= b U/|c1^2 - 2 damping wn c1 + wn^2|; figures
    6.7 to 6.10.

    Examples
    --------
    >>> plant = SecondOrderPlant(friction=20.0, stiffness=100.0, gain=1.0)
    >>> sliding_displacement(plant, 10.0, 1.0)  # damping 1, c1 = wn
    inf
    >>> sliding_displacement(plant, 20.0, 1.0)
    0.01
    """
    rest = abs(slope * slope - plant.friction * slope + plant.stiffness)
    return plant.gain * level / rest if rest > 0.0 else math.inf


def slides_at_once(plant: SecondOrderPlant, slope: float) -> bool:
    """Return whether the line of a plant without stiffness is not left where it is first met.

    Parameters
    ----------
    plant : SecondOrderPlant
        The plant (6.1).
    slope : float
        c1 [1/s].

    Returns
    -------
    bool
        Whether 0 < c1 < 2 a: at full voltage the velocity stays below b U/a.

    Raises
    ------
    InputError
        For a plant with stiffness.

    Notes
    -----
    The thesis states c1 < a, (6.6), which suffices.
    """
    if plant.stiffness != 0.0:
        raise InputError("slides_at_once is about the plant (6.1), which has no stiffness")
    return 0.0 < slope < 2 * plant.friction


def structure_trajectory(
    plant: SecondOrderPlant, voltage: float, start: tuple[float, float], duration: float
) -> PhaseTrajectory:
    """Return the trajectory of a plant under one voltage: a structure on its own.

    Parameters
    ----------
    plant : SecondOrderPlant
        The plant.
    voltage : float
        [V].
    start : (float, float)
        Displacement and velocity [m], [m/s].
    duration : float
        [s].

    Notes
    -----
    Equations (6.2) and (6.3), figure 6.1 of the thesis.
    """
    step = expm(_matrix(plant) * _STEP)
    states = [np.array([*start, voltage])]
    for _ in range(round(duration / _STEP)):
        states.append(step @ states[-1])
    rows = np.array(states)
    time = _STEP * np.arange(len(rows), dtype=float)
    return PhaseTrajectory(time, rows[:, 0], rows[:, 1], math.nan, 0)


def phase_trajectory(
    plant: SecondOrderPlant,
    slope: float,
    level: float,
    start: tuple[float, float],
    duration: float,
) -> PhaseTrajectory:
    """Return the trajectory of a plant under a relay on a line through the origin.

    Parameters
    ----------
    plant : SecondOrderPlant
        The plant.
    slope : float
        c1 of sigma = -(c1 x + x'), u = U sgn(sigma) [1/s].
    level : float
        Of the relay [V].
    start : (float, float)
        Displacement and velocity [m], [m/s].
    duration : float
        [s].

    Returns
    -------
    PhaseTrajectory
        Exact between switchings, and along the line x' = -c1 x inside the sliding domain.

    Notes
    -----
    Section 6.2 of the thesis, figures 6.2 to 6.4.
    """
    domain = sliding_displacement(plant, slope, level)
    points = [(0.0, *start)]
    sliding_from, switchings = math.nan, 0
    while points[-1][0] < duration and switchings < _MOST_SWITCHINGS:
        now, x, v = points[-1]
        sigma = -(slope * x + v)
        if abs(sigma) < 1e-9 * max(abs(v), 1e-9) and abs(x) <= domain:
            sliding_from = now
            break
        points += _to_the_line(
            plant, slope, _voltage(plant, slope, level, x, v), points[-1], duration
        )
        switchings += points[-1][0] < duration
    if not math.isnan(sliding_from):
        now, x, _ = points[-1]
        for t in np.arange(_STEP, duration - now, _STEP):
            decayed = x * math.exp(-slope * t)
            points.append((now + t, decayed, -slope * decayed))
    time, displacement, velocity = np.array(points).T
    return PhaseTrajectory(time, displacement, velocity, sliding_from, switchings)


def _voltage(plant: SecondOrderPlant, slope: float, level: float, x: float, v: float) -> float:
    """Return the relay's voltage; on the line that of the side the trajectory goes to."""
    sigma = -(slope * x + v)
    if abs(sigma) < 1e-9 * max(abs(v), 1e-9):
        # Outside the sliding domain both voltages carry the state to one and the same side.
        sigma = -(slope * v + plant.acceleration(x, v, 0.0))
    return math.copysign(level, sigma)


def _to_the_line(
    plant: SecondOrderPlant,
    slope: float,
    voltage: float,
    start: tuple[float, float, float],
    duration: float,
) -> list[tuple[float, float, float]]:
    """Return the points from a start up to where the line is next crossed, or to the end."""
    matrix = _matrix(plant)
    step = expm(matrix * _STEP)
    now, state = start[0], np.array([start[1], start[2], voltage])
    side = math.copysign(1.0, voltage)
    points: list[tuple[float, float, float]] = []
    while now < duration:
        after = step @ state
        if side * -(slope * after[0] + after[1]) <= 0.0:

            def sigma(t: float, state: Array = state) -> float:
                moved = expm(matrix * t) @ state
                return float(-(slope * moved[0] + moved[1]))

            if sigma(1e-9) * side <= 0.0:
                # It starts on the line itself and is driven straight back: this is sliding.
                return points or [(now, float(state[0]), -slope * float(state[0]))]
            t = float(brentq(sigma, 1e-9, _STEP, xtol=1e-15))
            x = float((expm(matrix * t) @ state)[0])
            return [*points, (now + t, x, -slope * x)]
        state, now = after, now + _STEP
        points.append((now, float(state[0]), float(state[1])))
    return points


def _matrix(plant: SecondOrderPlant) -> Array:
    """Return the system matrix with the constant voltage as third state."""
    return np.array([[0, 1, 0], [-plant.stiffness, -plant.friction, plant.gain], [0, 0, 0.0]])
