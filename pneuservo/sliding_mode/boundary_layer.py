"""How wide a boundary layer round a surface has to be."""

WIDTHS = 1e-3, 1e6
"""Narrowest and widest that can be asked for, orders of magnitude round what a servo has: beyond
them nothing but rounding is worked out of it [m/s2]."""


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
