"""A seal tester, made for tests.

Shares no code with the package. Friction is Maxwell slip: many springs in parallel, each of
which breaks loose at its own deflection (Lampaert, Al-Bender and Swevers 2003), or a sharp
Coulomb law. The drive has a finite acceleration; displacement and force are recorded with noise.
"""

import numpy as np

from pneuservo.recordings import Recording

RATE = 100.0
AMBIENT = 1.013e5
AREA = np.pi / 4.0 * 0.025**2
COULOMB = 6.0
MIDDLE, HALF_STROKE = 0.025, 0.015
PRESSURES = (1e5, 3e5, 5e5)
LASER_NOISE = 3e-6
FORCE_NOISE = 0.05
# Deflections at which the springs slip, and their stiffness: a long tail, as seals have.
BREAKAWAY = np.geomspace(3e-5, 1.5e-3, 12)
STIFFNESS = BREAKAWAY**-1.8


def drive(samples=1000, speeds=(0.008,), half_stroke=HALF_STROKE, ramp=0.1):
    """Position [m] and velocity [m/s] of strokes, two at each speed in turn.

    The drive turns with a constant acceleration that takes it through rest in `ramp` [s].
    """
    time = np.arange(samples) / RATE
    corners, velocities, sign = [0.0], [0.0], 1.0
    while corners[-1] < time[-1]:
        speed = speeds[(len(corners) // 4) % len(speeds)]
        for span in (ramp, 2.0 * half_stroke / speed - ramp):
            corners.append(corners[-1] + span)
            velocities.append(sign * speed)
        sign = -sign
    fine = np.linspace(0.0, time[-1], 20 * samples)
    fast = np.interp(fine, corners, velocities)
    moved = np.concatenate([[0.0], np.cumsum(0.5 * (fast[1:] + fast[:-1]) * fine[1])])
    position = MIDDLE - half_stroke + np.interp(time, fine, moved)
    return position, np.interp(time, corners, velocities)


def place(position):
    """-1 to 1 along the recorded stroke, less its outermost hundredths."""
    low, high = np.percentile(position, [1.0, 99.0])
    return (position - 0.5 * (low + high)) / (0.5 * (high - low))


def maxwell_slip(position):
    """Force of the springs over their sum of slip forces, -1 to 1; they start relaxed."""
    weights = STIFFNESS * BREAKAWAY / np.sum(STIFFNESS * BREAKAWAY)
    deflection = np.zeros(len(BREAKAWAY))
    share = np.zeros(len(position))
    for k in range(1, len(position)):
        step = position[k] - position[k - 1]
        deflection = np.clip(deflection + step, -BREAKAWAY, BREAKAWAY)
        share[k] = np.sum(weights * deflection / BREAKAWAY)
    return share


def sharp(position, velocity):
    """Coulomb's law."""
    return np.sign(velocity)


def slipping(position, velocity):
    """Maxwell slip."""
    return maxwell_slip(position)


def recordings(seed, motion, law=sharp, level=None, extra=None, pressures=PRESSURES, noise=None):
    """Recordings at held gauge pressures [Pa].

    `level` is a function of position, speed, gauge pressure and time that returns how large
    sliding friction is [N], `extra` one that returns what else the load cell reads [N], and
    `noise` one that makes the load cell's noise from a generator and a number of samples [N].
    """
    position, velocity = motion
    time = np.arange(len(position)) / RATE
    state = law(position, velocity)
    made = []
    for index, pressure in enumerate(pressures):
        rng = np.random.default_rng([seed, index])
        # The regulator lets the pressure breathe with the motion, as on real rigs.
        gauge = pressure + 2000.0 * np.sign(velocity) * (1.0 - np.exp(-(time % 4.0)))
        arguments = position, np.abs(velocity), gauge, time
        friction = (level(*arguments) if level else COULOMB) * state
        reading = gauge * AREA - friction + (extra(*arguments) if extra else 0.0)
        white = FORCE_NOISE * rng.standard_normal(len(time))
        channels = {
            "displacement": position + LASER_NOISE * rng.standard_normal(len(time)),
            "pressure_a": gauge + AMBIENT,
            "force": reading + (noise(rng, len(time)) if noise else white),
        }
        made.append(Recording(f"seal-{pressure:g}-{seed}", time, channels, "seal-tester"))
    return made
