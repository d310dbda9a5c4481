"""Samples thinned out to what a picture can show."""

import numpy as np

from pneuservo.arrays import Array


def thinned(x: Array, y: Array, most: int = 1500) -> tuple[Array, Array]:
    """Return a curve with few points that looks the same: lowest and highest of each stretch.

    Parameters
    ----------
    x, y : (n,) array
        The curve; NaN in y are kept apart.
    most : int, optional
        About how many points to keep.

    Returns
    -------
    x, y : (m,) array
        The kept points in order.

    Examples
    --------
    >>> len(thinned(np.arange(9000.0), np.arange(9000.0))[0]) <= 1502
    True
    """
    if len(x) <= most:
        return x, y
    keep = []
    for stretch in np.array_split(np.arange(len(x)), most // 2):
        part = y[stretch]
        if np.all(np.isnan(part)):
            keep.append(int(stretch[0]))
            continue
        keep += sorted({int(stretch[np.nanargmin(part)]), int(stretch[np.nanargmax(part)])})
    index = np.array(keep)
    return x[index], y[index]
