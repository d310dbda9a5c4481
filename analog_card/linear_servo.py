"""The servo behind the card in five numbers: its linear model, and where a relay makes it cycle."""

import math
from dataclasses import dataclass

import numpy as np

from analog_card.errors import InputError


@dataclass(frozen=True)
class LinearServo:
    """Displacement over valve voltage, X/U = b0/(s (s^2 + a2 s + a1)) times the valve.

    Attributes
    ----------
    b0 : float
        Jerk for each volt at the valve [m/(s3 V)].
    a1, a2 : float
        Stiffness of the gas and viscous friction, over the mass [1/s2], [1/s].
    valve_frequency : float
        Natural frequency of the valve [Hz]; infinite without valve dynamics.
    valve_damping : float
        Its damping ratio.

    Notes
    -----
    Equation (5.26) of the thesis, second-order valve (4.32). The defaults are the rig of
    the thesis with the piston at 20 mm and the valve at null, from a study of this circuit
    (5678 m/s3 at the full 5 V).
    """

    b0: float = 5678.0 / 5.0
    a1: float = 14065.0
    a2: float = 54.9
    valve_frequency: float = 200.0
    valve_damping: float = 0.7

    def response(self, frequency: np.ndarray) -> np.ndarray:
        """Return displacement over voltage [m/V].

        Parameters
        ----------
        frequency : ndarray, shape (n,)
            [Hz].
        """
        s = 2j * math.pi * np.asarray(frequency, float)
        valve = np.ones_like(s)
        if math.isfinite(self.valve_frequency):
            r = s / (2 * math.pi * self.valve_frequency)
            valve = 1 / (r * r + 2 * self.valve_damping * r + 1)
        return valve * self.b0 / (s * (s * s + self.a2 * s + self.a1))


def converter_step(full_scale: float, bits: int = 12) -> float:
    """Return half a least significant bit, the least that a converter is sure to see.

    Parameters
    ----------
    full_scale : float
        Range of the converter, in any unit.
    bits : int, optional
        Of the converter.

    Notes
    -----
    Equations (9.1) and (9.2) of the thesis.

    Examples
    --------
    >>> round(1e6 * converter_step(30e-3), 3)  # um of a stroke of 30 mm
    3.662
    """
    return 0.5 * full_scale / 2**bits


def detectable_frequency(servo: LinearServo, level: float, threshold: float) -> float:
    """Return the highest switching frequency that a converter still sees in the displacement.

    Parameters
    ----------
    servo : LinearServo
        What is switched.
    level : float
        Amplitude of the switched voltage [V].
    threshold : float
        Least displacement amplitude that is seen, from `converter_step` [m].

    Returns
    -------
    float
        Where level times |X/U| falls to the threshold for the last time [Hz].

    Raises
    ------
    InputError
        When that is not between 1 Hz and 100 kHz.

    Notes
    -----
    Section 9.1.1 of the thesis: faster chattering stays below half a bit.
    """
    from scipy.optimize import brentq

    def excess(logarithm: float) -> float:
        seen = level * abs(servo.response(np.array([10.0**logarithm]))[0])
        return math.log(seen / threshold)

    grid = np.linspace(0.0, 5.0, 501)
    values = np.array([excess(point) for point in grid])
    last = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    if len(last) == 0:
        raise InputError(
            f"switching {level:g} V never moves the piston by {threshold:g} m between 1 Hz and "
            "100 kHz; give a lower threshold"
        )
    return float(10.0 ** brentq(excess, grid[last[-1]], grid[last[-1] + 1]))


def limit_cycle(
    frequency: np.ndarray, loop: np.ndarray, level: float, delay_factor: float = 0.0
) -> tuple[float, float]:
    """Return the limit cycle of a relay round a linear loop, by its describing function.

    Parameters
    ----------
    frequency : ndarray, shape (n,)
        Increasing [Hz].
    loop : ndarray, shape (n,)
        Switching function for each volt of the relay, of a loop that is stable with the sign
        of a negative feedback [1/V or any].
    level : float
        Amplitude of the relay [V].
    delay_factor : float, optional
        The relay follows the crossing of its input later by the root of this over the slope of
        the input there [s2 unit of the switching function/s]; 0 switches at once.

    Returns
    -------
    frequency, amplitude : float
        Of the switching function [Hz], in its unit.

    Raises
    ------
    InputError
        When the phase does not reach half a turn within the frequencies.

    Notes
    -----
    Describing function 4 M/(pi A) of a relay of level M: it cycles where the loop's phase, with
    that of the delay, is -180 degrees, with the amplitude A = (4 M/pi)|loop|.
    """
    amplitude = 4 * level / math.pi * np.abs(loop)
    slope = 2 * math.pi * frequency * amplitude
    delay = np.sqrt(delay_factor / slope)
    phase = np.unwrap(np.angle(loop)) - 2 * math.pi * frequency * delay
    crossing = np.flatnonzero((phase[:-1] > -math.pi) & (phase[1:] <= -math.pi))
    if len(crossing) == 0:
        raise InputError(
            f"no limit cycle between {frequency[0]:g} and {frequency[-1]:g} Hz: the phase of the "
            "loop does not reach -180 degrees"
        )
    k = int(crossing[0])
    share = (phase[k] + math.pi) / (phase[k] - phase[k + 1])
    at = frequency[k] * (frequency[k + 1] / frequency[k]) ** share
    return float(at), float(np.interp(at, frequency, amplitude))
