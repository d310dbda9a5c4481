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
LASER_NOISE = 3e-6
FORCE_NOISE = 0.05


def drive(samples, speeds=(0.008,), half_stroke=HALF_STROKE, ramp=0.1):
    """Position [m] and velocity [m/s] of strokes about 25 mm, one speed after the other.

    The drive turns with a constant acceleration that takes it through rest in `ramp` [s].
    """
    time = np.arange(samples) / RATE
    corners, velocities, moment, sign = [0.0], [0.0], 0.0, 1.0
    while moment < time[-1]:
        speed = speeds[(len(corners) // 4) % len(speeds)]
        cruise = 2.0 * half_stroke / speed - ramp
        for span, velocity in ((ramp, sign * speed), (cruise, sign * speed)):
            moment += span
            corners.append(moment)
            velocities.append(velocity)
        sign = -sign
    velocity = np.interp(time, corners, velocities)
    fine = np.linspace(0.0, time[-1], 20 * samples)
    moved = np.concatenate([[0.0], np.cumsum(np.diff(fine) * 0.5 * (
        np.interp(fine[1:], corners, velocities) + np.interp(fine[:-1], corners, velocities)))])
    return 0.025 - half_stroke + np.interp(time, fine, moved), velocity


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
