"""One law that goes over into another."""

from pneuservo.plant.compilation import compiled


@compiled
def lesser(value, limit, sharpness):
    """Return the smaller of a value's size and a limit, with the value's sign, blended.

    Parameters
    ----------
    value, limit : float
        In the same unit; the limit is greater than 0.
    sharpness : float
        Exponent of the blend: 2 goes over softly, 10 within some per cent [-].

    Notes
    -----
    y = x/(1 + |x/limit|^n)^(1/n): Churchill and Usagi 1972, A general expression for the
    correlation of rates of transfer.

    Examples
    --------
    >>> round(lesser(-3.0, 4.0, 2.0), 3), round(lesser(100.0, 4.0, 2.0), 3)
    (-2.4, 3.997)
    >>> round(lesser(3.0, 4.0, 12.0), 3)
    2.992
    """
    return value / (1.0 + (abs(value) / limit) ** sharpness) ** (1.0 / sharpness)
