"""The parameter sets of the reproduction: as printed, and reconciled, one of each per chapter."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from types import MappingProxyType

PRINTED, RECONCILED = "printed", "reconciled"


@dataclass(frozen=True)
class ParameterSet:
    """Parameters that every row of a chapter shares.

    Attributes
    ----------
    kind : str
        ``printed`` or ``reconciled``.
    chapter : int
        Of the thesis.
    title : str
        What it is, in words.
    base : str
        What it changes or adds to.
    reason : str
        Why another set than the printed one; empty for a printed one.
    values : mapping of str to float
        In SI.
    """

    kind: str
    chapter: int
    title: str
    base: str
    reason: str
    values: Mapping[str, float]

    def __getitem__(self, key: str) -> float:
        """Return a value in SI."""
        return self.values[key]


@cache
def parameter_sets() -> tuple[ParameterSet, ...]:
    """Return all parameter sets, printed ones first, by chapter."""
    text = (files("pneuservo.thesis") / "parameter_sets.toml").read_text(encoding="utf-8")
    data = tomllib.loads(text)
    return tuple(
        _set(kind, name, entry)
        for kind in (PRINTED, RECONCILED)
        for name, entry in data[kind].items()
    )


def parameter_set(kind: str, chapter: int) -> ParameterSet:
    """Return the set of one kind and chapter.

    Parameters
    ----------
    kind : str
        ``printed`` or ``reconciled``.
    chapter : int
        Of the thesis.

    Raises
    ------
    KeyError
        When the chapter has no such set.

    Examples
    --------
    >>> parameter_set("reconciled", 8)["b0"]
    1045.0
    """
    for candidate in parameter_sets():
        if (candidate.kind, candidate.chapter) == (kind, chapter):
            return candidate
    raise KeyError(f"no {kind} parameter set for chapter {chapter}")


def _set(kind: str, name: str, entry: dict[str, float | str]) -> ParameterSet:
    words = {key: str(entry.pop(key, "")) for key in ("title", "base", "reason")}
    values = {key: float(value) for key, value in entry.items()}
    chapter = int(name.removeprefix("chapter-"))
    return ParameterSet(kind, chapter, **words, values=MappingProxyType(values))
