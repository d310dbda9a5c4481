"""What of a card differs from one to the next: parts, op-amps and temperature, drawn by seed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from analog_card.behaviour_elements import (
    PARTS,
    POTENTIOMETERS,
    TRACKS,
    ZENERS,
    figure_name,
    nominal_elements,
    offset_name,
    zener_voltage,
)
from analog_card.design import AMPLIFIER_FIGURES, AMPLIFIERS, Design
from analog_card.design_tolerances import REFERENCE_TEMPERATURE

# A normal quantity stands at this many standard deviations in a worst case: 15 mV for an offset of
# 5 mV, the most that the data sheet allows.
NORMAL_EXTREME = 3.0
# What both zeners have in common.
PAIR = "zener pair"
# What says how much the drifts do.
TEMPERATURE = "temperature"
# Figures of an op-amp that are spread by a factor, and by a voltage; the others by a share.
_FACTORS = ("bias_current", "open_loop_gain")
_VOLTAGES = ("positive_swing", "negative_swing")


@dataclass(frozen=True)
class Quantity:
    """One thing that differs from card to card.

    Attributes
    ----------
    name : str
        Of an element, of a potentiometer's track, of an offset's drift, of the zener pair, or
        ``temperature``.
    spread : float
        Largest deviation if evenly spread, standard deviation if normal: relative for parts, the
        logarithm of a factor, in SI for the rest.
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


def quantities(design: Design) -> tuple[Quantity, ...]:
    """Return everything that differs from card to card, in the order it is drawn.

    Parameters
    ----------
    design : Design
        The card, with its tolerances.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> [item.spread for item in quantities(load_design()) if item.name == "P4"]
    [0.2]
    """
    tolerances = design.tolerances
    found = [
        Quantity(name, design.part_tolerance(section, part).tolerance)
        for name, (section, part) in (PARTS | TRACKS).items()
    ]
    found.append(Quantity(PAIR, tolerances.zener.tolerance))
    found += [Quantity(name, tolerances.zener.matching) for name in ZENERS]
    spread = tolerances.operational_amplifier
    found += [Quantity(offset_name(name), spread.offset_voltage, True) for name in AMPLIFIERS]
    found += [Quantity(_drift(name), spread.offset_drift, True) for name in AMPLIFIERS]
    for figure in AMPLIFIER_FIGURES:
        size = getattr(spread, figure)
        size = math.log(size) if figure in _FACTORS else size
        found += [Quantity(figure_name(name, figure), size) for name in AMPLIFIERS]
    return (*found, Quantity(TEMPERATURE, tolerances.temperature.half))


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
    deviations: Mapping[str, float], design: Design, relay: bool = False
) -> dict[str, float]:
    """Return the values of the elements of one card.

    Parameters
    ----------
    deviations : mapping of str to float
        From `draw`; what is not named stands at its nominal value.
    design : Design
        The card as designed, with its tolerances.
    relay : bool, optional
        Whether the feedback of the boundary-layer amplifier is opened.

    Returns
    -------
    dict of str to float
        As from `analog_card.behaviour_elements.nominal_elements`. Offset voltages are about zero:
        the design's is the typical figure of a data sheet, which has no sign.

    Examples
    --------
    >>> from analog_card.design_file import load_design
    >>> card = elements_of({"xinverter.rinput": 1.0}, load_design())
    >>> round(card["xinverter.rinput"] / card["xinverter.rfeedback"], 6)
    1.001
    """
    off = {item.name: deviations.get(item.name, 0.0) * item.spread for item in quantities(design)}
    temperature = design.tolerances.temperature.middle + off[TEMPERATURE]
    values = nominal_elements(design, relay, temperature)
    for name in PARTS:
        values[name] *= 1 + off[name]
    for name, place in POTENTIOMETERS.items():
        for part in ("rupper", "rlower"):
            values[f"{place}.{part}"] *= 1 + off[name]
    # Deviations are of the breakdown voltage; its drift and the forward voltage are not theirs.
    breakdown = zener_voltage(design)
    for name in ZENERS:
        values[name] += breakdown * ((1 + off[PAIR]) * (1 + off[name]) - 1)
    # A drift is alike to either side and a card at one temperature: only how far away counts. So a
    # drift acts the same way at both ends of the range.
    away = abs(temperature - REFERENCE_TEMPERATURE)
    for name in AMPLIFIERS:
        values[offset_name(name)] = off[offset_name(name)] + off[_drift(name)] * away
        for figure in AMPLIFIER_FIGURES:
            place = figure_name(name, figure)
            values[place] = _spread_figure(figure, values[place], off[place])
    return values


def _spread_figure(figure: str, value: float, deviation: float) -> float:
    if figure in _FACTORS:
        return value * math.exp(deviation)
    return value + deviation if figure in _VOLTAGES else value * (1 + deviation)


def _drift(amplifier: str) -> str:
    return f"{amplifier} drift"
