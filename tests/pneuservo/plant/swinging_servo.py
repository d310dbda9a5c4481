"""A servo with effects that a sine of the command swings about: what it does, and how alike."""

import dataclasses

import numpy as np

from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

RIG = load_rig("single-axis")
TIME = np.arange(0.0, 0.3, 1e-3)
START = InitialState(0.012)
COMMAND = 4.0 * np.sin(2.0 * np.pi * 5.0 * TIME)
CHANNELS = ("displacement", "velocity", "pressure_a", "pressure_b", "spool")
# Named, so that it runs in the kernel with effects.
BASELINE = {"load.spring": {"stiffness": 0.0}}


def run(effects, command=COMMAND, start=START, rig=RIG):
    rig = dataclasses.replace(rig, effects=effects)
    return simulate(rig, time=TIME, command=command, supply_pressure=6.5e5, initial=start)


def assert_same(found, expected, tolerance):
    for name in CHANNELS:
        span = np.ptp(expected[name])
        assert np.abs(found[name] - expected[name]).max() <= tolerance * span, name
