"""The two differentiators in time, compiled, with op-amps that slew and saturate.

They are linear while an op-amp is, and linear with a given output while it slews or saturates: a
step is the exact solution of whichever holds.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analog_card.compilation import compiled

# Places in the state, see `analog_card.differentiator`; behind it the buffered displacement, its
# first and second derivative, the constant one, and the rates of op-amps that slew.
INPUT_1, FEEDBACK_1, AMPLIFIER_1, INPUT_2, FEEDBACK_2, AMPLIFIER_2 = range(6)
FRONT = 6
DISPLACEMENT, VELOCITY, ACCELERATION, ONE, RATE_1, RATE_2 = range(6, 12)
EXTENDED = 12

# What an op-amp is doing: within its limits, slewing or saturated to either side.
LINEAR, SLEWING, SATURATED = 0, 1, 2
# Of the junctions that clamp an op-amp [V].
THERMAL_VOLTAGE = 0.025865

Numbers = NDArray[np.float64]


class CardNumbers(NamedTuple):
    """A channel of the card, as the kernels take it."""

    duration: Numbers
    """Length of a step at each level of division, shape (3,) [s]."""
    solution: Numbers
    """Differentiators one step later, by what their op-amps do and level, shape (4, 3, 6, 12)."""
    demanded: Numbers
    """Rates of the op-amps of the differentiators if nothing limits them, shape (2, 12) [V/s]."""
    taps: Numbers
    """Outputs of the differentiators, shape (2, 12)."""
    decay: Numbers
    """What a lag keeps over a step, by level and lag, shape (3, 6)."""
    share: Numbers
    """Time constant of a lag over the step, likewise."""
    buffer_gain: float
    demand_gain: float
    buffer_lag: float
    buffer_offset: float
    demand_offset: float
    difference: Numbers
    inverter: Numbers
    surface: Numbers
    comparator_gain: float
    comparator_offset: float
    swings: Numbers
    """Lowest and highest voltage inside the op-amps of the differentiators, shape (2, 2) [V]."""
    rate_swing: Numbers
    surface_swing: Numbers
    comparator_swing: Numbers
    slew_rates: Numbers
    """Of the op-amps of the differentiators and of the boundary-layer amplifier [V/s]."""
    clamped: Numbers
    """Clamped voltage for inputs from -`clamped_to` on, equally spaced [V]."""
    clamped_to: float
    clamped_step: float
    fraction: float
    control_offset: float


@compiled
def product(row: Numbers, vector: Numbers) -> float:
    """Return a row of factors on the extended state."""
    total = 0.0
    for i in range(EXTENDED):
        total += row[i] * vector[i]
    return total


@compiled
def _clamp_voltage(rate: float, slew_rate: float) -> float:
    """Return how far from the full swing an op-amp's clamp holds it against a rate [V].

    The clamp is a junction, so that the swing is a little less when little drives against it.
    """
    if rate >= slew_rate or math.isinf(slew_rate):
        return 0.0
    return THERMAL_VOLTAGE * math.log(rate / slew_rate)


@compiled
def _saturated_output(
    output: float, demanded: float, feedback: float, swing: Numbers, slew_rate: float
) -> float:
    """Return where an op-amp that drives against its swing stands, and its clamp with it.

    Its rate falls as the output rises, by the feedback: the share u of its full rate solves
    output + (demanded - slew rate e^u)/feedback = swing + Vt u. Newton's steps from u = 0, where
    the difference is negative, come down to the solution.
    """
    sign = 1.0 if demanded > 0.0 else -1.0
    limit = swing[1] if demanded > 0.0 else -swing[0]
    excess = sign * output + sign * demanded / feedback - limit
    full = slew_rate / feedback
    if excess >= full or math.isinf(full):
        return sign * limit
    u = 0.0
    for _ in range(50):
        part = full * math.exp(u)
        change = (excess - part - THERMAL_VOLTAGE * u) / (part + THERMAL_VOLTAGE)
        u += change
        if abs(change) < 1e-6:
            break
    return sign * (limit + THERMAL_VOLTAGE * u)


@compiled
def _mode(output: float, demanded: float, swing: Numbers, slew_rate: float) -> int:
    """Return what an op-amp does: 0, or with the sign of its rate slewing or saturated."""
    if demanded > 0.0 and output >= swing[1] + _clamp_voltage(demanded, slew_rate):
        return SATURATED
    if demanded < 0.0 and output <= swing[0] - _clamp_voltage(-demanded, slew_rate):
        return -SATURATED
    if demanded > slew_rate:
        return SLEWING
    if demanded < -slew_rate:
        return -SLEWING
    return LINEAR


@compiled
def _drive(mode: int, slew_rate: float) -> float:
    """Return the rate of an op-amp that is not linear."""
    return mode * slew_rate if abs(mode) == SLEWING else 0.0


@compiled
def step_differentiators(
    front: Numbers, first: int, second: int, level: int, card: CardNumbers, result: Numbers
) -> None:
    """Write the differentiators one step of a level later."""
    front[RATE_1] = _drive(first, card.slew_rates[0])
    front[RATE_2] = _drive(second, card.slew_rates[1])
    driven = (first != LINEAR) + 2 * (second != LINEAR)
    for i in range(FRONT):
        result[i] = product(card.solution[driven, level, i], front)
    step = card.duration[level]
    result[DISPLACEMENT] = (
        front[DISPLACEMENT] + (front[VELOCITY] + 0.5 * front[ACCELERATION] * step) * step
    )
    result[VELOCITY] = front[VELOCITY] + front[ACCELERATION] * step
    result[ACCELERATION] = front[ACCELERATION]
    result[ONE] = 1.0
    result[RATE_1] = 0.0
    result[RATE_2] = 0.0


@compiled
def modes_of(front: Numbers, card: CardNumbers) -> tuple[int, int]:
    """Return what the two op-amps do: 0, or with the sign of their rate slewing or saturated."""
    return (
        _mode(
            front[AMPLIFIER_1],
            product(card.demanded[0], front),
            card.swings[0],
            card.slew_rates[0],
        ),
        _mode(
            front[AMPLIFIER_2],
            product(card.demanded[1], front),
            card.swings[1],
            card.slew_rates[1],
        ),
    )


@compiled
def hold(front: Numbers, place: int, stage: int, card: CardNumbers) -> None:
    """Put the op-amp of a differentiator that drives against its swing where it stands."""
    row = card.demanded[stage]
    front[place] = _saturated_output(
        front[place],
        product(row, front),
        -row[place],
        card.swings[stage],
        card.slew_rates[stage],
    )
