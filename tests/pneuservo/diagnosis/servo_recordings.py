"""Recordings of the servo without any effect, made by the plant itself."""

import numpy as np

from pneuservo.recordings import Recording
from pneuservo.simulation import simulate

NOISE = {"displacement": 1e-5, "pressure_a": 500.0, "pressure_b": 500.0}


def recorded(
    rig, controller, seed: int, duration: float = 4.0, interval: float = 1e-3, noise=NOISE
) -> Recording:
    """Return a run from set point to set point, with white noise on displacement and pressures."""
    time = np.arange(0.0, duration, interval)
    rng = np.random.default_rng(seed)
    held = round(0.4 / interval)
    demand = np.repeat(rng.uniform(0.006, 0.024, len(time) // held + 1), held)[: len(time)]
    run = simulate(rig, time=time, controller=controller, demand=demand)
    return noisy(run, rng, noise)


def noisy(run, rng, noise=NOISE) -> Recording:
    """Return a run as transducers with white noise record it."""
    channels = {name: run[name] + rng.normal(0.0, noise[name], len(run.time)) for name in noise}
    return Recording("run", run.time, channels | {"valve_voltage": run["valve_voltage"]})
