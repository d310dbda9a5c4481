"""What JSON can hold of an answer."""

import math
from typing import Any


def plain_json(value: Any) -> Any:
    """Return the same with None for what JSON has no number for.

    Parameters
    ----------
    value : object
        Dictionaries, lists and tuples of anything; tuples become lists.

    Examples
    --------
    >>> plain_json({"settling_time": float("nan"), "tried": (1.0, float("inf"))})
    {'settling_time': None, 'tried': [1.0, None]}
    """
    if isinstance(value, dict):
        return {key: plain_json(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [plain_json(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
