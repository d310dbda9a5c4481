"""One row of the reproduction: what the thesis states, what we find, and whether they agree."""

import math
from dataclasses import dataclass

# Verdicts, and within what a number counts as reproduced.
REPRODUCED, IN_KIND, NOT = "reproduced", "in kind", "not"
REPRODUCED_WITHIN = 0.03

Value = float | str | None


@dataclass(frozen=True)
class Row:
    """A stated result of the thesis beside ours.

    Attributes
    ----------
    id : str
        Unique; chapter, table and quantity, such as ``8.1-nyquist-frequency``.
    what : str
        The result, in words.
    unit : str
        Of all three values; empty for a pure number or a statement in words.
    stated : float, str or None
        The thesis' value, or its statement in words.
    printed : float, str or None
        Ours with the parameters as printed (after corrections of the scan); None when there is no
        such value.
    reconciled : float, str or None
        Ours with the chapter's reconciled parameters; None when the chapter has none.
    verdict : str
        ``reproduced`` (a number within 3 %), ``in kind`` or ``not``.
    reason : str
        Why, when it is not simply reproduced; also where the thesis contradicts itself.
    source : str
        Where it stands in the thesis.

    Raises
    ------
    ValueError
        When the verdict is none of the three, or anything but ``reproduced`` goes without a reason.
    """

    id: str
    what: str
    unit: str
    stated: Value
    printed: Value
    reconciled: Value
    verdict: str
    reason: str
    source: str

    def __post_init__(self) -> None:
        """Refuse a verdict without ground."""
        if self.verdict not in (REPRODUCED, IN_KIND, NOT):
            raise ValueError(f"row {self.id}: verdict {self.verdict!r}")
        if self.verdict != REPRODUCED and not self.reason:
            raise ValueError(f"row {self.id}: verdict {self.verdict!r} needs a reason")

    @property
    def printed_difference(self) -> float | None:
        """Return (printed - stated)/|stated|; None when either is no number."""
        return relative_difference(self.stated, self.printed)

    @property
    def reconciled_difference(self) -> float | None:
        """Return (reconciled - stated)/|stated|; None when either is no number."""
        return relative_difference(self.stated, self.reconciled)


def relative_difference(stated: Value, ours: Value) -> float | None:
    """Return (ours - stated)/|stated|; None when either is no number or nothing is stated.

    Parameters
    ----------
    stated, ours : float, str or None
        In the same unit.

    Examples
    --------
    >>> relative_difference(200.0, 203.0)
    0.015
    >>> relative_difference("stable", 1.0) is None
    True
    """
    if not isinstance(stated, int | float) or not isinstance(ours, int | float) or stated == 0:
        return None
    return (ours - stated) / abs(stated)


def verdict(stated: Value, *ours: Value, in_kind: bool = False) -> str:
    """Return whether a number is reproduced by either set of parameters.

    Parameters
    ----------
    stated : float, str or None
        The thesis' value.
    *ours : float, str or None
        Ours with the printed and with the reconciled parameters.
    in_kind : bool, optional
        What to call a number further off: the same behaviour with another figure, or not.

    Returns
    -------
    str
        ``reproduced`` when one of ours lies within 3 % of the stated value.

    Examples
    --------
    >>> verdict(203.4, 193.4, 201.8), verdict(203.4, 193.4), verdict(203.4, 193.4, in_kind=True)
    ('reproduced', 'not', 'in kind')
    """
    differences = [relative_difference(stated, value) for value in ours]
    near = [d for d in differences if d is not None and math.isfinite(d)]
    if any(abs(d) <= REPRODUCED_WITHIN for d in near):
        return REPRODUCED
    return IN_KIND if in_kind else NOT


def number_row(
    id: str,  # noqa: A002 - the name of the field
    what: str,
    unit: str,
    stated: float,
    printed: float | None,
    reconciled: float | None,
    source: str,
    reason: str = "",
    in_kind: bool = False,
) -> Row:
    """Return the row of a number, with its verdict by `verdict`.

    Parameters
    ----------
    id, what, unit, stated, printed, reconciled, source, reason
        As in `Row`. The reason is needed when the number is not reproduced.
    in_kind : bool, optional
        As in `verdict`.

    Examples
    --------
    >>> number_row("8.1-f", "limit cycle", "Hz", 203.4, 193.4, 201.8, "Table 8.1").verdict
    'reproduced'
    """
    return Row(
        id,
        what,
        unit,
        stated,
        printed,
        reconciled,
        verdict(stated, printed, reconciled, in_kind=in_kind),
        reason,
        source,
    )
