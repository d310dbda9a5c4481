"""``python -m benchmarks``: the compiled simulation against scipy with the same compiled equations,
and the card's netlist in closed loop against its behaviour (`benchmarks.circuit_loop`).

Both have to bring the displacement to within `ALLOWED_ERROR` of a run with steps of 1 us. Each
then runs with the loosest setting that does, in turn, so that a busy machine slows both alike.
Ratios are what to compare between machines; milliseconds are not.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import circuit_loop
from benchmarks.scipy_reference import ScipyLoop
from pneuservo.controllers import SlidingMode
from pneuservo.rigs import load_rig
from pneuservo.simulation import InitialState, simulate

ALLOWED_ERROR = 0.1e-6  # m
DURATION = 1.0  # s
ROUNDS = 5
STEPS = (200e-6, 100e-6, 50e-6, 20e-6, 10e-6, 5e-6)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)

TIME = np.arange(0.0, DURATION + 5e-4, 1e-3)
# 15 to 24 mm and back, from a little beside the first set point.
DEMAND = np.where(TIME < 0.5, 0.024, 0.015)
START = InitialState(0.0145)
RIG = load_rig("single-axis")


@dataclass
class Contender:
    """A way to simulate, with the loosest setting that is good enough."""

    name: str
    setting: float
    error: float
    run: Callable[[], np.ndarray]


def compiled_run(controller: SlidingMode, step: float) -> np.ndarray:
    return simulate(
        RIG, time=TIME, controller=controller, demand=DEMAND, initial=START, largest_step=step
    )["displacement"]


def loosest(
    name: str,
    settings: tuple[float, ...],
    run: Callable[[float], np.ndarray],
    reference: np.ndarray,
) -> Contender:
    for setting in settings:
        error = float(np.max(np.abs(run(setting) - reference)))
        if error <= ALLOWED_ERROR:
            return Contender(name, setting, error, partial(run, setting))
    raise SystemExit(f"{name}: no setting comes within {ALLOWED_ERROR:g} m")


def milliseconds(run: Callable[[], np.ndarray]) -> float:
    start = time.process_time()
    run()
    return (time.process_time() - start) * 1e3


def compare(case: str, controller: SlidingMode, table: Table) -> None:
    reference = compiled_run(controller, 1e-6)
    scipy_loop = ScipyLoop(RIG, controller, START)
    contenders = (
        loosest("compiled, step", STEPS, lambda s: compiled_run(controller, s), reference),
        loosest(
            "scipy LSODA, rtol",
            TOLERANCES,
            lambda s: scipy_loop.displacement(TIME, DEMAND, s),
            reference,
        ),
    )
    rounds = np.array([[milliseconds(each.run) for each in contenders] for _ in range(ROUNDS)])
    ratios = rounds[:, 1] / rounds[:, 0]
    for index, each in enumerate(contenders):
        took = np.median(rounds[:, index])
        ratio = "1"
        if index:
            ratio = f"{np.median(ratios):.0f} ({ratios.min():.0f} to {ratios.max():.0f})"
        table.add_row(
            case,
            each.name,
            f"{each.setting:.0e}",
            f"{each.error * 1e6:.1e} um",
            f"{took:.1f} ms",
            f"{DURATION * 1e3 / took:.1f}",
            ratio,
        )


def main() -> None:
    table = Table("controller", "method", "setting", "error", "CPU/s", "x real time", "slower by")
    compare("layer 5 m/s2", SlidingMode(boundary_layer=5.0), table)
    compare("ideal relay", SlidingMode(boundary_layer=0.0), table)
    Console(width=120).print(table)
    Console(width=120).print(circuit_loop.compare())


if __name__ == "__main__":
    main()
