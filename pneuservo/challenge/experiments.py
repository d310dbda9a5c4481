"""The experiments: what drives the valve for ten seconds, on which load and supply."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from pneuservo.challenge.truth.control import CENTRING, PROPORTIONAL, SLIDING, STORED, Control
from pneuservo.challenge.truth.parameters import Array

DURATION = 10.0
RATE = 1000.0
TICK = 1e-3
"""A computer in step with the recording drives the valve: its voltage holds this long [s]."""
_FINER = 10
"""The voltage of an analogue controller, which runs on, is followed in so many parts of that."""


@dataclass(frozen=True)
class Experiment:
    """One experiment.

    Parameters
    ----------
    kind : str
        Its name, of `KINDS`.
    control : Control
        What drives the valve.
    start : float
        Displacement at rest at the start [m].
    changes : mapping of str to float, optional
        What this run adds to rig parameters, SI: a load, a supply set lower.
    """

    kind: str
    control: Control
    start: float
    changes: dict[str, float] = field(default_factory=dict)


def experiment(
    kind: str, rng: np.random.Generator, changes: dict[str, float] | None = None
) -> Experiment:
    """Return an experiment with its own random set points.

    Parameters
    ----------
    kind : str
        A name of `KINDS`.
    rng : Generator
        Draws the set points.
    changes : mapping of str to float, optional
        What this run adds to rig parameters, SI.

    Returns
    -------
    Experiment
        Ten seconds.
    """
    control, start = KINDS[kind](rng)
    return Experiment(kind, control, start, changes or {})


def _times() -> Array:
    return np.arange(round(DURATION / TICK)) * np.float64(TICK)


def _steps(rng: np.random.Generator, hold: float) -> Array:
    count = round(DURATION / hold)
    levels = rng.uniform(5e-3, 25e-3, count)
    # Far enough from the one before to be a step.
    for index in range(1, count):
        if abs(levels[index] - levels[index - 1]) < 3e-3:
            levels[index] += 6e-3 if levels[index] < 15e-3 else -6e-3
    held = levels[np.minimum((_times() / hold).astype(int), count - 1)]
    return np.asarray(held, dtype=np.float64)


def _control(kind: int, demand: Array, gain: float = 0.0, boundary: float = 0.0) -> Control:
    none = np.zeros(1)
    quiet = np.zeros(len(demand))
    return Control(kind, TICK, demand, quiet, none, none, gain=gain, boundary=boundary)


def _sliding_mode(rng: np.random.Generator) -> tuple[Control, float]:
    demand = _steps(rng, rng.choice([0.5, 1.0, 1.25]))
    return _control(SLIDING, demand, boundary=rng.uniform(8.0, 25.0)), demand[0]


def _relay(rng: np.random.Generator) -> tuple[Control, float]:
    demand = _steps(rng, rng.choice([0.5, 1.0, 1.25]))
    return _control(SLIDING, demand, boundary=0.0), demand[0]


def _proportional(rng: np.random.Generator) -> tuple[Control, float]:
    demand = _steps(rng, rng.choice([0.5, 1.0]))
    return _control(PROPORTIONAL, demand, gain=rng.uniform(200.0, 500.0)), demand[0]


def _analogue(sampled: tuple[Control, float]) -> tuple[Control, float]:
    """Return the same controller as one that never stops to look, and where it starts."""
    control, start = sampled
    demand = np.repeat(control.demand, _FINER)
    quiet = np.zeros(len(demand))
    finer = control._replace(tick=TICK / _FINER, demand=demand, noise=quiet, continuous=True)
    return finer, start


def _analogue_sliding_mode(rng: np.random.Generator) -> tuple[Control, float]:
    control, start = _analogue(_sliding_mode(rng))
    return control._replace(boundary=rng.uniform(4.0, 25.0)), start


def _analogue_proportional(rng: np.random.Generator) -> tuple[Control, float]:
    return _analogue(_proportional(rng))


def _regulation(rng: np.random.Generator) -> tuple[Control, float]:
    demand = np.full(round(DURATION / TICK), rng.uniform(8e-3, 22e-3))
    return _control(PROPORTIONAL, demand, gain=rng.uniform(200.0, 400.0)), demand[0]


def _small_steps(rng: np.random.Generator) -> tuple[Control, float]:
    middle, height = rng.uniform(8e-3, 22e-3), rng.uniform(1e-4, 4e-4)
    demand = middle + height * (np.floor(_times() / 2.5) % 2.0)
    return _control(PROPORTIONAL, demand, gain=rng.uniform(200.0, 400.0)), middle


def _triangle(rng: np.random.Generator) -> tuple[Control, float]:
    low, high = rng.uniform(3e-3, 7e-3), rng.uniform(21e-3, 26e-3)
    period = rng.uniform(5.0, 10.0)
    part = np.abs(2.0 * np.mod(_times() / period, 1.0) - 1.0)
    demand = high - (high - low) * part
    return _control(PROPORTIONAL, demand, gain=rng.uniform(400.0, 600.0)), demand[0]


def _multilevel(rng: np.random.Generator) -> tuple[Control, float]:
    levels = 5.0 * rng.uniform(0.03, 1.0, 400) ** 1.5
    # The product of the two keeps the piston off its stops.
    spans = np.minimum(rng.uniform(0.02, 0.25, 400), 0.12 / levels)
    none = np.zeros(round(DURATION / TICK))
    return Control(CENTRING, TICK, none, none, levels, spans), 15e-3


def _staircase(rng: np.random.Generator) -> tuple[Control, float]:
    heights = np.array([0.0, 0.2, 0.5, 1.0, 2.0, 3.0, 2.0, 1.0, 0.5, 0.2]) * 1e-2
    stairs = np.concatenate([heights, -heights]) * 5.0 * rng.uniform(0.8, 1.3)
    step = rng.uniform(0.1, 0.25)
    command = stairs[(_times() / step).astype(int) % len(stairs)]
    return _control(STORED, command), rng.uniform(10e-3, 18e-3)


def _hold(rng: np.random.Generator) -> tuple[Control, float]:
    time, command = _times(), np.zeros(round(DURATION / TICK))
    start, sign = 0.5, rng.choice([-1.0, 1.0])
    while start < DURATION:
        length, height = rng.uniform(0.03, 0.15), rng.uniform(0.3, 1.5)
        command[(time >= start) & (time < start + length)] = sign * height
        start, sign = start + rng.uniform(1.0, 2.5), -sign
    return _control(STORED, command), 15e-3


def _stop_test(rng: np.random.Generator) -> tuple[Control, float]:
    time, command = _times(), np.zeros(round(DURATION / TICK))
    start, sign = 0.3, rng.choice([-1.0, 1.0])
    while start < DURATION:
        length, height = rng.uniform(0.25, 0.5), rng.uniform(1.5, 5.0)
        command[(time >= start) & (time < start + length)] = sign * height
        start, sign = start + length + rng.uniform(1.2, 2.0), -sign
    return _control(STORED, command), 15e-3


ANALOGUE = ("analogue sliding-mode", "analogue proportional")
"""Kinds in which the set point is recorded beside the voltage."""
KINDS: dict[str, Callable[[np.random.Generator], tuple[Control, float]]] = {
    "sliding-mode": _sliding_mode,
    "relay": _relay,
    "proportional": _proportional,
    ANALOGUE[0]: _analogue_sliding_mode,
    ANALOGUE[1]: _analogue_proportional,
    "regulation": _regulation,
    "small-steps": _small_steps,
    "multilevel": _multilevel,
    "triangle": _triangle,
    "staircase": _staircase,
    "hold": _hold,
    "stop-test": _stop_test,
}
