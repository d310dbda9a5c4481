"""Sliding surfaces of any order: their weights, from what the sliding motion has to do."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analog_card.surface_weights import state_weights
from pneuservo.errors import InputError

# Further poles of a surface above the second order, so many times further left than the pair.
FURTHER_POLES = 4.0


@dataclass(frozen=True)
class Surface:
    """sigma = -(c1 e + c2 e' + ... + cn e^(n-1)), with the error e = displacement - demand.

    Parameters
    ----------
    weights : tuple of float
        c1 to cn; the last, of the highest derivative, is 1 by convention [1/s^(n-1)] to [-].

    Raises
    ------
    InputError
        When there are fewer than two weights, or the sliding motion is not stable.

    Notes
    -----
    Equations (6.40) and (7.1) of the thesis. With u = +U sgn(sigma) the sign makes the feedback
    negative; (6.25) and (7.8) print the other one.

    Examples
    --------
    >>> surface = surface_from_settling_time(0.07)
    >>> [round(weight, 1) for weight in surface.weights]
    [3265.3, 114.3, 1.0]
    """

    weights: tuple[float, ...]

    def __post_init__(self) -> None:
        """Refuse weights along which nothing slides to the origin."""
        if len(self.weights) < 2 or not all(math.isfinite(c) for c in self.weights):
            raise InputError(
                f"a surface needs two finite weights or more, c1 to cn; found {self.weights}"
            )
        if self.weights[-1] <= 0.0 or np.any(self.poles.real >= 0.0):
            raise InputError(
                f"the surface with the weights {self.weights} is not stable: its sliding motion "
                "does not come to rest. With c3 = 1 both c1 and c2 have to be greater than 0"
            )

    @property
    def order(self) -> int:
        """Order of the sliding motion, one below the number of weights."""
        return len(self.weights) - 1

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles of the sliding motion [1/s]."""
        return np.asarray(np.roots(self.weights[::-1]), complex)

    @property
    def settling_time(self) -> float:
        """4 over the distance of the nearest pole from the imaginary axis [s]."""
        return float(4 / np.min(-self.poles.real))

    def value(self, *derivatives: float) -> float:
        """Return the switching function.

        Parameters
        ----------
        *derivatives : float
            The error [m] and its derivatives [m/s^k], as many as there are weights.
        """
        return -sum(c * d for c, d in zip(self.weights, derivatives, strict=True))


def surface_from_settling_time(
    settling_time: float, damping: float = 1.0, order: int = 2, further: float = FURTHER_POLES
) -> Surface:
    """Return a surface whose sliding motion settles in a given time.

    Parameters
    ----------
    settling_time : float
        4/(damping wn) of the dominant pole or pair [s].
    damping : float, optional
        Of the pair, above 0 up to 1 [-].
    order : int, optional
        1 has a single pole, 2 a pair, more add real poles.
    further : float, optional
        How many times further left the added poles lie [-].

    Returns
    -------
    Surface
        Its last weight is 1.

    Raises
    ------
    InputError
        For a settling time not above 0 s, a damping not above 0 or above 1, an order below 1.

    Notes
    -----
    Equations (7.3) and (7.4) of the thesis for order 2. A double pole enters a 2 % band after
    5.83/wn, 1.46 times the settling time by that definition.

    Examples
    --------
    >>> surface_from_settling_time(0.4, order=1).weights
    (10.0, 1.0)
    >>> surface_from_settling_time(0.07, order=4).order
    4
    """
    if not 0.0 < settling_time < math.inf:
        raise InputError(f"settling time is {settling_time:g} s; it has to be greater than 0")
    if not 0.0 < damping <= 1.0:
        raise InputError(f"damping is {damping:g}; it has to be above 0 and at most 1")
    if order < 1:
        raise InputError(f"order is {order}; a surface has the order 1 or more")
    decay = 4 / settling_time
    if order == 1:
        return Surface((decay, 1.0))
    weights = np.array([*state_weights(settling_time, damping), 1.0])
    for _ in range(order - 2):
        weights = np.convolve(weights, [further * decay, 1.0])
    return Surface(tuple(float(weight) for weight in weights))


def equal_pole_surface(rate: float, order: int) -> Surface:
    """Return the surface (d/dt + rate)^order, all its poles at one place.

    Parameters
    ----------
    rate : float
        Distance of the poles from the imaginary axis [1/s].
    order : int
        1 or more.

    Notes
    -----
    Equation (6.9) of the thesis, after Slotine.

    Examples
    --------
    >>> equal_pole_surface(10.0, 2).weights  # (6.10): a double pole
    (100.0, 20.0, 1.0)
    """
    weights = np.array([1.0])
    for _ in range(order):
        weights = np.convolve(weights, [rate, 1.0])
    return Surface(tuple(float(weight) for weight in weights))


def largest_rate(
    structural_frequency: float = math.inf, delay: float = 0.0, sampling: float = math.inf
) -> float:
    """Return the largest rate that unmodelled dynamics leave to `equal_pole_surface` [1/s].

    Parameters
    ----------
    structural_frequency : float, optional
        Lowest mode that the model leaves out [Hz].
    delay : float, optional
        Largest unmodelled delay [s].
    sampling : float, optional
        Sampling frequency [Hz].

    Notes
    -----
    Equations (6.11) to (6.13) of the thesis in the form of Slotine and Li (1991): 2 pi/3 of the
    mode, a third over the delay, a fifth of the sampling frequency.

    Examples
    --------
    >>> largest_rate(sampling=1000.0)
    200.0
    """
    limits = [2 * math.pi / 3 * structural_frequency, sampling / 5]
    if delay > 0.0:
        limits.append(1 / (3 * delay))
    return min(limits)


def damping_from_overshoot(overshoot: float) -> float:
    """Return the damping ratio of a pair that overshoots by a share of the step [-].

    Parameters
    ----------
    overshoot : float
        0 to below 1 [-].

    Raises
    ------
    InputError
        For an overshoot below 0, or of 1 and more.

    Notes
    -----
    Equation (7.4) of the thesis, solved for the damping.

    Examples
    --------
    >>> round(damping_from_overshoot(0.0432), 3)
    0.707
    """
    if not 0.0 <= overshoot < 1.0:
        raise InputError(f"overshoot is {overshoot:g}; it has to be 0 or more and below 1")
    if overshoot == 0.0:
        return 1.0
    logarithm = math.log(overshoot)
    return -logarithm / math.hypot(math.pi, logarithm)
