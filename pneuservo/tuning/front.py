"""The front: settings that keep every limit and that no others beat, and the one to take."""

from collections.abc import Sequence

import numpy as np

from pneuservo.errors import FitError
from pneuservo.tuning.evaluation import Worst, worst_by_single_runs
from pneuservo.tuning.problem import LIMITED, TuningProblem


def front_of(problem: TuningProblem, tried: Sequence[Worst]) -> list[Worst]:
    """Return the settings that keep every limit and that none of the others beats.

    Parameters
    ----------
    problem : TuningProblem
        With the limits.
    tried : sequence of Worst
        Everything tried.

    Returns
    -------
    list of Worst
        By increasing settling time; of settings that cannot be told apart the first.

    Raises
    ------
    FitError
        When nothing tried keeps the limits.
    """
    from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

    feasible = list(
        {each.objectives(): each for each in reversed(tried) if each.feasible(problem)}.values()
    )
    if not feasible:
        raise FitError(_nothing(problem, tried))
    objectives = np.array([each.objectives() for each in feasible])
    kept = NonDominatedSorting().do(objectives, only_non_dominated_front=True)
    return sorted((feasible[int(k)] for k in kept), key=lambda each: each.objectives())


def by_preference(front: Sequence[Worst]) -> list[int]:
    """Return the settings of a front, those first to take unless one figure matters more.

    Parameters
    ----------
    front : sequence of Worst
        From `front_of`.

    Notes
    -----
    By the distance to the point that is best in every figure, each figure counted in shares of its
    range over the front (compromise programming, Zeleny 1973).
    """
    objectives = np.array([each.objectives() for each in front])
    best, span = objectives.min(axis=0), np.ptp(objectives, axis=0)
    away = (objectives - best) / np.where(span > 0.0, span, 1.0)
    places = np.argsort(np.sum(away**2, axis=1), kind="stable")
    return [int(place) for place in places]


def confirmed(problem: TuningProblem, front: Sequence[Worst]) -> tuple[int, Worst]:
    """Return which settings of a front to take, and what single runs say of them.

    Parameters
    ----------
    problem : TuningProblem
        With the set of rigs and the limits.
    front : sequence of Worst
        From `front_of`.

    Raises
    ------
    FitError
        When single runs confirm none.

    Notes
    -----
    A loop about to lose stability amplifies what the longer steps of runs side by side leave: the
    first are taken by preference that keep the limits in single runs as well.
    """
    for place in by_preference(front):
        located = worst_by_single_runs(problem, front[place].settings)
        if located.feasible(problem):
            return place, located
    raise FitError(
        f"not one of the {len(front)} settings of the front keeps the limits in single runs as "
        "well: the set leaves hardly any room. Allow more by --overshoot or --error, or state a "
        "smaller set of rigs"
    )


def _nothing(problem: TuningProblem, tried: Sequence[Worst]) -> str:
    """Return what came nearest to the limits."""
    nearest = min(
        tried, key=lambda each: sum(max(excess, 0.0) for excess in each.excesses(problem))
    )
    overshoot, error = (nearest.figures[name] for name in LIMITED)
    words = [f"{nearest.lacking} of {len(problem.members)} rigs do not settle"]
    if overshoot is not None:
        words.append(f"overshoot {100 * overshoot:.3g} %")
    if error is not None:
        words.append(f"steady-state error {1e3 * error:.3g} mm")
    return (
        f"not one of {len(tried)} settings keeps the limits in every rig of the set (overshoot "
        f"{100 * problem.largest_overshoot:.3g} %, steady-state error "
        f"{1e3 * problem.largest_error:.3g} mm); the nearest: {', '.join(words)}. Allow more by "
        "--overshoot or --error, search longer by --generations, or state a smaller set of rigs"
    )
