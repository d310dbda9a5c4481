"""Where a discharge coefficient bends: the break points of a row of a table."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from pneuservo.arrays import Array
from pneuservo.calibration.flow_curve import FlowCurve
from pneuservo.calibration.pressure_fit import PLATEAU, PressureFit, interpolation, weights
from pneuservo.errors import InputError

# Inner break points of a row, and among how many places they are first looked for.
_INNER, _PLACES = 3, 16
# Shares of the range where the inner ones are looked for besides: spread, and crowded at the start.
_OTHER_PLACES = ((0.02, 0.25, 0.8), (0.02, 0.08, 0.3))
_NEAR_EQUAL = 0.95


def found_break_points(fit: PressureFit) -> Array:
    """Return the break points that fit a transient best.

    Parameters
    ----------
    fit : PressureFit
        The transient.

    Returns
    -------
    (n,) array
        From 0 to 1, in steps of 0.01; five unless the flow sees too little of the range [-].

    Notes
    -----
    Straight lines through the curve first, then the pressure itself decides, from that start and
    two others: lines through noisy slopes may miss a bend at either end.
    """
    curve = fit.curve
    starts = [_through_curve(curve)]
    if len(starts[0]) == _INNER + 2:
        lowest, highest = float(curve.pressure_ratio.min()), float(curve.pressure_ratio.max())
        span = min(highest, _NEAR_EQUAL) - lowest
        starts += [
            np.array([0.0, *(lowest + np.array(shares) * span), 1.0]) for shares in _OTHER_PLACES
        ]
    best = min((fit.solve(start, movable=True) for start in starts), key=lambda found: found.cost)
    return np.unique(np.round(best.break_points, 2))


def required_break_points(break_points: Sequence[float]) -> Array:
    """Return break points that were given, refusing any that make no row.

    Parameters
    ----------
    break_points : sequence of float
        From 0 to 1, increasing [-].

    Raises
    ------
    InputError
        When they do not.
    """
    points = np.asarray(break_points, dtype=float)
    if len(points) < 2 or points[0] != 0.0 or points[-1] != 1.0 or (np.diff(points) <= 0.0).any():
        raise InputError(
            f"break points {points.tolist()}: two or more pressure ratios are needed that increase "
            "from 0 to 1"
        )
    return points


def _through_curve(curve: FlowCurve) -> Array:
    """Return break points where straight lines fit the curve best."""
    weight = weights(curve)
    target = np.append(curve.coefficient * weight, 0.0)
    level = 1.0 / (PLATEAU * float(np.max(np.abs(curve.coefficient))))

    def misfit(inner: Sequence[float]) -> float:
        hats = interpolation(curve.pressure_ratio, np.array([0.0, *inner, 1.0]))
        plateau = np.zeros(hats.shape[1])
        plateau[:2] = level, -level
        columns = np.vstack((hats * weight[:, np.newaxis], plateau))
        solution = np.linalg.lstsq(columns, target, rcond=1e-6)[0]
        return float(np.sum((columns @ solution - target) ** 2))

    lowest, highest = float(curve.pressure_ratio.min()), float(curve.pressure_ratio.max())
    places = np.unique(np.round(np.linspace(lowest, highest, _PLACES + 2)[1:-1], 2))
    places = places[(places > max(lowest, 0.0)) & (places < min(highest, 1.0))]
    inner = min(combinations(places, min(_INNER, len(places))), key=misfit)
    return np.array([0.0, *inner, 1.0])
