"""Controllers of the two-link manipulator that do not change: linear ones and computed torque."""

import math
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from pneuservo.arrays import Array
from pneuservo.manipulator.manipulator import Manipulator, nominal, printed_state_feedback

# Every loop is asked for (s + 4)^2, equation (A1.8): a double pole, settled in about a second.
POLE = 4.0
POSITION_GAIN, VELOCITY_GAIN = POLE * POLE, 2.0 * POLE


class Motion(NamedTuple):
    """Where the joints are, or should be."""

    angles: Array
    """(2,) [rad]."""
    rates: Array
    """(2,) [rad/s]."""
    accelerations: Array
    """(2,) [rad/s^2]."""


class Controller(Protocol):
    """What commands the torques of the joints, once a sampling period."""

    kind: ClassVar[str]

    def torque(self, measured: Motion, demanded: Motion) -> Array:
        """Return the torques until the next sample [N m].

        Parameters
        ----------
        measured : Motion
            The accelerations are those up to this sample.
        demanded : Motion
            From the filter of the reference.
        """


def demanded_motion(time: float, targets: Array, pole: float = POLE) -> Motion:
    """Return a step through a critically damped filter of second order, with its derivatives.

    Parameters
    ----------
    time : float
        Since the step [s].
    targets : (2,) array
        Where the step ends; it starts at 0 [rad].
    pole : float, optional
        Double pole of the filter, as a rate [1/s].

    Examples
    --------
    >>> demanded_motion(10.0, np.array([1.0, 0.5])).angles.round(6).tolist()
    [1.0, 0.5]
    """
    passed = pole * time
    fading = math.exp(-passed)
    return Motion(
        targets * (1.0 - (1.0 + passed) * fading),
        targets * (pole * passed * fading),
        targets * (pole * pole * (1.0 - passed) * fading),
    )


def gravity_compensation(model: Manipulator, angles: Array) -> Array:
    """Return the torques that hold the links where they are [N m].

    Parameters
    ----------
    model : Manipulator
        What the controller takes the manipulator to be.
    angles : (2,) array
        Measured [rad].
    """
    still = np.zeros(2)
    torque: Array = model.regressor(angles, still, still) @ model.parameters
    return torque


def joint_models(model: Manipulator) -> tuple[Array, Array]:
    """Return a and b of the joints' own models a/(s (s + b)), other joints taken as disturbance.

    Parameters
    ----------
    model : Manipulator
        What the controller takes the manipulator to be.

    Returns
    -------
    a, b : (2,) array
        [rad/(s^2 V)], [1/s].

    Notes
    -----
    Equations (A1.5) to (A1.7), linear where the second link stands at right angles.
    """
    first, second = _constant_inertias(model)
    yielding = np.array([1.0 / first, 1.0 / first + 1.0 / second])
    return np.array(model.actuator_gains) * yielding, np.array(model.frictions) * yielding


def _constant_inertias(model: Manipulator) -> tuple[float, float]:
    """Return J1 + m1 lc1^2 + m2 l1^2 and J2 + m2 lc2^2 [kg m^2]."""
    (m1, m2), (j1, j2), (lc1, lc2) = model.masses, model.inertias, model.centres
    return j1 + m1 * lc1 * lc1 + m2 * model.length * model.length, j2 + m2 * lc2 * lc2


def decoupling_gain(model: Manipulator) -> Array:
    """Return the state-feedback gain that gives both joints (s + 4)^2, without coupling.

    Parameters
    ----------
    model : Manipulator
        What the controller takes the manipulator to be.

    Returns
    -------
    (2, 4) array
        On [theta1, theta1', theta2, theta2'] [V/rad], [V s/rad].

    Notes
    -----
    What (A1.12) prints to one or two digits: the inverse of the linear model of (A1.4), whose mass
    matrix is that at right angles. No general algorithm places a fourfold pole with two inputs.

    Examples
    --------
    >>> decoupling_gain(nominal()).round(4).tolist()
    [[6.4, 1.325, 1.2, 0.6], [2.4, 1.2, 2.4, 0.7]]
    """
    first, second = _constant_inertias(model)
    inertia = np.array([[first + second, second], [second, second]])
    friction = np.diag(model.frictions)
    per_volt = np.array(model.actuator_gains)[:, None]
    gain = np.empty((2, 4))
    gain[:, 0::2] = POSITION_GAIN * inertia / per_volt
    gain[:, 1::2] = (VELOCITY_GAIN * inertia - friction) / per_volt
    return gain


@dataclass(frozen=True)
class ProportionalDerivative:
    """Each joint for itself: proportional and derivative, acceleration and gravity fed forward.

    Parameters
    ----------
    model : Manipulator, optional
        What it is designed for.

    Notes
    -----
    Equations (A1.6) to (A1.9) and Fig A1.2 of the thesis. Table A1.2 prints its gains.

    Examples
    --------
    >>> [gain.round(4).tolist() for gain in ProportionalDerivative().gains]
    [[5.2, 1.95], [0.725, 0.475]]
    """

    kind: ClassVar[str] = "pd"
    model: Manipulator = field(default_factory=nominal)

    @property
    def gains(self) -> tuple[Array, Array]:
        """Return kp [V/rad] and kd [V s/rad] of the joints."""
        a, b = joint_models(self.model)
        return POSITION_GAIN / a, (VELOCITY_GAIN - b) / a

    def torque(self, measured: Motion, demanded: Motion) -> Array:
        """Return the torques until the next sample; see `Controller`."""
        proportional, derivative = self.gains
        a, _ = joint_models(self.model)
        voltage = (
            proportional * (demanded.angles - measured.angles)
            + derivative * (demanded.rates - measured.rates)
            + demanded.accelerations / a
        )
        return voltage * np.array(self.model.actuator_gains) + gravity_compensation(
            self.model, measured.angles
        )


@dataclass(frozen=True)
class StateFeedback:
    """Feedback of all four states through one matrix, gravity fed forward.

    Parameters
    ----------
    gain : (2, 4) array, optional
        On [theta1, theta1', theta2, theta2'] [V/rad], [V s/rad].
    model : Manipulator, optional
        Whose gravity is compensated.

    Notes
    -----
    Equations (A1.10) to (A1.12): u = K (r - x), the reference with its rates.
    """

    kind: ClassVar[str] = "state-feedback"
    gain: Array = field(default_factory=printed_state_feedback)
    model: Manipulator = field(default_factory=nominal)

    def torque(self, measured: Motion, demanded: Motion) -> Array:
        """Return the torques until the next sample; see `Controller`."""
        error = np.empty(4)
        error[0::2] = demanded.angles - measured.angles
        error[1::2] = demanded.rates - measured.rates
        voltage = self.gain @ error
        return voltage * np.array(self.model.actuator_gains) + gravity_compensation(
            self.model, measured.angles
        )


def servo_acceleration(measured: Motion, demanded: Motion) -> Array:
    """Return the acceleration that brings the error to zero along (s + 4)^2 [rad/s^2].

    Parameters
    ----------
    measured, demanded : Motion
        As in `Controller.torque`.

    Notes
    -----
    Equation (A1.15), theta* = theta_d'' + Kv E' + Kp E.
    """
    return (
        demanded.accelerations
        + VELOCITY_GAIN * (demanded.rates - measured.rates)
        + POSITION_GAIN * (demanded.angles - measured.angles)
    )


@dataclass(frozen=True)
class ComputedTorque:
    """The torques that a model needs for the acceleration wanted.

    Parameters
    ----------
    model : Manipulator, optional
        What it takes the manipulator to be.

    Notes
    -----
    Equations (A1.13) to (A1.17): with a perfect model E'' + Kv E' + Kp E = 0.
    """

    kind: ClassVar[str] = "computed-torque"
    model: Manipulator = field(default_factory=nominal)

    def torque(self, measured: Motion, demanded: Motion) -> Array:
        """Return the torques until the next sample; see `Controller`."""
        wanted = servo_acceleration(measured, demanded)
        torque: Array = (
            self.model.regressor(measured.angles, measured.rates, wanted) @ self.model.parameters
        )
        return torque
