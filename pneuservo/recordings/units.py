"""Units in sidecars: turned into SI, refused when unknown; gauge pressures told apart."""

import math
import re
from dataclasses import dataclass
from typing import Any

from analog_card.errors import InputError as QuantityError
from analog_card.quantities import unit_factor
from pneuservo.errors import InputError
from pneuservo.naming import nearest

_ONE = "1"
"""How the unit of a pure number is written."""
# What is offered in messages, by SI unit: the kind of quantity and how people write its units.
_KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "s": ("a time", ("s", "ms", "us")),
    "Hz": ("a frequency", ("Hz", "kHz")),
    "m": ("a length", ("m", "mm", "um", "inch")),
    "m/s": ("a velocity", ("m/s", "mm/s")),
    "m/s**2": ("an acceleration", ("m/s**2", "g_0")),
    "Pa": ("a pressure", ("Pa", "kPa", "MPa", "bar", "mbar", "psi")),
    "K": ("a temperature", ("K", "degC", "degF")),
    "V": ("a voltage", ("V", "mV")),
    "N": ("a force", ("N", "kN", "kgf", "lbf")),
    "kg": ("a mass", ("kg", "g")),
    "": ("a pure number", (_ONE, "percent")),
}
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*")
_SYMBOLS = re.compile(r"[A-Za-z°µμΩ%][A-Za-z0-9_°µμΩ²³%./*^() -]{0,39}")
_POWER = re.compile(r"(?:\*\*|\^)\s*-?\d(?!\s*(?:\d|\.|\*\*|\^))")
_FREE_DIGIT = re.compile(r"(?<![A-Za-z0-9_])\d|\*\*|\^")
_SQUARE_OR_CUBE = re.compile(r"(?<=[A-Za-z])([23])(?![A-Za-z0-9])")
_REFERENCE_WORD = re.compile(r"(.*\S)\s+(gauge|absolute|abs)", re.IGNORECASE)
_REFERENCE_MARK = re.compile(r"(m?bar|psi|[kM]?Pa)(?:\((g|a)\)|(g|a))")


@dataclass(frozen=True)
class Conversion:
    """How numbers in a written unit become SI: ``scale * number + offset``.

    Parameters
    ----------
    scale, offset : float
        The factor, and what is added.
    gauge : bool or None
        Whether the unit says gauge (True) or absolute (False); None when it says neither.
    """

    scale: float
    offset: float
    gauge: bool | None = None


def conversion(text: str, unit: str, where: str) -> Conversion:
    """Return how numbers in a written unit become SI.

    Parameters
    ----------
    text : str
        The unit as written, such as ``"mm"``; a pressure may say ``"bar gauge"``.
    unit : str
        The SI unit wanted; ``""`` for a pure number.
    where : str
        File and key, for the message.

    Returns
    -------
    Conversion
        Scale, offset and what was said about gauge or absolute.

    Raises
    ------
    InputError
        When the unit is unknown or of the wrong dimension.

    Examples
    --------
    >>> conversion("mm", "m", "step.toml: [channels] displacement")
    Conversion(scale=0.001, offset=0.0, gauge=None)
    >>> conversion("bar gauge", "Pa", "step.toml: [channels] pressure_a").gauge
    True
    >>> conversion("1", "", "step.toml: [channels] spool").scale
    1.0
    """
    symbol, gauge = _gauge_or_absolute(text.strip()) if unit == "Pa" else (text.strip(), None)
    symbol = _SQUARE_OR_CUBE.sub(r"**\1", symbol)
    if symbol in (unit, unit or _ONE):
        return Conversion(1.0, 0.0, gauge)
    kind, examples = _KINDS.get(unit, (f"a quantity in {unit}", (unit,)))
    accepted = f"{kind} is needed, for example in {', '.join(examples)}"
    # Powers are kept to one digit: a tower of them would be computed for ever.
    safe = _SYMBOLS.fullmatch(symbol) and not _FREE_DIGIT.search(_POWER.sub("", symbol))
    if not safe or not _convertible(symbol, symbol):
        raise InputError(
            f"{where}: the unit {text!r} is not known; {accepted}{nearest(text, examples)}"
        )
    if (unit and _convertible(symbol, "")) or not _convertible(symbol, unit):
        raise InputError(f"{where}: the unit {text!r} has the wrong dimension; {accepted}")
    scale, offset = unit_factor(symbol, unit, where)
    return Conversion(scale, offset, gauge)


def quantity(value: Any, unit: str, where: str) -> float:
    """Return a written quantity in SI.

    Parameters
    ----------
    value : str or float
        Number and unit, such as ``"6.82 kg"``; a bare number only where a pure number is wanted.
    unit : str
        The SI unit wanted; ``""`` for a pure number.
    where : str
        File and key, for the message.

    Returns
    -------
    float
        The value [unit].

    Raises
    ------
    InputError
        When number or unit is missing, unknown or of the wrong dimension, or not finite.

    Examples
    --------
    >>> quantity("70 ms", "s", "step.toml: [controller] settling_time")
    0.07
    """
    number, text = _number_and_unit(value, unit, where)
    if not text:
        return number
    how = conversion(text, unit, where)
    return _finite(number * how.scale + how.offset, value, where)


def difference(value: Any, unit: str, where: str) -> float:
    """Return a written difference, such as a noise amplitude, in SI: no zero point is added.

    Parameters
    ----------
    value : str or float
        Number and unit, such as ``"0.03 mm"`` or ``"0.2 degC"``.
    unit : str
        The SI unit wanted; ``""`` for a pure number.
    where : str
        File and key, for the message.

    Returns
    -------
    float
        The difference [unit].

    Raises
    ------
    InputError
        As `quantity`.

    Examples
    --------
    >>> difference("0.2 degC", "K", "step.toml: [channels] temperature_a noise_rms")
    0.2
    """
    number, text = _number_and_unit(value, unit, where)
    return number * conversion(text, unit, where).scale if text else number


def parse_pressure(value: Any, ambient: float | None, where: str) -> float:
    """Return a written pressure as absolute pressure.

    Parameters
    ----------
    value : str
        Number and unit; absolute unless the unit says gauge, as in ``"6.1 bar gauge"``.
    ambient : float or None
        Ambient pressure [Pa], added to a gauge pressure; None where gauge makes no sense.
    where : str
        File and key, for the message.

    Returns
    -------
    float
        Absolute pressure [Pa].

    Raises
    ------
    InputError
        As `quantity`, when a gauge pressure is given without an ambient pressure, or when
        the absolute pressure is not positive.

    Examples
    --------
    >>> parse_pressure("6.1 bar gauge", 101300.0, "step.toml: [conditions] supply_pressure")
    711300.0
    """
    number, text = _number_and_unit(value, "Pa", where)
    how = conversion(text, "Pa", where)
    pressure = number * how.scale
    if how.gauge:
        if ambient is None:
            raise InputError(
                f"{where}: {value!r} is a gauge pressure, and there is no ambient pressure to add; "
                "write the absolute pressure, for example '1.013 bar'"
            )
        pressure += ambient
    if pressure <= 0.0:
        raise InputError(
            f"{where}: {value!r} is {pressure:g} Pa absolute, which cannot be; "
            "for a gauge pressure write for example '6.1 bar gauge'"
        )
    return _finite(pressure, value, where)


def plain_number(value: Any) -> float | None:
    """Return a TOML number as floating point, infinite beyond its range; None if it is none."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        return float(value)
    except OverflowError:  # a whole number of any length
        return math.inf


def _number_and_unit(value: Any, unit: str, where: str) -> tuple[float, str]:
    kind, examples = _KINDS.get(unit, (f"a quantity in {unit}", (unit,)))
    accepted = f"write {kind}, for example " + (f"'1.5 {examples[0]}'" if unit else "0.7")
    plain = plain_number(value)
    if isinstance(value, str):
        match = _NUMBER.fullmatch(value)
        if not match:
            raise InputError(f"{where}: {value!r} does not begin with a number; {accepted}")
        number, text = float(match[1]), match[2]
        if text.startswith(","):
            raise InputError(f"{where}: {value!r} has a comma; write the decimal mark as a point")
    elif plain is None:
        raise InputError(f"{where}: {value!r} is not a quantity; {accepted}")
    else:
        number, text = plain, ""
    if unit and not text:
        raise InputError(f"{where}: {value!r} has no unit; {accepted}")
    return _finite(number, value, where), text


def _finite(number: float, value: Any, where: str) -> float:
    if not math.isfinite(number):
        raise InputError(f"{where}: {value!r} is not a finite number")
    return number


def _gauge_or_absolute(text: str) -> tuple[str, bool | None]:
    word = _REFERENCE_WORD.fullmatch(text)
    if word:
        return word[1], word[2].lower() == "gauge"
    mark = _REFERENCE_MARK.fullmatch(text)
    if mark:
        return mark[1], "g" in (mark[2], mark[3])
    return text, None


def _convertible(text: str, unit: str) -> bool:
    try:
        unit_factor(text, unit)
    except QuantityError:
        return False
    return True
