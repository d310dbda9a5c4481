"""The linear models of chapter 5: conventional and advanced, and as python-control systems."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.linear.servo_data import ServoData

if TYPE_CHECKING:
    from control import StateSpace, TransferFunction

# Share of the supply pressure that the conventional model takes for both quiescent pressures.
CONVENTIONAL_PRESSURE = 0.8


def advanced_servo(data: ServoData, displacement: float, extending: bool) -> LinearServo:
    """Return the linear model about a position, for one direction of the valve's opening.

    Parameters
    ----------
    data : ServoData
        The servo at its quiescent pressures.
    displacement : float
        Piston position, 0 to the stroke [m].
    extending : bool
        Which paths of the valve are open.

    Returns
    -------
    LinearServo
        With the dynamics of the valve.

    Raises
    ------
    InputError
        When the position is outside the stroke.

    Notes
    -----
    Equations (5.26) and (5.30) to (5.34) of the thesis: small movements about slow steady motion,
    polytropic chambers, one temperature, what the flow loses as pressures change left out.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> servo = advanced_servo(table_5_2(), 0.015, extending=True)
    >>> round(servo.a1), round(servo.b0)  # the thesis' own figures: 18421 1/s2, 1077 m/(s3 V)
    (18421, 1077)
    """
    if not 0.0 <= displacement <= data.stroke:
        raise InputError(
            f"displacement {displacement:g} m is outside the stroke, 0 to {data.stroke:g} m"
        )
    length_a = displacement + data.dead_volume_a / data.area_a
    length_b = data.stroke - displacement + data.dead_volume_b / data.area_b
    supply, exhaust, areas = data.supply_pressure, data.exhaust_pressure, data.flow_areas
    if extending:
        flow_a = areas.supply_to_a * data.through(supply, data.pressure_a)
        flow_b = areas.b_to_exhaust * data.through(data.pressure_b, exhaust)
    else:
        flow_a = areas.a_to_exhaust * data.through(data.pressure_a, exhaust)
        flow_b = areas.supply_to_b * data.through(supply, data.pressure_b)
    stiffness = data.pressure_a * data.area_a / length_a + data.pressure_b * data.area_b / length_b
    return LinearServo(
        b0=_inflow(data) * (flow_a / length_a + flow_b / length_b),
        a1=data.polytropic_index / data.mass * stiffness,
        a2=data.viscous_friction / data.mass,
        valve_frequency=data.valve_frequency,
        valve_damping=data.valve_damping,
    )


def conventional_servo(
    data: ServoData, displacement: float | None = None, extending: bool = True
) -> LinearServo:
    """Return the conventional linear model: equal areas, both chambers at 0.8 of the supply.

    Parameters
    ----------
    data : ServoData
        The servo; its rod-side area and dead volume stand for both chambers.
    displacement : float, optional
        Piston position, 0 to the stroke; by default mid-stroke [m].
    extending : bool, optional
        Which chamber is charged; it makes no difference at mid-stroke.

    Returns
    -------
    LinearServo
        With the dynamics of the valve.

    Notes
    -----
    Equations (5.23) to (5.27) of the thesis, after Shearer (1956): choked flow on either side, so
    that `advanced_servo` of `equal_areas` differs in the charging flow and the pressures.

    Examples
    --------
    >>> from pneuservo.linear import table_5_2
    >>> servo = conventional_servo(table_5_2())
    >>> round(servo.a1), round(servo.b0, 1), round(servo.a2, 3)
    (17248, 1059.7, 54.945)
    """
    position = 0.5 * data.stroke if displacement is None else displacement
    pressure = CONVENTIONAL_PRESSURE * data.supply_pressure
    choked = data.gas.choked_coefficient
    equal = replace(
        data,
        area_a=data.area_b,
        dead_volume_a=data.dead_volume_b,
        pressure_a=pressure,
        pressure_b=pressure,
    )
    servo = advanced_servo(equal, position, extending)
    dead = equal.dead_volume_b / equal.area_b
    length_a, length_b = position + dead, equal.stroke - position + dead
    charged, other = (length_a, length_b) if extending else (length_b, length_a)
    areas = data.flow_areas
    into = areas.supply_to_a if extending else areas.supply_to_b
    out = areas.b_to_exhaust if extending else areas.a_to_exhaust
    flow = choked * (into * data.supply_pressure / charged + out * pressure / other)
    return replace(servo, b0=_inflow(data) * flow)


def without_valve(servo: LinearServo) -> LinearServo:
    """Return the same servo with a valve that follows at once.

    Parameters
    ----------
    servo : LinearServo
        The servo.
    """
    return replace(servo, valve_frequency=math.inf)


def transfer_function(servo: LinearServo) -> "TransferFunction":
    """Return displacement over valve voltage as a python-control system [m/V].

    Parameters
    ----------
    servo : LinearServo
        The servo; third order without the dynamics of the valve, else fifth.

    Examples
    --------
    >>> transfer_function(without_valve(LinearServo())).poles().size
    3
    """
    import control

    plant = control.tf([servo.b0], [1.0, servo.a2, servo.a1, 0.0], inputs="u", outputs="x")
    if not math.isfinite(servo.valve_frequency):
        return plant
    w = 2 * math.pi * servo.valve_frequency
    return plant * control.tf([w * w], [1.0, 2 * servo.valve_damping * w, w * w])


def state_matrices(servo: LinearServo) -> tuple[Array, Array]:
    """Return system and input matrix of the canonical state-space form.

    Parameters
    ----------
    servo : LinearServo
        The servo.

    Returns
    -------
    a : (n, n) array
        States displacement, velocity, acceleration; with the dynamics of the valve also its
        opening in volts and the rate of that.
    b : (n, 1) array
        Input the valve voltage.
    """
    valve = math.isfinite(servo.valve_frequency)
    order = 5 if valve else 3
    a, b = np.zeros((order, order)), np.zeros((order, 1))
    a[0, 1] = a[1, 2] = 1.0
    a[2, 1], a[2, 2] = -servo.a1, -servo.a2
    if valve:
        w = 2 * math.pi * servo.valve_frequency
        a[2, 3], a[3, 4] = servo.b0, 1.0
        a[4, 3], a[4, 4], b[4, 0] = -w * w, -2 * servo.valve_damping * w, w * w
    else:
        b[2, 0] = servo.b0
    return a, b


def state_space(servo: LinearServo) -> "StateSpace":
    """Return the canonical state-space form as a python-control system.

    Parameters
    ----------
    servo : LinearServo
        The servo.

    Returns
    -------
    control.StateSpace
        With the states of `state_matrices`; outputs displacement, velocity and acceleration.
    """
    import control

    a, b = state_matrices(servo)
    names = ["displacement", "velocity", "acceleration", "opening", "opening_rate"][: len(a)]
    return control.ss(
        a,
        b,
        np.eye(3, len(a)),
        np.zeros((3, 1)),
        states=names,
        inputs=["u"],
        outputs=names[:3],
    )


def _inflow(data: ServoData) -> float:
    """Return n R sqrt(T)/(m Umax): jerk for each volt and each flow over length."""
    root = math.sqrt(data.gas.temperature)
    return data.polytropic_index * data.gas.gas_constant * root / (data.mass * data.full_voltage)
