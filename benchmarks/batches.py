"""Many runs at once: Monte Carlo, threads, gradients, and what a further axis costs."""

import os
import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.problem import CARDS, RIG, START, course, displacement
from benchmarks.results import Row
from benchmarks.single_runs import interleaved, milliseconds
from pneuservo.controllers import AnalogueCard
from pneuservo.simulation import Batch, simulate_batch, simulate_gradient
from pneuservo.simulation.gradient import RELATIVE_STEP
from pneuservo.simulation.trials import RELAY_STEP, SMOOTH_STEP

# What `simulate_batch` takes by default, and what its errors are seen against.
STEPS, SHORT_STEP = {"boundary layer": SMOOTH_STEP, "relay": RELAY_STEP}, 12.5e-6
SEED = 20
# Standard deviations of what varies, as shares of the value.
SPREADS = {
    "load.mass": 0.03,
    "piston.viscous_friction": 0.1,
    "piston.coulomb_friction": 0.3,
    "valve.flow.area_s_a": 0.05,
    "valve.flow.area_a_e": 0.05,
    "valve.spool.frequency": 0.1,
    "valve.spool.damping": 0.1,
    "supply.pressure": 0.02,
}
# Committed and elsewhere: wall clock of 1000 runs of 1 s on two processors.
_MONTE_CARLO = {"boundary layer": (1.0, 0.24), "relay": (1.5, 0.52)}
_THREADS = 2
AXES = (1, 2, 4, 8, 16, 32, 64)
DURATIONS = (0.25, 0.5, 1.0, 2.0, 4.0)


def varied(count: int) -> dict[str, NDArray[np.float64]]:
    """Return parameter values of many rigs."""
    random = np.random.default_rng(SEED)
    return {
        key: RIG[key] * np.abs(1.0 + spread * random.standard_normal(count))
        for key, spread in SPREADS.items()
    }


def batch(card: AnalogueCard, count: int, duration: float, step: float, jobs: int) -> Batch:
    """Return a Monte Carlo study through the public function."""
    times, demand = course(duration)
    return simulate_batch(
        RIG,
        varied(count),
        time=times,
        demand=demand,
        controller=card,
        initial=START,
        largest_step=step,
        jobs=jobs,
    )


def monte_carlo_rows(count: int, duration: float, rounds: int) -> Iterator[Row]:
    """Yield wall clock and CPU time of Monte Carlo studies, and what two threads make of them."""
    for case, card in CARDS.items():
        step = STEPS[case]
        run = partial(batch, card, count, duration, step)
        error = _population_error(card, min(count, 64), duration, step)
        wall = np.array(
            [[_wall(partial(run, jobs)) for jobs in (1, _THREADS)] for _ in range(rounds)]
        )
        cpu = np.array([milliseconds(partial(run, jobs)) for jobs in (1, _THREADS)]) / 1e3
        load = f"load average {os.getloadavg()[0]:.1f}"
        errors = "error over the runs: median {:.2g}, 95 % {:.2g}, worst {:.2g} um".format(*error)
        best = wall.min(axis=0)
        yield Row(
            f"{case}: {count} x {duration:g} s Monte Carlo on two processors, wall clock",
            float(best[1]),
            "s",
            *_MONTE_CARLO[case],
            higher_is_better=False,
            spread=(float(best[1]), float(wall[:, 1].max())),
            note=f"steps of {step * 1e6:g} us; {errors}; {load}",
        )
        yield Row(
            f"{case}: the same, CPU time for each processor",
            float(cpu[1] / _THREADS),
            "s",
            *_MONTE_CARLO[case],
            higher_is_better=False,
            note=f"{cpu[0]:.2f} s in one thread",
        )
        yield Row(
            f"{case}: parallel efficiency on two processors, CPU time in one thread over two",
            float(cpu[0] / cpu[1]),
            "",
            0.75,
            0.85,
            note="what two threads cost each other; not what they wait",
        )
        yield Row(
            f"{case}: parallel efficiency on two processors, wall clock",
            float(best[0] / (_THREADS * best[1])),
            "",
            0.75,
            0.85,
            note=f"{load}; says nothing on a busy machine",
        )


def _population_error(
    card: AnalogueCard, count: int, duration: float, step: float
) -> tuple[float, ...]:
    """Return median, 95 % and largest error of the displacement over the runs [um]."""
    found, exact = (batch(card, count, duration, each, 1) for each in (step, SHORT_STEP))
    errors = np.abs(found["displacement"] - exact["displacement"]).max(axis=1) * 1e6
    return float(np.median(errors)), float(np.quantile(errors, 0.95)), float(errors.max())


def _wall(run: partial[Batch]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def gradient_rows(duration: float, rounds: int) -> Iterator[Row]:
    """Yield what a gradient of eight parameters costs, in single runs."""
    times, demand = course(duration)
    keys = tuple(SPREADS)
    for case, card in CARDS.items():

        def gradient(card: AnalogueCard = card) -> NDArray[np.float64]:
            found = simulate_gradient(
                RIG,
                keys,
                time=times,
                controller=card,
                demand=demand,
                initial=START,
                largest_step=SMOOTH_STEP,
                jobs=1,
            )
            return found.derivatives["displacement"]

        took = interleaved([partial(displacement, card, duration, SMOOTH_STEP), gradient], rounds)
        ratios = took[:, 1] / took[:, 0]
        yield Row(
            f"{case}: gradient of eight parameters over one run",
            float(np.median(ratios)),
            "runs",
            6.0,
            4.3,
            higher_is_better=False,
            spread=(float(ratios.min()), float(ratios.max())),
            note=_gradient_note(gradient(), card, keys, times, demand),
        )


def _gradient_note(
    found: NDArray[np.float64],
    card: AnalogueCard,
    keys: tuple[str, ...],
    times: NDArray[np.float64],
    demand: NDArray[np.float64],
) -> str:
    """Return how far the derivatives are from central differences."""
    steps = np.array([RELATIVE_STEP * RIG[key] for key in keys])
    ends = []
    for sign in (1.0, -1.0):
        values = {
            key: RIG[key] + sign * steps[i] * (np.arange(8) == i) for i, key in enumerate(keys)
        }
        ends.append(
            simulate_batch(
                RIG,
                values,
                time=times,
                controller=card,
                demand=demand,
                initial=START,
                largest_step=SMOOTH_STEP,
                jobs=1,
            )["displacement"]
        )
    central = (ends[0] - ends[1]) / (2.0 * steps[:, np.newaxis])
    differences = np.abs(found - central).max(axis=1) / np.abs(central).max(axis=1)
    return f"up to {differences.max():.1e} of its largest value from central differences"


def scaling_rows(duration: float, rounds: int) -> Iterator[Row]:
    """Yield what a simulated second costs in longer runs, and a further axis beside others."""
    card = CARDS["boundary layer"]
    for length in DURATIONS:
        took = interleaved([partial(displacement, card, length * duration, SMOOTH_STEP)], rounds)
        yield Row(
            f"one axis, {length * duration:g} s simulated",
            float(np.median(took)) / (length * duration),
            "ms/s",
        )
    for count in AXES:
        took = interleaved([partial(batch, card, count, duration, SMOOTH_STEP, 1)], rounds)
        each = float(np.median(took)) / duration / count
        yield Row(f"{count} axes side by side, for each", each, "ms/s")
