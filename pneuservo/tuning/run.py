"""Tuning from the set of rigs to the settings to take, in processes or on a cluster."""

from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from analog_card.design import Design
from analog_card.processes import processes
from pneuservo.tuning.check import Judged, judged, run_check
from pneuservo.tuning.evaluation import Worst
from pneuservo.tuning.front import confirmed, front_of
from pneuservo.tuning.problem import LIMITED, OBJECTIVES, POTENTIOMETERS, TuningProblem
from pneuservo.tuning.search import Search, search


@dataclass(frozen=True)
class RobustTuning:
    """What a tuning for a set of rigs gave.

    Attributes
    ----------
    problem : TuningProblem
        What was tuned.
    plan : Search
        How long was searched.
    tried : list of Worst
        Everything that was tried, in order.
    front : list of Worst
        What keeps every limit and is beaten by nothing, by increasing settling time.
    choice : int
        Which of the front to take.
    located : Worst
        The same settings by single runs with every event located.
    trials : list of dict
        Of the check, as from `pneuservo.tuning.check.run_check`.
    """

    problem: TuningProblem
    plan: Search
    tried: list[Worst]
    front: list[Worst]
    choice: int
    located: Worst
    trials: list[dict[str, Any]]

    @property
    def chosen(self) -> Worst:
        """Return the settings to take."""
        return self.front[self.choice]

    @property
    def design(self) -> Design:
        """Return the card turned to them."""
        return self.problem.turned(self.chosen.settings)

    @property
    def judged(self) -> list[Judged]:
        """Return what the check says; nothing without one."""
        return judged(self.problem, self.located, self.trials)

    def table(self) -> pd.DataFrame:
        """Return the front, one row for each setting: P1 to P4, figures, and where each is worst.

        In SI; rigs by their number in the set, from 0.
        """
        rows = [
            {
                **dict(zip(POTENTIOMETERS, each.settings, strict=True)),
                **each.figures,
                **{f"{name}_rig": each.rigs[name] for name in (*OBJECTIVES, *LIMITED)},
                "recommended": index == self.choice,
            }
            for index, each in enumerate(self.front)
        ]
        return pd.DataFrame(rows)


def run_tuning(
    problem: TuningProblem,
    plan: Search | None = None,
    trials: int = 0,
    folder: str | Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
    pool: Executor | None = None,
) -> RobustTuning:
    """Find the settings that are best in the worst rig of a set.

    Parameters
    ----------
    problem : TuningProblem
        What is tuned.
    plan : Search, optional
        How long is searched, and its seed.
    trials : int, optional
        Of the check of the settings found.
    folder : str or Path, optional
        Where everything is kept as it comes, so that a stopped tuning goes on.
    jobs : int, optional
        Processes to run in, or those of the pool.
    step : callable, optional
        Told about everything simulated.
    pool : Executor, optional
        Runs it elsewhere, such as `pneuservo.campaign.cluster.cluster`.

    Returns
    -------
    RobustTuning
        The same however it was run.

    Raises
    ------
    FitError
        When no settings tried keep the limits in every rig.
    InputError
        When the folder holds another tuning.

    Examples
    --------
    >>> from pneuservo.tuning.problem import tuning_problem
    >>> problem = tuning_problem({"vary": {"load.mass": "1.8, 7 kg"}, "demand": "15,24 mm"})
    >>> found = run_tuning(problem, Search(population=8, generations=4))
    >>> found.chosen.feasible(problem)
    True
    """
    plan = plan or Search()
    place = None if folder is None else Path(folder)
    # One pool for all generations: a process compiles or loads its kernels once.
    own = processes(jobs) if pool is None and jobs > 1 else nullcontext(pool)
    with own as used:
        tried = search(problem, plan, place, jobs, step, used)
        front = front_of(problem, tried)
        choice, located = confirmed(problem, front)
        settings = front[choice].settings
        # Another seed than that of the set and the search.
        checked = run_check(problem, settings, trials, plan.seed + 1, place, jobs, step, used)
    return RobustTuning(problem, plan, tried, front, choice, located, checked)
