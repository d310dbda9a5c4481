"""State feedback: gains by pole placement, the closed loop, and its step response by each model."""

from typing import TYPE_CHECKING

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.controllers import StateFeedback
from pneuservo.errors import InputError
from pneuservo.linear.models import state_space
from pneuservo.linear.parameter_update import Motion, parameter_update_response
from pneuservo.linear.servo_data import ServoData
from pneuservo.plant import integrator
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation import InitialState, simulate
from pneuservo.simulation.inputs import LARGEST_STEP, require_kind

if TYPE_CHECKING:
    from control import StateSpace


# The third pole by default, so many times further left than the pair.
THIRD_POLE_FACTOR = 15.0


def place_poles(
    servo: LinearServo,
    sensitivity: float,
    settling_time: float = 0.4,
    damping: float = 0.4,
    third_pole: float | None = None,
) -> StateFeedback:
    """Return the state feedback that gives the loop a settling time and a damping ratio.

    Parameters
    ----------
    servo : LinearServo
        The servo; the dynamics of its valve are not taken in.
    sensitivity : float
        Displacement transducer, on whose volts the gains act [V/m].
    settling_time : float, optional
        4/(damping wn) of the dominant pair [s].
    damping : float, optional
        Of the pair, above 0 up to 1 [-].
    third_pole : float, optional
        Distance of the third, real pole from the imaginary axis; by default 15 times that of the
        pair, as the thesis' table 5.5 has it [rad/s].

    Returns
    -------
    StateFeedback
        The controller, limited to its default level.

    Raises
    ------
    InputError
        When a requirement is out of range.

    Notes
    -----
    Equations (5.46) to (5.49) of the thesis: coefficients of (s + p)(s^2 + 2 damping wn s + wn^2).

    Examples
    --------
    >>> from pneuservo.linear import advanced_servo, table_5_2
    >>> controller = place_poles(advanced_servo(table_5_2(), 0.015, True), 10 / 0.03)
    >>> round(controller.gain, 3), round(controller.velocity_gain, 4)
    (0.261, -0.0412)
    """
    for name, value in (("settling time", settling_time), ("third pole", third_pole or 1.0)):
        if not 0.0 < value < np.inf:
            raise InputError(f"{name} is {value:g}; it has to be greater than 0")
    if not 0.0 < damping <= 1.0:
        raise InputError(f"damping is {damping:g}; it has to be above 0 and at most 1")
    decay = 4 / settling_time
    frequency = decay / damping
    pole = third_pole or THIRD_POLE_FACTOR * decay
    scale = servo.b0 * sensitivity
    return StateFeedback(
        gain=frequency**2 * pole / scale,
        velocity_gain=(frequency**2 + 2 * decay * pole - servo.a1) / scale,
        acceleration_gain=(pole + 2 * decay - servo.a2) / scale,
    )


def closed_loop(servo: LinearServo, controller: StateFeedback, sensitivity: float) -> "StateSpace":
    """Return displacement over demand as a python-control system.

    Parameters
    ----------
    servo : LinearServo
        The servo, with the dynamics of its valve or without.
    controller : StateFeedback
        Its gains; the level is not taken in.
    sensitivity : float
        Displacement transducer [V/m].

    Notes
    -----
    Equation (5.45) of the thesis, second use of that number.
    """
    import control

    plant = state_space(servo)
    gains = sensitivity * np.array(
        [[controller.gain, controller.velocity_gain, controller.acceleration_gain]]
    )
    return control.ss(
        plant.A - plant.B @ gains @ plant.C,
        plant.B * gains[0, 0],
        plant.C[:1],
        [[0.0]],
        inputs=["demand"],
        outputs=["displacement"],
    )


def largest_real_part(servo: LinearServo, controller: StateFeedback, sensitivity: float) -> float:
    """Return the real part of the rightmost pole of the loop; stable below 0 [1/s].

    Parameters
    ----------
    servo, controller, sensitivity
        As in `closed_loop`.
    """
    return float(np.max(closed_loop(servo, controller, sensitivity).poles().real))


def linear_step(
    servo: LinearServo, controller: StateFeedback, sensitivity: float, time: Array
) -> Array:
    """Return the response of the linear model to a unit step of the demand [-].

    Parameters
    ----------
    servo, controller, sensitivity
        As in `closed_loop`.
    time : (n,) array
        Equally spaced, from 0 [s].
    """
    import control

    response = control.step_response(closed_loop(servo, controller, sensitivity), time)
    return np.asarray(response.outputs)


def parameter_update_step(
    data: ServoData,
    controller: StateFeedback,
    sensitivity: float,
    time: Array,
    origin: float,
    target: float,
) -> Motion:
    """Return the response of the parameter-update model to a step of the demand.

    Parameters
    ----------
    data : ServoData
        The servo.
    controller, sensitivity
        As in `closed_loop`.
    time : (n,) array
        From the step on [s].
    origin, target : float
        Demand before and after [m].
    """

    def law(_t: float, x: float, v: float, a: float) -> float:
        gains = controller
        return sensitivity * (
            gains.gain * (target - x) - gains.velocity_gain * v - gains.acceleration_gain * a
        )

    return parameter_update_response(data, law, time, origin)


def nonlinear_step(
    rig: Rig,
    controller: StateFeedback,
    time: Array,
    origin: float,
    target: float,
    pressure_b: float | None = None,
    grid: Array | None = None,
) -> Motion:
    """Return the response of the non-linear plant to a step of the demand.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``; the gains act on the volts of its own transducer.
    controller : StateFeedback
        Its gains.
    time : (n,) array
        From the step on [s].
    origin, target : float
        Where the piston rests before, and the demand [m].
    pressure_b : float, optional
        At the start, the other chamber balancing it; by default 0.75 of the supply [Pa].
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].
    """
    start = InitialState(displacement=origin, pressure_b=pressure_b)
    if grid is None:
        run = simulate(rig, time=time, controller=controller, demand=target, initial=start)
        return Motion(run.time, run["displacement"], run["velocity"], run["acceleration"])
    plant = plant_numbers.single_axis(require_kind(rig, "single-axis"))
    outputs = integrator.run(
        np.array(time, float),
        np.column_stack((np.full(len(time), target), np.zeros(len(time)))),
        start.state(plant, origin, 0.0),
        controller.law(rig),
        plant,
        grid,
        LARGEST_STEP,
    )
    return Motion(time, *outputs[:, :3].T)
