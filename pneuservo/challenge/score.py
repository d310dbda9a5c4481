"""Judged cases as tables: shares with intervals, medians, and who was taken for whom."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from statistics import median

from pneuservo.challenge.classes import classmates
from pneuservo.challenge.judge import CONFIDENT, UNEXPLAINED, Judged
from pneuservo.intervals import CONFIDENCE


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Return the 95 % interval of a share.

    Parameters
    ----------
    successes, trials : int
        How often, of how many.

    Returns
    -------
    low, high : float
        Wilson's score interval (1927); 0 to 1 when nothing was tried.

    Examples
    --------
    >>> [round(bound, 3) for bound in wilson(1, 47)]
    [0.004, 0.111]
    """
    if trials == 0:
        return 0.0, 1.0
    from scipy.stats import binomtest

    found = binomtest(successes, trials).proportion_ci(CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)


@dataclass(frozen=True)
class Measure:
    """One line of the score.

    Parameters
    ----------
    group : str
        Which cases, in words.
    name : str
        What was counted.
    value : float
        Share or figure; nan without a case.
    count : int
        Cases it comes from.
    low, high : float
        95 % interval of a share; nan for a figure.
    asked : float or None
        What is asked for.
    at_least : bool
        Whether more is better.
    """

    group: str
    name: str
    value: float
    count: int
    low: float = math.nan
    high: float = math.nan
    asked: float | None = None
    at_least: bool = True

    @property
    def met(self) -> bool | None:
        """Return whether it is as asked; None when nothing is asked or nothing was counted."""
        if self.asked is None or self.count == 0:
            return None
        return self.value >= self.asked if self.at_least else self.value <= self.asked


# Group, strata, visibility, measure, asked share.
_SHARES: tuple[tuple[str, tuple[str, ...], str, str, float | None], ...] = (
    ("no effect", ("none",), "", "no false alarm", 46 / 47),
    ("no effect", ("none",), "", "no false physics", None),
    ("wrong parameter", ("wrong-parameter",), "", "not called physics", 0.95),
    ("wrong parameter", ("wrong-parameter",), "", "right parameter", None),
    *(
        (f"single, {visibility}", ("single", "noisy"), visibility, name, asked)
        for visibility, rows in (
            (
                "visible",
                (
                    ("detected", 0.95),
                    ("block first", 0.95),
                    ("name first", 0.85),
                    ("name in the first two", 0.93),
                    ("class", 0.95),
                    ("nothing else named", None),
                ),
            ),
            (
                "faint",
                (
                    ("detected", 0.50),
                    ("block first", 0.80),
                    ("name first", 0.55),
                    ("name in the first two", 0.75),
                    ("class", 0.75),
                ),
            ),
        )
        for name, asked in rows
    ),
    ("single, hidden", ("single",), "hidden", "consistent", None),
    ("single, hidden", ("single",), "hidden", "said not visible", None),
    ("single, hidden", ("single",), "hidden", "named after the experiment", 0.90),
    ("outside, visible", ("outside",), "visible", "unexplained in the right block", 0.75),
    ("outside, visible", ("outside",), "visible", "no confident wrong name", 0.90),
    ("outside, faint", ("outside",), "faint", "unexplained in the right block", 0.50),
    ("pair", ("pair",), "visible", "both names", 0.60),
    ("pair", ("pair",), "visible", "at least one name", 0.95),
    ("pair", ("pair",), "visible", "no wrong name", 0.90),
    ("missing channels", ("missing-channels",), "", "not too fine", 1.0),
    ("missing channels", ("missing-channels",), "visible", "class", None),
)
_LENIENT = {
    "name first",
    "name in the first two",
    "nothing else named",
    "both names",
    "said not visible",
    "right parameter",
    "no false physics",
    "unexplained",
}
_ONE_EFFECT = ("single", "noisy", "missing-channels")
# Group, strata, figure, what is asked at most.
_FIGURES: tuple[tuple[str, tuple[str, ...], str, float | None], ...] = (
    ("single, visible", _ONE_EFFECT, "before held_back", None),
    ("single, visible", _ONE_EFFECT, "after held_back", 1.10),
    ("pair, visible", ("pair",), "after held_back", 1.25),
    ("same formula, visible", (*_ONE_EFFECT, "wrong-parameter"), "parameter error", 0.10),
    ("all", (), "seconds", 60.0),
)


def measures(cases: Sequence[Judged]) -> list[Measure]:
    """Return the score.

    Parameters
    ----------
    cases : sequence of Judged
        Every case once.

    Returns
    -------
    list of Measure
        Shares with Wilson intervals, then medians of figures.
    """
    found = []
    for group, strata, visibility, name, asked in _SHARES:
        met = [
            case.right[name]
            for case in cases
            if case.stratum in strata and visibility in ("", case.visibility) and name in case.right
        ]
        share = sum(met) / len(met) if met else math.nan
        low, high = wilson(sum(met), len(met))
        found.append(Measure(group, name, share, len(met), low, high, asked))
    for group, strata, name, asked in _FIGURES:
        values = [
            case.figures[name]
            for case in cases
            if (not strata or (case.stratum in strata and case.visibility == "visible"))
            and not math.isnan(case.figures.get(name, math.nan))
        ]
        value = median(values) if values else math.nan
        found.append(
            Measure(group, f"median {name}", value, len(values), asked=asked, at_least=False)
        )
    return [*found, _coverage(cases), _calibration(cases)]


def confusion(cases: Sequence[Judged]) -> dict[str, dict[str, int]]:
    """Return how often each family of effects was taken for which, pairs by their first effect.

    Parameters
    ----------
    cases : sequence of Judged
        Every case once; hidden ones are left out.

    Returns
    -------
    dict of str to dict of str to int
        Concealed family to answered family to number of cases.
    """
    table: dict[str, dict[str, int]] = {}
    for case in cases:
        if case.visibility == "hidden" and case.stratum != "none":
            continue
        row = table.setdefault(case.row, {})
        row[case.column] = row.get(case.column, 0) + 1
    return table


def wrong(cases: Sequence[Judged]) -> list[Judged]:
    """Return the cases that were answered wrongly, hidden ones that were merely not seen left out.

    Parameters
    ----------
    cases : sequence of Judged
        Every case once.

    Notes
    -----
    Right is what the case's own measures ask for; of the names of a single effect its class will
    do, and of a pair one of them.
    """
    return [
        case
        for case in cases
        if any(not met for name, met in case.right.items() if name not in _LENIENT)
    ]


def _coverage(cases: Sequence[Judged]) -> Measure:
    inside = [case.figures["inside the interval"] for case in cases
              if "inside the interval" in case.figures]  # fmt: skip
    share = sum(inside) / len(inside) if inside else math.nan
    low, high = wilson(round(sum(inside)), len(inside))
    return Measure("same formula", "size inside its interval", share, len(inside), low, high)


def _calibration(cases: Sequence[Judged]) -> Measure:
    """Return the expected calibration error of what is stated of classes, over five bins."""
    stated = [
        (case.class_probability, float(case.right["class"]))
        for case in cases
        if case.probability > 0.0 and "class" in case.right
    ]
    error = 0.0
    for bin_ in range(5):
        inside = [pair for pair in stated if min(int(pair[0] * 5.0), 4) == bin_]
        if inside:
            gap = sum(p for p, _ in inside) - sum(met for _, met in inside)
            error += abs(gap) / len(stated)
    value = error if stated else math.nan
    return Measure("single", "calibration error", value, len(stated), asked=0.10, at_least=False)


_BELIED = (
    "class",
    "no wrong name",
    "no confident wrong name",
    "not called physics",
    "no false physics",
)
"""What is not right where a confident name is wrong, by the kinds of cases."""


def confident_and_wrong(cases: Sequence[Judged]) -> list[Judged]:
    """Return the cases whose first name was asserted and is outside everything it could be."""
    return [
        case
        for case in cases
        if case.probability >= CONFIDENT
        and any(case.right.get(name) is False for name in _BELIED)
        and not {UNEXPLAINED, *chain(*map(classmates, case.truth))} & set(case.named[:1])
    ]
