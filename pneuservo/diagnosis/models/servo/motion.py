"""The motion behind a noisy displacement: where the piston is, and when it moves which way."""

import math

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.compilation import compiled

Array = NDArray[np.float64]

FORCE_CHANGES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Accelerations by which an unmodelled force, friction above all, may jump [m/s^2] ..."""
FORCE_CHANGE_TIME = 5e-3
"""... within this time [s]; the one that makes the recorded displacement likeliest is taken."""
REST_CHANGE = 0.02
"""The same of a piston that comes to rest, whatever the pressures do [m/s^2] ..."""
CREEP = (1e-6, 1e-5)
"""... or it only creeps, at these speeds [m/s] ..."""
CREEP_TIME = 5e-3
"""... for this time [s]; again the likeliest is taken."""
GLIDING = 0.0
"""Speed of creep that stands for a piston that comes to rest."""
REST_TIME = 0.1
"""Time over which it has to look at rest [s] ..."""
REST_FORCE = 5.0
"""... and over which the pressures' force may swing by more than all of the Coulomb friction, in
its own noise: in chatter too a piston moves by less than its displacement's noise."""
FORCE_SMOOTHING = 5e-3
"""Time over which their force is averaged [s]."""


def smooth_motion(
    time: Array,
    displacement: Array,
    noise_rms: float,
    driving: Array | None,
    driving_rms: float,
    friction: float,
) -> tuple[Array, Array, Array, Array, NDArray[np.bool_]]:
    """Return displacement, velocity and acceleration without the displacement's noise.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    displacement : (n,) array
        As measured; NaN where there is none [m].
    noise_rms : float
        Its noise, whose zero wanders as that of any transducer [m].
    driving : (n,) array or None
        Acceleration that the measured pressures would give without friction [m/s^2].
    driving_rms : float
        Noise of that acceleration [m/s^2].
    friction : float
        Acceleration that the Coulomb friction takes [m/s^2].

    Returns
    -------
    displacement, velocity, acceleration : (n,) array
        [m], [m/s], [m/s^2].
    velocity_rms : (n,) array
        How well the velocity is known [m/s].
    rest : (n,) array of bool
        While the piston rests.

    Notes
    -----
    Kalman filter and Rauch-Tung-Striebel smoother (Rauch, Tung and Striebel 1965) for
    acceleration = driving + disturbance, the disturbance a random walk that takes up friction,
    gravity and a wrong mass. The pressures carry the fast part of the acceleration, so that no
    cut-off has to be chosen. While the piston sticks they do not move it, and what their noise
    makes of its velocity would go on into the chambers: where it makes the readings likelier they
    are left out, and it comes to rest slowly or creeps. The wandering zero is part of the
    displacement, not of the velocity: a piston at rest does not follow it.
    """
    known = np.zeros_like(time) if driving is None else driving
    start = float(displacement[np.isfinite(displacement)][0])
    measured, variance = displacement - start, max(noise_rms, 1e-9) ** 2
    nowhere, everywhere = np.zeros(len(time), dtype=np.bool_), np.ones(len(time), dtype=np.bool_)

    def smoothed(
        rest: NDArray[np.bool_], change: float, creep: float
    ) -> tuple[Array, Array, Array]:
        found: tuple[Array, Array, Array] = _smooth(
            time, measured, variance, known, driving_rms**2, change, rest, creep, friction
        )
        return found

    tried = ((smoothed(nowhere, change, GLIDING), change) for change in FORCE_CHANGES)
    moving, change = max(tried, key=lambda found: float(np.sum(found[0][2])))
    rest_likelihood = smoothed(everywhere, change, GLIDING)[2]
    interval = float(np.median(np.diff(time)))
    most = 2.0 * friction + REST_FORCE * driving_rms / math.sqrt(_averaged_samples(interval))
    rest = _at_rest(rest_likelihood - moving[2], interval)
    rest[_swing(known, interval) > most] = False
    states, variances, _ = moving
    if rest.any():
        resting = (smoothed(rest, change, creep) for creep in (GLIDING, *CREEP))
        states, variances, _ = max(resting, key=lambda found: float(np.sum(found[2])))
    acceleration = states[:, 2] + np.where(rest, 0.0, known)
    # A moving piston's velocity is as well known as it is on the whole.
    typical = float(np.median(moving[1]))
    velocity_rms = np.sqrt(np.where(rest, np.clip(variances, 0.0, typical), typical))
    return states[:, 0] + states[:, 3] + start, states[:, 1], acceleration, velocity_rms, rest


def _at_rest(likelier: Array, interval: float) -> NDArray[np.bool_]:
    """Return where the piston rests, from how much likelier that makes the readings."""
    from scipy.ndimage import uniform_filter1d

    width = max(1, round(REST_TIME / interval))
    return np.asarray(uniform_filter1d(likelier, width, mode="nearest") > 0.0)


def _swing(driving: Array, interval: float) -> Array:
    """Return from where to where the averaged force goes around each sample."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    width = max(1, round(REST_TIME / interval))
    smooth = averaged_force(driving, interval)
    return np.asarray(maximum_filter1d(smooth, width) - minimum_filter1d(smooth, width))


def averaged_force(force: Array, interval: float) -> Array:
    """Return a force without most of the noise of the pressures behind it.

    Parameters
    ----------
    force : (n,) array
        Or the acceleration that it gives [any unit].
    interval : float
        Of the samples [s].
    """
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(force, _averaged_samples(interval), mode="nearest"))


def _averaged_samples(interval: float) -> int:
    return max(1, round(FORCE_SMOOTHING / interval))


@compiled
def _transition(interval, creeps):
    """Return how displacement, velocity, acceleration and the transducer's zero go on."""
    step = np.eye(4)
    step[0, 1] = interval
    if creeps:
        step[1, 1] = math.exp(-interval / CREEP_TIME)
        step[2, 2] = 0.0
    else:
        step[0, 2] = 0.5 * interval**2
        step[1, 2] = interval
    step[3, 3] = math.exp(-interval / WANDER_TIME)
    return step


@compiled
def _spread_out(spread, interval, driving_variance, change):
    """Add what the noise of the driving force and a jumping disturbance make uncertain."""
    h, wander = interval, change * change / FORCE_CHANGE_TIME
    push = np.array([0.5 * h * h, h, 0.0])
    for i in range(3):
        for j in range(3):
            spread[i, j] += driving_variance * push[i] * push[j]
    walk = np.array([h**2.5 / 20.0**0.5, h**1.5 / 3.0**0.5, h**0.5])
    # The exact covariance of an integrated random walk.
    spread[0, 0] += wander * walk[0] ** 2
    spread[0, 1] += wander * h**4 / 8.0
    spread[1, 0] += wander * h**4 / 8.0
    spread[0, 2] += wander * h**3 / 6.0
    spread[2, 0] += wander * h**3 / 6.0
    spread[1, 1] += wander * walk[1] ** 2
    spread[1, 2] += wander * h**2 / 2.0
    spread[2, 1] += wander * h**2 / 2.0
    spread[2, 2] += wander * walk[2] ** 2


@compiled
def _smooth(time, measured, variance, driving, driving_variance, change, rest, creep, friction):
    n = time.shape[0]
    predicted, filtered = np.zeros((n, 4)), np.zeros((n, 4))
    spread_predicted, spread_filtered = np.zeros((n, 4, 4)), np.zeros((n, 4, 4))
    state, likelihood = np.zeros(4), np.zeros(n)
    wandering = LIKELY_WANDER**2 * variance
    spread = np.diag(np.array([1e-4, 1.0, 1e4, wandering]))
    for k in range(n):
        if k:
            h = time[k] - time[k - 1]
            creeps = rest[k] and creep > GLIDING
            step = _transition(h, creeps)
            if rest[k] != rest[k - 1]:
                # Moving, it is what friction takes of the driving force; at rest, all there is.
                spread[2, 2] += (friction + abs(driving[k])) ** 2
            state = step @ state
            spread = step @ spread @ step.T
            if creeps:
                spread[1, 1] += creep * creep * (1.0 - step[1, 1] ** 2)
                spread[2, 2] += (creep / CREEP_TIME) ** 2
            elif rest[k]:
                _spread_out(spread, h, 0.0, REST_CHANGE)
            else:
                mean = 0.5 * (driving[k] + driving[k - 1])
                state[0] += 0.5 * h * h * mean
                state[1] += h * mean
                _spread_out(spread, h, driving_variance, change)
            spread[3, 3] += wandering * (1.0 - step[3, 3] ** 2)
        predicted[k] = state
        spread_predicted[k] = spread
        if measured[k] == measured[k]:
            row = spread[0] + spread[3]
            expected, error = row[0] + row[3] + variance, measured[k] - state[0] - state[3]
            likelihood[k] = -0.5 * (math.log(expected) + error * error / expected)
            gain = row / expected
            state = state + gain * error
            for i in range(4):
                for j in range(4):
                    spread[i, j] -= gain[i] * row[j]
        filtered[k] = state
        spread_filtered[k] = spread
    velocity_variance = np.empty(n)
    velocity_variance[n - 1] = spread_filtered[n - 1, 1, 1]
    for k in range(n - 2, -1, -1):
        step = _transition(time[k + 1] - time[k], rest[k + 1] and creep > GLIDING)
        back = spread_filtered[k] @ step.T @ np.linalg.inv(spread_predicted[k + 1])
        filtered[k] = filtered[k] + back @ (filtered[k + 1] - predicted[k + 1])
        gained = back @ (spread_filtered[k + 1] - spread_predicted[k + 1]) @ back.T
        spread_filtered[k] = spread_filtered[k] + gained
        velocity_variance[k] = spread_filtered[k, 1, 1]
    return filtered, velocity_variance, likelihood
