"""The choice judged by other means: rigs drawn from inside the set, cards with all they have."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from analog_card.errors import AnalogCardError
from analog_card.tolerance import draw, elements_of, quantities
from analog_card.tolerance_trials import fingerprint, requiring, run_trials
from pneuservo.campaign.axes import Axis, Random
from pneuservo.campaign.metrics import metrics_of
from pneuservo.campaign.parameters import varied_rig
from pneuservo.campaign.plan import Campaign
from pneuservo.controllers import card_of
from pneuservo.errors import PneuservoError
from pneuservo.simulation import simulate
from pneuservo.tuning.evaluation import Settings, Worst
from pneuservo.tuning.problem import LIMITED, OBJECTIVES, TuningProblem

# Shares of the work that each process gets.
_SHARES = 10


@dataclass(frozen=True)
class Judged:
    """What the trials of a check say about one figure.

    Attributes
    ----------
    figure : str
        One of the objectives or of what is limited.
    limit : float
        The worst of the set for an objective, otherwise the limit [unit of the figure].
    median, highest : float or None
        By size; None when no trial has it [unit of the figure].
    within : int
        Trials that have it and are within the limit.
    trials : int
        How many there were.
    """

    figure: str
    limit: float
    median: float | None
    highest: float | None
    within: int
    trials: int


def drawn_rigs(problem: TuningProblem, seed: int) -> Campaign:
    """Return the campaign that draws rigs from inside the set.

    Parameters
    ----------
    problem : TuningProblem
        With the set.
    seed : int
        Of the draws.

    Notes
    -----
    A parameter of the rig with several values is drawn evenly between the lowest and the highest;
    what is drawn in the set is drawn anew. Parts of the card are left out: cards are drawn whole.
    """
    own = [axis for axis in problem.campaign.axes if axis.name in problem.campaign.rig.parameters]
    return replace(problem.campaign, axes=tuple(map(_between, own)), trials=1, seed=seed)


def run_check(
    problem: TuningProblem,
    settings: Settings,
    trials: int,
    seed: int = 0,
    folder: Path | None = None,
    jobs: int = 1,
    step: Callable[[str], None] = lambda what: None,
    pool: Executor | None = None,
) -> list[dict[str, Any]]:
    """Simulate settings in drawn rigs with drawn cards.

    Parameters
    ----------
    problem : TuningProblem
        With the set of rigs.
    settings : tuple of float
        P1 to P4.
    trials : int
        How many.
    seed : int, optional
        Of rigs and cards.
    folder : Path, optional
        Where trials are kept as they come, each choice in a file of its own.
    jobs : int, optional
        Processes that the pool has.
    step : callable, optional
        Told about each trial done.
    pool : Executor, optional
        Runs them elsewhere than in this process.

    Returns
    -------
    list of dict
        ``values`` of the rig, ``metrics``, and ``error``, what kept a trial from being simulated.

    Notes
    -----
    Independent of the search in the draws (`drawn_rigs`, and cards by all their tolerances, op-amps
    and temperature), in the card (its behaviour, with offsets and op-amps) and in the integration
    (single runs).
    """
    if trials == 0:
        return []
    # A search gone on with can choose other settings: each choice has a file of its own.
    choice = fingerprint(problem.identity(), settings, seed)
    return run_trials(
        partial(_trials, problem, settings, seed),
        trials,
        f"check of tuning {choice}",
        folder and folder / f"check-{choice}.jsonl",
        jobs,
        step,
        pool,
        max(1, trials // (_SHARES * jobs)),
        requiring("values", "metrics", "error"),
    )


def judged(problem: TuningProblem, worst: Worst, trials: Sequence[dict[str, Any]]) -> list[Judged]:
    """Return what the trials of a check say about each figure.

    Parameters
    ----------
    problem : TuningProblem
        With the limits.
    worst : Worst
        Of the settings checked, over the set.
    trials : sequence of dict
        From `run_check`.
    """
    limits = {name: worst.figures[name] for name in OBJECTIVES} | dict(
        zip(LIMITED, (problem.largest_overshoot, problem.largest_error), strict=True)
    )
    return [_judged(name, float(limits[name] or 0.0), trials) for name in limits] if trials else []


def _judged(figure: str, limit: float, trials: Sequence[dict[str, Any]]) -> Judged:
    values = [each["metrics"][figure] for each in trials]
    sizes = sorted(abs(value) for value in values if value is not None)
    return Judged(
        figure,
        limit,
        sizes[len(sizes) // 2] if sizes else None,
        sizes[-1] if sizes else None,
        sum(size <= limit for size in sizes),
        len(trials),
    )


def _between(axis: Axis) -> Axis:
    if isinstance(axis, Random) or len(axis.values) == 1:
        return axis
    return Random(axis.name, axis.unit, axis.shown, "uniform", min(axis.values), max(axis.values))


def _trials(
    problem: TuningProblem, settings: Settings, seed: int, indices: Sequence[int]
) -> Iterator[dict[str, Any]]:
    campaign, design = drawn_rigs(problem, seed), problem.turned(settings)
    items, names = quantities(design), (*OBJECTIVES, *LIMITED)
    for index in indices:
        values = campaign.values(index)
        metrics: dict[str, float | None] = dict.fromkeys(names)
        error = None
        try:
            run = simulate(
                varied_rig(campaign.rig, values),
                time=campaign.time,
                demand=campaign.demand,
                controller=card_of(design, elements=elements_of(draw(items, seed, index), design)),
            )
            metrics = metrics_of(run, names)
        except (PneuservoError, AnalogCardError) as problem_found:
            error = str(problem_found)
        yield {"values": values, "metrics": metrics, "error": error}
