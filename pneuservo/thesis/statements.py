"""Rows for what the thesis states in words."""

from dataclasses import dataclass

from pneuservo.thesis.rows import IN_KIND, NOT, REPRODUCED, Row


@dataclass(frozen=True)
class Finding:
    """What we find where the thesis states something in words.

    Attributes
    ----------
    holds : bool
        Whether the statement is true of it.
    words : str
        What it is, with its numbers.
    """

    holds: bool
    words: str


def statement_row(
    id: str,  # noqa: A002 - the name of the field
    what: str,
    stated: str,
    printed: Finding | None,
    source: str,
    reason: str = "",
    reconciled: Finding | None = None,
    in_kind: bool = False,
) -> Row:
    """Return the row of a statement in words.

    Parameters
    ----------
    id, what, stated, source, reason
        As in `pneuservo.thesis.rows.Row`. The reason is kept only where the statement is not
        simply reproduced.
    printed, reconciled : Finding, optional
        Ours with either set of parameters.
    in_kind : bool, optional
        Whether what holds only in part is called ``in kind``, or what does not hold ``not``.

    Examples
    --------
    >>> found = Finding(True, "9 of 9 unstable")
    >>> statement_row("5.17", "retraction gains", "unstable", found, "Fig 5.17").verdict
    'reproduced'
    """
    findings = [finding for finding in (printed, reconciled) if finding is not None]
    if any(finding.holds for finding in findings) and not in_kind:
        verdict = REPRODUCED
    else:
        verdict = IN_KIND if in_kind else NOT
    words = [finding.words if finding else None for finding in (printed, reconciled)]
    return Row(id, what, "", stated, words[0], words[1], verdict, reason, source)
