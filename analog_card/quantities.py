"""Numbers with units, as people type them, turned into SI."""

import math
import numbers
import re
from collections.abc import Sequence
from functools import cache
from typing import Any

from analog_card.errors import InputError

# A power operator, and one that is harmless: a single digit and nothing that goes on from there.
# Anything else, such as a tower of powers, might be computed for ever.
_POWER = re.compile(r"\*\*|\^")
_SMALL_POWER = re.compile(r"(?:\*\*|\^)\s*-?\d(?!\s*(?:\d|\.|[eE][+-]?\d|\*\*|\^))")
_LONGEST = 80
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
# What may stand behind a number: a unit, perhaps 1/ ahead of it. Not another number, as behind a
# decimal comma or a space between thousands, for pint would multiply the two; nor a sum.
_UNIT = re.compile(r"(?!.*[^\s*/^(]\s+\d)(?:1?\s*/\s*)?(?![\d*/^])(?:[^,;+-]|(?<=[*^])\s*-)*")
# A power written the way people type it, as in m/s2 and cm3; pint wants s**2 and cm**3.
_TYPED_POWER = re.compile(r"\b([A-Za-zµ]+)([23])\b")


@cache
def _registry() -> Any:
    import pint

    registry: Any = pint.UnitRegistry(autoconvert_offset_to_baseunit=True)
    return registry


def to_si(value: str | float, unit: str, what: str = "value") -> float:
    """Return a quantity as a number in the given SI unit.

    Parameters
    ----------
    value : str or float
        A number with a unit, such as ``"70 ms"``; a plain number is taken to be in `unit` already.
    unit : str
        The SI unit of the result, such as ``"s"``; ``""`` for a pure number.
    what : str, optional
        What the quantity is, for the error message.

    Returns
    -------
    float
        The value [unit].

    Raises
    ------
    InputError
        When the text is not a number with a unit, the unit is unknown or has another
        dimension, or the value is not finite.

    Examples
    --------
    >>> to_si("70 ms", "s")
    0.07
    >>> to_si("5000 mm/s2", "m/s2")
    5.0
    >>> to_si(5, "V")
    5.0
    >>> to_si("20 degC", "K"), to_si("8 uV/degC", "V/K")
    (293.15, 8e-06)
    >>> to_si("6.82 bar", "kg", "load_mass")
    Traceback (most recent call last):
    analog_card.errors.InputError: load_mass: '6.82 bar' has the unit of a pressure, ...
    """
    number = _convert(value, unit, what)
    if not math.isfinite(number):
        raise InputError(f"{what}: {value!r} is not a finite number{_example(unit)}")
    return number


def to_si_all(values: Sequence[str], unit: str, what: str = "value") -> list[float]:
    """Return quantities in the given SI unit; one without a unit has the unit of the last.

    Parameters
    ----------
    values : sequence of str
        Numbers with or without a unit.
    unit : str
        The SI unit of the result; ``""`` for pure numbers.
    what : str, optional
        What the quantities are, for the error message.

    Returns
    -------
    list of float
        The values [unit].

    Raises
    ------
    InputError
        As `to_si`.

    Examples
    --------
    >>> to_si_all(["15", "24", "6 mm"], "m")
    [0.015, 0.024, 0.006]
    """
    parts = [value.strip() for value in values]
    units = [unit_of(part) for part in parts]
    return [
        to_si(part if own or not part else f"{part} {units[-1] or unit}", unit, what)
        for part, own in zip(parts, units, strict=True)
    ]


def unit_of(value: str) -> str:
    """Return the unit that a quantity is written with; empty without one.

    Examples
    --------
    >>> unit_of("6.5 bar"), unit_of("1e-3")
    ('bar', '')
    """
    return _NUMBER.sub("", value, count=1).strip()


def _is_number_with_unit(text: str) -> bool:
    number = _NUMBER.match(text)
    return number is not None and _UNIT.fullmatch(text[number.end() :].strip()) is not None


def unit_factor(found: str, unit: str, what: str = "unit") -> tuple[float, float]:
    """Return scale and offset that turn numbers in one unit into another.

    Parameters
    ----------
    found : str
        The unit the numbers are in, such as ``"mm"`` or ``"degC"``.
    unit : str
        The unit wanted, such as ``"m"`` or ``"K"``.
    what : str, optional
        Whose unit it is, for the error message.

    Returns
    -------
    scale, offset : float
        wanted = scale * found + offset.

    Raises
    ------
    InputError
        When the unit is unknown or has another dimension.

    Examples
    --------
    >>> unit_factor("mm", "m")
    (0.001, 0.0)
    """
    if _NUMBER.match(found.strip()) and not found.strip().startswith(("1/", "1 /")):
        raise InputError(f"{what}: {found!r} begins with a number; a unit alone is needed")
    at_zero = _convert(f"0 {found}", unit, what)
    scale = _convert(f"1 {found}", unit, what) - at_zero
    if not (math.isfinite(scale) and scale):
        raise InputError(f"{what}: {found!r} is not a unit")
    return scale, at_zero


def as_text(value: float, unit: str, digits: int = 12) -> str:
    """Return a quantity as people write it, with a prefix that keeps the number short.

    Parameters
    ----------
    value : float
        The value [unit].
    unit : str
        Its SI unit; ``""`` for a pure number.
    digits : int, optional
        Significant digits; with 12 `to_si` reads the same value back to one part in 10^12.

    Returns
    -------
    str
        Number and unit.

    Examples
    --------
    >>> as_text(1e-7, "F"), as_text(15054.4, "ohm", 3), as_text(0.48, "")
    ('100 nF', '15.1 kΩ', '0.48')
    """
    if not unit:
        return f"{value:.{digits}g}"
    return f"{_registry().Quantity(value, unit):.{digits}g#~P}"


def _convert(value: str | float, unit: str, what: str) -> float:
    unit = _TYPED_POWER.sub(r"\1**\2", unit)
    if isinstance(value, bool) or not isinstance(value, numbers.Real | str):
        raise InputError(f"{what}: {value!r} is not a quantity{_example(unit)}")
    if isinstance(value, numbers.Real):
        try:
            return float(value)
        except OverflowError:  # a whole number of any length
            return math.inf
    # Only texts need it; it takes long to import.
    import pint

    registry = _registry()
    harmless = len(_POWER.findall(value)) == len(_SMALL_POWER.findall(value))
    if len(value) > _LONGEST or not harmless or not _is_number_with_unit(value.strip()):
        comma = "; a decimal point is needed in place of the comma" if "," in value else ""
        raise InputError(
            f"{what}: {value[:_LONGEST]!r} cannot be read as a number with a unit"
            f"{comma}{_example(unit)}"
        )
    try:
        # Parsed as number and unit, never evaluated as an expression with functions.
        quantity = _quantity(_TYPED_POWER.sub(r"\1**\2", value.strip()))
    except Exception as problem:
        raise InputError(
            f"{what}: {value!r} cannot be read as a number with a unit{_example(unit)}"
        ) from problem
    if quantity.unitless and str(quantity.units) == "dimensionless":
        return float(quantity.magnitude)
    if unit == "Hz" and "radian" in str(quantity.to_root_units().units):
        turns = quantity.to("radian/second").magnitude / (2.0 * math.pi)
        raise InputError(f"{what}: {value!r} is an angular frequency; write {turns:g} Hz")
    try:
        return float(quantity.to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError as problem:
        wanted = _dimension(registry.Quantity(1.0, unit or "dimensionless"))
        raise InputError(
            f"{what}: {value!r} has the unit of {_dimension(quantity)}, "
            f"{wanted} is needed{_example(unit)}"
        ) from problem


def _quantity(text: str) -> Any:
    number = re.match(_NUMBER, text)
    assert number is not None
    unit = text[number.end() :].strip()
    # Per degree Celsius means per kelvin; only a unit that is a degree alone is a temperature.
    units = _registry().parse_units(f"1{unit}" if unit.startswith("/") else unit, as_delta=True)
    return _registry().Quantity(float(number.group()), units)


_DIMENSIONS = {
    "V": "a voltage",
    "A": "a current",
    "Pa": "a pressure",
    "m": "a length",
    "m**2": "an area",
    "m**3": "a volume",
    "kg": "a mass",
    "s": "a time",
    "Hz": "a frequency",
    "K": "a temperature",
    "N": "a force",
    "m/s": "a velocity",
    "m/s**2": "an acceleration",
    "ohm": "a resistance",
    "F": "a capacitance",
    "kg/s": "a mass flow",
    "": "a pure number",
}
_EXAMPLES = {
    "V": "5 V",
    "Pa": "6.5 bar",
    "m": "30 mm",
    "kg": "1.82 kg",
    "s": "70 ms",
    "Hz": "610 Hz",
    "K": "20 degC",
    "N": "5 N",
    "ohm": "120 kohm",
    "m/s**2": "5 m/s2",
    "F": "100 nF",
    "m**3": "50 cm**3",
    "": "0.7",
}


def _dimension(quantity: Any) -> str:
    for unit, name in _DIMENSIONS.items():
        if quantity.check(_registry().Quantity(1.0, unit or "dimensionless").dimensionality):
            return name
    return str(quantity.dimensionality)


def _example(unit: str) -> str:
    example = _EXAMPLES.get(unit)
    return f"; write for example {example!r}" if example else ""
