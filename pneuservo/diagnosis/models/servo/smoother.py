"""The filter and smoother that a noisy displacement is passed through."""

import math

import numpy as np

from pneuservo.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.compilation import compiled, compiled_lean
from pneuservo.plant.copying import put, put_table

FORCE_CHANGE_TIME = 5e-3
"""Within this time the force on a moving piston jumps [s]."""
REST_CHANGE = 0.02
"""By so much it may while the piston comes to rest, whatever the pressures do [m/s^2]."""
UNEVEN_FADING = 0.3
"""Share of the speed at which a piston comes to rest by which it fades unevenly."""
GLIDING = 0.0
"""Speed of creep that stands for a piston that comes to rest."""
FASTEST_CREEP = 1e-4
"""A piston that rests creeps no faster, nor does one that rests when the recording begins [m/s]."""


@compiled_lean
def _write_transition(step, interval, creeps, fades):
    """Write how displacement, velocity, acceleration and the transducer's zero go on."""
    for i in range(4):
        for j in range(4):
            step[i, j] = 1.0 if i == j else 0.0
    step[0, 1] = interval
    if creeps:
        step[1, 1] = math.exp(-interval / fades)
        step[2, 2] = 0.0
    else:
        step[0, 2] = 0.5 * interval**2
        step[1, 2] = interval
    step[3, 3] = math.exp(-interval / WANDER_TIME)


@compiled_lean
def _carry(state, spread, step, moved, half):
    """Carry a state and its covariance on; the last two are room to work in.

    Written out, for matrices as small cost calls alone; nothing goes from a lower row to a higher.
    """
    for i in range(4):
        moved[i] = 0.0
        for m in range(i, 4):
            moved[i] += step[i, m] * state[m]
        for j in range(4):
            half[i, j] = 0.0
            for m in range(i, 4):
                half[i, j] += step[i, m] * spread[m, j]
    for i in range(4):
        state[i] = moved[i]
        for j in range(4):
            spread[i, j] = 0.0
            for m in range(j, 4):
                spread[i, j] += half[i, m] * step[j, m]


@compiled_lean
def _spread_out(spread, interval, driving_variance, change):
    """Add what the noise of the driving force and a jumping disturbance make uncertain."""
    h, wander = interval, change * change / FORCE_CHANGE_TIME
    # The exact covariance of an integrated random walk.
    places = driving_variance * h**4 / 4.0 + wander * h**5 / 20.0
    both = driving_variance * h**3 / 2.0 + wander * h**4 / 8.0
    spread[0, 0] += places
    spread[0, 1] += both
    spread[1, 0] += both
    spread[0, 2] += wander * h**3 / 6.0
    spread[2, 0] += wander * h**3 / 6.0
    spread[1, 1] += driving_variance * h**2 + wander * h**3 / 3.0
    spread[1, 2] += wander * h**2 / 2.0
    spread[2, 1] += wander * h**2 / 2.0
    spread[2, 2] += wander * h


@compiled
def smooth(
    time,
    measured,
    variance,
    driving,
    driving_variance,
    given,
    change,
    rest,
    creep,
    fades,
    friction,
    back,
):
    """Return the likeliest motion behind a displacement, and how likely each reading is.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    measured : (n,) array
        Displacement; NaN where there is none [m].
    variance : float
        Of its white noise [m^2].
    driving : (n,) array
        Acceleration that the measured pressures would give without friction [m/s^2].
    driving_variance : float
        Of its noise [m^2/s^4].
    given : (n,) array
        Acceleration that acts besides, on the mean of the interval before each sample, while the
        piston moves [m/s^2].
    change : float
        By which an unmodelled acceleration may jump while the piston moves [m/s^2].
    rest : (n,) array of bool
        While the piston rests.
    creep : (n,) array
        Speed at which it creeps then, or `GLIDING` [m/s].
    fades : (n,) array
        Time within which the speed of a piston that creeps fades [s].
    friction : float
        Acceleration that the Coulomb friction takes [m/s^2].
    back : bool
        Whether what later readings tell is carried back: else the states are what those up to
        each sample tell. The likelihood does not ask for it.

    Returns
    -------
    states : (n, 4) array
        Displacement [m], velocity [m/s], acceleration beside those [m/s^2], and how far
        the zero of the transducer has wandered [m].
    velocity_variance : (n,) array
        Only where something is carried back [m^2/s^2].
    likelihood : (n,) array
        Logarithm of that of each reading given those before, but for a constant.
    """
    n = time.shape[0]
    predicted, filtered = np.zeros((n, 4)), np.zeros((n, 4))
    kept = n if back else 1
    spread_predicted, spread_filtered = np.zeros((kept, 4, 4)), np.zeros((kept, 4, 4))
    state, likelihood, came = np.zeros(4), np.zeros(n), 0.0
    wandering = LIKELY_WANDER**2 * variance
    fastest = FASTEST_CREEP if rest[0] else 1.0
    spread, row = np.diag(np.array([1e-4, fastest**2, 1e4, wandering])), np.zeros(4)
    step, moved, half = np.zeros((4, 4)), np.zeros(4), np.zeros((4, 4))
    for k in range(n):
        if k:
            h = time[k] - time[k - 1]
            creeps = rest[k] and creep[k] > GLIDING
            _write_transition(step, h, creeps, fades[k])
            if rest[k] != rest[k - 1]:
                # Moving, it is what friction takes of the driving force; at rest, all there is.
                spread[2, 2] += (friction + abs(driving[k])) ** 2
                came = state[1]
            _carry(state, spread, step, moved, half)
            if creeps:
                came *= step[1, 1]
                uneven = creep[k] ** 2 + (UNEVEN_FADING * came) ** 2
                spread[1, 1] += uneven * (1.0 - step[1, 1] ** 2)
                spread[2, 2] += uneven / fades[k] ** 2
            elif rest[k]:
                _spread_out(spread, h, 0.0, REST_CHANGE)
            else:
                mean = 0.5 * (driving[k] + driving[k - 1]) + given[k]
                state[0] += 0.5 * h * h * mean
                state[1] += h * mean
                _spread_out(spread, h, driving_variance, change)
            spread[3, 3] += wandering * (1.0 - step[3, 3] ** 2)
        if back:
            put(state, predicted[k])
            put_table(spread, spread_predicted[k])
        if measured[k] == measured[k]:
            for j in range(4):
                row[j] = spread[0, j] + spread[3, j]
            expected, error = row[0] + row[3] + variance, measured[k] - state[0] - state[3]
            likelihood[k] = -0.5 * (math.log(expected) + error * error / expected)
            for i in range(4):
                state[i] += row[i] / expected * error
                for j in range(4):
                    spread[i, j] -= row[i] * row[j] / expected
        for i in range(4):
            filtered[k, i] = state[i]
        if back:
            put_table(spread, spread_filtered[k])
    velocity_variance = np.zeros(n)
    if not back:
        return filtered, velocity_variance, likelihood
    velocity_variance[n - 1] = spread_filtered[n - 1, 1, 1]
    for k in range(n - 2, -1, -1):
        creeps = rest[k + 1] and creep[k + 1] > GLIDING
        _write_transition(step, time[k + 1] - time[k], creeps, fades[k + 1])
        share = spread_filtered[k] @ step.T @ np.linalg.inv(spread_predicted[k + 1])
        put(filtered[k] + share @ (filtered[k + 1] - predicted[k + 1]), filtered[k])
        gained = share @ (spread_filtered[k + 1] - spread_predicted[k + 1]) @ share.T
        put_table(spread_filtered[k] + gained, spread_filtered[k])
        velocity_variance[k] = spread_filtered[k, 1, 1]
    return filtered, velocity_variance, likelihood
