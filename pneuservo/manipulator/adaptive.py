"""Variable-structure adaptive control: a model whose parameters are switched between bounds."""

import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.manipulator.controllers import VELOCITY_GAIN, Motion, servo_acceleration
from pneuservo.manipulator.manipulator import Manipulator, bounds, nominal


@dataclass
class VariableStructureAdaptive:
    """Computed torque whose parameters are switched between bounds, so that errors die out.

    Parameters
    ----------
    model : Manipulator, optional
        Its lengths are taken as known; its other values are not used.
    limits : (2, 6) array, optional
        Lower and upper bound of each of `Manipulator.parameters`; by default table A1.3.
    boundary_layer : float, optional
        Half width in the filtered error, the same for both joints; 0 for none [rad/s].
    slope : float, optional
        Weight of the error beside its rate in the filtered error [1/s].

    Attributes
    ----------
    estimates : (6,) array
        The parameters in use, in SI.

    Notes
    -----
    Equations (A1.18) to (A1.25) after Tso and others 1990, 1991. The filtered error is
    E1 = E' + slope E, whose slope has to lie below Kv = 8/s and is not printed. Inside the boundary
    layer, where both filtered errors are below its width, the switching is replaced by its linear
    interpolation: the printed form of (A1.25) is unreadable. What is left of the error is there
    up to boundary_layer/slope, and where one joint needs all of it, switching goes on at the edge.
    The acceleration in the switching function is the measured one.

    Raises
    ------
    InputError
        When the boundary layer is negative, or the slope not between 0 and Kv.
    """

    kind: ClassVar[str] = "variable-structure-adaptive"
    model: Manipulator = field(default_factory=nominal)
    limits: Array = field(default_factory=bounds)
    boundary_layer: float = 0.02
    slope: float = 2.0
    estimates: Array = field(init=False)

    def __post_init__(self) -> None:
        """Start between the bounds."""
        if not 0.0 <= self.boundary_layer < math.inf:
            raise InputError(
                f"{self.kind}: boundary_layer is {self.boundary_layer:g} rad/s; it has to be 0 or "
                "more"
            )
        if not 0.0 < self.slope < VELOCITY_GAIN:
            raise InputError(
                f"{self.kind}: slope is {self.slope:g} 1/s; it has to be between 0 and "
                f"Kv = {VELOCITY_GAIN:g} 1/s"
            )
        self.estimates = self.limits.mean(axis=0)

    def torque(self, measured: Motion, demanded: Motion) -> Array:
        """Return the torques until the next sample, having switched; see `Controller`."""
        self.estimates = self._switched(measured, demanded)
        wanted = servo_acceleration(measured, demanded)
        torque: Array = (
            self.model.regressor(measured.angles, measured.rates, wanted) @ self.estimates
        )
        return torque

    def _switched(self, measured: Motion, demanded: Motion) -> Array:
        """Return the estimates by (A1.24) and (A1.25)."""
        low, high = self.limits
        error = demanded.rates - measured.rates + self.slope * (demanded.angles - measured.angles)
        influence = np.linalg.solve(self._estimated_inertia(measured.angles), self._now(measured))
        if np.all(np.abs(error) < self.boundary_layer):
            whole = np.abs(influence).sum(axis=0) * self.boundary_layer
            share = np.divide(error @ influence, whole, out=np.zeros(6), where=whole > 0.0)
        else:
            share = np.sign(error @ influence)
        return 0.5 * (high + low) + 0.5 * (high - low) * share

    def _now(self, measured: Motion) -> Array:
        return self.model.regressor(measured.angles, measured.rates, measured.accelerations)

    def _estimated_inertia(self, angles: Array) -> Array:
        """Return the mass matrix by the estimates of the last sample."""
        still = np.zeros(2)
        held = self.model.regressor(angles, still, still)
        columns = [
            (self.model.regressor(angles, still, unit) - held) @ self.estimates
            for unit in np.eye(2)
        ]
        return np.column_stack(columns)
