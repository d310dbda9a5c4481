"""A seal tester, made for tests.

Shares no code with the package. Friction is Maxwell slip: many springs in parallel, each of
which breaks loose at its own deflection (Lampaert and others 2003); with all springs rigid it is
Coulomb friction. The drive position is known at every moment; displacement is recorded with the
laser's noise.
"""

import numpy as np

from pneuservo.recordings import Recording

RATE = 100.0
AMBIENT = 1.013e5
DIAMETER = 0.025
AREA = np.pi / 4.0 * DIAMETER**2
COULOMB = 6.0
HALF_STROKE = 0.015
LASER_NOISE = 8e-6
FORCE_NOISE = 0.05


def drive(samples, speed=0.008, slow=None):
    """Triangular motion about 25 mm: position [m] and velocity [m/s].

    `slow` is the speed of every second pair of strokes, where two speeds are wanted.
    """
    speeds = (speed, speed, slow or speed, slow or speed)
    ends = [0.0]
    while ends[-1] < samples / RATE:
        ends.append(ends[-1] + 2.0 * HALF_STROKE / speeds[(len(ends) - 1) % 4])
    turns = [0.025 + HALF_STROKE * (-1.0) ** (k + 1) for k in range(len(ends))]
    time = np.arange(samples) / RATE
    # A turn belongs to the stroke it ends, as seen from the samples.
    stroke = np.searchsorted(ends, time, side="left") - 1
    stroke[0] = 0
    velocity = np.array([speeds[k % 4] * (-1.0) ** k for k in stroke])
    return np.interp(time, ends, turns), velocity


def maxwell_slip(position, breakaway, stiffness):
    """Force of parallel springs over their sum of slip forces, -1 to 1.

    `breakaway` holds the deflection at which each spring slips [m], `stiffness` its share of the
    stiffness; the springs start relaxed.
    """
    weights = stiffness * breakaway / np.sum(stiffness * breakaway)
    deflection = np.zeros(len(breakaway))
    share = np.empty(len(position))
    share[0] = 0.0
    for k in range(1, len(position)):
        step = position[k] - position[k - 1]
        deflection = np.clip(deflection + step, -breakaway, breakaway)
        share[k] = np.sum(weights * deflection / breakaway)
    return share


def recording(pressure, seed, samples=1000, noise=None, friction=None, force=None, motion=None):
    """One recording at a held gauge pressure [Pa].

    `friction` is a function of position, velocity, gauge pressure and time that returns the force
    against the motion with its sign [N]; `force` turns the true force into what the load cell
    would read.
    """
    rng = np.random.default_rng(seed)
    position, velocity = motion or drive(samples)
    samples = len(position)
    time = np.arange(samples) / RATE
    # The regulator lets the pressure breathe with the motion, as on real rigs.
    gauge = pressure + 2000.0 * np.sign(velocity) * (1.0 - np.exp(-(time % 4.0)))
    if friction is None:
        resistance = COULOMB * np.sign(velocity)
    else:
        resistance = friction(position, velocity, gauge, time)
    true = gauge * AREA - resistance
    reading = true if force is None else force(true, position, gauge, time)
    if noise is None:
        noise = FORCE_NOISE * rng.standard_normal(samples)
    channels = {
        "displacement": position + LASER_NOISE * rng.standard_normal(samples),
        "pressure_a": gauge + AMBIENT,
        "force": reading + noise,
    }
    return Recording(f"seal-{pressure:g}-{seed}", time, channels, "seal-tester")
