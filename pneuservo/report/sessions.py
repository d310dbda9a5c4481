"""What differs between two sessions, in words."""

from collections.abc import Sequence
from typing import Any

from pneuservo.report.words import quantity

_ROUNDING = 1e-9


def between_sessions_in_words(answer: dict[str, Any]) -> list[str]:
    """Return how the recordings differ from the session that their rig was fitted to.

    Parameters
    ----------
    answer : dict
        The document of a diagnosis.

    Returns
    -------
    list of str
        Sentences; empty when the rig was not fitted to other recordings.
    """
    sessions = answer.get("sessions")
    if not sessions:
        return []
    sentences = [_misfit(sessions)]
    by_name = {f"param.{entry['what']}": entry for entry in sessions["differences"]}
    told: set[str] = set()
    for name, entry in by_name.items():
        if name not in told:
            told.update(entry["class"])
            others = [_alternative(other, by_name) for other in entry["class"] if other != name]
            sentences.append(_difference(entry, others))
    if len(sentences) == 1:
        sentences.append("No difference is larger than recordings of one session differ.")
    return sentences


def _misfit(sessions: dict[str, Any]) -> str:
    parts = []
    for channel, level in sessions["misfit"].items():
        missed = (
            f"misses the {channel.replace('_', ' ')} by {quantity(level['here'], level['unit'])}"
        )
        if level["trained"] is not None:
            missed += f", against {quantity(level['trained'], level['unit'])} there"
        parts.append(missed)
    names = ", ".join(sessions["trained_on"])
    return f"As it was fitted to {names}, the model {'; '.join(parts)}."


def _difference(entry: dict[str, Any], others: Sequence[str]) -> str:
    """Return a difference in words; one that does not vary within a session has no interval."""
    unit, step = entry["unit"], _step(entry)
    here, there = (quantity(entry[key], unit, step) for key in ("here", "trained"))
    sentence = f"{entry['what']}: {here} here, {there} there, a change of {_change(entry)}"
    if step != entry["difference"]["value"]:
        low, high = (quantity(entry["difference"][end], unit, step) for end in ("low", "high"))
        sentence += f" (95 % from {low} to {high})"
    if others:
        sentence += f"; these recordings cannot tell it from {', '.join(others)}"
    return f"{sentence}."


def _alternative(name: str, by_name: dict[str, dict[str, Any]]) -> str:
    return f"{name} ({_change(by_name[name])})" if name in by_name else name


def _change(entry: dict[str, Any]) -> str:
    return quantity(entry["difference"]["value"], entry["unit"], _step(entry))


def _step(entry: dict[str, Any]) -> float:
    """Return half the interval of a difference; all of it where nothing but rounding varies."""
    size = entry["difference"]
    half, value = 0.5 * (size["high"] - size["low"]), float(size["value"])
    return half if half > _ROUNDING * abs(value) else value
