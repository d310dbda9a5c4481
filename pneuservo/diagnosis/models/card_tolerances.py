"""How far the stages of a healthy card may be from its design, by the tolerances of its parts."""

import math
from collections.abc import Mapping
from functools import cache

import numpy as np

from analog_card.behaviour import CardBehaviour, card_stages
from analog_card.behaviour_elements import DIFFERENTIATORS, differentiator_parts
from analog_card.behaviour_limiter import inputs as limiter_inputs
from analog_card.design import Design
from analog_card.design_tolerances import REFERENCE_TEMPERATURE
from analog_card.tolerance import NORMAL_EXTREME, TEMPERATURE, elements_of, quantities

Errors = dict[str, tuple[float, float]]

_BESIDE = {"asymmetry": 4e-3, "offset": 3e-3}
"""What a dial, a contact or the zero of a recorder adds to errors that the parts make ..."""
_BESIDE_SIZE = 0.01
"""... and to those of a size."""


@cache
def stage_errors(design: Design) -> dict[str, Errors]:
    """Return standard deviation and largest size of every error that tolerances allow.

    Parameters
    ----------
    design : Design
        The card, with its tolerances.

    Returns
    -------
    dict of str to dict of str to (float, float)
        By tap and error; offsets [V], all others shares [-].

    Notes
    -----
    Each quantity that differs from card to card is moved alone, at the end of the temperature range
    where drifts are largest. Evenly spread ones add up to the largest size, of the normal ones
    three standard deviations count.
    """
    warmer = design.tolerances.temperature.middle >= REFERENCE_TEMPERATURE
    rest = {TEMPERATURE: 1.0 if warmer else -1.0}
    items = [item for item in quantities(design) if item.spread]
    base = _figures(design, rest)
    moved = [
        # The other end of the range is as far as the temperature goes.
        _figures(design, rest | {item.name: -rest.get(item.name, -1.0)})
        for item in items
    ]
    normal = np.array([item.normal for item in items], bool)
    found: dict[str, Errors] = {}
    for key, value in base.items():
        channel, error = key
        change = np.array([each[key] - value for each in moved])
        deviation = np.where(normal, 1.0, 1.0 / math.sqrt(3.0)) * change
        drawn = NORMAL_EXTREME * np.linalg.norm(change[normal])
        largest = float(np.sum(np.abs(change[~normal])) + drawn)
        beside = _BESIDE.get(error, _BESIDE_SIZE)
        sigma = math.hypot(float(np.linalg.norm(deviation)), beside)
        found.setdefault(channel, {})[error] = (sigma, largest + beside)
    return found


def _figures(design: Design, deviations: Mapping[str, float]) -> dict[tuple[str, str], float]:
    """Return what errors are counted in of one card: logarithms of sizes, and offsets [V]."""
    elements = elements_of(deviations, design)
    stages = card_stages(CardBehaviour(design, elements))
    found = {}
    for k, stage in enumerate(DIFFERENTIATORS):
        channel, parts = f"card_{stage}", differentiator_parts(stage, elements, design)
        found[channel, "gain_error"] = math.log(parts.resistance * parts.capacitance)
        # One lag goes with the gain: what its resistor does is left for the other.
        lag = parts.series_resistance * parts.feedback_capacitance
        found[channel, "lag_error"] = math.log(lag)
        drop = stages.bias_currents[k] * parts.resistance
        found[channel, "offset"] = float(stages.differentiator_offsets[k] + drop)
    ahead = (stages.difference[0], stages.inverter[0], 1.0)
    for state, gain in zip(
        ("displacement", "velocity", "acceleration"), stages.surface[:3] * ahead, strict=True
    ):
        found["card_surface", f"{state}_error"] = math.log(abs(gain))
    difference = stages.difference[:2] @ stages.buffer_offsets + stages.difference[2]
    found["card_surface", "offset"] = float(
        stages.surface[3] + stages.surface[0] * difference + stages.surface[1] * stages.inverter[1]
    )
    curve = stages.limiter
    gain = stages.comparator_gain * curve.division * curve.fraction
    low, high = stages.control_offset + curve.fraction * np.interp(
        stages.comparator_swing, limiter_inputs(), curve.clamped
    )
    found["card_output", "gain_error"] = math.log(gain)
    found["card_output", "offset"] = float(stages.comparator_offset + stages.control_offset / gain)
    found["card_output", "level_error"] = math.log(high - low)
    found["card_output", "asymmetry"] = float((high + low) / (high - low))
    return found
