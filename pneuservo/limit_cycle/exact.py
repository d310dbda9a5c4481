"""Exact limit cycles of a relay round a linear loop, after Tsypkin and Hamel."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq
from threadpoolctl import threadpool_limits

from pneuservo.arrays import Array
from pneuservo.limit_cycle.cycle import Cycle
from pneuservo.limit_cycle.loop import Loop, loop_system

# Periods looked at [Hz], and samples of a cycle at which it is checked and its extremes read.
LOWEST, HIGHEST, PERIODS, SAMPLES = 5.0, 5e3, 400, 400
# Perturbations may neither grow nor shrink along the integrator of a sampled loop.
_ROUNDING = 1e-6
# Samples after which a perturbation shows whether it grows.
_MANY = 2000
# Longest half period of a digital cycle, in samples.
_LONGEST_HALF = 5000
# Beyond this a half period has no state of its own: an eigenvalue at -1.
_LARGEST_CONDITION = 1e12


@dataclass(frozen=True)
class _OpenLoop:
    """Rate a x + b u, surface with its sign turned c x, displacement error e x."""

    a: Array
    b: Array
    c: Array
    e: Array

    @classmethod
    def of(cls, loop: Loop) -> "_OpenLoop":
        system = loop_system(loop)
        return cls(system.A, system.B[:, 0], system.C[0], system.C[1])

    def held(self, duration: float) -> tuple[Array, Array]:
        """Return what carries the state over a time, and what a held volt adds."""
        n = len(self.a)
        block = np.zeros((n + 1, n + 1))
        block[:n, :n], block[:n, n] = self.a, self.b
        both = expm(block * duration)
        return both[:n, :n], both[:n, n]


# Matrices this small only wait for each other in threads.
@threadpool_limits.wrap(limits=1, user_api="blas")
def exact_cycles(loop: Loop) -> list[Cycle]:
    """Return the limit cycles of a relay loop with one switching each way, without approximation.

    Parameters
    ----------
    loop : Loop
        Without a boundary layer. Its asymmetry is left out when it is sampled.

    Returns
    -------
    list of Cycle
        Slowest first. A sampled loop has one for every number of samples to which it can lock.

    Raises
    ------
    ValueError
        When the loop has a boundary layer.

    Notes
    -----
    The state after a whole period is the state before it, and the switching function is zero at
    both switchings (Tsypkin 1984; state-space form, Astrom 1995). As the servo integrates, the
    mean of the voltage is zero, which fixes the share of each half. A cycle is stable when the
    derivative of the state over one period, with the switchings moving along, has no eigenvalue
    beyond the unit circle. Of a sampled loop the switchings do not move: a perturbation of the
    displacement stays as it is, so that its extremes depend on the start within a margin.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> loop = Loop(LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0))
    >>> [cycle] = exact_cycles(loop)
    >>> round(cycle.frequency, 1), round(cycle.amplitude, 2), cycle.stable
    (199.2, 3.86, True)
    """
    if loop.boundary_layer > 0.0:
        raise ValueError("the exact method is that of a relay; the loop has a boundary layer")
    if loop.signals.sampled:
        return _sampled_cycles(loop)
    system = _OpenLoop.of(loop)
    periods = 1.0 / np.geomspace(HIGHEST, LOWEST, PERIODS)
    at_switching = np.array([_state_at_switchings(system, loop, t)[1] @ system.c for t in periods])
    cycles = []
    for k in np.flatnonzero(np.sign(at_switching[:-1]) != np.sign(at_switching[1:])):
        period = float(
            brentq(
                lambda t: float(_state_at_switchings(system, loop, t)[1] @ system.c),
                periods[k],
                periods[k + 1],
                xtol=1e-13,
            )
        )
        cycle = _continuous_cycle(system, loop, period)
        if cycle is not None:
            cycles.append(cycle)
    return cycles[::-1]


def _durations(loop: Loop, period: float) -> tuple[float, float]:
    """Return how long the voltage is positive and negative, so that its mean is zero."""
    positive = 0.5 * (1.0 - loop.asymmetry) * period
    return positive, period - positive


def _state_at_switchings(system: _OpenLoop, loop: Loop, period: float) -> tuple[Array, Array]:
    """Return the states where the voltage becomes positive, on the surface, and negative."""
    (first, second), (up, down) = _durations(loop, period), loop.levels
    carry_1, add_1 = system.held(first)
    carry_2, add_2 = system.held(second)
    # One period leaves the integrated displacement open; the surface closes it. Scaled by the
    # states' sizes, which range from metres to their fourth derivatives.
    matrix = np.vstack((np.eye(len(system.a)) - carry_2 @ carry_1, system.c))
    right = np.append(carry_2 @ add_1 * up - add_2 * down, 0.0)
    scale = np.abs(add_1) * up + 1e-300
    scaled = matrix * scale
    rows = np.linalg.norm(scaled, axis=1) + 1e-300
    solution, *_ = np.linalg.lstsq(scaled / rows[:, np.newaxis], right / rows, rcond=1e-12)
    start = solution * scale
    return start, carry_1 @ start + add_1 * up


def _continuous_cycle(system: _OpenLoop, loop: Loop, period: float) -> Cycle | None:
    """Return the cycle of a period, None when the surface changes its sign elsewhere too."""
    start, middle = _state_at_switchings(system, loop, period)
    (first, second), (up, down) = _durations(loop, period), loop.levels
    positive = _course(system, start, first, up)
    negative = _course(system, middle, second, -down)
    sigma = [-part @ system.c for part in (positive, negative)]
    slack = _ROUNDING * max(np.abs(np.concatenate(sigma)))
    if sigma[0].min() < -slack or sigma[1].max() > slack:
        return None
    weights = np.array([first, second]) / period
    error = weights @ [np.mean(part @ system.e) for part in (positive, negative)]
    return Cycle(
        1.0 / period,
        float(sigma[0].max()),
        float(sigma[1].min()),
        _is_stable(system, loop, start, middle, period),
        -float(error),
    )


def _course(system: _OpenLoop, start: Array, duration: float, voltage: float) -> Array:
    """Return states in the middles of equal parts of a time."""
    half_carry, half_add = system.held(0.5 * duration / SAMPLES)
    carry, add = system.held(duration / SAMPLES)
    states = np.empty((SAMPLES, len(start)))
    states[0] = half_carry @ start + half_add * voltage
    for k in range(1, SAMPLES):
        states[k] = carry @ states[k - 1] + add * voltage
    return states


def _is_stable(system: _OpenLoop, loop: Loop, start: Array, middle: Array, period: float) -> bool:
    (first, second), (up, down) = _durations(loop, period), loop.levels
    n = len(start)
    total = np.eye(n)
    for duration, state, voltage in ((first, middle, up), (second, start, -down)):
        rate = system.a @ state + system.b * voltage
        crossing = system.c @ rate
        if crossing == 0.0:
            return False
        moved = np.eye(n) - np.outer(rate, system.c) / crossing
        total = moved @ system.held(duration)[0] @ total
    return bool(np.max(np.abs(np.linalg.eigvals(total))) < 1.0 + _ROUNDING)


def _sampled_cycles(loop: Loop) -> list[Cycle]:
    system = _OpenLoop.of(loop)
    level, n = loop.level, len(system.a)
    bounded = _stays_bounded(system.a)
    cycles = []
    carry, add = np.eye(n), np.zeros(n)
    longest = min(round(0.5 / (LOWEST * loop.signals.sampling_time)), _LONGEST_HALF)
    for half in range(1, max(longest, 1) + 1):
        carry_before, add_before = carry, add
        add = system.a @ add + system.b
        carry = system.a @ carry
        turned = np.eye(n) + carry
        if np.linalg.cond(turned) > _LARGEST_CONDITION:
            continue
        start = np.asarray(-np.linalg.solve(turned, add * level), dtype=np.float64)
        last = carry_before @ start + add_before * level
        if system.c @ start >= 0.0 or system.c @ last >= 0.0:
            continue
        sigma = _surface_of_half(system, start, level, half)
        if sigma.min() <= 0.0:
            continue
        frequency = 0.5 / (half * loop.signals.sampling_time)
        high = float(sigma.max())
        cycles.append(Cycle(frequency, high, -high, bounded, 0.0))
    return cycles[::-1]


def _surface_of_half(system: _OpenLoop, start: Array, level: float, half: int) -> Array:
    sigma = np.empty(half)
    state = start
    for k in range(half):
        sigma[k] = -system.c @ state
        state = system.a @ state + system.b * level
    return sigma


def _stays_bounded(carry: Array) -> bool:
    """Return whether powers of a matrix do not grow, neither by a power nor in proportion.

    The eigenvalues alone do not tell: bilinear differences have a double one at -1, whose ringing
    grows in proportion to time.
    """
    early = np.linalg.matrix_power(carry, _MANY)
    late = np.linalg.matrix_power(carry, 2 * _MANY)
    return bool(np.linalg.norm(late) < 1.5 * np.linalg.norm(early))
