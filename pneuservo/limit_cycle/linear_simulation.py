"""Closed-loop step responses of the linear servo, advanced exactly from switching to switching."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from threadpoolctl import threadpool_limits

from pneuservo.arrays import Array
from pneuservo.limit_cycle.loop import Loop, loop_system

# Demand less displacement at the start, and how long the loop is followed: the thesis' step.
START_ERROR, DURATION = 9e-3, 0.4
# Samples of an analogue loop; switchings are located between them [s].
INTERVAL = 20e-6
# A loop that switches this often within one interval is taken to be on the surface.
_MOST_SWITCHINGS = 20


@dataclass(frozen=True)
class StepCourse:
    """What a closed loop does after a step of the demand.

    Attributes
    ----------
    time : (n,) array
        [s].
    surface : (n,) array
        Switching function [m/s2].
    error : (n,) array
        Demand less displacement [m].
    voltage : (n,) array
        From the controller [V].
    sampled : bool
        Whether the controller is digital: the surface then holds from sample to sample.
    """

    time: Array
    surface: Array
    error: Array
    voltage: Array
    sampled: bool


# Matrices this small only wait for each other in threads.
@threadpool_limits.wrap(limits=1, user_api="blas")
def simulate_linear(
    loop: Loop, start_error: float = START_ERROR, duration: float = DURATION
) -> StepCourse:
    """Simulate the linear servo under its controller from rest at a distance from the demand.

    Parameters
    ----------
    loop : Loop
        The loop.
    start_error : float, optional
        Demand less displacement at the start [m].
    duration : float, optional
        [s].

    Returns
    -------
    StepCourse
        At the sampling times of a digital controller, every 20 us of an analogue one.

    Notes
    -----
    Between switchings the loop is linear and advanced by matrix exponentials; switchings are
    located to rounding. A relay loop of relative degree one that can no longer cross its surface
    slides on it under the equivalent control (Filippov 1960), (6.24) of the thesis.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> loop = Loop(LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0))
    >>> bool(abs(simulate_linear(loop, duration=0.3).error[-1]) < 1e-4)
    True
    """
    if loop.signals.sampled:
        return simulate_sampled(loop, np.array([start_error]), duration)[0]
    system = loop_system(loop)
    a, b, c, e = system.A, system.B[:, 0], system.C[0], system.C[1]
    start = _at_rest(loop, a, e) * -start_error
    states, voltage = _Switching(loop, a, b, c).run(start, duration)
    time = np.arange(len(states), dtype=float) * INTERVAL
    return StepCourse(time, -states @ c, -states @ e, voltage, sampled=False)


def simulate_sampled(loop: Loop, start_errors: Array, duration: float) -> list[StepCourse]:
    """Simulate the linear servo under a digital controller from several starts at once.

    Parameters
    ----------
    loop : Loop
        A sampled loop.
    start_errors : (n,) array
        Demand less displacement at the start [m].
    duration : float
        [s].

    Returns
    -------
    list of StepCourse
        One of each start, at the sampling times.
    """
    system = loop_system(loop)
    a, b, c, e = system.A, system.B[:, 0], system.C[0], system.C[1]
    starts = np.multiply.outer(-start_errors, _at_rest(loop, a, e))
    states, voltage = _sampled(loop, a, b, c, starts, duration)
    time = np.arange(len(states), dtype=float) * loop.signals.sampling_time
    surface, error = -(states @ c), -(states @ e)
    return [
        StepCourse(time, surface[:, k], error[:, k], voltage[:, k], sampled=True)
        for k in range(len(start_errors))
    ]


def output(loop: Loop, surface: Array | float) -> Array:
    """Return what acts on the servo for values of the surface, with the loop's asymmetry [V].

    Parameters
    ----------
    loop : Loop
        The loop.
    surface : float or array
        [m/s2].

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> loop = Loop(LinearServo(), (3265.3, 114.3, 1.0), boundary_layer=2.0)
    >>> output(loop, np.array([-3.0, 1.0])).tolist()
    [-5.0, 2.5]
    """
    up, down = loop.levels
    value = np.asarray(surface, dtype=float)
    if loop.boundary_layer > 0.0:
        share = np.clip(value / loop.boundary_layer, -1.0, 1.0)
    else:
        share = np.where(value >= 0.0, 1.0, -1.0)
    return share * np.where(value >= 0.0, up, down)


def _at_rest(loop: Loop, a: Array, e: Array) -> Array:
    """Return the state with everything at rest, filters and memories included, 1 m beyond.

    It is what the open loop leaves as it is: its rate, or its change per sample, vanishes.
    """
    change = a - np.eye(len(a)) if loop.signals.sampled else a
    vector = np.linalg.svd(change)[2][-1]
    rest: Array = vector / (e @ vector)
    return rest


def _sampled(
    loop: Loop, a: Array, b: Array, c: Array, start: Array, duration: float
) -> tuple[Array, Array]:
    """Return states and voltages at every sample; a start may have several rows."""
    count = math.floor(duration / loop.signals.sampling_time + 1e-9) + 1
    states, voltage = np.empty((count, *start.shape)), np.empty((count, *start.shape[:-1]))
    state = start
    for k in range(count):
        states[k] = state
        voltage[k] = output(loop, -(state @ c))
        state = state @ a.T + np.multiply.outer(voltage[k], b)
    return states, voltage


@dataclass(frozen=True, eq=False)
class _Region:
    """Where the loop is linear: rate = matrix [state, 1] while low <= surface <= high."""

    matrix: Array
    low: float
    high: float

    @cached_property
    def over_interval(self) -> Array:
        """Return what carries the state over one interval."""
        carried: Array = expm(self.matrix * INTERVAL)
        return carried


class _Switching:
    """An analogue loop in its linear regions."""

    def __init__(self, loop: Loop, a: Array, b: Array, c: Array) -> None:
        up, down = loop.levels
        layer = loop.boundary_layer
        self.loop, self.c = loop, np.append(c, 0.0)
        outside = [(-math.inf, -layer, -down, 0.0), (layer, math.inf, up, 0.0)]
        inside = [(-layer, 0.0, 0.0, down / layer), (0.0, layer, 0.0, up / layer)] if layer else []
        self.regions = [
            _Region(_augmented(a - gain * np.outer(b, c), b * held), low, high)
            for low, high, held, gain in (outside[0], *inside, outside[1])
        ]
        # Only a surface that answers the voltage with a slope can be slid on.
        self.sliding: _Region | None = None
        authority = float(c @ b)
        if not layer and authority > 0.0:
            equivalent = -(c @ a) / authority
            self.sliding = _Region(_augmented(a + np.outer(b, equivalent), 0.0 * b), 0.0, 0.0)
            self.equivalent = np.append(equivalent, 0.0)

    def run(self, start: Array, duration: float) -> tuple[Array, Array]:
        """Return states and voltages at every interval."""
        count = round(duration / INTERVAL) + 1
        states, voltage = np.empty((count, len(start))), np.empty(count)
        state = np.append(start, 1.0)
        region = self._region_of(float(-self.c @ state))
        for k in range(count):
            states[k] = state[:-1]
            sliding = region is self.sliding
            surface = float(-self.c @ state)
            voltage[k] = float(self.equivalent @ state) if sliding else output(self.loop, surface)
            state, region = self._over_interval(state, region)
        return states, voltage

    def _region_of(self, surface: float) -> _Region:
        return next(region for region in self.regions if region.low <= surface <= region.high)

    def _over_interval(self, state: Array, region: _Region) -> tuple[Array, _Region]:
        ahead: Array = region.over_interval @ state
        remaining = INTERVAL
        for _ in range(_MOST_SWITCHINGS):
            if region is self.sliding:
                up, down = self.loop.levels
                if -down <= float(self.equivalent @ ahead) <= up:
                    break
                region = self.regions[-1 if float(self.equivalent @ ahead) > 0.0 else 0]
                break
            surface = float(-self.c @ ahead)
            if region.low <= surface <= region.high:
                break
            bound = region.low if surface < region.low else region.high
            reached = self._crossing(state, region, remaining, bound)
            state = expm(region.matrix * reached) @ state
            region = self._next(state, region, bound)
            remaining -= reached
            ahead = expm(region.matrix * remaining) @ state
        return ahead, region

    def _crossing(self, state: Array, region: _Region, remaining: float, bound: float) -> float:
        def beyond(passed: float) -> float:
            return float(-self.c @ (expm(region.matrix * passed) @ state)) - bound

        # A start on the bound itself is left in the direction of the course.
        first = 1e-9 * remaining
        if beyond(first) * beyond(remaining) > 0.0:
            return first
        return float(brentq(beyond, first, remaining, xtol=1e-15))

    def _next(self, state: Array, region: _Region, bound: float) -> _Region:
        place = self.regions.index(region)
        neighbour = self.regions[place + (1 if bound == region.high else -1)]
        if self.sliding is None:
            return neighbour
        # The neighbour drives the surface back: there is nowhere to go but along it.
        towards = float(-self.c @ (neighbour.matrix @ state))
        returns = towards < 0.0 if bound == region.high else towards > 0.0
        return self.sliding if returns else neighbour


def _augmented(a: Array, constant: Array) -> Array:
    n = len(a)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = a, constant
    return block
