"""The reproduction as a page, and as plain values."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from analog_card.plain_json import plain_json
from pneuservo.thesis.chapters import Chapter
from pneuservo.thesis.parameter_sets import ParameterSet, parameter_sets
from pneuservo.thesis.rows import IN_KIND, NOT, REPRODUCED, Row, Value

VERDICTS = (REPRODUCED, IN_KIND, NOT)
_SIGNIFICANT = 4


def write_reproduction(chapters: Sequence[Chapter], page: Path) -> str:
    """Return the text of the page.

    Parameters
    ----------
    chapters : sequence of Chapter
        Recomputed.
    page : Path
        Where it will stand; pictures are named from there.

    Returns
    -------
    str
        Markdown.
    """
    template = (files("pneuservo.thesis") / "reproduction.md.jinja").read_text(encoding="utf-8")
    # Markdown, of our own words and numbers only.
    environment = Environment(  # noqa: S701
        undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    environment.filters |= {"value": shown, "percent": percent, "cell": cell}
    return environment.from_string(template).render(
        chapters=[
            {
                "chapter": chapter,
                "counts": counts(chapter.rows),
                "sets": _sets_of(chapter.number),
                "pictures": [
                    picture.relative_to(page.parent).as_posix() for picture in chapter.pictures
                ],
            }
            for chapter in chapters
        ],
        total=counts([row for chapter in chapters for row in chapter.rows]),
        verdicts=VERDICTS,
    )


def to_dict(chapters: Sequence[Chapter]) -> dict[str, object]:
    """Return everything as plain values, for JSON; what is no number there is null.

    Parameters
    ----------
    chapters : sequence of Chapter
        Recomputed.
    """
    rows = [row for chapter in chapters for row in chapter.rows]
    return {
        "rows": [
            {
                **{key: plain_json(value) for key, value in asdict(row).items()},
                "printed_difference": plain_json(row.printed_difference),
                "reconciled_difference": plain_json(row.reconciled_difference),
            }
            for row in rows
        ],
        "verdicts": counts(rows),
        "parameter_sets": [
            {"kind": s.kind, "chapter": s.chapter, "title": s.title, "values": dict(s.values)}
            for s in parameter_sets()
        ],
        "pictures": [str(picture) for chapter in chapters for picture in chapter.pictures],
    }


def counts(rows: Sequence[Row]) -> dict[str, int]:
    """Return how many rows have each verdict."""
    found = Counter(row.verdict for row in rows)
    return {verdict: found[verdict] for verdict in VERDICTS}


def shown(value: Value) -> str:
    """Return a value as people read it: four significant digits.

    Examples
    --------
    >>> shown(203.4), shown(1664.66), shown(-0.0514), shown("stable"), shown(None)
    ('203.4', '1665', '-0.0514', 'stable', '')
    """
    if value is None:
        return ""
    if isinstance(value, str):
        return cell(value)
    if not math.isfinite(value):
        return "none"
    if value == 0.0:
        return "0"
    magnitude = math.floor(math.log10(abs(value)))
    if -4 <= magnitude < 6:
        digits = max(_SIGNIFICANT - 1 - magnitude, 0)
        text = f"{value:.{digits}f}"
        return text.rstrip("0").rstrip(".") if "." in text else text
    return f"{value:.{_SIGNIFICANT - 1}e}"


def percent(difference: float | None) -> str:
    """Return a relative difference in percent, empty for None.

    Examples
    --------
    >>> percent(-0.0078), percent(None)
    ('-0.8 %', '')
    """
    if difference is None or not math.isfinite(difference):
        return ""
    return f"{100.0 * difference:+.1f} %"


def cell(text: str) -> str:
    """Return text that can stand in a table's cell."""
    return text.replace("|", "\\|").replace("\n", " ")


def _sets_of(chapter: int | str) -> list[ParameterSet]:
    return [candidate for candidate in parameter_sets() if candidate.chapter == chapter]
