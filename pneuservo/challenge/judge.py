"""One answer against one key: what was right about it, as numbers that can be averaged."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pneuservo.challenge.classes import classmates, family

NO_EFFECT, UNEXPLAINED, NO_ANSWER = "none", "unexplained", "no answer"
CONFIDENT = 0.8
"""Probability from which a name is asserted."""


@dataclass(frozen=True)
class Judged:
    """What is counted of one case.

    Parameters
    ----------
    case, stratum, visibility : str
        Which case, its part of the mix, how visible its effect is.
    truth : tuple of str
        Ids that were concealed.
    named : tuple of str
        Ids that were asserted, the likeliest first; `UNEXPLAINED` and ``param.`` ids included.
    right : mapping of str to bool
        Measure to whether it was met; measures that do not apply are missing.
    figures : mapping of str to float
        Residuals over noise, parameter error, seconds, visibility.
    probability : float
        Of the first name.
    class_probability : float
        Of all names that were called as good as the first one, or are of its class.
    shared : bool
        Whether truth and catalogue may share the formula.
    """

    case: str
    stratum: str
    visibility: str
    truth: tuple[str, ...]
    named: tuple[str, ...]
    right: Mapping[str, bool] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)
    probability: float = 0.0
    class_probability: float = 0.0
    shared: bool = False

    @property
    def row(self) -> str:
        """Return the row of the confusion table."""
        return family(self.truth[0])

    @property
    def column(self) -> str:
        """Return the column of the confusion table."""
        return family(self.named[0]) if self.named else NO_EFFECT


def judge(
    case: str,
    key: Mapping[str, Any],
    answer: Mapping[str, Any] | None,
    seconds: float = math.nan,
    further: Mapping[str, Any] | None = None,
) -> Judged:
    """Judge one answer.

    Parameters
    ----------
    case : str
        Name of the case.
    key : mapping
        Its key.
    answer : mapping or None
        Content of diagnosis.json; None when there is none, which is a wrong answer.
    seconds : float, optional
        How long it took [s].
    further : mapping, optional
        The answer with the experiments that follow a hidden effect.

    Returns
    -------
    Judged
        What was right.
    """
    answer = answer or {}
    truth = tuple(key["effects"])
    named = names(answer) if answer else (NO_ANSWER,)
    measures = {
        "none": _control,
        "wrong-parameter": _wrong_parameter,
        "outside": _outside,
        "pair": _pair,
    }.get(key["stratum"], _single)
    right = measures(key, answer, named)
    if key["stratum"] == "missing-channels":
        right["not too fine"] = not named or not _beyond(named, truth)
    if further is not None and max(key["follow_up"]) >= 10.0:
        right["named after the experiment"] = bool(names(further)[:1]) and (
            names(further)[0] == truth[0]
        )
    figures = {"visibility": min(key["distances"]), "seconds": seconds, **_fit_figures(key, answer)}
    figures.update(_parameter_figures(key, answer))
    probability = _entries(answer)[0].get("probability", 0.0) if _entries(answer) else 0.0
    return Judged(
        case, key["stratum"], key["visibility"], truth, named, right, figures,
        float(probability), _class_probability(answer), bool(key["shared"]),
    )  # fmt: skip


def names(answer: Mapping[str, Any]) -> tuple[str, ...]:
    """Return what an answer asserts, the likeliest first.

    Parameters
    ----------
    answer : mapping
        Content of diagnosis.json.

    Examples
    --------
    >>> names({"verdict": "unexplained", "missing": []})
    ('unexplained',)
    >>> names({"verdict": "parameter", "corrected_parameters": {"load.mass": {}}})
    ('param.load.mass',)
    """
    verdict = answer.get("verdict")
    if verdict == "consistent":
        return ()
    found = [str(entry.get("effect")) for entry in _entries(answer)]
    found = [UNEXPLAINED if name.startswith(UNEXPLAINED) else name for name in found]
    if verdict == "parameter":
        found += [f"param.{name}" for name in answer.get("corrected_parameters", {})]
    if verdict == UNEXPLAINED and UNEXPLAINED not in found:
        found.insert(0, UNEXPLAINED)
    return tuple(dict.fromkeys(found))


def _entries(answer: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(answer.get("missing") or [])


def _class_probability(answer: Mapping[str, Any]) -> float:
    """Return the probability that what is missing is of the class of the first name."""
    entries = _entries(answer)
    if not entries:
        return 0.0
    first = entries[0]
    mates = classmates(str(first.get("effect"))) | set(first.get("class") or [])
    stated = {str(a.get("effect")): float(a.get("probability", 0.0)) for a in _others(first)}
    stated[str(first.get("effect"))] = float(first.get("probability", 0.0))
    return min(sum(stated[name] for name in stated.keys() & mates), 1.0)


def _others(entry: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return list(entry.get("alternatives") or [])


def _blocks(answer: Mapping[str, Any]) -> list[str]:
    return [str(entry.get("block")) for entry in answer.get("located") or []]


def _control(key: Mapping[str, Any], answer: Mapping[str, Any], named: tuple[str, ...]) -> dict:
    return {
        "no false alarm": answer.get("verdict") == "consistent",
        "no false physics": answer.get("verdict") in ("consistent", "parameter"),
    }


def _wrong_parameter(
    key: Mapping[str, Any], answer: Mapping[str, Any], named: tuple[str, ...]
) -> dict:
    return {
        "not called physics": answer.get("verdict") in ("parameter", "consistent"),
        "right parameter": key["effects"][0] in named,
    }


def _outside(key: Mapping[str, Any], answer: Mapping[str, Any], named: tuple[str, ...]) -> dict:
    # What comes second behind a name is no answer.
    unexplained = named[:1] == (UNEXPLAINED,)
    entries = _entries(answer)
    sure = bool(entries) and entries[0].get("probability", 0.0) >= CONFIDENT
    blocks = _blocks(answer)
    return {
        "detected": bool(named) and named[0] != NO_ANSWER,
        "unexplained": unexplained,
        "unexplained in the right block": unexplained
        and bool(blocks)
        and blocks[0] in key["blocks"][0],
        "no confident wrong name": unexplained or not sure,
    }


def _single(key: Mapping[str, Any], answer: Mapping[str, Any], named: tuple[str, ...]) -> dict:
    truth = key["effects"][0]
    if key["visibility"] == "hidden":
        unseen = {str(entry.get("effect")) for entry in answer.get("not_visible") or []}
        return {
            "consistent": answer.get("verdict") == "consistent",
            "said not visible": bool(unseen & classmates(truth)),
        }
    blocks = _blocks(answer)
    entries = _entries(answer)
    stated = set(entries[0].get("class") or []) if entries else set()
    second = [name for name in _alternatives(entries) if name not in named[:1]][:1]
    first = named[0] if named else ""
    return {
        "detected": bool(named) and first != NO_ANSWER,
        "block first": bool(blocks) and blocks[0] in key["blocks"][0],
        "name first": first == truth,
        "name in the first two": truth in (first, *second, *named[1:2]),
        "class": first in classmates(truth) or truth in stated,
        "nothing else named": not set(named) - classmates(truth) - {first, UNEXPLAINED},
    }


def _alternatives(entries: list[Mapping[str, Any]]) -> list[str]:
    if not entries:
        return []
    ranked = sorted(_others(entries[0]), key=lambda entry: -float(entry.get("probability", 0.0)))
    return [str(entry.get("effect")) for entry in ranked]


def _pair(key: Mapping[str, Any], answer: Mapping[str, Any], named: tuple[str, ...]) -> dict:
    truth = set(key["effects"])
    known = set().union(*(classmates(name) for name in truth))
    asserted = {name for name in named if name != UNEXPLAINED}
    return {
        "detected": bool(named) and named[0] != NO_ANSWER,
        "both names": truth <= asserted,
        "at least one name": bool(truth & asserted),
        "no wrong name": not (asserted - known),
    }


def _beyond(named: tuple[str, ...], truth: tuple[str, ...]) -> bool:
    """Return whether the first name lies outside everything the truth can be taken for."""
    if named[0] == UNEXPLAINED:
        return False
    return not any(named[0] in classmates(effect) for effect in truth)


def _fit_figures(key: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, float]:
    """Return residuals over the true noise, root mean square over channels."""
    found: dict[str, float] = {}
    channels = (answer.get("fit") or {}).get("channels") or {}
    for stage in ("before", "after"):
        for part in ("used", "held_back"):
            ratios = [
                float(entry[stage][part]) / key["noise"][name]
                for name, entry in channels.items()
                if name in key["noise"] and (entry.get(stage) or {}).get(part) is not None
            ]
            if ratios:
                found[f"{stage} {part}"] = math.sqrt(sum(r * r for r in ratios) / len(ratios))
    return found


def _parameter_figures(key: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, float]:
    """Return the relative error of the size, where truth and answer mean the same by it."""
    truth = key["effects"][0]
    if not truth.startswith("param."):
        if not key["shared"]:
            return {}
        entries = [entry for entry in _entries(answer) if entry.get("effect") == truth]
        values = [
            found
            for entry in entries
            for found in (entry.get("parameters") or {}).values()
            if found.get("unit", "") == key["units"][0]
        ]
        return _error(values[0], key["sizes"][0]) if values else {}
    name = truth.removeprefix("param.")
    corrected = (answer.get("corrected_parameters") or {}).get(name)
    return _error(corrected, key["parameters"][name]) if corrected else {}


def _error(found: Mapping[str, Any], true: float) -> dict[str, float]:
    value, low, high = (float(found[part]) for part in ("value", "low", "high"))
    # Sizes are positive; which direction counts as that is the law's own affair.
    ends = (low, high) if value >= 0.0 else (-high, -low)
    return {
        "parameter error": abs(abs(value) / true - 1.0),
        "inside the interval": float(ends[0] <= true <= ends[1]),
    }
