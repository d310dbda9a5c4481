"""Voltages of boundary layers round a surface."""

import math


def boundary_layer(sigma: float, level: float, width: float) -> float:
    """Return the voltage of the saturating law [V].

    Parameters
    ----------
    sigma : float
        Switching function.
    level : float
        Largest voltage [V].
    width : float
        Where the voltage reaches its level; 0 is a relay [unit of sigma].

    Notes
    -----
    Equation (6.43) of the thesis.

    Examples
    --------
    >>> [boundary_layer(sigma, 5.0, 5.0) for sigma in (2.5, -9.0)], boundary_layer(1e-9, 5.0, 0.0)
    ([2.5, -5.0], 5.0)
    """
    if abs(sigma) >= width:
        return math.copysign(level, sigma) if sigma else 0.0
    return level * sigma / width


def smooth_boundary_layer(sigma: float, level: float, width: float) -> float:
    """Return the voltage of the smooth law, U sigma/(|sigma| + width) [V].

    Parameters
    ----------
    sigma, level : float
        As in `boundary_layer`.
    width : float
        Where the voltage is half its level [unit of sigma].

    Notes
    -----
    Equation (6.44) of the thesis. Its gain at the surface is that of the saturating law.

    Examples
    --------
    >>> smooth_boundary_layer(5.0, 5.0, 5.0)
    2.5
    """
    return level * sigma / (abs(sigma) + width) if sigma else 0.0
