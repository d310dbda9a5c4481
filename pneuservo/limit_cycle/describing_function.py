"""Limit cycles by the describing function and the extended Nyquist criterion."""

import math

import control
import numpy as np
from scipy.optimize import brentq
from threadpoolctl import threadpool_limits

from pneuservo.limit_cycle.cycle import Cycle
from pneuservo.limit_cycle.loop import BILINEAR, Loop, loop_response, loop_system

# Where crossings of the negative real axis are looked for [Hz], and how closely.
LOWEST, HIGHEST, POINTS = 0.5, 20e3, 2000
# Share of the amplitude by which a cycle is disturbed to see whether it is stable [-].
_SLIGHTLY = 1e-3


# Matrices this small only wait for each other in threads.
@threadpool_limits.wrap(limits=1, user_api="blas")
def describing_function_cycles(loop: Loop) -> list[Cycle]:
    """Return the limit cycles that the extended Nyquist criterion finds, slowest first.

    Parameters
    ----------
    loop : Loop
        The loop.

    Returns
    -------
    list of Cycle
        Empty when the open loop never reaches half a turn, or a boundary layer is wide enough.

    Notes
    -----
    G(jw) = -1/N(A), (6.42) of the thesis, with N = 4 M/(pi A) for a relay of level M, (6.41); only
    crossings of the negative real axis are cycles. A cycle is stable when G encircles -1/N for a
    slightly smaller amplitude, not for a slightly larger one. A digital controller is judged by
    G(exp(jwT)), up to half its sampling frequency, where switching at every sample is a cycle too.

    An integrating servo under unequal levels keeps the mean of its voltage at zero by shifting
    the switching function: by its dual-input describing function (Gelb and Vander Velde 1968) by
    A sin(pi a/2) for levels M (1 +- a), which is -c1 times the mean error.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> loop = Loop(LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0))
    >>> [cycle] = describing_function_cycles(loop)
    >>> round(cycle.frequency, 1), round(cycle.amplitude, 2), cycle.stable
    (201.8, 3.78, True)
    """
    top = min(HIGHEST, loop.highest_frequency)
    if loop.signals.differentiation == BILINEAR:
        # Their gain is infinite at half the sampling frequency.
        top *= 0.999
    grid = np.geomspace(LOWEST, top, POINTS)
    response = loop_response(loop, grid)
    cycles = []
    for k in np.flatnonzero(np.sign(response.imag[:-1]) != np.sign(response.imag[1:])):
        if response[k].real >= 0.0 and response[k + 1].real >= 0.0:
            continue
        low, high = grid[k], grid[k + 1]
        if k + 2 == len(grid) and loop.signals.sampled:
            # At half the sampling frequency G is real by itself, up to rounding.
            continue
        frequency = float(brentq(lambda f: _imaginary(loop, f), low, high, xtol=1e-9))
        cycles += _cycle(loop, frequency)
    if loop.signals.sampled and top == loop.highest_frequency:
        cycles += _cycle(loop, top)
    return cycles


def _imaginary(loop: Loop, frequency: float) -> float:
    return float(loop_response(loop, np.array([frequency]))[0].imag)


def _cycle(loop: Loop, frequency: float) -> list[Cycle]:
    """Return the cycle where the open loop is real; none on the positive side or in the layer."""
    gain = -float(loop_response(loop, np.array([frequency]))[0].real)
    if gain <= 0.0:
        return []
    amplitude = _amplitude(loop, gain)
    if amplitude is None:
        return []
    amplitude *= math.cos(0.5 * math.pi * loop.asymmetry)
    shift = amplitude * math.sin(0.5 * math.pi * loop.asymmetry)
    stable = _dies_out_beyond(loop, gain)
    error = 0.0 - shift / loop.weights[0]
    return [Cycle(frequency, amplitude - shift, -amplitude - shift, stable, error)]


def _dies_out_beyond(loop: Loop, gain: float) -> bool:
    """Return whether an oscillation slightly larger than that of a crossing dies out.

    The describing function falls with the amplitude: the loop with slightly less than the gain
    that closes it has to be stable, in every mode.
    """
    system = loop_system(loop)
    closing = (1.0 - _SLIGHTLY) / gain
    poles = np.linalg.eigvals(system.A - closing * np.outer(system.B[:, 0], system.C[0]))
    if loop.signals.sampled:
        return bool(np.max(np.abs(poles)) < 1.0)
    return bool(np.max(poles.real) < 0.0)


def _amplitude(loop: Loop, gain: float) -> float | None:
    """Return the amplitude at which N(A) times the loop's gain is 1; None without one."""
    if loop.boundary_layer == 0.0:
        relay = control.relay_hysteresis_nonlinearity(loop.level, 0.0)
        return gain * float(relay.describing_function(1.0).real)
    slope = loop.level / loop.boundary_layer
    if slope * gain <= 1.0:
        return None
    saturation = control.saturation_nonlinearity(loop.boundary_layer)

    def excess(amplitude: float) -> float:
        return slope * gain * float(saturation.describing_function(amplitude).real) - 1.0

    # N(A) lies below 4 M/(pi A).
    highest = 4.0 / math.pi * loop.level * gain
    return float(brentq(excess, loop.boundary_layer, highest, xtol=1e-12))
