"""What of a card differs from one to the next: parts, op-amps and temperature, drawn by seed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analog_card.behaviour_elements import (
    DIFFERENTIATORS,
    POTENTIOMETERS,
    ZENERS,
    nominal_elements,
    offset_name,
)
from analog_card.design import AMPLIFIERS, Design
from analog_card.errors import InputError

# A normal quantity stands at this many standard deviations in a worst case: 15 mV for an offset of
# 5 mV, the most that the data sheet allows.
NORMAL_EXTREME = 3.0
_REFERENCE = 25.0  # degrees Celsius, where the design's values hold
_MATCHED = ("xdifference.", "xinverter.")


@dataclass(frozen=True)
class Tolerances:
    """How far the parts of a card may be from their values.

    Attributes
    ----------
    resistor, matched_resistor, capacitor, potentiometer, zener : float
        Largest relative deviation, evenly spread; matched are the resistors of difference
        amplifier and inverter, the potentiometer's is that of its track [-].
    offset_voltage : float
        Standard deviation of an op-amp's offset voltage [V].
    offset_drift : float
        Standard deviation of its drift [V/K].
    lowest_temperature, highest_temperature : float
        Of the whole card, evenly spread [degC].
    resistor_coefficient, capacitor_coefficient, zener_coefficient : float
        Relative change with temperature, the same for all of a kind [1/K].

    Notes
    -----
    Defaults: metal film 1 % and 50 ppm/K, polypropylene capacitors 5 % and -200 ppm/K, 6.2 V zeners
    5 % and 300 ppm/K, tracks 20 %: common figures of such parts. CA3140 offset 5 mV and drift
    8 uV/K: data sheet FN957.10.
    """

    resistor: float = 0.01
    matched_resistor: float = 0.001
    capacitor: float = 0.05
    potentiometer: float = 0.2
    zener: float = 0.05
    offset_voltage: float = 5e-3
    offset_drift: float = 8e-6
    lowest_temperature: float = 15.0
    highest_temperature: float = 45.0
    resistor_coefficient: float = 50e-6
    capacitor_coefficient: float = -200e-6
    zener_coefficient: float = 300e-6

    def __post_init__(self) -> None:
        """Refuse tolerances that no part has."""
        for name in ("resistor", "matched_resistor", "capacitor", "potentiometer", "zener"):
            if not 0 <= getattr(self, name) < 1:
                raise InputError(f"{name} tolerance: {getattr(self, name):g} is not from 0 to 1")
        for name in ("offset_voltage", "offset_drift"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name}: {getattr(self, name):g} is not 0 or more")
        if self.lowest_temperature > self.highest_temperature:
            raise InputError(
                f"temperature from {self.lowest_temperature:g} to {self.highest_temperature:g} "
                "degC: the lowest comes first"
            )


@dataclass(frozen=True)
class Quantity:
    """One thing that differs from card to card.

    Attributes
    ----------
    name : str
        Of an element, of a potentiometer's track, of an offset's drift, or ``temperature``.
    spread : float
        Largest deviation if evenly spread, standard deviation if normal; relative for parts, in
        SI for offsets, drifts and temperature.
    normal : bool
        Whether it is normally distributed.
    """

    name: str
    spread: float
    normal: bool = False

    @property
    def extreme(self) -> float:
        """Return how many times the spread it stands at in a worst case."""
        return NORMAL_EXTREME if self.normal else 1.0


def quantities(design: Design, tolerances: Tolerances) -> tuple[Quantity, ...]:
    """Return everything that differs from card to card, in the order it is drawn.

    Parameters
    ----------
    design : Design
        The card.
    tolerances : Tolerances
        How far.
    """
    found = []
    for name in _parts(design):
        spread = tolerances.capacitor if _is_capacitor(name) else tolerances.resistor
        spread = tolerances.matched_resistor if name.startswith(_MATCHED) else spread
        found.append(Quantity(name, spread))
    found += [Quantity(name, tolerances.potentiometer) for name in POTENTIOMETERS]
    found += [Quantity(name, tolerances.zener) for name in ZENERS]
    found += [Quantity(offset_name(n), tolerances.offset_voltage, True) for n in AMPLIFIERS]
    found += [Quantity(f"{n} drift", tolerances.offset_drift, True) for n in AMPLIFIERS]
    half = (tolerances.highest_temperature - tolerances.lowest_temperature) / 2
    return (*found, Quantity("temperature", half))


def draw(items: tuple[Quantity, ...], seed: int, index: int) -> dict[str, float]:
    """Return the deviations of one card, as multiples of each quantity's spread.

    Parameters
    ----------
    items : tuple of Quantity
        From `quantities`.
    seed, index : int
        Of the study and of the card; the same two always give the same card.

    Examples
    --------
    >>> items = (Quantity("a", 0.01), Quantity("b", 5e-3, normal=True))
    >>> draw(items, 1, 7) == draw(items, 1, 7) != draw(items, 1, 8)
    True
    """
    random = np.random.default_rng([seed, index])
    # Both are always drawn, so that one card's numbers do not depend on what is normal.
    even, normal = random.uniform(-1, 1, len(items)), random.standard_normal(len(items))
    return {item.name: float(normal[k] if item.normal else even[k]) for k, item in enumerate(items)}


def elements_of(
    deviations: Mapping[str, float], design: Design, tolerances: Tolerances, relay: bool = False
) -> dict[str, float]:
    """Return the values of the elements of one card.

    Parameters
    ----------
    deviations : mapping of str to float
        From `draw`; what is not named stands at its nominal value.
    design : Design
        The card as designed.
    tolerances : Tolerances
        What a deviation of 1 amounts to.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.

    Returns
    -------
    dict of str to float
        As from `analog_card.behaviour_elements.nominal_elements`.
    """
    values = nominal_elements(design, relay)
    middle = (tolerances.lowest_temperature + tolerances.highest_temperature) / 2
    spread = {item.name: item.spread for item in quantities(design, tolerances)}
    off = {name: deviations.get(name, 0.0) * spread[name] for name in spread}
    warmer = middle + off["temperature"] - _REFERENCE
    resistor = 1 + tolerances.resistor_coefficient * warmer
    for name in _parts(design):
        capacitor = _is_capacitor(name)
        drifted = 1 + tolerances.capacitor_coefficient * warmer if capacitor else resistor
        values[name] *= (1 + off[name]) * drifted
    for name, place in POTENTIOMETERS.items():
        for part in ("rupper", "rlower"):
            values[f"{place}.{part}"] *= (1 + off[name]) * resistor
    for name in ZENERS:
        values[name] *= (1 + off[name]) * (1 + tolerances.zener_coefficient * warmer)
    for name in AMPLIFIERS:
        values[offset_name(name)] = off[offset_name(name)] + off[f"{name} drift"] * warmer
    return values


def _parts(design: Design) -> list[str]:
    """Return the names of resistors and capacitors, those of tracks and of the link left out."""
    left_out = (*POTENTIOMETERS.values(), "xboundary.rlink")
    bias = tuple(f"{place}.rbias" for place in DIFFERENTIATORS.values())
    return [
        name
        for name in nominal_elements(design)
        if name.rpartition(".")[2][0] in "rc" and not name.startswith((*left_out, *bias))
    ]


def _is_capacitor(name: str) -> bool:
    return name.rpartition(".")[2].startswith("c")
