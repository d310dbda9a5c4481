"""What a tuning for a set of rigs says, as plain values and in words."""

from dataclasses import asdict
from typing import Any

from analog_card.tuning import read_settings
from pneuservo.campaign.metrics import METRICS
from pneuservo.campaign.summary import shown, shown_unit
from pneuservo.tuning.evaluation import Worst
from pneuservo.tuning.problem import LIMITED, OBJECTIVES, POTENTIOMETERS, TuningProblem
from pneuservo.tuning.run import RobustTuning

# A limit binds from this share of it on, a potentiometer within this share of an end of its travel.
_NEARLY, _END = 0.9, 0.01


def summary(found: RobustTuning) -> dict[str, Any]:
    """Return a tuning as plain values, for JSON.

    Parameters
    ----------
    found : RobustTuning
        What was found.

    Returns
    -------
    dict
        Everything in SI: the set, the limits, the front, the settings to take with what binds,
        the same by single runs, and what the check says.
    """
    problem = found.problem
    turned = read_settings(found.design)
    return {
        "title": problem.campaign.title,
        "rig": problem.campaign.rig.name,
        "design": problem.design.title,
        "duration": float(problem.campaign.time[-1] - problem.campaign.time[0]),
        "seed": found.plan.seed,
        "population": found.plan.population,
        "generations": found.plan.generations,
        "tried": len(found.tried),
        "feasible": sum(each.feasible(problem) for each in found.tried),
        "rigs": list(problem.members),
        "limits": {
            "overshoot": problem.largest_overshoot,
            "steady_state_error": problem.largest_error,
        },
        "before": _plain(found.tried[0], problem),
        "front": [_plain(each, problem) for each in found.front],
        "recommended": {
            **_plain(found.chosen, problem),
            "place": found.choice,
            "ohm": {item.name: item.resistance for item in turned.potentiometers},
            "achieved": turned.achieved,
            "binds": binding(found.chosen, problem),
        },
        "single_runs": found.located.figures,
        "check": {
            "trials": len(found.trials),
            "failed": sum(each["error"] is not None for each in found.trials),
            "figures": [asdict(each) for each in found.judged],
        },
    }


def binding(worst: Worst, problem: TuningProblem) -> list[dict[str, Any]]:
    """Return what keeps settings from being better.

    Parameters
    ----------
    worst : Worst
        The settings and what they are worth.
    problem : TuningProblem
        With the set of rigs and the limits.

    Returns
    -------
    list of dict
        For each objective the rig in which it is worst; limits from nine tenths on, with the rig;
        potentiometers at an end of their travel.
    """
    found = [_bound("worst", name, worst, problem) for name in OBJECTIVES]
    beyond = dict(zip(LIMITED, worst.excesses(problem)[1:], strict=True))
    found += [
        _bound("limit", name, worst, problem) for name in LIMITED if beyond[name] >= _NEARLY - 1.0
    ]
    return found + [
        {"kind": "end of travel", "figure": name, "value": setting}
        for name, setting in zip(POTENTIOMETERS, worst.settings, strict=True)
        if not _END <= setting <= 1.0 - _END
    ]


def shown_figure(name: str, value: float | None) -> float:
    """Return a figure in the unit in which people read it; NaN for None."""
    if value is None:
        return float("nan")
    return float(shown(value, shown_unit(name), METRICS[name]))


def _bound(kind: str, name: str, worst: Worst, problem: TuningProblem) -> dict[str, Any]:
    rig = worst.rigs[name]
    return {
        "kind": kind,
        "figure": name,
        "value": worst.figures[name],
        "rig": rig,
        "values": problem.members[rig],
    }


def _plain(worst: Worst, problem: TuningProblem) -> dict[str, Any]:
    return {
        "settings": dict(zip(POTENTIOMETERS, worst.settings, strict=True)),
        "figures": worst.figures,
        "rigs": worst.rigs,
        "feasible": worst.feasible(problem),
    }
