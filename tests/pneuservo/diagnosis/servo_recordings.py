"""Recordings of the servo without any effect, made by the plant itself."""

import numpy as np

from pneuservo.recordings import Recording
from pneuservo.simulation import simulate

NOISE = {"displacement": 1e-5, "pressure_a": 500.0, "pressure_b": 500.0}


def recorded(rig, controller, seed: int, duration: float = 4.0) -> Recording:
    """Return a run from set point to set point, with white noise on displacement and pressures."""
    time = np.arange(0.0, duration, 1e-3)
    rng = np.random.default_rng(seed)
    demand = np.repeat(rng.uniform(0.006, 0.024, len(time) // 400 + 1), 400)[: len(time)]
    run = simulate(rig, time=time, controller=controller, demand=demand)
    channels = {name: run[name] + rng.normal(0.0, NOISE[name], len(time)) for name in NOISE}
    return Recording("run", time, channels | {"valve_voltage": run["valve_voltage"]})
