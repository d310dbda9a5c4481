"""The motion behind a noisy displacement: where the piston is, and when it moves which way."""

import math

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.servo.smoother import GLIDING, smooth

Array = NDArray[np.float64]

FORCE_CHANGES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Accelerations by which an unmodelled force, friction above all, may jump [m/s^2]; the one that
makes the recorded displacement likeliest is taken."""
RESTS = (
    (GLIDING, 5e-3),
    (1e-6, 5e-3),
    (1e-5, 5e-3),
    (1e-5, 0.02),
    (1e-5, 0.035),
    (1e-5, 0.06),
    (1e-5, 0.12),
)
"""A piston at rest glides to a stop, or creeps at such a speed [m/s] while that at which it came
fades within such a time [s], as loops bring it to a set point; again the likeliest."""
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
    are left out, and it comes to rest slowly, or creeps. The wandering zero is part of the
    displacement, not of the velocity: a piston at rest does not follow it.
    """
    known = np.zeros_like(time) if driving is None else driving
    start = float(displacement[np.isfinite(displacement)][0])
    measured, variance = displacement - start, max(noise_rms, 1e-9) ** 2
    nowhere, everywhere = np.zeros(len(time), dtype=np.bool_), np.ones(len(time), dtype=np.bool_)

    def passed(
        rest: NDArray[np.bool_],
        change: float,
        way: tuple[float, float] = RESTS[0],
        back: bool = False,
    ) -> tuple[Array, Array, Array]:
        found: tuple[Array, Array, Array] = smooth(
            time, measured, variance, known, driving_rms**2, change, rest, *way, friction, back
        )
        return found

    def likelihood(
        rest: NDArray[np.bool_], change: float, way: tuple[float, float] = RESTS[0]
    ) -> float:
        return float(np.sum(passed(rest, change, way)[2]))

    change = max(FORCE_CHANGES, key=lambda change: likelihood(nowhere, change))
    states, variances, likely = passed(nowhere, change, back=True)
    # A moving piston's velocity is as well known as it is on the whole.
    typical = float(np.median(variances))
    likely_at_rest = passed(everywhere, change)[2]
    interval = float(np.median(np.diff(time)))
    most = 2.0 * friction + REST_FORCE * driving_rms / math.sqrt(averaged_samples(interval))
    rest = _at_rest(likely_at_rest - likely, interval)
    rest[_swing(known, interval) > most] = False
    if rest.any():
        way = max(RESTS, key=lambda way: likelihood(rest, change, way))
        states, variances, _ = passed(rest, change, way, back=True)
    acceleration = states[:, 2] + np.where(rest, 0.0, known)
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
    smooth = averaged(driving, interval)
    return np.asarray(maximum_filter1d(smooth, width) - minimum_filter1d(smooth, width))


def averaged(readings: Array, interval: float, over: float = FORCE_SMOOTHING) -> Array:
    """Return pressures, or the force that they give, without most of their noise.

    Parameters
    ----------
    readings : (..., n) array
        [any unit].
    interval : float
        Of the samples [s].
    over : float, optional
        Time round each sample that is averaged over [s].
    """
    from scipy.ndimage import uniform_filter1d

    return np.asarray(uniform_filter1d(readings, averaged_samples(interval, over), mode="nearest"))


def averaged_samples(interval: float, over: float = FORCE_SMOOTHING) -> int:
    """Return how many samples `averaged` takes the mean of.

    Parameters
    ----------
    interval, over : float
        Of the samples; that is averaged over [s].
    """
    return max(1, round(over / interval))
