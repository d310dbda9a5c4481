"""The session of recordings that the values of a rig file were fitted to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from analog_card.toml_file import table_in
from pneuservo.errors import InputError


@dataclass(frozen=True)
class Session:
    """What a set of recordings, taken together, says of itself.

    Parameters
    ----------
    recordings : tuple of str
        Their names.
    misfit : mapping of str to float
        Root mean square that the repaired model leaves of each judged channel [SI].
    values : mapping of str to tuple of float
        By rig parameter or circumstance, one value per recording [SI].
    units : mapping of str to str
        The SI unit of each of the values.
    freedom : mapping of str to int
        How many of the values the fit left free to scatter: a line through two points has none.
    """

    recordings: tuple[str, ...]
    misfit: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    freedom: Mapping[str, int] = field(default_factory=dict)

    def as_table(self) -> dict[str, Any]:
        """Return it as a table for a rig file."""
        return {
            "recordings": list(self.recordings),
            "misfit": dict(self.misfit),
            "values": {
                name: {
                    "unit": self.units[name],
                    "each": list(each),
                    "freedom": self.freedom[name],
                }
                for name, each in self.values.items()
            },
        }


def read_session(table: Mapping[str, Any], where: str) -> Session | None:
    """Return the session that a rig file states.

    Parameters
    ----------
    table : mapping
        ``[diagnosis]`` of the file.
    where : str
        What messages call the table.

    Returns
    -------
    Session or None
        None when the file names no recordings.

    Raises
    ------
    InputError
        When a value is not what a diagnosis writes.

    Examples
    --------
    >>> read_session({"recordings": ["a"], "misfit": {"force": 0.7}}, "model.toml").misfit
    {'force': 0.7}
    """
    names = table.get("recordings", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InputError(f"{where} recordings: {names!r} is not a list of names")
    if not names:
        return None
    misfit = {
        channel: _number(value, f"{where} misfit {channel}")
        for channel, value in table_in(table, "misfit", where, InputError).items()
    }
    values, units, freedom = {}, {}, {}
    for name, entry in table_in(table, "values", where, InputError).items():
        each = entry.get("each") if isinstance(entry, dict) else None
        if not isinstance(each, list) or len(each) != len(names):
            raise InputError(
                f"{where} values {name}: needs a list 'each' of {len(names)} numbers, "
                "one per recording"
            )
        values[name] = tuple(_number(value, f"{where} values {name}") for value in each)
        units[name] = str(entry.get("unit", ""))
        freedom[name] = int(_number(entry.get("freedom", 0), f"{where} values {name} freedom"))
    return Session(tuple(names), misfit, values, units, freedom)


def _number(value: Any, what: str) -> float:
    # NaN fails the comparison.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise InputError(f"{what}: {value!r} is not a finite number")
    return float(value)
