"""A leaking test volume, simulated from mass and energy with a catalogue valve's flow law.

Nothing here is used by the plant or by the diagnosis: a diagnosis that only finds what its own
equations have made proves nothing.
"""

import math
from pathlib import Path

import numpy as np

from pneuservo.recordings import Recording, write_recording

AMBIENT_PRESSURE, AMBIENT_TEMPERATURE = 1.013e5, 293.0
_VOLUME = 50e-6
_SONIC_CONDUCTANCE = 5.0e-12
"""ISO 6358 sonic conductance of the leak [m^3/(s Pa)]."""
_CRITICAL_RATIO = 0.25
"""ISO 6358 critical pressure ratio of the leak [-]: well below a nozzle's 0.528."""
_REFERENCE_DENSITY, _REFERENCE_TEMPERATURE = 1.185, 293.15
_WALL_CONDUCTANCE = 0.08
"""Heat transfer from gas to wall [W/K]."""
_R, _CV, _CP = 287.06, 717.6, 1004.7
_INITIAL_GAUGE = 7.0e5
_RELEASED = 4.0
"""When the fill line is shut and the volume left alone [s]."""
_NOISE_RMS, _RESOLUTION = 250.0, 100.0


def leaking_volume(seed: int = 0, duration: float = 90.0, rate: float = 10.0) -> Recording:
    """Return a recording of a closed volume that leaks to the atmosphere.

    Parameters
    ----------
    seed : int, optional
        Seed of the noise.
    duration : float, optional
        Length of the recording [s].
    rate : float, optional
        Samples per second [Hz].

    Returns
    -------
    Recording
        Rig ``dead-volume``, channel ``dead_volume_pressure``, with noise and quantisation.

    Notes
    -----
    States are the mass and the internal energy of the gas; the leak follows ISO 6358 (2013)
    with a critical ratio of 0.25; the wall gives heat back. The volume is held at 7 bar gauge
    for 4 s before it is left alone.

    Examples
    --------
    >>> len(leaking_volume(duration=10.0))
    101
    """
    from scipy.integrate import solve_ivp

    time = np.arange(round(duration * rate) + 1) / rate
    pressure = AMBIENT_PRESSURE + _INITIAL_GAUGE
    mass = pressure * _VOLUME / (_R * AMBIENT_TEMPERATURE)
    alone = time[time > _RELEASED]
    solution = solve_ivp(
        _gas_balance,
        (_RELEASED, time[-1]),
        [mass, mass * _CV * AMBIENT_TEMPERATURE],
        method="Radau",
        t_eval=alone,
        rtol=1e-8,
        atol=1e-12,
    )
    true = np.full(len(time), pressure)
    true[len(time) - len(alone) :] = solution.y[1] * _R / (_CV * _VOLUME)
    noisy = true + _NOISE_RMS * np.random.default_rng(seed).standard_normal(len(time))
    reading = np.round(noisy / _RESOLUTION) * _RESOLUTION
    return Recording(
        "leaking-volume",
        time,
        {"dead_volume_pressure": reading},
        "dead-volume",
        conditions={"ambient_pressure": AMBIENT_PRESSURE, "temperature": AMBIENT_TEMPERATURE},
        title="example: a test volume that leaks",
        notes="Simulated from mass and energy with an ISO 6358 leak; not a measurement.",
    )


def write_example(folder: Path, seed: int = 0) -> Path:
    """Write the example recording and its sidecar into a folder.

    Parameters
    ----------
    folder : Path
        Where to write ``leaking-volume.csv`` and ``leaking-volume.toml``.
    seed : int, optional
        Seed of the noise.

    Returns
    -------
    Path
        The recording.
    """
    path = folder / "leaking-volume.csv"
    write_recording(leaking_volume(seed), path)
    return path


def _gas_balance(time: float, state: np.ndarray) -> list[float]:
    mass, energy = state
    temperature = energy / (mass * _CV)
    pressure = mass * _R * temperature / _VOLUME
    outflow = _iso_flow(pressure, temperature)
    heat = _WALL_CONDUCTANCE * (AMBIENT_TEMPERATURE - temperature)
    return [-outflow, heat - outflow * _CP * temperature]


def _iso_flow(pressure: float, temperature: float) -> float:
    ratio = AMBIENT_PRESSURE / pressure
    choked = (
        _SONIC_CONDUCTANCE
        * _REFERENCE_DENSITY
        * pressure
        * math.sqrt(_REFERENCE_TEMPERATURE / temperature)
    )
    if ratio <= _CRITICAL_RATIO:
        return choked
    share = (ratio - _CRITICAL_RATIO) / (1.0 - _CRITICAL_RATIO)
    return choked * math.sqrt(max(0.0, 1.0 - share * share))
