"""The compiled non-linear plant linearised by differences: the check of the linear models."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import root

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.plant import single_axis as places
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.piston import EXTENDING, RETRACTING
from pneuservo.rigs import Rig, plant_numbers

if TYPE_CHECKING:
    from control import StateSpace


# States of the piston and its chambers, and the sizes by which they are varied: m, m/s, Pa, Pa.
_STATES = (places.DISPLACEMENT, places.VELOCITY, places.PRESSURE_A, places.PRESSURE_B)
_NAMES = ("displacement", "velocity", "pressure_a", "pressure_b")
_STEPS = (1e-7, 1e-4, 10.0, 10.0)
_VOLTAGE_STEP = 1e-4
# In what accelerations are counted, also where the rod lies level [m/s2].
_STANDARD_GRAVITY = 9.81


@dataclass(frozen=True)
class OperatingPoint:
    """Where the plant is linearised.

    Attributes
    ----------
    displacement, velocity : float
        [m], [m/s].
    pressure_a, pressure_b : float
        Absolute [Pa].
    voltage : float
        Command that holds the spool where it is; its sign is the direction of motion [V].
    """

    displacement: float
    velocity: float
    pressure_a: float
    pressure_b: float
    voltage: float


def steady_motion(
    rig: Rig, displacement: float, voltage: float, grid: Array | None = None
) -> OperatingPoint:
    """Return velocity and pressures of the non-linear plant in steady motion past a position.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    displacement : float
        [m].
    voltage : float
        Command, not zero; positive extends [V].
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].

    Returns
    -------
    OperatingPoint
        Where neither the pressures nor the velocity change.

    Raises
    ------
    InputError
        When the search does not find such a motion.
    """
    if voltage == 0.0:
        raise InputError("voltage is 0; a piston in steady motion needs an open valve")
    supply = rig["supply.pressure"]
    scale = np.array([voltage, supply, supply])

    def imbalance(unknown: Array) -> Array:
        velocity, pressure_a, pressure_b = unknown * scale
        point = OperatingPoint(displacement, velocity, pressure_a, pressure_b, voltage)
        rate = _rates(rig, point, grid)
        # m/s2 over the acceleration of gravity, and supply pressures each second.
        return np.array([rate[1] / _STANDARD_GRAVITY, rate[2] / supply, rate[3] / supply])

    start = np.array([0.03 / rig["valve.full_voltage"], 0.7, 0.85])
    found = root(imbalance, start, tol=1e-12)
    if not found.success:
        raise InputError(
            f"rig {rig.name}: no steady motion was found at {voltage:g} V; the load may be too "
            "large for the supply pressure"
        )
    velocity, pressure_a, pressure_b = (float(value) for value in found.x * scale)
    return OperatingPoint(displacement, velocity, pressure_a, pressure_b, voltage)


def linearised_plant(rig: Rig, point: OperatingPoint, grid: Array | None = None) -> "StateSpace":
    """Return the plant's kernels linearised by central differences, without the spool's dynamics.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    point : OperatingPoint
        About what; at a voltage of (almost) 0 the valve only passes what it is opened further.
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].

    Returns
    -------
    control.StateSpace
        States displacement, velocity and both pressures; input the valve voltage; outputs the
        states.
    """
    import control

    columns = [
        (
            _rates(rig, _moved(point, name, step), grid)
            - _rates(rig, _moved(point, name, -step), grid)
        )
        / (2 * step)
        for name, step in zip((*_NAMES, "voltage"), (*_STEPS, _VOLTAGE_STEP), strict=True)
    ]
    return control.ss(
        np.column_stack(columns[:4]),
        columns[4][:, np.newaxis],
        np.eye(4),
        np.zeros((4, 1)),
        states=list(_NAMES),
        inputs=["u"],
        outputs=list(_NAMES),
    )


def _moved(point: OperatingPoint, name: str, by: float) -> OperatingPoint:
    values = dict(vars(point))
    values[name] += by
    return OperatingPoint(**values)


def _rates(rig: Rig, point: OperatingPoint, grid: Array | None) -> Array:
    """Return the rates of displacement, velocity and both pressures by the plant's kernel."""
    plant = plant_numbers.single_axis(rig)
    state = np.zeros(places.PLANT_STATES)
    state[list(_STATES)] = [point.displacement, point.velocity, point.pressure_a, point.pressure_b]
    state[places.SPOOL] = point.voltage / plant.valve.full_voltage
    # By the voltage: a velocity varied about zero must not turn Coulomb friction round.
    motion = EXTENDING if point.voltage >= 0.0 else RETRACTING
    modes = np.array([motion, places.SPOOL_FREE, 1])
    rate = np.empty_like(state)
    used = plant_numbers.valve_grid(rig.valve) if grid is None else grid
    places.derivative(state, modes, np.zeros(2), OPEN_LOOP, plant, used, rate)
    return rate[list(_STATES)]
