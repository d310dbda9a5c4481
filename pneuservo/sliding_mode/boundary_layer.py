"""Boundary layers round a surface: their voltages, and how wide they have to be."""

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


def layer_cut_off(b0: float, level: float, width: float) -> float:
    """Return the corner frequency of the loop inside a boundary layer, c3 being 1 [rad/s].

    Parameters
    ----------
    b0 : float
        Jerk for each volt [m/(s3 V)].
    level : float
        Of the law [V].
    width : float
        Of the layer [m/s2].

    Notes
    -----
    Equation (6.45) of the thesis; (6.46) wants it at or below the lowest unmodelled frequency.

    Examples
    --------
    >>> layer_cut_off(1045.0, 5.0, 5.0)
    1045.0
    """
    return b0 * level / width


def layer_width(b0: float, level: float, cut_off: float) -> float:
    """Return the boundary layer with a given corner frequency, the inverse of `layer_cut_off`.

    Parameters
    ----------
    b0, level : float
        As in `layer_cut_off`.
    cut_off : float
        At most that of the lowest unmodelled dynamics, such as the valve's [rad/s].
    """
    return b0 * level / cut_off
