"""Units as the answer spells them."""

from typing import Any


def written(unit: str) -> str:
    """Return a unit as answers spell it.

    Parameters
    ----------
    unit : str
        SI, as the catalogue spells it.

    Examples
    --------
    >>> written("m**2")
    'm^2'
    """
    return unit.replace("**", "^")


def with_units_as_written(answer: Any) -> Any:
    """Return plain data with every unit in it spelt as the answer spells them.

    Parameters
    ----------
    answer : dict, list or anything else
        Of dicts those entries count that are called ``unit``.

    Examples
    --------
    >>> with_units_as_written([{"value": 1.0, "unit": "kg/(s*Pa**2)"}])
    [{'value': 1.0, 'unit': 'kg/(s*Pa^2)'}]
    """
    if isinstance(answer, list):
        return [with_units_as_written(entry) for entry in answer]
    if not isinstance(answer, dict):
        return answer
    return {
        key: written(entry) if key == "unit" else with_units_as_written(entry)
        for key, entry in answer.items()
    }
