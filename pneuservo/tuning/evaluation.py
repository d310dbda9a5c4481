"""What settings are worth: every rig of the set simulated, and the worst of each figure."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneuservo.campaign.metrics import metrics_of
from pneuservo.simulation import Simulation, simulate, simulate_batch
from pneuservo.tuning.problem import LIMITED, OBJECTIVES, TuningProblem

Settings = tuple[float, ...]

# What a figure that is no number counts as, in limits: further off than any loop that moves.
_NO_NUMBER = 1e3

# The valve's dead band of 0.03 V (thesis chapter 4, not modelled) swallows a smaller chatter; of
# settling time and effort 1 % counts.
RESOLUTION = {"settling_time": 2e-3, "chatter": 0.03, "control_effort": 0.01}
"""Differences of objectives that make no settings better [SI]."""


@dataclass(frozen=True)
class Worst:
    """The worst of every figure over a set of rigs.

    Attributes
    ----------
    settings : tuple of float
        P1 to P4, fractions of travel.
    figures : dict of str to float or None
        By the names of `OBJECTIVES` and `LIMITED`, in SI; None when one rig has no such figure,
        such as the settling time of a loop that does not settle.
    rigs : dict of str to int
        In which rig of the set each is worst; the first without a number.
    lacking : int
        In how many rigs a figure is no number.
    """

    settings: Settings
    figures: dict[str, float | None]
    rigs: dict[str, int]
    lacking: int

    def objectives(self) -> tuple[float, ...]:
        """Return what is made small, to what can be told apart; infinite where not a number."""
        return tuple(_rounded(self.figures[name], step) for name, step in RESOLUTION.items())

    def excesses(self, problem: TuningProblem) -> tuple[float, ...]:
        """Return by how much each limit is exceeded; none is above 0 when all are kept.

        Parameters
        ----------
        problem : TuningProblem
            With the limits.

        Returns
        -------
        tuple of float
            Share of the rigs that lack a figure, and of overshoot and error what they are beyond
            their limit, as a share of it.
        """
        limits = (problem.largest_overshoot, problem.largest_error)
        found = [self.lacking / len(problem.members)]
        for name, limit in zip(LIMITED, limits, strict=True):
            value = self.figures[name]
            found.append(_NO_NUMBER if value is None else abs(value) / limit - 1.0)
        return tuple(found)

    def feasible(self, problem: TuningProblem) -> bool:
        """Return whether every rig has every figure and keeps every limit."""
        return all(excess <= 0.0 for excess in self.excesses(problem))


def evaluate(
    problem: TuningProblem, settings: Sequence[Settings], indices: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """Yield what some of many settings are worth, as `pneuservo.tuning.search` keeps it.

    Parameters
    ----------
    problem : TuningProblem
        With the set of rigs.
    settings : sequence of tuple of float
        P1 to P4 of each.
    indices : sequence of int
        Which of them.

    Yields
    ------
    dict
        The attributes of a `Worst`.
    """
    for index in indices:
        yield vars(worst_by_batch(problem, settings[index]))


def worst_by_batch(problem: TuningProblem, settings: Settings) -> Worst:
    """Return the worst of every figure, all rigs of the set simulated side by side.

    Parameters
    ----------
    problem : TuningProblem
        With the set of rigs.
    settings : tuple of float
        P1 to P4, fractions of travel.

    Examples
    --------
    >>> from pneuservo.tuning.problem import tuning_problem
    >>> problem = tuning_problem({"vary": {"load.mass": "1.8, 7 kg"}, "demand": "15,24 mm"})
    >>> worst = worst_by_batch(problem, problem.now)
    >>> 0.1 < worst.figures["settling_time"] < 0.2, worst.rigs["settling_time"]
    (True, 1)
    """
    campaign = problem.campaign
    names = [name for name in problem.members[0] if name in campaign.rig.parameters]
    runs = simulate_batch(
        campaign.rig,
        {name: [values[name] for values in problem.members] for name in names},
        time=campaign.time,
        demand=campaign.demand,
        controller=problem.controllers(settings),
        channels=("displacement", "valve_voltage"),
        # One setting is one batch: what it gives must not depend on which others are tried.
        jobs=1,
    )
    channels = {"displacement": runs["displacement"], "valve_voltage": runs["valve_voltage"]}
    return _worst(
        settings,
        [
            Simulation(
                rig,
                campaign.time,
                {"demand": campaign.demand, **{name: channels[name][k] for name in channels}},
            )
            for k, rig in enumerate(problem.rigs)
        ],
    )


def worst_by_single_runs(problem: TuningProblem, settings: Settings) -> Worst:
    """Return the same from one run after the other, every event located exactly.

    Parameters
    ----------
    problem : TuningProblem
        With the set of rigs.
    settings : tuple of float
        P1 to P4, fractions of travel.
    """
    time, demand = problem.campaign.time, problem.campaign.demand
    cards = problem.controllers(settings)
    runs = [
        simulate(rig, time=time, demand=demand, controller=card)
        for rig, card in zip(problem.rigs, cards, strict=True)
    ]
    return _worst(settings, runs)


def _worst(settings: Settings, runs: Sequence[Simulation]) -> Worst:
    names = (*OBJECTIVES, *LIMITED)
    found = [metrics_of(run, names) for run in runs]
    figures: dict[str, float | None] = {}
    rigs: dict[str, int] = {}
    for name in names:
        values = [each[name] for each in found]
        sizes = [math.inf if value is None else abs(value) for value in values]
        rigs[name] = int(np.argmax(sizes))
        figures[name] = values[rigs[name]]
    lacking = sum(any(value is None for value in each.values()) for each in found)
    return Worst(tuple(settings), figures, rigs, lacking)


def _rounded(value: float | None, step: float) -> float:
    return math.inf if value is None else round(value / step) * step
