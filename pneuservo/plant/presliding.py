"""How friction builds up over a distance after a reversal."""

import math

import numpy as np

from pneuservo.plant.compilation import compiled


@compiled
def presliding_step(state, step, travel, exponent):
    """Return the share of the sliding friction that has built up after one more step, -1 to 1.

    Parameters
    ----------
    state : float
        Share before the step [-].
    step : float
        Displacement of the step, without a reversal inside it [m].
    travel, exponent : float
        As in `presliding_state`.

    Examples
    --------
    >>> round(presliding_step(0.0, 1e-5, 1e-5, 1.0), 4)  # 1 - exp(-1)
    0.6321
    """
    if step == 0.0:
        return state
    direction = 1.0 if step > 0.0 else -1.0
    rest = 1.0 - state * direction
    if travel <= 0.0:
        rest = 0.0
    elif rest > 0.0:
        distance = abs(step) / travel
        if exponent - 1.0 < 1e-9:
            rest *= math.exp(-distance)
        else:
            rest *= (1.0 + (exponent - 1.0) * distance * rest ** (exponent - 1.0)) ** (
                -1.0 / (exponent - 1.0)
            )
    return direction * (1.0 - rest)


@compiled
def presliding_state(displacement, travel, exponent, initial):
    """Return the share of the sliding friction that has built up, -1 to 1.

    Parameters
    ----------
    displacement : (n,) array
        Piston displacement [m].
    travel : float
        Distance over which friction builds up after a reversal; 0 for at once [m].
    exponent : float
        Shape of the build-up: 1 exponential, larger values with a longer tail [-].
    initial : float
        State at the first sample, -1 to 1 [-].

    Returns
    -------
    (n,) array
        The state; while the piston rests it stays.

    Notes
    -----
    Dahl 1968: dz/dx = (1/travel) (1 - z sgn(dx))^exponent sgn(dx), solved exactly over each
    step. With travel = 0 this is sgn(v), the Coulomb law.

    Examples
    --------
    >>> presliding_state(np.array([0.0, 1e-3, 0.5e-3]), 0.0, 1.0, 0.0).tolist()
    [0.0, 1.0, -1.0]
    """
    state = np.empty(displacement.size)
    state[0] = initial
    for k in range(1, displacement.size):
        step = displacement[k] - displacement[k - 1]
        state[k] = presliding_step(state[k - 1], step, travel, exponent)
    return state
