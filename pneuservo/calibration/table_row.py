"""One row of a discharge-coefficient table, from one transient."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.calibration.break_points import found_break_points, required_break_points
from pneuservo.calibration.flow_curve import FlowCurve, flow_curve
from pneuservo.calibration.pressure_fit import Found, PressureFit
from pneuservo.calibration.transient import LEAK, Transient
from pneuservo.errors import InputError
from pneuservo.intervals import INTERVAL
from pneuservo.noise import effective_samples

# So wide an interval, as a share of the largest coefficient, decides nothing.
_VISIBLE = 0.25


@dataclass(frozen=True)
class TableRow:
    """Discharge coefficients of one path at one command.

    Parameters
    ----------
    transient : Transient
        What it was found from.
    polytropic_index : float
        That was assumed [-].
    pressure_ratio : (n,) array
        Break points, from 0 to 1; linear between them [-].
    coefficient : (n,) array
        At the break points, that of the nearest one in reach where the transient does not come;
        of a leak the effective area [m^2].
    half_width : (n,) array
        Half width of the 95 % interval; NaN where the transient does not reach.
    residual : (k,) array
        Pressure measured less modelled, over `time` [Pa].
    curve : FlowCurve
        The coefficient straight from the rate of the pressure.
    """

    transient: Transient
    polytropic_index: float
    pressure_ratio: Array
    coefficient: Array
    half_width: Array
    time: Array = field(repr=False)
    modelled: Array = field(repr=False)
    residual: Array = field(repr=False)
    curve: FlowCurve = field(repr=False)

    @property
    def path(self) -> str:
        """Return the flow path."""
        return self.transient.path

    @property
    def command(self) -> float:
        """Return the magnitude of the command [V]."""
        return self.transient.command

    @property
    def visible(self) -> Mask:
        """Return which of the coefficients the transient decides."""
        return np.isfinite(self.half_width)

    def at(self, pressure_ratio: Array | float) -> Array:
        """Return the coefficient at pressure ratios, linear between the break points."""
        values: Array = np.asarray(np.interp(pressure_ratio, self.pressure_ratio, self.coefficient))
        return values


def fit_row(
    transient: Transient,
    break_points: Sequence[float] | None = None,
    polytropic_index: float | None = None,
) -> TableRow:
    """Find the discharge coefficients that explain one transient.

    Parameters
    ----------
    transient : Transient
        The charge or discharge.
    break_points : sequence of float, optional
        Pressure ratios from 0 to 1 between which the coefficient is linear; multiples of 0.01. By
        default five, the three inner ones where they fit best [-].
    polytropic_index : float, optional
        That is assumed: by default the rig's, and 1 for a leak, which is slow [-].

    Returns
    -------
    TableRow
        With 95 % intervals.

    Raises
    ------
    InputError
        For break points that are not allowed, and when the pressure changes too little to decide a
        flow by.

    Notes
    -----
    Equation (4.34) integrated: the pressure is simulated by the plant's own equations and compared
    with all samples, so that noise is never differentiated. Intervals are those of linearised
    least squares with the samples worth what their residual's correlation leaves of them.

    Examples
    --------
    >>> from pneuservo.calibration import simulate_transient, transient_of
    >>> row = fit_row(transient_of(simulate_transient("s_a", 5.0)), [0.0, 0.25, 0.6, 0.9, 1.0])
    >>> bool(abs(row.at(0.6) - 0.75) < 0.01)
    True
    """
    if polytropic_index is None:
        leak = transient.path == LEAK
        polytropic_index = 1.0 if leak else transient.rig["dead-volume.polytropic_index"]
    curve = flow_curve(transient, polytropic_index)
    fit = PressureFit(transient, polytropic_index, curve)
    knots = found_break_points(fit) if break_points is None else required_break_points(break_points)
    found = fit.solve(knots)
    half = _half_widths(fit, found)
    # The first one is held to the second by the plateau, not by samples.
    reached = (half < _VISIBLE * fit.scale) & (knots > 0.0)
    if not reached.any():
        raise InputError(
            f"{transient.name}: the pressure goes from {fit.measured[0]:.6g} Pa to "
            f"{fit.measured[-1]:.6g} Pa with a noise of {transient.noise_rms:.3g} Pa, too little "
            "to decide a flow by. Record for longer, or check supply and ambient pressure under "
            "[conditions]"
        )
    nearest = np.abs(np.subtract.outer(knots, knots[reached])).argmin(axis=1)
    return TableRow(
        transient,
        polytropic_index,
        knots,
        found.coefficients[reached][nearest],
        np.where(reached, half, np.nan),
        fit.time,
        fit.measured - found.residual,
        found.residual,
        curve,
    )


def _half_widths(fit: PressureFit, found: Found) -> Array:
    residual = found.residual
    left = max(float(np.sqrt(np.mean(residual**2))), fit.noise)
    inflation = (left / fit.noise) ** 2 * len(residual) / effective_samples(residual)
    # What is known beforehand is worth what it is, however well the samples are fitted.
    information = found.slopes.T @ found.slopes / inflation + found.known.T @ found.known
    half: Array = INTERVAL * fit.scale * np.sqrt(np.diag(np.linalg.inv(information)))[1:]
    return half
