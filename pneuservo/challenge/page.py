"""The trial as a page in Markdown: the score, who was taken for whom, and every wrong answer."""

import math
from collections.abc import Sequence
from statistics import median

from pneuservo.challenge.judge import Judged
from pneuservo.challenge.score import Measure, confident_and_wrong, confusion, measures, wrong
from pneuservo.challenge.trial import Trial, judge_cases

_HEAD = """# The concealed-effect trial

Blind cases from a simulator that shares no code, no integrator and, where it matters, no formula
with the diagnosis: chambers by mass and energy with a wall where heat is the effect, flow by an
expansion factor, friction by elements that slip one after the other, hysteresis by relays, hoses
of ten cells, leaks half viscous and half kinetic (`pneuservo/challenge`). Without an effect both
follow the baseline's law, so that what they differ by is far below the noise.

How visible an effect is, d', is decided by the trial and not by the tool: the norm of what the
effect changes in the recordings over their noise, after every tolerated parameter and the start
of every half second has explained what it can. Visible is d' of 10 and more, faint 4 to 10,
hidden below 4. Keys are sealed before the first diagnosis: the hashes are in `commitments.json`.
"""


def trial_page(trials: Sequence[tuple[Trial, Sequence[Judged]]]) -> str:
    """Return the page of one or more trials, each with a seed of its own.

    Parameters
    ----------
    trials : sequence of (Trial, sequence of Judged)
        Trials and their judged cases.

    Returns
    -------
    str
        Markdown.
    """
    return "\n".join([_HEAD, *(_one(trial, judged) for trial, judged in trials)])


def _one(trial: Trial, judged: Sequence[Judged]) -> str:
    visible = [case.figures["visibility"] for case in judged if case.visibility == "visible"]
    middle = f"{median(visible):.0f}" if visible else "none"
    lines = [
        f"## Seed {trial.seed}: {len(judged)} of {trial.cases} cases",
        "",
        f"Program diagnosed with: {', '.join(trial.programs)}"
        + (" (frozen)." if len(trial.programs) == 1 else ": **not frozen**."),
        f"Median visibility of the visible ones: {middle}.",
        "",
        "| cases | measure | asked | found | 95 % interval | of |",
        "| --- | --- | --- | --- | --- | --- |",
        *(_line(found) for found in measures(judged)),
        "",
        *_ablations(trial, judged),
        "### Who was taken for whom",
        "",
        *_confusion(judged),
        "",
        f"### Wrong answers ({len(wrong(judged))}, of which "
        f"{len(confident_and_wrong(judged))} a confident wrong name)",
        "",
        "| case | of | concealed | d' | answered | probability | missed |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        *(_wrong(case) for case in wrong(judged)),
        "",
    ]
    return "\n".join(lines)


def _ablations(trial: Trial, judged: Sequence[Judged]) -> list[str]:
    """Return the score with parts of the diagnosis left out in turn, on the cases both have."""
    if not trial.ablations:
        return []
    lines = [
        "### With a part left out",
        "",
        "An omission that does not hurt is a part that can go.",
        "",
        "| cases | measure | everything | "
        + " | ".join(f"without {name}" for name in trial.ablations)
        + " |",
        "| --- | --- | --- |" + " --- |" * len(trial.ablations),
    ]
    others = [judge_cases(trial, name) for name in trial.ablations]
    common = set.intersection(*({case.case for case in cases} for cases in (judged, *others)))
    tables = [
        measures([case for case in cases if case.case in common]) for cases in (judged, *others)
    ]
    for row in zip(*tables, strict=True):
        if row[0].asked is not None and row[0].count:
            values = " | ".join(f"{found.value:.3g}" for found in row)
            lines.append(f"| {row[0].group} | {row[0].name} | {values} |")
    return [*lines, ""]


def _line(found: Measure) -> str:
    # Without a case there is nothing to say.
    if found.count == 0:
        return f"| {found.group} | {found.name} | {_asked(found)} | - | - | 0 |"
    share = not math.isnan(found.low)
    value = f"{100.0 * found.value:.0f} %" if share else f"{found.value:.3g}"
    interval = f"{100.0 * found.low:.0f} to {100.0 * found.high:.0f} %" if share else "-"
    mark = {True: " (met)", False: " (**missed**)", None: ""}[found.met]
    return (
        f"| {found.group} | {found.name} | {_asked(found)} | {value}{mark} "
        f"| {interval} | {found.count} |"
    )


def _asked(found: Measure) -> str:
    if found.asked is None:
        return "-"
    sign = "≥" if found.at_least else "≤"
    share = not math.isnan(found.low)
    return f"{sign} {100.0 * found.asked:.0f} %" if share else f"{sign} {found.asked:g}"


def _confusion(judged: Sequence[Judged]) -> list[str]:
    table = confusion(judged)
    columns = sorted({column for row in table.values() for column in row})
    return [
        "Rows: concealed. Columns: first name of the answer. Hidden cases are left out.",
        "",
        f"| | {' | '.join(columns)} |",
        f"| --- |{' --- |' * len(columns)}",
        *(
            f"| **{name}** | {' | '.join(str(row.get(column, '')) for column in columns)} |"
            for name, row in sorted(table.items())
        ),
    ]


def _wrong(case: Judged) -> str:
    missed = ", ".join(name for name, met in case.right.items() if not met)
    return (
        f"| {case.case} | {case.stratum} | {', '.join(case.truth)} "
        f"| {case.figures['visibility']:.0f} | {', '.join(case.named) or 'consistent'} "
        f"| {case.probability:.2f} | {missed} |"
    )
