"""Noise and range of a rig's transducers, as its file states them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from analog_card.errors import InputError as QuantityError
from analog_card.quantities import to_si
from pneuservo.errors import InputError
from pneuservo.naming import require_known

_UNITS = {
    "single-axis": {"displacement": "m", "pressure": "Pa"},
    "dead-volume": {"pressure": "Pa"},
}


@dataclass(frozen=True)
class Transducer:
    """What keeps a transducer's reading from being exact; the default is exact.

    Parameters
    ----------
    noise : float, optional
        Standard deviation of a reading; each is drawn anew [m] or [Pa].
    low, high : float, optional
        Least and largest reading; what lies beyond reads as these [m] or [Pa].
    """

    noise: float = 0.0
    low: float = -math.inf
    high: float = math.inf

    def as_table(self) -> dict[str, float | list[float]]:
        """Return what a rig file says of it, in SI."""
        return {"noise": self.noise, "range": [self.low, self.high]}


def read_transducers(table: Mapping[str, Any], kind: str, where: str) -> dict[str, Transducer]:
    """Return the transducers that a rig file states.

    Parameters
    ----------
    table : mapping
        ``[transducers]`` of the file: by ``displacement`` and ``pressure`` a table with ``noise``
        and ``range``, a pair.
    kind : str
        Of the rig.
    where : str
        What messages call the table.

    Returns
    -------
    dict of str to Transducer
        In SI.

    Raises
    ------
    InputError
        When a key is not known, or a value is not one a transducer can have.

    Examples
    --------
    >>> table = {"pressure": {"noise": "0.5 kPa", "range": ["0 bar", "21.7 bar"]}}
    >>> read_transducers(table, "single-axis", "rig.toml")["pressure"]
    Transducer(noise=500.0, low=0.0, high=2170000.0)
    """
    units = _UNITS.get(kind, {})
    found = {}
    for name, entry in table.items():
        if not units:
            raise InputError(f"{where}: a rig of kind {kind} has none that can be simulated")
        require_known(name, units, where)
        if not isinstance(entry, dict):
            raise InputError(f"{where} {name}: has to be a table with noise, range or both")
        for key in entry:
            require_known(key, ("noise", "range"), f"{where} {name}")
        found[name] = _transducer(entry, units[name], f"{where} {name}")
    return found


def _transducer(entry: Mapping[str, Any], unit: str, what: str) -> Transducer:
    span = entry.get("range", (-math.inf, math.inf))
    if not isinstance(span, list | tuple) or len(span) != 2:
        raise InputError(f"{what}: range is {span!r}; it has to be a pair, least and largest")
    try:
        noise = to_si(entry.get("noise", 0.0), unit, f"{what} noise")
        low, high = (value if _is_endless(value) else to_si(value, unit, what) for value in span)
    except QuantityError as problem:
        raise InputError(str(problem)) from problem
    if not noise >= 0.0:
        raise InputError(f"{what}: noise is {noise:g} {unit}; it has to be 0 or more")
    if not low < high:
        raise InputError(f"{what}: range is {low:g} to {high:g} {unit}; it has to be rising")
    return Transducer(noise, low, high)


def _is_endless(value: Any) -> bool:
    return isinstance(value, float) and math.isinf(value)
