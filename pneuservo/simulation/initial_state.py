"""Where a run of the single axis starts."""

import math
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant import single_axis as places
from pneuservo.plant.single_axis import SingleAxis

# The chamber on the rod side of a piston at rest, as a share of the supply pressure.
_PRESSURE_B_AT_REST = 0.75


@dataclass(frozen=True)
class InitialState:
    """State at the first time of a run; what is None follows from rest and the force balance.

    Parameters
    ----------
    displacement : float, optional
        0 to the stroke; by default the first demand, or mid-stroke without one [m].
    velocity : float, optional
        [m/s].
    pressure_a, pressure_b : float, optional
        Absolute [Pa]. A missing one balances the other; with both missing pressure_b is 0.75 of
        the supply pressure.
    spool : float, optional
        Fraction of full opening, -1 to 1 [-].
    spool_rate : float, optional
        [1/s].
    """

    displacement: float | None = None
    velocity: float = 0.0
    pressure_a: float | None = None
    pressure_b: float | None = None
    spool: float = 0.0
    spool_rate: float = 0.0

    def state(self, plant: SingleAxis, default_displacement: float, external_force: float) -> Array:
        """Return the state as the kernels take it.

        Parameters
        ----------
        plant : SingleAxis
            The numbers of the rig.
        default_displacement : float
            Used when none is given [m].
        external_force : float
            Force at the rod at the start, positive when it resists extension [N].

        Returns
        -------
        (6,) array
            Places as named in `pneuservo.plant.single_axis`, in SI.

        Raises
        ------
        InputError
            When a value is one the rig cannot have.
        """
        displacement = default_displacement if self.displacement is None else self.displacement
        pressure_a, pressure_b = self._pressures(plant, external_force)
        stroke = plant.piston.stroke
        _require("displacement", displacement, 0.0, stroke, "m")
        _require("spool", self.spool, -1.0, 1.0, "")
        for name, pressure in (("pressure_a", pressure_a), ("pressure_b", pressure_b)):
            if not 0.0 < pressure < math.inf:
                raise InputError(
                    f"initial {name} is {pressure:.6g} Pa; it has to be greater than 0. "
                    "It follows from the balance of forces unless it is given"
                )
        for name, value in (("velocity", self.velocity), ("spool_rate", self.spool_rate)):
            if not math.isfinite(value):
                raise InputError(f"initial {name} is {value}; it has to be a finite number")
        state = np.zeros(places.PLANT_STATES)
        state[places.DISPLACEMENT] = displacement
        state[places.VELOCITY] = self.velocity
        state[places.PRESSURE_A] = pressure_a
        state[places.PRESSURE_B] = pressure_b
        state[places.SPOOL] = self.spool
        state[places.SPOOL_RATE] = self.spool_rate
        return state

    def _pressures(self, plant: SingleAxis, external_force: float) -> tuple[float, float]:
        piston = plant.piston
        # What the chambers have to carry: pa Aa - pb Ab, positive lifts against gravity.
        load = (
            plant.ambient_pressure * (piston.area_a - piston.area_b)
            - piston.mass * piston.gravity
            + external_force
        )
        pressure_a, pressure_b = self.pressure_a, self.pressure_b
        if pressure_b is None:
            if pressure_a is None:
                pressure_b = _PRESSURE_B_AT_REST * plant.supply_pressure
            else:
                pressure_b = (pressure_a * piston.area_a - load) / piston.area_b
        if pressure_a is None:
            pressure_a = (pressure_b * piston.area_b + load) / piston.area_a
        return pressure_a, pressure_b


def _require(name: str, value: float, low: float, high: float, unit: str) -> None:
    if not low <= value <= high:
        unit = f" {unit}" if unit else ""
        raise InputError(
            f"initial {name} is {value:.6g}{unit}; it has to be from {low:g} to {high:g}{unit}"
        )
