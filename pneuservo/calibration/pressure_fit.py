"""Fitting the pressure of a dead volume by the coefficients at break points."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.calibration.flow_curve import FlowCurve
from pneuservo.calibration.transient import Transient, in_flow
from pneuservo.plant.dead_volume import PORT_A, PORT_B, run_dead_volume
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.plant.valve import (
    B_TO_EXHAUST,
    PRESSURE_RATIO_CELLS,
    SUPPLY_TO_A,
    VOLTAGE_CELLS,
)
from pneuservo.rigs.plant_numbers import dead_volume

# Below the first break point the flow is choked and the coefficient nearly constant.
PLATEAU = 0.05
# A coefficient lies between 0 and about 1. One that no sample depends on keeps its start, and an
# interval as wide as this says so.
_UNKNOWN = 1.0
_STEPS_PER_SAMPLE = 4
_MOST_SAMPLES = 3000
# Beyond the end of the flow there is nothing to see but where it ended.
_BEYOND = 1.2
_COEFFICIENT_STEP, _RATIO_STEP, _PRESSURE_STEP = 1e-4, 0.01, 0.1
_MOST_EVALUATIONS = 30


@dataclass(frozen=True)
class Found:
    """Coefficients at break points that fit a transient.

    Parameters
    ----------
    break_points, coefficients : (n,) array
        Pressure ratios [-] and values there.
    residual : (k,) array
        Pressure measured less modelled [Pa].
    slopes : (k, n) array
        Sensitivity of the model to the coefficients, in noise per scale.
    known : (m, n) array
        The same of what is known beforehand.
    cost : float
        Half the sum of squares.
    """

    break_points: Array
    coefficients: Array
    residual: Array
    slopes: Array
    known: Array
    cost: float


class PressureFit:
    """The pressure in the volume, from its start and the coefficients at break points.

    Parameters
    ----------
    transient : Transient
        What was measured.
    polytropic_index : float
        That is assumed [-].
    curve : FlowCurve
        The coefficient straight from the rate of the pressure; where a fit starts.
    """

    def __init__(self, transient: Transient, polytropic_index: float, curve: FlowCurve):
        self.curve, self.noise = curve, transient.noise_rms
        self.scale = float(np.max(np.abs(curve.coefficient))) or 1.0
        self.time, self.measured = _used(transient)
        plant = dead_volume(
            transient.rig.with_values({"dead-volume.polytropic_index": polytropic_index})
        )
        # Any path of the kernel serves; the area is that of the one the transient belongs to.
        self._path = SUPPLY_TO_A if transient.charging else B_TO_EXHAUST
        self._port = PORT_A if transient.charging else PORT_B
        name = f"area_{FLOW_PATHS[self._path]}"
        self._plant = plant._replace(valve=plant.valve._replace(**{name: transient.area}))
        self._voltage = np.full(len(self.time), plant.valve.full_voltage)
        self._step = (self.time[-1] - self.time[0]) / len(self.time) / _STEPS_PER_SAMPLE
        self._ratios = np.arange(PRESSURE_RATIO_CELLS + 1) / PRESSURE_RATIO_CELLS
        self._grid = np.zeros((len(FLOW_PATHS), VOLTAGE_CELLS + 1, len(self._ratios)))

    def pressure(self, start: float, break_points: Array, coefficients: Array) -> Array:
        """Return the pressure at the times of the samples [Pa]."""
        self._grid[self._path] = np.interp(self._ratios, break_points, coefficients)
        found: Array = run_dead_volume(
            self.time, self._voltage, start, self._port, self._plant, self._grid, self._step
        )
        return found

    def first_guess(self, break_points: Array) -> Array:
        """Return coefficients at break points that fit the curve."""
        hats = interpolation(self.curve.pressure_ratio, break_points)
        weight = weights(self.curve)
        solution = np.linalg.lstsq(
            hats * weight[:, np.newaxis], self.curve.coefficient * weight, rcond=1e-6
        )[0]
        guess: Array = np.clip(solution, 0.0, self.scale)
        return guess

    def solve(self, break_points: Array, movable: bool = False) -> Found:
        """Fit start pressure and coefficients, and the inner break points when they may move.

        Parameters
        ----------
        break_points : (n,) array
            From 0 to 1 [-].
        movable : bool, optional
            Whether the inner ones may move.
        """
        from scipy.optimize import least_squares

        start = np.maximum(self.first_guess(break_points) / self.scale, 1e-3)
        inner = break_points[1:-1] if movable else np.empty(0)
        count = len(start)

        def placed(vector: Array) -> Array:
            if not movable:
                return break_points
            return np.concatenate(([0.0], np.sort(vector[count + 1 :]), [1.0]))

        def cost(vector: Array) -> Array:
            values = vector[1 : count + 1]
            first = self.measured[0] + self.noise * vector[0]
            pressure = self.pressure(first, placed(vector), values * self.scale)
            plateau = (values[0] - values[1]) / PLATEAU
            known = np.append(plateau, (values - start) / _UNKNOWN)
            return np.concatenate(((pressure - self.measured) / self.noise, known))

        steps = np.concatenate(
            (
                [_PRESSURE_STEP],
                np.full(count, _COEFFICIENT_STEP),
                np.full(len(inner), _RATIO_STEP),
            )
        )
        lower = np.concatenate(([-np.inf], np.zeros(count), np.full(len(inner), _RATIO_STEP)))
        upper = np.concatenate((np.full(count + 1, np.inf), np.full(len(inner), 1.0 - _RATIO_STEP)))
        found: Any = least_squares(
            cost,
            np.concatenate(([0.0], start, inner)),
            lambda vector: _slopes(cost, vector, steps),
            bounds=(lower, upper),
            x_scale="jac",
            max_nfev=_MOST_EVALUATIONS,
        )
        samples, values = len(self.measured), slice(0, count + 1)
        return Found(
            placed(found.x),
            found.x[1 : count + 1] * self.scale,
            -self.noise * found.fun[:samples],
            found.jac[:samples, values],
            found.jac[samples:, values],
            float(found.cost),
        )


def weights(curve: FlowCurve) -> Array:
    """Return the weight of every point of a curve; none counts as perfectly known."""
    least = 1e-3 * float(np.max(np.abs(curve.coefficient)))
    return 1.0 / np.maximum(curve.half_width, least)


def interpolation(ratio: Array, break_points: Array) -> Array:
    """Return the linear interpolation between break points as a matrix, one column for each."""
    units = np.eye(len(break_points))
    return np.column_stack([np.interp(ratio, break_points, unit) for unit in units])


def _slopes(cost: Callable[[Array], Array], vector: Array, steps: Array) -> Array:
    """Return the Jacobian by equal steps: the size of a coefficient of 0 is no measure of it."""
    here = cost(vector)
    moved = vector + np.diag(steps)
    return np.column_stack([(cost(m) - here) / h for m, h in zip(moved, steps, strict=True)])


def _used(transient: Transient) -> tuple[Array, Array]:
    """Return the samples that a fit uses: those that flow and a few more, evenly thinned."""
    last = int(_BEYOND * np.flatnonzero(in_flow(transient))[-1])
    used = np.arange(min(len(transient.time), last + 1))
    used = used[:: -(-len(used) // _MOST_SAMPLES)]
    return np.ascontiguousarray(transient.time[used]), transient.pressure[used]
