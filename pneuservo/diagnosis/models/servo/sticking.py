"""While the piston sticks: whether the friction of a model would have held it."""

import math

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.servo.push import push
from pneuservo.diagnosis.noise import LIKELY_WANDER
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.friction_effects import breakaway_gain

WITHIN, JUDGED, PASSED_OVER = 1, 2, 3
"""The piston sticks; at the sample at which the time until then is judged; and the same where it
does not stick itself."""
SURE_FOR = 0.05
"""It sticks that has been held for this long, and will be [s]."""
ONE_SAMPLE = 0.5
"""So long a rest counts as one sample: as fast as the zeros of the transducers wander [s]."""
UNEVEN = 0.1
"""Share of the Coulomb friction by which it differs from one rest to the next."""


def sticking(
    held: NDArray[np.bool_], touching: NDArray[np.bool_], interval: float
) -> NDArray[np.int64]:
    """Return while the piston sticks, and at which samples that is judged.

    Parameters
    ----------
    held, touching : (n,) array of bool
        While it is held, and while it may touch a stop, which may hold it as well.
    interval : float
        Of the samples [s].

    Returns
    -------
    (n,) array
        0, `WITHIN` or `JUDGED`: each rest once per `ONE_SAMPLE`, and at its end.

    Examples
    --------
    >>> held = np.ones(1000, dtype=bool)
    >>> np.flatnonzero(sticking(held, ~held, 1e-3) == JUDGED).tolist()
    [549, 949]
    """
    from scipy.ndimage import binary_erosion, label

    window = np.ones(2 * max(1, round(SURE_FOR / interval)) + 1)
    found = np.asarray(binary_erosion(held & ~touching, window)).astype(np.int64)
    numbered, rests = label(found)
    most = max(1, round(ONE_SAMPLE / interval))
    for rest in range(1, rests + 1):
        samples = np.flatnonzero(numbered == rest)
        found[samples[most - 1 :: most]] = JUDGED
        found[samples[-1]] = JUDGED
    return found


def shared(judged: NDArray[np.int64], also: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return while two pistons stick, at the samples at which the first is judged.

    Parameters
    ----------
    judged, also : (n,) array of int
        From `sticking`.

    Examples
    --------
    >>> shared(np.array([1, 1, 2, 0]), np.array([1, 2, 0, 1])).tolist()
    [1, 1, 3, 0]
    """
    found = np.where(also != 0, judged, 0)
    return np.where((judged == JUDGED) & (also == 0), PASSED_OVER, found)


def unsure_force(noise_force: float, coulomb_friction: float) -> float:
    """Return how well it is known by how much a force exceeds what friction can hold [N].

    Parameters
    ----------
    noise_force : float
        What the noise of both pressures makes of the force on the piston [N].
    coulomb_friction : float
        Of the baseline [N].
    """
    return math.hypot(LIKELY_WANDER * noise_force, UNEVEN * coulomb_friction)


@compiled
def too_much_to_hold(time, state, rest, external_force, servo):
    """Return by how much the force on a resting piston exceeds what friction can hold [N].

    Parameters
    ----------
    time, state, external_force, servo
        As in `pneuservo.diagnosis.models.servo.push.push`.
    rest : float
        How long it has rested [s].
    """
    mass = servo.plant.piston.mass
    gained = breakaway_gain(rest, servo.effects.friction)
    onward = mass * push(time, state, 0.0, 0.0, external_force, 1.0, servo) - gained
    back = mass * push(time, state, 0.0, 0.0, external_force, -1.0, servo) + gained
    return max(onward, 0.0) - min(back, 0.0)
