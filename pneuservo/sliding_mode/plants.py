"""The plants that a sliding-mode law is tried on: linear, parameter-update and non-linear."""

import math
from typing import Protocol

import numpy as np
from scipy.linalg import expm

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.linear.models import state_matrices
from pneuservo.linear.parameter_update import parameter_update_jerk
from pneuservo.linear.servo_data import ServoData
from pneuservo.plant import single_axis as places
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.events import settle
from pneuservo.plant.integrator import advance, initial_modes
from pneuservo.plant.piston import acceleration
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation import InitialState
from pneuservo.simulation.inputs import require_kind


class Plant(Protocol):
    """A servo that is advanced step by step with a held voltage."""

    def motion(self) -> tuple[float, ...]:
        """Return displacement [m] and its derivatives, at least to the acceleration."""

    def advance(self, voltage: float, step: float) -> None:
        """Move on by one step with the voltage held [V], [s]."""


class LinearPlant:
    """A linear servo at rest at a displacement, advanced exactly.

    Parameters
    ----------
    servo : LinearServo
        With valve dynamics its motion goes on to the fourth derivative, which its states give.
    displacement : float
        [m].
    """

    def __init__(self, servo: LinearServo, displacement: float):
        self._servo = servo
        a, b = state_matrices(servo)
        order = len(a)
        self._matrix = np.zeros((order + 1, order + 1))
        self._matrix[:order, :order], self._matrix[:order, order] = a, b[:, 0]
        self._state = np.zeros(order + 1)
        self._state[0] = displacement
        self._step, self._transition = 0.0, np.eye(order + 1)

    def motion(self) -> tuple[float, ...]:
        """Return displacement, velocity, acceleration; with a valve also jerk and its rate."""
        x, v, a = (float(value) for value in self._state[:3])
        if not math.isfinite(self._servo.valve_frequency):
            return x, v, a
        servo, (opening, rate) = self._servo, self._state[3:5]
        jerk = servo.b0 * opening - servo.a1 * v - servo.a2 * a
        return x, v, a, float(jerk), float(servo.b0 * rate - servo.a1 * a - servo.a2 * jerk)

    def advance(self, voltage: float, step: float) -> None:
        """Move on by one step."""
        if step != self._step:
            self._step, self._transition = step, expm(self._matrix * step)
        self._state[-1] = voltage
        self._state = self._transition @ self._state


class UpdatePlant:
    """The parameter-update model behind the dynamics of its valve, advanced by Runge-Kutta steps.

    Parameters
    ----------
    data : ServoData
        The servo.
    displacement : float
        Where it starts at rest [m].
    """

    def __init__(self, data: ServoData, displacement: float):
        self._data = data
        self._state = np.array([displacement, 0.0, 0.0, 0.0, 0.0])

    def motion(self) -> tuple[float, ...]:
        """Return displacement, velocity and acceleration."""
        x, v, a = (float(value) for value in self._state[:3])
        return x, v, a

    def advance(self, voltage: float, step: float) -> None:
        """Move on by one step."""
        state = self._state
        first = self._rate(state, voltage)
        second = self._rate(state + 0.5 * step * first, voltage)
        third = self._rate(state + 0.5 * step * second, voltage)
        fourth = self._rate(state + step * third, voltage)
        self._state = state + step / 6 * (first + 2 * second + 2 * third + fourth)

    def _rate(self, state: Array, voltage: float) -> Array:
        x, v, a, opening, rate = (float(value) for value in state)
        w = 2 * math.pi * self._data.valve_frequency
        spool = w * w * (voltage - opening) - 2 * self._data.valve_damping * w * rate
        jerk = parameter_update_jerk(self._data, x, v, a, opening)
        return np.array([v, a, jerk, rate, spool])


class NonlinearPlant:
    """The compiled non-linear plant, its voltage held over each step.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    displacement : float
        Where it starts at rest [m].
    """

    def __init__(self, rig: Rig, displacement: float):
        self._plant = plant_numbers.single_axis(require_kind(rig, "single-axis"))
        self._grid = plant_numbers.valve_grid(rig.valve)
        self._state = InitialState(displacement=displacement).state(self._plant, displacement, 0.0)
        self._inputs = np.zeros(2)
        self._modes = initial_modes(self._state, self._inputs, self._plant)
        self._work, self._result = np.empty((3, len(self._state))), np.empty(len(self._state))

    def motion(self) -> tuple[float, ...]:
        """Return displacement, velocity and acceleration."""
        force = places.piston_force(self._state, self._inputs, self._plant)
        rate = acceleration(force, self._modes[places.MOTION], self._plant.piston)
        return float(self._state[places.DISPLACEMENT]), float(self._state[places.VELOCITY]), rate

    def advance(self, voltage: float, step: float) -> None:
        """Move on by one step."""
        self._inputs[places.COMMAND] = voltage
        settle(self._state, self._modes, self._inputs, OPEN_LOOP, self._plant)
        advance(
            self._state,
            step,
            self._modes,
            self._inputs,
            OPEN_LOOP,
            self._plant,
            self._grid,
            self._work,
            self._result,
        )
