"""The search: settings tried generation by generation, kept as they come."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from analog_card.tolerance_trials import fingerprint, requiring, run_trials
from pneuservo.errors import InputError
from pneuservo.tuning.evaluation import Settings, Worst, evaluate
from pneuservo.tuning.problem import OBJECTIVES, POTENTIOMETERS, TuningProblem, settable

GENERATIONS = "generations"
"""Name of the folder in which generations are kept as they come."""
# What a setting that settles nowhere counts as; it is told from others by its limits only.
_FAR = 1e6


@dataclass(frozen=True)
class Search:
    """How long is searched.

    Attributes
    ----------
    population : int
        Settings tried in each generation.
    generations : int
        How many.
    seed : int
        Of the first settings and of what becomes of them.
    """

    population: int = 40
    generations: int = 30
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what makes no search."""
        if self.population < 4 or self.generations < 1:
            raise InputError(
                f"{self.generations} generations of {self.population} settings: at least 1 of 4 is "
                "needed"
            )
        if self.seed < 0:
            raise InputError(f"seed is {self.seed}; it has to be 0 or more")

    def __len__(self) -> int:
        """Return how many settings are tried at most."""
        return self.population * self.generations


def search(
    problem: TuningProblem,
    plan: Search,
    folder: Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
    pool: Executor | None = None,
) -> list[Worst]:
    """Try settings, those that did well leading to the next.

    Parameters
    ----------
    problem : TuningProblem
        What is tuned.
    plan : Search
        How long.
    folder : Path, optional
        Where generations are kept as they come, so that a stopped search goes on.
    jobs : int, optional
        Processes that the pool has.
    step : callable, optional
        Told about each setting tried.
    pool : Executor, optional
        Runs them elsewhere than in this process.

    Returns
    -------
    list of Worst
        Everything tried, in order; the same however it was run.

    Raises
    ------
    InputError
        When the folder holds another search.

    Notes
    -----
    NSGA-II with constrained domination (Deb, Pratap, Agarwal and Meyarivan 2002) by pymoo, from a
    Latin hypercube over the whole travel of P1 to P4 and the settings that the card has now. A
    search gone on with repeats the choices and takes from the folder what they led to.
    """
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    space = Problem(
        n_var=len(POTENTIOMETERS), n_obj=len(OBJECTIVES), n_ieq_constr=3, xl=0.0, xu=1.0
    )
    algorithm = NSGA2(pop_size=plan.population, sampling=_first(problem, plan))
    algorithm.setup(space, termination=("n_gen", plan.generations), seed=plan.seed)
    tried: list[Worst] = []
    for generation in range(plan.generations):
        candidates = algorithm.ask()
        settings = [settable(row) for row in candidates.get("X")]
        worst = _tried(problem, settings, generation, folder, jobs, step, pool)
        tried += worst
        objectives = np.array([np.minimum(each.objectives(), _FAR) for each in worst])
        limits = np.array([each.excesses(problem) for each in worst])
        Evaluator().eval(StaticProblem(space, F=objectives, G=limits), candidates)
        algorithm.tell(infills=candidates)
    return tried


def _first(problem: TuningProblem, plan: Search) -> np.ndarray:
    """Return the first generation: all over the travel, and where the card stands now."""
    from scipy.stats.qmc import LatinHypercube

    spread = LatinHypercube(len(POTENTIOMETERS), rng=np.random.default_rng(plan.seed))
    first = spread.random(plan.population)
    first[0] = problem.now
    return first


def _tried(
    problem: TuningProblem,
    settings: Sequence[Settings],
    generation: int,
    folder: Path | None,
    jobs: int,
    step: Callable[[str], None],
    pool: Executor | None,
) -> list[Worst]:
    # Told from others by what it tries: more generations leave those before as they are.
    name = f"generation {generation} of tuning {fingerprint(problem.identity(), settings)}"
    found: list[dict[str, Any]] = run_trials(
        partial(evaluate, problem, settings),
        len(settings),
        name,
        None if folder is None else folder / GENERATIONS / f"{generation:04}.jsonl",
        jobs,
        step,
        pool,
        -(-len(settings) // (2 * jobs)),
        requiring(*(each.name for each in fields(Worst))),
    )
    return [
        Worst(tuple(each["settings"]), each["figures"], each["rigs"], each["lacking"])
        for each in found
    ]
