"""How well the observer knows what it follows, and what each reading therefore corrects."""

import math

import numpy as np

from pneuservo.noise import LIKELY_WANDER, WANDER_TIME
from pneuservo.plant.compilation import compiled
from pneuservo.plant.copying import put, put_table
from pneuservo.plant.servo.pneumatics import pneumatic_rates
from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B

FOLLOWED_A, FOLLOWED_B, POSITION, SPEED, ZERO_A, ZERO_B, ZERO_PLACE = range(7)
"""What the observer corrects: both pressures, the motion as the transducer has it, and by how much
the zeros of the three transducers have wandered."""
ESTIMATED = 7
READ = (FOLLOWED_A, FOLLOWED_B, POSITION)
"""What each reading reads ..."""
ZEROS = (ZERO_A, ZERO_B, ZERO_PLACE)
"""... and the zero it is read from."""
GAIN_ROWS = ESTIMATED + len(READ)
FORCE_STEP = 0.05
"""An unmodelled force, as a share of the Coulomb friction, that comes and goes ..."""
TURNING_STEP = 0.3
"""... more of it where the piston turns round, for real friction gives way first, ..."""
FORCE_TIME = 1e-2
"""... within this time [s]."""
UNKNOWN_PRESSURE = 1e5
"""How little is known of a pressure, at the most [Pa]."""
_PRESSURE_STEP = 100.0
_SPEED_STEP = 1e-3


@compiled
def start_covariance(reading, variance, speed_rms):
    """Return how well everything is known that begins as the first samples read.

    Parameters
    ----------
    reading : (3,) array
        The first readings; NaN where there is none, SI.
    variance : (3,) array
        Of the noise of each reading, SI.
    speed_rms : float
        How well the speed is known [m/s].
    """
    covariance = np.zeros((ESTIMATED, ESTIMATED))
    covariance[FOLLOWED_A, FOLLOWED_A] = covariance[FOLLOWED_B, FOLLOWED_B] = UNKNOWN_PRESSURE**2
    covariance[POSITION, POSITION] = variance[2]
    covariance[SPEED, SPEED] = speed_rms * speed_rms
    for slot in range(3):
        here, zero, own = READ[slot], ZEROS[slot], LIKELY_WANDER**2 * variance[slot]
        covariance[zero, zero] = own
        if reading[slot] == reading[slot]:
            covariance[here, here] = variance[slot] + own
            covariance[here, zero] = covariance[zero, here] = -own
    return covariance


@compiled
def carry_on(
    covariance,
    state,
    speed,
    reversal,
    unsteadiness,
    turning_unsteadiness,
    force_rms,
    interval,
    spread,
    held,
    variance,
    memory,
    rows,
    drive,
    servo,
    grid,
    rate,
    moved,
    start,
):
    """Carry the covariance on by one interval.

    Parameters
    ----------
    covariance : (7, 7) array
        Written.
    state, memory, rows, drive, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    speed, reversal : float
        Smoothed velocity of the piston, and over how much of it friction turns round [m/s].
    unsteadiness, turning_unsteadiness : float
        Unmodelled force as a multiple of `FORCE_STEP`, and of `TURNING_STEP` [-].
    force_rms : float
        Noise of the force at the rod, as it was measured [N].
    interval : float
        [s].
    spread : (2,) array
        Variance that the interval adds to what is known of each pressure [Pa^2].
    held : bool
        Whether the motion is taken over.
    variance : (3,) array
        Of the noise of each reading, SI.
    rate, moved, start : (m,) array
        Room to work in, as long as the state.

    Returns
    -------
    float
        Rate at which a pressure's deviation decays times the interval, of the chamber in which it
        is larger: above 1 it decays within the interval [-].
    """
    plant = servo.plant
    piston, mass = plant.piston, plant.piston.mass
    change = np.zeros((ESTIMATED, ESTIMATED))
    put(state, start)
    pneumatic_rates(start, speed, memory, rows, drive, 0.0, servo, grid, rate)
    if not held:
        faster = speed + _SPEED_STEP
        pneumatic_rates(start, faster, memory, rows, drive, 0.0, servo, grid, moved)
        change[FOLLOWED_A, SPEED] = interval * (moved[PRESSURE_A] - rate[PRESSURE_A]) / _SPEED_STEP
        change[FOLLOWED_B, SPEED] = interval * (moved[PRESSURE_B] - rate[PRESSURE_B]) / _SPEED_STEP
        change[SPEED, SPEED] = -interval * piston.viscous_friction / mass
    places, areas = (PRESSURE_A, PRESSURE_B), (piston.area_a, -piston.area_b)
    for side in range(2):
        here = places[side]
        start[here] += _PRESSURE_STEP
        pneumatic_rates(start, speed, memory, rows, drive, 0.0, servo, grid, moved)
        start[here] -= _PRESSURE_STEP
        change[side, side] = interval * (moved[here] - rate[here]) / _PRESSURE_STEP
        change[SPEED, side] = interval * areas[side] / mass
    decays = max(abs(change[FOLLOWED_A, FOLLOWED_A]), abs(change[FOLLOWED_B, FOLLOWED_B]))
    change[POSITION, SPEED] = interval
    kept = math.exp(-interval / WANDER_TIME)
    for zero in ZEROS:
        change[zero, zero] = -interval / WANDER_TIME
    # To second order: one interval is a good part of a swing of the piston on its air; in parts
    # in each of which a pressure does not decay by more than it is.
    parts = max(1, math.ceil(decays))
    change = change / parts
    change = np.eye(ESTIMATED) + change + 0.5 * change @ change
    for _ in range(parts):
        put_table(change @ covariance @ change.T, covariance)
    for slot in range(3):
        covariance[ZEROS[slot], ZEROS[slot]] += (1.0 - kept**2) * LIKELY_WANDER**2 * variance[slot]
    for side in range(2):
        covariance[side, side] += spread[side]
        beyond = math.sqrt(covariance[side, side]) / UNKNOWN_PRESSURE
        if beyond > 1.0:
            for other in range(ESTIMATED):
                covariance[side, other] /= beyond
            for other in range(ESTIMATED):
                covariance[other, side] /= beyond
    turning = 1.0 - math.tanh(speed / reversal) ** 2
    unknown = unsteadiness * FORCE_STEP + turning_unsteadiness * TURNING_STEP * turning
    unknown *= piston.coulomb_friction / mass
    covariance[SPEED, SPEED] += unknown * unknown * FORCE_TIME * interval
    # Each reading of the force is wrong for one interval.
    covariance[SPEED, SPEED] += (force_rms * interval / mass) ** 2
    return decays


@compiled
def take_over(covariance, position_variance, velocity_rms):
    """Forget what the motion tells of the pressures: friction is whatever it has to be.

    Parameters
    ----------
    covariance : (7, 7) array
        Written.
    position_variance : float
        Of the noise of the displacement [m^2].
    velocity_rms : float
        How well the smoothed velocity is known [m/s].
    """
    for other in range(ESTIMATED):
        covariance[SPEED, other] = covariance[other, SPEED] = 0.0
        # The piston is where it reads, but for how far the zero has wandered.
        covariance[POSITION, other] = covariance[other, POSITION] = -covariance[ZERO_PLACE, other]
    covariance[POSITION, SPEED] = covariance[SPEED, POSITION] = 0.0
    covariance[POSITION, POSITION] = position_variance + covariance[ZERO_PLACE, ZERO_PLACE]
    covariance[SPEED, SPEED] = velocity_rms * velocity_rms


@compiled
def weigh(covariance, error, variance, gain, share):
    """Write the gains of the readings that are there, and take up what they tell.

    Parameters
    ----------
    covariance : (7, 7) array
        Written.
    error : (3,) array
        What was expected of each reading is off by this; only whether it is NaN counts here, SI.
    variance : (3,) array
        Of the noise of each reading, SI.
    gain : (GAIN_ROWS, 3) array
        Written: what each error corrects; the last rows, what of each reading the errors of those
        before it make expected.
    share : (3,) array
        Written: noise of each reading over the spread its innovation is expected to have.
    """
    gain[:, :] = 0.0
    share[:] = 0.0
    # One reading after the other; each meets what those before it have corrected.
    for slot in range(3):
        if error[slot] != error[slot]:
            continue
        here, zero = READ[slot], ZEROS[slot]
        row = covariance[here] + covariance[zero]
        expected = row[here] + row[zero] + variance[slot]
        share[slot] = math.sqrt(variance[slot] / expected)
        own = row / expected
        before = gain[here] + gain[zero]
        put(before, gain[ESTIMATED + slot])
        for place in range(ESTIMATED):
            for other in range(3):
                gain[place, other] -= own[place] * before[other]
            gain[place, slot] += own[place]
        # Joseph's form: pressures and places differ by ten powers of ten.
        kept = np.eye(ESTIMATED)
        for place in range(ESTIMATED):
            kept[place, here] -= own[place]
            kept[place, zero] -= own[place]
        put_table(kept @ covariance @ kept.T, covariance)
        for place in range(ESTIMATED):
            for other in range(ESTIMATED):
                covariance[place, other] += variance[slot] * own[place] * own[other]


@compiled
def force_spread(covariance, piston):
    """Return the standard deviation of the force that both pressures give [N].

    Parameters
    ----------
    covariance : (7, 7) array
        From `weigh`.
    piston : Piston
        With its areas.
    """
    a, b = piston.area_a, piston.area_b
    square = a * a * covariance[FOLLOWED_A, FOLLOWED_A] + b * b * covariance[FOLLOWED_B, FOLLOWED_B]
    square -= 2.0 * a * b * covariance[FOLLOWED_A, FOLLOWED_B]
    return math.sqrt(max(square, 0.0))
