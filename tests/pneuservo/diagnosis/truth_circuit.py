"""A circuit that imitates a mass on a spring, made for tests.

Shares no code with the package: the drive is a multisine that is known at every moment, the
linear circuit follows in closed form from its frequency response, and the others from an
equation of motion in volts, solved with far shorter steps.
"""

from functools import cache

import numpy as np

from pneuservo.recordings import Recording

RATE, SAMPLES = 600.0, 1600
TIME = np.arange(SAMPLES) / RATE
FREQUENCY, DAMPING, GAIN = 40.0, 0.08, 0.9
OMEGA = 2.0 * np.pi * FREQUENCY
NOISE = 2e-3
# From 2 to 120 Hz: the package's interpolation of the input passes this band unchanged, and the
# top of the band is left to the noise.
LINES = np.arange(5, 321, 5) * RATE / SAMPLES
DRIVE_RMS = 0.1
STEPS = 8
SEEDS = (1, 2)
# What is planted: coefficients of the restoring voltage (square, cube and fifth power of the
# output, and a spring half as stiff within 50 mV of the middle) and of the dissipating voltage
# (cube of the rate over omega, and dry).
LAWS = {
    "cubic": (0.0, 4.0, 0.0, 0.0, 0.0, 0.0),
    "quadratic": (0.3, 0.0, 0.0, 0.0, 0.0, 0.0),
    "quintic": (0.0, 0.0, 30.0, 0.0, 0.0, 0.0),
    "kinked": (0.0, 0.0, 0.0, -0.5, 0.0, 0.0),
    "cubic damping": (0.0, 0.0, 0.0, 0.0, 2.0, 0.0),
    "dry": (0.0, 0.0, 0.0, 0.0, 0.0, 0.01),
    "cubic and quadratic": (0.3, 4.0, 0.0, 0.0, 0.0, 0.0),
    "cubic and dry": (0.0, 4.0, 0.0, 0.0, 0.0, 0.01),
}


@cache
def phases(seed):
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(LINES))


def drive(time, seed):
    """Random-phase multisine [V]."""
    angle = 2.0 * np.pi * np.multiply.outer(time, LINES) + phases(seed)
    return DRIVE_RMS * np.sqrt(2.0 / len(LINES)) * np.cos(angle).sum(axis=-1)


def linear_output(seed):
    """Steady state of the linear circuit from its frequency response [V]."""
    ratio = LINES / FREQUENCY
    response = GAIN / (1.0 - ratio**2 + 2j * DAMPING * ratio)
    angle = 2.0 * np.pi * np.multiply.outer(TIME, LINES) + phases(seed)
    waves = np.real(response * np.exp(1j * angle)).sum(axis=-1)
    return DRIVE_RMS * np.sqrt(2.0 / len(LINES)) * waves


@cache
def _outputs():
    """Outputs of all circuits with all drives, from rest, in one system of equations [V]."""
    square, cube, fifth, kink, rate_cube, dry = (
        np.array(column)[:, None] for column in zip(*LAWS.values(), strict=True)
    )
    half_steps = np.arange(2 * STEPS * (SAMPLES - 1) + 1) / (2 * STEPS * RATE)
    push = GAIN * np.column_stack([drive(half_steps, seed) for seed in SEEDS])

    def slope(state, force):
        # The rate is over omega, so that both states are volts.
        voltage, rate = state
        force = force - voltage * (1.0 + voltage * (square + voltage * cube))
        force -= fifth * voltage**5 + kink * np.minimum(np.maximum(voltage, -0.05), 0.05)
        force -= rate * (2.0 * DAMPING + rate_cube * rate**2) + dry * np.tanh(rate / 2e-3)
        return np.array([rate, force])

    # Runge-Kutta steps a quarter of the package's err by 1/256 of its error; at the corners of
    # the dry and the kinked law they stay below a tenth of the noise.
    step = OMEGA / (STEPS * RATE)
    state = np.zeros((2, len(LAWS), len(SEEDS)))
    outputs = [state[0]]
    for k in range(0, len(half_steps) - 1, 2):
        first = slope(state, push[k])
        second = slope(state + 0.5 * step * first, push[k + 1])
        third = slope(state + 0.5 * step * second, push[k + 1])
        fourth = slope(state + step * third, push[k + 2])
        state = state + step / 6.0 * (first + 2.0 * (second + third) + fourth)
        if (k // 2 + 1) % STEPS == 0:
            outputs.append(state[0])
    return np.moveaxis(outputs, 0, -1)


def output(law, seed):
    """Output of the circuit with one of the laws, from rest [V]."""
    return _outputs()[list(LAWS).index(law), SEEDS.index(seed)]


def recording(voltage, seed, noise=None, input_offset=0.0):
    """What the recorder stores: the input as it should be, the output with its noise."""
    if noise is None:
        noise = NOISE * np.random.default_rng(seed).standard_normal(SAMPLES)
    channels = {
        "circuit_input": drive(TIME, seed) + input_offset,
        "circuit_output": voltage + noise,
    }
    return Recording(f"circuit-{seed}", TIME, channels, "circuit")
