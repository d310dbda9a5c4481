"""One run against scipy's LSODA on the same equations, at equal error."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchmarks.compiled_plant import CompiledPlant
from benchmarks.numpy_plant import NumpyPlant
from benchmarks.problem import ALLOWED_ERROR, CARDS, displacement, reference
from benchmarks.results import Row
from benchmarks.scipy_loop import scipy_displacement

STEPS = (100e-6, 50e-6, 40e-6, 25e-6, 20e-6, 10e-6, 5e-6)
TOLERANCES = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 5e-8, 2e-8, 1e-8)
# Committed and elsewhere: against NumPy, against the compiled equations, times real time.
_FIGURES = {
    "boundary layer": ((50.0, 132.0), (5.0, 15.0), (200.0, 676.0)),
    "relay": ((500.0, 1800.0), (150.0, 350.0), (150.0, 260.0)),
}


@dataclass(frozen=True)
class Contender:
    """A way to simulate, with the loosest setting that is good enough."""

    name: str
    setting: float
    error: float
    run: Callable[[], NDArray[np.float64]]


def loosest(
    name: str,
    settings: Sequence[float],
    run: Callable[[float], NDArray[np.float64]],
    exact: NDArray[np.float64],
) -> Contender:
    """Return a way to simulate with its loosest setting, this and all tighter ones good enough.

    A loose setting that only happens to come out well is not one to rely on, so that the next
    tighter one has to be good too.
    """
    found = None
    for setting in settings:
        try:
            error = float(np.max(np.abs(run(setting) - exact)))
        except ValueError:
            # At loose settings scipy's search for the time of an event can break down.
            error = np.inf
        if error > ALLOWED_ERROR:
            found = None
        elif found is None:
            found = Contender(name, setting, error, partial(run, setting))
        else:
            return found
    if found is None:
        raise SystemExit(f"{name}: no setting comes within {ALLOWED_ERROR:g} m")
    return found


def milliseconds(run: Callable[[], object]) -> float:
    """Return the CPU time of a run [ms]."""
    start = time.process_time()
    run()
    return (time.process_time() - start) * 1e3


def interleaved(runs: Sequence[Callable[[], object]], rounds: int) -> NDArray[np.float64]:
    """Return CPU times [ms], one row for each round in which all take their turn."""
    return np.array([[milliseconds(run) for run in runs] for _ in range(rounds)])


def single_rows(duration: float, rounds: int) -> Iterator[Row]:
    """Yield the rows of one run against scipy, and against the clock."""
    for case, card in CARDS.items():
        exact = reference(card, duration)
        against_numpy, against_compiled, real_time = _FIGURES[case]
        own = loosest("own", STEPS, partial(displacement, card, duration), exact)
        compiled = partial(scipy_displacement, CompiledPlant(card), duration)
        foreign = {"compiled": loosest("LSODA, compiled", TOLERANCES, compiled, exact)}
        # The same equations need about the same setting: the slow ones are not tried with looser.
        settings = TOLERANCES[TOLERANCES.index(foreign["compiled"].setting) :]
        in_numpy = partial(scipy_displacement, NumpyPlant(card), duration)
        foreign["NumPy"] = loosest("LSODA, NumPy", settings, in_numpy, exact)
        # Ten own runs for each foreign one, or the clock's resolution and the caches would tell.
        own_runs = partial(_repeat, own.run, 10)
        took = interleaved([own_runs, *(each.run for each in foreign.values())], rounds)
        took[:, 0] /= 10.0
        yield _real_time(case, own, took[:, 0], duration, real_time)
        for column, (name, figures) in enumerate(
            (("compiled", against_compiled), ("NumPy", against_numpy)), start=1
        ):
            ratios = took[:, column] / took[:, 0]
            yield Row(
                f"{case}: faster than solve_ivp LSODA on {name} equations",
                float(np.median(ratios)),
                "x",
                *figures,
                spread=(float(ratios.min()), float(ratios.max())),
                error_um=max(own.error, foreign[name].error) * 1e6,
                note=f"LSODA rtol {foreign[name].setting:g}, "
                f"{np.median(took[:, column]) / duration:.0f} ms/s",
            )


def _real_time(
    case: str,
    own: Contender,
    took: NDArray[np.float64],
    duration: float,
    figures: tuple[float, float],
) -> Row:
    factors = 1e3 * duration / took
    return Row(
        f"{case}: times real time",
        float(np.median(factors)),
        "x",
        *figures,
        spread=(float(factors.min()), float(factors.max())),
        error_um=own.error * 1e6,
        note=f"steps of {own.setting * 1e6:g} us, {np.median(took) / duration:.2f} ms/s",
    )


def _repeat(run: Callable[[], object], count: int) -> None:
    for _ in range(count):
        run()
