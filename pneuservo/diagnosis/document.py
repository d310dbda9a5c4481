"""The answer in the form of the output contract: diagnosis.json and model.toml."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pneuservo.diagnosis.diagnosis import Diagnosis
from pneuservo.diagnosis.fit import Fit, rms
from pneuservo.diagnosis.guilty_blocks import located
from pneuservo.diagnosis.judge import TIED, UNDECIDED
from pneuservo.diagnosis.models import Case
from pneuservo.diagnosis.models.model import Table
from pneuservo.diagnosis.rivals import SUREST
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.sessions import between_sessions, session_of
from pneuservo.diagnosis.side_by_side import at_a_time
from pneuservo.diagnosis.strained import OUT_OF_TOLERANCE
from pneuservo.diagnosis.unexplained import Unexplained
from pneuservo.diagnosis.units import with_units_as_written
from pneuservo.diagnosis.visibility import lookalikes, not_visible
from pneuservo.effects import CATALOGUE, effect_by_id
from pneuservo.rigs.rig_file import rig_document

SCHEMA = 1
WORTH_CORRECTING = 0.1
"""A parameter that moved by a smaller share of its tolerance is not worth correcting."""
WHOLE_TOLERANCE = 1.0
"""The same where long recordings tell every parameter better than its tolerance does, unless a law
stands beside it: parameters make up for what that lacks. (In sixteen answers of another simulator
that named an effect, a spool's frequency was corrected by one to four tolerances, and was within
one of them in each.)"""

_REPAIRED = ", repaired"


def document(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the diagnosis as plain data.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.

    Returns
    -------
    dict
        ``schema``, ``verdict``, ``located``, ``missing``, ``corrected_parameters``,
        ``cannot_separate``, ``not_visible`` and ``fit``, ready for JSON; ``partial`` too when the
        search was interrupted, ``not_judged`` when recordings could only be followed, ``sessions``
        when the rig was fitted to other recordings.
    """
    with at_a_time(diagnosis.jobs):
        answer: dict[str, Any] = with_units_as_written(_document(diagnosis))
    return answer


def _document(diagnosis: Diagnosis) -> dict[str, Any]:
    verdict = diagnosis.verdict
    missing = [_missing(diagnosis, m) for m in _effects(diagnosis.search)]
    if verdict == "unexplained" and not missing:
        missing = [_unexplained(diagnosis, 1.0)]
    elif diagnosis.named_table is not None:
        named = _tabulated(diagnosis.named_table, SUREST)
        others = [entry for entry in missing if entry["effect"] != named["effect"]]
        missing = [*(apart_from(named["effect"], entry) for entry in others), named]
    elif diagnosis.unnamed_share:
        missing.append(_unexplained(diagnosis, _doubt(diagnosis, missing)))
    corrected = _corrected(diagnosis) if verdict != "consistent" else {}
    partial = {"partial": True} if diagnosis.search.interrupted else {}
    sessions = between_sessions(diagnosis.search, diagnosis.rig)
    followed = diagnosis.only_followed
    return {
        "schema": SCHEMA,
        **partial,
        "verdict": verdict,
        "located": located(diagnosis) if verdict != "consistent" else [],
        # Where probability does not decide, in the order they were needed.
        "missing": sorted(missing, key=lambda entry: -entry["probability"]),
        "corrected_parameters": corrected,
        "cannot_separate": _cannot_separate(diagnosis, missing, corrected),
        "not_visible": [
            entry
            for entry in ([] if partial else not_visible(diagnosis.search))
            if not any(entry["effect"] in found["class"] for found in missing)
        ],
        "fit": _fit(diagnosis),
        **({"not_judged": followed} if followed else {}),
        **({"sessions": sessions} if sessions else {}),
    }


def apart_from(name: str, entry: dict[str, Any]) -> dict[str, Any]:
    """Return an entry without what is named beside it: that is no longer in its place.

    Parameters
    ----------
    name : str
        Id of the effect that is named beside it.
    entry : dict
        One of ``missing``.

    Returns
    -------
    dict
        A copy whose ``class`` and ``alternatives`` lack the name.
    """
    return entry | {
        "class": [member for member in entry["class"] if member != name],
        "alternatives": [other for other in entry["alternatives"] if other["effect"] != name],
    }


def repaired_model(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the repaired rig as a table for ``model.toml``.

    Parameters
    ----------
    diagnosis : Diagnosis
        What was found.

    Returns
    -------
    dict
        A rig file: every fitted parameter and every effect with value and interval, and what else
        the rig has that the built-in one of its kind has not.
    """
    chosen, rig = diagnosis.repaired, diagnosis.rig
    model = rig_document(replace(rig, title=f"{rig.title.removesuffix(_REPAIRED)}{_REPAIRED}"))
    for key, parameter in rig.parameters.items():
        if key in chosen.shared:
            model["parameters"][key] = model["parameters"].get(key, {}) | {
                "value": chosen.shared[key],
                "unit": parameter.unit,
                "tolerance": f"{parameter.tolerance!r} {parameter.unit}".strip(),
                "low": chosen.intervals[key][0],
                "high": chosen.intervals[key][1],
                "nominal": _nominal(diagnosis, key),
                "source": "fitted by the diagnosis",
            }
    effects = model.setdefault("effects", {})
    for member in _effects(diagnosis.search):
        effects[member] = {
            name: {key: entry[key] for key in ("value", "unit", "low", "high")}
            for name, entry in _parameters(diagnosis, member).items()
        }
    if diagnosis.unexplained is not None:
        effects[diagnosis.unexplained.table.effect] = diagnosis.unexplained.parameters
    model["diagnosis"] = {"verdict": diagnosis.verdict} | _session(diagnosis.search)
    return dict(with_units_as_written(model))


def _nominal(diagnosis: Diagnosis, key: str) -> float:
    """Return what a parameter was taken to be before anything was fitted to any recording."""
    here, there = diagnosis.search.cases[0].rig.parameters[key], diagnosis.rig.parameters[key]
    measured_anew = here.value != there.value
    return here.value if measured_anew or there.nominal is None else there.nominal


def _session(search: Search) -> dict[str, Any]:
    """Return what a rig file says of the recordings that it was fitted to."""
    if search.model.steady:
        # A recording stands once per judged channel among the cases.
        return {"recordings": list(dict.fromkeys(case.recording.name for case in search.cases))}
    return session_of(search.model, search.cases, search.chosen).as_table()


def _effects(search: Search) -> list[str]:
    return [member for member in search.accepted if not member.startswith("param.")]


def _parameters(diagnosis: Diagnosis, member: str) -> dict[str, dict[str, Any]]:
    effect, chosen = effect_by_id(member, diagnosis.model.kind), diagnosis.repaired
    found = {}
    for parameter in effect.parameters:
        key = effect.key(parameter.name)
        low, high = chosen.intervals[key]
        found[parameter.name] = {
            "value": chosen.shared[key],
            "unit": parameter.unit,
            "low": low,
            "high": high,
        }
    return found


def _derived(diagnosis: Diagnosis, member: str) -> dict[str, dict[str, Any]]:
    found = {}
    case = diagnosis.search.cases[0]
    for name, (unit, follows) in diagnosis.model.derived(case, member).items():
        value, low, high = diagnosis.repaired.interval_of(follows)
        found[name] = {"value": value, "unit": unit, "low": low, "high": high}
    return found


def _missing(diagnosis: Diagnosis, member: str) -> dict[str, Any]:
    search = diagnosis.search
    effect = effect_by_id(member, search.model.kind)
    rivals = search.rivals(member)
    own = next(rival for rival in rivals if rival.candidate == member)
    others = [rival for rival in rivals if rival.candidate not in (member, "")]
    close = [
        r.candidate
        for r in others
        if r.information_criterion < own.information_criterion + UNDECIDED
    ]
    alike = [name for name in close if name in CATALOGUE]
    alike += [name for name in search.alike(member) if name not in alike]
    probability = {rival.candidate: rival.probability for rival in rivals}
    # Where laws differ in form alone criteria of theirs say nothing; elsewhere the simpler one
    # of those that are tied is named. Either way they share what they have.
    tied = [
        rival.candidate
        for rival in others
        if -TIED < rival.information_criterion - own.information_criterion < 0.0
    ]
    together = [member, *(alike if search.model.steady else tied)]
    shared = min(sum(probability[name] for name in together), SUREST) / len(together)
    probability |= dict.fromkeys(together, shared)
    return {
        "effect": member,
        "block": search.block_of(member),
        "statement": effect.statement,
        "equation": effect.equation,
        "parameters": _parameters(diagnosis, member) | _derived(diagnosis, member),
        "probability": probability[member],
        "class": [member, *alike],
        "alternatives": [
            {"effect": rival.candidate, "probability": probability[rival.candidate]}
            for rival in others[:5]
        ],
    }


def _doubt(diagnosis: Diagnosis, missing: list[dict[str, Any]]) -> float:
    """Lower the probability of effects that explain little beside what has no name.

    Returns the probability that something without a name is at work.
    """
    unnamed = diagnosis.unnamed_share
    if diagnosis.holds_nameless:
        for entry in missing:
            entry["probability"] *= 1.0 - unnamed
        return unnamed
    doubts = []
    for entry in missing:
        share = max(diagnosis.search.share(entry["effect"]), 0.0)
        doubts.append(unnamed / (share + unnamed))
        entry["probability"] *= 1.0 - doubts[-1]
    # Beside a parameter alone no effect is doubted.
    return max(doubts, default=unnamed)


def _unexplained(diagnosis: Diagnosis, probability: float) -> dict[str, Any]:
    if diagnosis.unexplained is not None:
        return _tabulated(diagnosis.unexplained, min(probability, SUREST))
    return {
        "effect": "unexplained",
        "block": _guilty(diagnosis),
        "statement": _nothing_explains(diagnosis),
        "equation": "",
        "parameters": {},
        "probability": min(probability, SUREST),
        "class": ["unexplained"],
        "alternatives": [],
    }


def _nothing_explains(diagnosis: Diagnosis) -> str:
    if diagnosis.search.interrupted and diagnosis.misfit is None:
        return "The search was interrupted before anything explained what is left."
    return f"Nothing in the catalogue explains what is left{_look(diagnosis)}."


def _look(diagnosis: Diagnosis) -> str:
    """Return what has neither a name nor a table, in words."""
    if diagnosis.misfit is not None:
        return f": {diagnosis.misfit.words}"
    found = diagnosis.left_over
    if not found.beyond_chance:
        return "; it depends on nothing that was recorded"
    return f"; it depends on {found.name}, which accounts for {found.share:.0%} of it"


def _tabulated(found: Unexplained, probability: float) -> dict[str, Any]:
    name = found.table.form_of
    what = CATALOGUE[name].statement if name else "Nothing in the catalogue explains what is left."
    return {
        "effect": name or "unexplained",
        "block": found.table.block,
        "statement": (
            f"{what} Its shape: {found.shape}. "
            f"The repaired model holds it as a table{_whose(found.table)}."
        ),
        "equation": f"{found.table.effect} = table({found.table.quantity})",
        "parameters": found.parameters,
        "probability": probability,
        "class": [name or "unexplained"],
        "alternatives": [],
    }


def _whose(table: Table) -> str:
    """Return of which recording a table is listed, where each has one of its own."""
    return ", that of the recording in which it varies most" if table.own else ""


def _guilty(diagnosis: Diagnosis) -> str:
    """Return the block that most of what is left belongs to."""
    suspects = diagnosis.suspects
    return max(suspects, key=lambda block: suspects[block])


def _corrected(diagnosis: Diagnosis) -> dict[str, dict[str, Any]]:
    chosen, case = diagnosis.repaired, diagnosis.search.cases[0]
    corrected, worth = {}, WORTH_CORRECTING
    if diagnosis.model.steady:
        beside_a_law = chosen.hypothesis.effects or diagnosis.holds_nameless
        worth = OUT_OF_TOLERANCE if beside_a_law else WHOLE_TOLERANCE
    for key in diagnosis.model.fitted_to(diagnosis.search.cases):
        parameter, (low, high) = case.rig.parameters[key], chosen.intervals[key]
        moved = abs(chosen.shared[key] - parameter.value) > worth * parameter.tolerance
        if moved and not parameter.free and not low <= parameter.value <= high:
            corrected[key] = {
                "value": chosen.shared[key],
                "unit": parameter.unit,
                "low": low,
                "high": high,
            }
    return corrected


def _cannot_separate(
    diagnosis: Diagnosis, missing: list[dict[str, Any]], corrected: dict[str, Any]
) -> list[dict[str, Any]]:
    groups = [entry["class"] for entry in missing]
    groups += [lookalikes(diagnosis.search, parameter) for parameter in corrected]
    apart = []
    for group in groups:
        kind = diagnosis.model.kind
        named = [effect_by_id(name, kind).experiment for name in group if name in CATALOGUE]
        if len(group) > 1 and named:
            apart.append({"effects": group, "experiment": named[0]})
    return apart


def _fit(diagnosis: Diagnosis) -> dict[str, Any]:
    search, held_back = diagnosis.search, diagnosis.held_back
    units = {case.channel: case.unit for case in search.cases if case.recorded}
    # The noise that decided: an answer would contradict itself by another.
    noise = [
        np.full(len(r), level)
        for r, level in zip(search.baseline.residuals, search.unit_of_noise, strict=True)
    ]
    return {
        "channels": {
            channel: {
                "noise_rms": _rms_in(channel, noise, search.cases),
                "unit": unit,
                "before": {
                    "used": _rms_in(channel, search.baseline.residuals, search.cases),
                    "held_back": _held_back(channel, diagnosis.before_held_back, held_back),
                },
                "after": {
                    "used": _rms_in(channel, diagnosis.repaired.residuals, search.cases),
                    "held_back": _held_back(channel, diagnosis.after_held_back, held_back),
                },
            }
            for channel, unit in units.items()
        }
    }


def _held_back(channel: str, found: Fit | None, cases: Sequence[Case]) -> float | None:
    if found is None or channel not in found.channels:
        return None
    return _rms_in(channel, found.residuals, cases)


def _rms_in(channel: str, residuals: Sequence[Any], cases: Sequence[Case]) -> float:
    """Return the root mean square of what is left of a channel in all recordings [SI]."""
    return rms(
        [
            residual * case.scale
            for residual, case in zip(residuals, cases, strict=True)
            if case.channel == channel
        ]
    )
