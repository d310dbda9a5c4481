"""Running the two-link manipulator under a controller that acts once a sampling period."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.manipulator.controllers import Controller, Motion, demanded_motion
from pneuservo.manipulator.linkage import gravity_torque, mass_matrix, velocity_torque
from pneuservo.manipulator.manipulator import GRAVITY, Manipulator, nominal
from pneuservo.plant.compilation import compiled
from pneuservo.plant.copying import put

# The references of the appendix [rad].
TARGETS = (1.0, 0.5)


@dataclass(frozen=True)
class ManipulatorRun:
    """One simulated run.

    Parameters
    ----------
    time : (n,) array
        [s].
    angles, demanded : (n, 2) array
        Of the joints [rad].
    torques : (n, 2) array
        Held from each time to the next [N m].
    estimates : (n, 6) array or None
        Of the parameters, for a controller that adapts them.
    """

    time: Array
    angles: Array
    demanded: Array
    torques: Array
    estimates: Array | None = None

    @property
    def highest(self) -> Array:
        """Return the largest angle each joint came to [rad]."""
        highest: Array = self.angles.max(axis=0)
        return highest

    @property
    def final(self) -> Array:
        """Return the mean angles of the last tenth of the run [rad]."""
        final: Array = self.angles[-max(len(self.time) // 10, 1) :].mean(axis=0)
        return final

    def swing(self, share: float = 0.1) -> Array:
        """Return the range of the angles over the end of the run [rad].

        Parameters
        ----------
        share : float, optional
            Of the run, counted from its end [-].
        """
        last = max(round(share * len(self.time)), 1)
        swing: Array = np.ptp(self.angles[-last:], axis=0)
        return swing


def simulate_manipulator(
    controller: Controller,
    plant: Manipulator | None = None,
    targets: ArrayLike = TARGETS,
    duration: float = 4.0,
    sampling_time: float = 1e-3,
) -> ManipulatorRun:
    """Simulate a step of both references from rest upright, through the reference filter.

    Parameters
    ----------
    controller : Controller
        One of `pneuservo.manipulator.controllers`, or an own one; one that remembers is used up.
    plant : Manipulator, optional
        What is moved; by default the nominal one.
    targets : (2,) array, optional
        Where the references end [rad].
    duration : float, optional
        [s].
    sampling_time : float, optional
        Between two actions of the controller, whose torques are held [s].

    Returns
    -------
    ManipulatorRun
        The run.

    Raises
    ------
    InputError
        When duration or sampling time are not positive, or the motion has no end.

    Notes
    -----
    Classical Runge-Kutta, one step a sample. Actuators are ideal: torque at once and without limit.

    Examples
    --------
    >>> from pneuservo.manipulator.controllers import ComputedTorque
    >>> simulate_manipulator(ComputedTorque(), duration=3.0).final.round(2).tolist()
    [1.0, 0.5]
    """
    for name, value in (("duration", duration), ("sampling_time", sampling_time)):
        if not 0.0 < value < math.inf:
            raise InputError(f"{name} is {value:g} s; it has to be greater than 0")
    moved = nominal() if plant is None else plant
    linkage, friction = moved.linkage, np.array(moved.frictions)
    ends = np.asarray(targets, dtype=float)
    samples = round(duration / sampling_time) + 1
    time: Array = sampling_time * np.arange(samples, dtype=np.float64)
    angles, demanded, torques = np.zeros((3, samples, 2))
    estimates = np.zeros((samples, 6)) if hasattr(controller, "estimates") else None
    state, accelerations = np.zeros((2, 2)), np.zeros(2)
    for k in range(samples):
        wanted = demanded_motion(float(time[k]), ends)
        torque = controller.torque(Motion(state[0], state[1], accelerations), wanted)
        angles[k], demanded[k], torques[k] = state[0], wanted.angles, torque
        if estimates is not None:
            estimates[k] = controller.estimates  # type: ignore[attr-defined]
        state, accelerations = _next(state, torque, friction, linkage, sampling_time)
        if not np.isfinite(state).all():
            raise InputError(
                f"{controller.kind}: the motion has no end from t = {time[k]:g} s; give a shorter "
                "sampling_time, or a model nearer to the plant"
            )
    return ManipulatorRun(time, angles, demanded, torques, estimates)


@compiled
def joint_acceleration(angles, rates, torque, friction, linkage):  # type: ignore[no-untyped-def]
    """Return the accelerations of the joints under torques [rad/s^2].

    Parameters
    ----------
    angles, rates, torque : (n,) array
        [rad], [rad/s], [N m].
    friction : (n,) array
        Viscous, of the joints [N m s/rad].
    linkage : Linkage
        The links.

    Notes
    -----
    Equation (A1.2) of the thesis.
    """
    left = torque - velocity_torque(angles, rates, linkage) - friction * rates
    return np.linalg.solve(
        mass_matrix(angles, linkage), left - gravity_torque(angles, GRAVITY, linkage)
    )


@compiled
def _next(state, torque, friction, linkage, step):  # type: ignore[no-untyped-def]
    """Return the state a step later, and the accelerations at its end."""
    total, stage = np.zeros_like(state), state.copy()
    for k in range(4):
        rate = np.empty_like(state)
        put(stage[1], rate[0])
        put(joint_acceleration(stage[0], stage[1], torque, friction, linkage), rate[1])
        total += rate if k in (0, 3) else 2.0 * rate
        stage = state + (step if k == 2 else 0.5 * step) * rate
    result = state + step / 6.0 * total
    return result, joint_acceleration(result[0], result[1], torque, friction, linkage)
