"""Numbers and findings in words."""

import math
from typing import Any

UNITS = {
    "Pa": (1e-5, "bar"),
    "Pa/s": (1e-2, "mbar/s"),
    "m**2": (1e6, "mm²"),
    "kg/s": (1e6, "mg/s"),
    "V": (1e3, "mV"),
    "m": (1e3, "mm"),
    "m/s": (1e3, "mm/s"),
    "": (1.0, ""),
}
"""What people use in place of a unit of the SI: its scale and its name."""

_LIKELY = 0.5
"""Below this probability an effect is only claimed as one of its class."""

_STANDS_OUT = 1.5
"""So many times what is left of the recordings used, and the noise, is no chance: it is known to a
tenth."""
_WORSE = 1.2
"""So many times what the baseline leaves, and the noise, is worth a word."""


def quantity(value: float | None, unit: str, step: float = 0.0) -> str:
    """Return a number with three significant digits and a unit that people use.

    Parameters
    ----------
    value : float or None
        In SI.
    unit : str
        SI unit.
    step : float, optional
        A difference of which two digits have to show, where three of the value are too few [SI].

    Returns
    -------
    str
        Such as ``"0.503 mbar/s"``; a dash for None.

    Examples
    --------
    >>> quantity(502.9, "Pa"), quantity(1.6e-6, "kg/s"), quantity(None, "N")
    ('0.00503 bar', '1.6 mg/s', '–')
    >>> quantity(0.0252132, "m"), quantity(0.0252132, "m", step=2e-5)
    ('25.2 mm', '25.213 mm')
    """
    if value is None or not math.isfinite(value):
        return "–"
    unit = unit.replace("^", "**")
    scale, name = UNITS.get(unit, (1.0, unit.replace("**2", "²").replace("**3", "³")))
    digits = 3
    if value and step and math.isfinite(step):
        digits = max(digits, _magnitude(value) - _magnitude(step) + 2)
    return f"{value * scale:.{digits}g} {name.replace('**', '^').replace('*', ' ')}".strip()


def _magnitude(value: float) -> int:
    return math.floor(math.log10(abs(value)))


def not_judged_in_words(answer: dict[str, Any]) -> list[str]:
    """Return what is said of recordings that could only be followed.

    Parameters
    ----------
    answer : dict
        The document of a diagnosis.

    Returns
    -------
    list of str
        A sentence; none when all were judged.

    Examples
    --------
    >>> not_judged_in_words({})
    []
    >>> print(*not_judged_in_words({"not_judged": ["step"]}))
    What the command of step did between its samples is not known: nothing is named that shows there
    alone; record it faster.
    """
    names = answer.get("not_judged", [])
    if not names:
        return []
    return [
        f"What the command of {' and '.join(names)} did between its samples is not known: nothing "
        "is named that shows there alone; record it faster."
    ]


def headline(answer: dict[str, Any]) -> str:
    """Return the answer of a diagnosis in a sentence, and what should lower one's trust in it.

    Parameters
    ----------
    answer : dict
        The document of a diagnosis.

    Returns
    -------
    str
        One sentence; a second where far more than noise is left, and one where what was held back
        is predicted far worse than what was used is followed, or worse than by the baseline.
    """
    channels = answer["fit"]["channels"]
    left = _still_left(answer) if answer["verdict"] != "unexplained" else ""
    return _answered(answer) + left + (_not_predicted(channels) or _predicted_worse(channels))


def _answered(answer: dict[str, Any]) -> str:
    """Return the answer in one sentence."""
    channel, fit = _most_improved(answer["fit"]["channels"])
    name, unit = channel.replace("_", " "), fit["unit"]
    before, after = fit["before"]["used"], fit["after"]["used"]
    old, new = quantity(before, unit), quantity(after, unit)
    change = f"the misfit of the {name} " + (
        f"falls from {old} to {new}" if old != new else f"stays at {new}"
    )
    if answer["verdict"] == "consistent":
        beyond = "no effect in the catalogue does better than chance"
        if answer.get("partial"):
            beyond = "not all of what the catalogue would explain had been asked"
        return (
            f"The simulation agrees with the recordings: it misses the {name} by "
            f"{quantity(after, unit)}, and {beyond}."
        )
    if answer["verdict"] == "parameter":
        names = ", ".join(answer["corrected_parameters"]) or "a parameter"
        return f"A parameter is off ({names}), and no effect explains more: {change}."
    if answer["verdict"] == "unexplained":
        channel, left = farthest_off(answer["fit"]["channels"])
        much = quantity(left["after"]["used"], left["unit"])
        name = channel.replace("_", " ")
        return f"{answer['missing'][0]['statement']} What is left of the {name} is {much}."
    # What has no name is said last: it is what is left beside the names.
    named = sorted(answer["missing"], key=lambda entry: entry["effect"] == "unexplained")
    statements = " ".join(_claim(entry) for entry in named)
    return f"{statements} With that in the model {change}."


def _most_improved(channels: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the channel whose misfit falls most, and its figures."""
    return max(
        channels.items(),
        key=lambda item: item[1]["before"]["used"] / max(item[1]["after"]["used"], 1e-300),
    )


def farthest_off(channels: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the channel of which most is left, in its noise, and its figures.

    Parameters
    ----------
    channels : dict
        Of the answer's ``fit``.
    """
    return max(
        channels.items(),
        key=lambda item: item[1]["after"]["used"] / max(item[1]["noise_rms"], 1e-300),
    )


def _still_left(answer: dict[str, Any]) -> str:
    """Return a sentence on the channel that is missed most, if that is far more than noise."""
    channel, fit = farthest_off(answer["fit"]["channels"])
    times = fit["after"]["used"] / max(fit["noise_rms"], 1e-300)
    if times <= _STANDS_OUT:
        return ""
    name, left = channel.replace("_", " "), quantity(fit["after"]["used"], fit["unit"])
    return f" Not all is explained: {left} of the {name} are left, {times:.2g} times its noise."


def _not_predicted(channels: dict[str, Any]) -> str:
    """Return a sentence on the channel that is predicted worst, if one stands out."""
    worst, times = _missed_most(channels, "after", "used")
    if times <= _STANDS_OUT:
        return ""
    fit = channels[worst]
    left = quantity(fit["after"]["held_back"], fit["unit"])
    words = (
        f" What was held back is not predicted as well: {left} of the {worst.replace('_', ' ')} "
        f"are left there, {times:.2g} times as much"
    )
    if fit["after"]["used"] < fit["before"]["used"] and _as_much(fit):
        return f"{words}, by the baseline too: what was found is not why."
    return f"{words}. Something is different there, or shows that does not in the others."


def _predicted_worse(channels: dict[str, Any]) -> str:
    """Return a sentence on the channel that the baseline predicted better, if there is one."""
    worst, times = _missed_most(channels, "before", "held_back")
    if times <= _WORSE:
        return ""
    fit = channels[worst]
    before, after = (quantity(fit[when]["held_back"], fit["unit"]) for when in ("before", "after"))
    return (
        f" Of the {worst.replace('_', ' ')} that was held back the baseline leaves less: "
        f"{before}, not {after}."
    )


def _missed_most(channels: dict[str, Any], when: str, what: str) -> tuple[str, float]:
    """Return the channel missed most where it was held back, and how many times as much.

    As is left of it, or in its noise, by the figure that `when` and `what` name.
    """
    times = {
        name: fit["after"]["held_back"] / max(fit[when][what], fit["noise_rms"], 1e-300)
        for name, fit in channels.items()
        if fit["after"]["held_back"] is not None
    }
    return max(times.items(), key=lambda item: item[1], default=("", 0.0))


def _as_much(fit: dict[str, Any]) -> bool:
    """Return whether the baseline leaves as much of a channel that was held back."""
    return bool(fit["after"]["held_back"] > fit["before"]["held_back"] / _STANDS_OUT)


def _claim(entry: dict[str, Any]) -> str:
    """Return what is claimed of one effect: no more than its class when that is all there is."""
    if entry["probability"] >= _LIKELY or entry["effect"] == "unexplained":
        return str(entry["statement"])
    physics, _, _ = entry["statement"].partition(";")
    physics = f"{physics[0].lower()}{physics[1:]}".rstrip(".")
    rivals = entry["class"][1:]
    if not rivals:
        return f"It may be that {physics}, but more likely that only stands in for something else."
    return (
        f"It looks as if {physics}, but these recordings cannot tell that from {', '.join(rivals)}."
    )
