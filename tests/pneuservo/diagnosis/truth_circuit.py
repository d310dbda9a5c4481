"""A circuit that imitates a mass on a spring, made for tests.

Shares no code with the package: the drive is a multisine that is known at every moment, the
linear circuit follows in closed form from its frequency response, and the others from scipy's
DOP853 with its own equation of motion in volts.
"""

from functools import cache

import numpy as np
from scipy.integrate import solve_ivp

from pneuservo.recordings import Recording

RATE, SAMPLES = 600.0, 2400
FREQUENCY, DAMPING, GAIN = 70.0, 0.08, 0.9
OMEGA = 2.0 * np.pi * FREQUENCY
# From 2 to 180 Hz: the package's interpolation of the input passes this band unchanged, and the
# top of the band is left to the noise.
LINES = np.arange(8, 721, 8) * RATE / SAMPLES
DRIVE_RMS = 0.1


@cache
def phases(seed):
    return np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(LINES))


def drive(time, seed):
    """Random-phase multisine [V]."""
    angle = 2.0 * np.pi * np.multiply.outer(time, LINES) + phases(seed)
    return DRIVE_RMS * np.sqrt(2.0 / len(LINES)) * np.cos(angle).sum(axis=-1)


def linear_output(time, seed, offset=0.0):
    """Steady state of the linear circuit from its frequency response [V]."""
    ratio = LINES / FREQUENCY
    response = GAIN / (1.0 - ratio**2 + 2j * DAMPING * ratio)
    angle = 2.0 * np.pi * np.multiply.outer(time, LINES) + phases(seed)
    waves = np.real(response * np.exp(1j * angle)).sum(axis=-1)
    return DRIVE_RMS * np.sqrt(2.0 / len(LINES)) * waves - GAIN * offset


@cache
def output(seed, restoring=None, dissipation=None):
    """Output of the circuit with extra restoring and dissipating signals, from rest [V].

    `restoring` is a function of the output [V], `dissipation` of the output rate over omega [V].
    """
    time = np.arange(SAMPLES) / RATE

    def motion(moment, state):
        voltage, scaled_rate = state
        force = GAIN * drive(moment, seed) - voltage - 2.0 * DAMPING * scaled_rate
        if restoring is not None:
            force -= restoring(voltage)
        if dissipation is not None:
            force -= dissipation(scaled_rate)
        return [OMEGA * scaled_rate, OMEGA * force]

    solution = solve_ivp(
        motion, (0.0, time[-1]), [0.0, 0.0], method="DOP853", t_eval=time, rtol=1e-7, atol=1e-9
    )
    return solution.y[0]


def recording(voltage, noise, seed, input_offset=0.0):
    """What the recorder stores: the input as it should be, the output with its noise."""
    time = np.arange(SAMPLES) / RATE
    channels = {
        "circuit_input": drive(time, seed) + input_offset,
        "circuit_output": voltage + noise,
    }
    return Recording(f"circuit-{seed}", time, channels, "circuit")
