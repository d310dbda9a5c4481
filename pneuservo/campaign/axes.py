"""The axes of a campaign: values of a parameter, as a grid or drawn from a distribution."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analog_card.quantities import as_text, to_si, to_si_all, unit_of
from pneuservo.campaign.parameters import Varied
from pneuservo.errors import InputError
from pneuservo.naming import require_known

TOLERANCE = "tolerance"
_CALL = re.compile(r"(\w+)\s*\((.*)\)")
_MOST_VALUES = 10_000
# Units that people write with a prefix that keeps the number short.
_PREFIXED = ("m", "s", "Hz", "V", "F", "ohm")
_ALLOWED = (
    'a list such as "6.5, 7.1, 7.7 bar", a range such as "6.5:7.7 bar:5" (five values), '
    '"normal(1.825 kg, 3 %)", "uniform(6.5, 7.7 bar)", "log_uniform(1, 100 N)", or "tolerance"'
)


@dataclass(frozen=True)
class Grid:
    """Values that a parameter takes one after the other.

    Attributes
    ----------
    name : str
        Of the parameter.
    unit, shown : str
        Its SI unit, and the unit that people gave it in.
    values : tuple of float
        [unit].
    """

    name: str
    unit: str
    shown: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Random:
    """A distribution that a parameter is drawn from.

    Attributes
    ----------
    name : str
        Of the parameter.
    unit, shown : str
        Its SI unit, and the unit that people gave it in.
    distribution : str
        ``normal``, ``uniform`` or ``log_uniform``.
    first, second : float
        Mean and standard deviation of the normal, lowest and highest value of the others [unit].
    """

    name: str
    unit: str
    shown: str
    distribution: str
    first: float
    second: float

    def draw(self, generator: np.random.Generator) -> float:
        """Return one value [unit].

        Examples
        --------
        >>> axis = Random("load.mass", "kg", "kg", "uniform", 1.0, 2.0)
        >>> 1.0 <= axis.draw(np.random.default_rng(0)) <= 2.0
        True
        """
        if self.distribution == "normal":
            return float(generator.normal(self.first, self.second))
        if self.distribution == "uniform":
            return float(generator.uniform(self.first, self.second))
        return math.exp(generator.uniform(math.log(self.first), math.log(self.second)))


Axis = Grid | Random


def read_axis(varied: Varied, given: str | float | Sequence[str | float], where: str) -> Axis:
    """Return the axis that a text or a list describes.

    Parameters
    ----------
    varied : Varied
        The parameter.
    given : str, float, or a sequence of them
        One value or several, ``LOW:HIGH UNIT:COUNT``, a distribution with its two numbers, or
        ``tolerance``: as far as the parameter is known, or the part is sold.
    where : str
        Option or file, for the error message.

    Returns
    -------
    Grid or Random
        Everything in SI.

    Raises
    ------
    InputError
        When it is none of these, or a number has another dimension.

    Notes
    -----
    A number without a unit has the unit of the last; a plain one is in SI. A standard deviation in
    percent is of the mean.

    Examples
    --------
    >>> supply = Varied("supply.pressure", "Pa")
    >>> read_axis(supply, "6.5:7.7 bar:3", "--vary").values
    (650000.0, 710000.0, 770000.0)
    >>> mass = read_axis(Varied("load.mass", "kg"), "normal(1.825 kg, 3 %)", "--vary")
    >>> mass.first, round(mass.second, 5)
    (1.825, 0.05475)
    """
    what = f"{where} {varied.name}"
    if not isinstance(given, str):
        several = [given] if isinstance(given, int | float) else list(given)
        return _grid(varied, [str(value) for value in several], what)
    text = given.strip()
    if text == TOLERANCE:
        return _by_tolerance(varied, what)
    call = _CALL.fullmatch(text)
    if call is not None:
        return _random(varied, call[1], call[2].split(","), what)
    if ":" in text:
        return _range(varied, text, what)
    return _grid(varied, text.split(","), what)


def _grid(varied: Varied, texts: Sequence[str], what: str) -> Grid:
    if not any(text.strip() for text in texts):
        raise InputError(f"{what}: no value is given; allowed are {_ALLOWED}")
    values = to_si_all(texts, varied.unit, what)
    for value in values:
        varied.require_allowed(value, what)
    return Grid(varied.name, varied.unit, unit_of(texts[-1]) or varied.unit, tuple(values))


def _range(varied: Varied, text: str, what: str) -> Grid:
    parts = text.split(":")
    if len(parts) != 3 or not parts[2].strip().isdecimal():
        raise InputError(f"{what}: {text!r} is not LOW:HIGH UNIT:COUNT; allowed are {_ALLOWED}")
    count = int(parts[2])
    if not 2 <= count <= _MOST_VALUES:
        raise InputError(f"{what}: {count} values; a range has from 2 to {_MOST_VALUES}")
    ends = _grid(varied, parts[:2], what)
    low, high = ends.values
    if not math.isfinite(high - low):
        raise InputError(f"{what}: {text!r} is wider than any number; take ends closer together")
    values = tuple(float(value) for value in np.linspace(low, high, count))
    return Grid(varied.name, varied.unit, ends.shown, values)


def _random(varied: Varied, distribution: str, texts: Sequence[str], what: str) -> Random:
    require_known(distribution, ("normal", "uniform", "log_uniform"), what)
    if len(texts) != 2:
        raise InputError(f"{what}: {distribution} takes two numbers; allowed are {_ALLOWED}")
    if distribution == "normal" and unit_of(texts[1]) == "%":
        first = to_si(texts[0].strip(), varied.unit, what)
        second = to_si(texts[1].strip(), "", what) * abs(first)
        shown = unit_of(texts[0]) or varied.unit
    else:
        first, second = to_si_all(texts, varied.unit, what)
        shown = unit_of(texts[1]) or varied.unit
    varied.require_allowed(first, what)
    if distribution == "normal":
        possible, needed = second > 0, "a standard deviation greater than 0"
    elif distribution == "uniform":
        possible = first < second and math.isfinite(second - first)
        needed = "the lower value first, and a finite number between them"
    else:
        possible, needed = 0 < first < second, "two values greater than 0, the lower first"
    if not possible:
        raise InputError(f"{what}: {distribution}({', '.join(texts)}) needs {needed}")
    if distribution != "normal":
        varied.require_allowed(second, what)
    return Random(varied.name, varied.unit, shown, distribution, first, second)


def _by_tolerance(varied: Varied, what: str) -> Random:
    nominal, tolerance = varied.nominal, varied.tolerance
    if nominal is None or not tolerance:
        raise InputError(
            f"{what}: no tolerance is known of it; give a distribution, such as "
            '"normal(1.825 kg, 3 %)" or "uniform(6.5, 7.7 bar)"'
        )
    shown = varied.unit
    if shown in _PREFIXED:
        shown = unit_of(as_text(nominal, shown))
    if varied.even:
        low, high = nominal - tolerance, nominal + tolerance
        return Random(varied.name, varied.unit, shown, "uniform", low, high)
    return Random(varied.name, varied.unit, shown, "normal", nominal, tolerance)
