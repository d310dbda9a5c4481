"""The behavioural card in time, compiled: one step of a channel after another.

The stages behind the differentiators are lags of one time constant with limits. A step is divided
where an op-amp of a differentiator begins or ends to slew or saturate.
"""

import numpy as np

from analog_card.compilation import compiled
from analog_card.differentiator_kernel import (
    ACCELERATION,
    AMPLIFIER_1,
    AMPLIFIER_2,
    DISPLACEMENT,
    EXTENDED,
    FRONT,
    INPUT_1,
    LINEAR,
    ONE,
    RATE_1,
    RATE_2,
    SATURATED,
    VELOCITY,
    CardNumbers,
    Numbers,
    hold,
    modes_of,
    product,
    step_differentiators,
)

# Places in the state behind those of the differentiators: the outputs of the lags, and as many
# places further what each of them tends to.
DEVIATION, RATE, SURFACE, COMPARATOR, CONTROL = range(FRONT, FRONT + 5)
_TARGETS = 5
STATES = 16
# A step may be divided twice, each time by this.
DIVISION = 8
LEVELS = 3
_FINEST = DIVISION ** (LEVELS - 1)

# What `outputs` writes.
OUTPUTS = (
    "displacement",
    "first",
    "second",
    "deviation",
    "rate",
    "surface",
    "comparator",
    "clamped",
    "control",
)


@compiled
def _lagged(output: float, before: float, after: float, decay: float, share: float) -> float:
    """Return a lag one step later, its target going straight from one value to another."""
    behind = (after - before) * share
    return after - behind + (output - before + behind) * decay


@compiled
def _clip(value: float, limits: Numbers) -> float:
    return min(max(value, limits[0]), limits[1])


@compiled
def clamped_voltage(comparator: float, card: CardNumbers) -> float:
    """Return the voltage across the zeners for an output of the boundary-layer amplifier [V]."""
    place = (comparator + card.clamped_to) / card.clamped_step
    k = min(max(int(place), 0), card.clamped.shape[0] - 2)
    return card.clamped[k] + (place - k) * (card.clamped[k + 1] - card.clamped[k])


@compiled
def _back_step(
    state: Numbers, front: Numbers, wanted: float, level: int, card: CardNumbers
) -> None:
    """Advance the stages behind the differentiators by a step of a level."""
    decay, share = card.decay[level], card.share[level]
    target = (
        card.difference[0] * front[DISPLACEMENT] + card.difference[1] * wanted + card.difference[2]
    )
    place = DEVIATION + _TARGETS
    state[DEVIATION] = _lagged(state[DEVIATION], state[place], target, decay[1], share[1])
    state[place] = target

    target = card.inverter[0] * product(card.taps[0], front) + card.inverter[1]
    place = RATE + _TARGETS
    state[RATE] = _clip(
        _lagged(state[RATE], state[place], target, decay[2], share[2]), card.rate_swing
    )
    state[place] = target

    target = _surface_target(state, front, card)
    place = SURFACE + _TARGETS
    state[SURFACE] = _clip(
        _lagged(state[SURFACE], state[place], target, decay[3], share[3]), card.surface_swing
    )
    state[place] = target

    target = card.comparator_gain * (state[SURFACE] + card.comparator_offset)
    place = COMPARATOR + _TARGETS
    after = _lagged(state[COMPARATOR], state[place], target, decay[4], share[4])
    most = card.slew_rates[2] * card.duration[level]
    after = state[COMPARATOR] + min(max(after - state[COMPARATOR], -most), most)
    state[COMPARATOR] = _clip(after, card.comparator_swing)
    state[place] = target

    target = card.fraction * clamped_voltage(state[COMPARATOR], card) + card.control_offset
    place = CONTROL + _TARGETS
    state[CONTROL] = _lagged(state[CONTROL], state[place], target, decay[5], share[5])
    state[place] = target


@compiled
def _surface_target(state: Numbers, front: Numbers, card: CardNumbers) -> float:
    return (
        card.surface[0] * state[DEVIATION]
        + card.surface[1] * state[RATE]
        + card.surface[2] * product(card.taps[1], front)
        + card.surface[3]
    )


@compiled
def _load_front(
    state: Numbers,
    transducer: float,
    rate: float,
    second_rate: float,
    card: CardNumbers,
    front: Numbers,
) -> None:
    for i in range(FRONT):
        front[i] = state[i]
    # The buffer's lag is far shorter than any step: it is behind by that much.
    front[DISPLACEMENT] = (
        card.buffer_gain * (transducer - card.buffer_lag * rate) + card.buffer_offset
    )
    front[VELOCITY] = card.buffer_gain * rate
    front[ACCELERATION] = card.buffer_gain * second_rate
    front[ONE] = 1.0
    front[RATE_1] = 0.0
    front[RATE_2] = 0.0


@compiled
def rest(transducer: float, demand: float, card: CardNumbers, state: Numbers) -> None:
    """Write the state of a card at rest.

    Parameters
    ----------
    transducer, demand : float
        Voltages at its inputs [V].
    card : CardNumbers
        The card.
    state : (16,) array
        Written. The differentiators are to hold their state at rest for 0 V at the buffer.
    """
    front = np.empty(EXTENDED)
    wanted = card.demand_gain * demand + card.demand_offset
    _load_front(state, transducer, 0.0, 0.0, card, front)
    # At rest all of the displacement lies across the input capacitor.
    state[INPUT_1] += front[DISPLACEMENT]
    front[INPUT_1] = state[INPUT_1]
    state[DEVIATION] = (
        card.difference[0] * front[DISPLACEMENT] + card.difference[1] * wanted + card.difference[2]
    )
    state[RATE] = card.inverter[0] * product(card.taps[0], front) + card.inverter[1]
    state[SURFACE] = _clip(_surface_target(state, front, card), card.surface_swing)
    state[COMPARATOR] = _clip(
        card.comparator_gain * (state[SURFACE] + card.comparator_offset), card.comparator_swing
    )
    state[CONTROL] = card.fraction * clamped_voltage(state[COMPARATOR], card) + card.control_offset
    for i in range(DEVIATION, CONTROL + 1):
        state[i + _TARGETS] = state[i]
    state[SURFACE + _TARGETS] = _surface_target(state, front, card)
    state[COMPARATOR + _TARGETS] = card.comparator_gain * (state[SURFACE] + card.comparator_offset)


@compiled
def advance_card(
    state: Numbers,
    transducer: float,
    rate: float,
    second_rate: float,
    demand: float,
    card: CardNumbers,
    work: Numbers,
) -> float:
    """Advance a card by one step and return the mean of its control voltage over it [V].

    Parameters
    ----------
    state : (16,) array
        Changed.
    transducer, rate, second_rate : float
        Transducer voltage at the start of the step [V], its first [V/s] and second derivative
        [V/s^2], taken to hold over the step.
    demand : float
        Demand over the step, as transducer voltage [V].
    card : CardNumbers
        The card.
    work : (2, 12) array
        Overwritten.
    """
    front, trial = work[0], work[1]
    _load_front(state, transducer, rate, second_rate, card, front)
    wanted = card.demand_gain * demand + card.demand_offset
    # A demand that has jumped does so at the start of the step.
    state[DEVIATION + _TARGETS] = (
        card.difference[0] * front[DISPLACEMENT] + card.difference[1] * wanted + card.difference[2]
    )
    first, second = modes_of(front, card)
    mean = 0.0
    level, done = 0, 0
    while done < _FINEST:
        length = _FINEST
        for _ in range(level):
            length //= DIVISION
        step_differentiators(front, first, second, level, card, trial)
        first_after, second_after = modes_of(trial, card)
        if level < LEVELS - 1:
            if first_after != first or second_after != second:
                level += 1
                continue
        elif first * first_after == -1 or second * second_after == -1:
            # Slewing has gone too far: from here on it is the linear op-amp that settles.
            if first * first_after == -1:
                first = LINEAR
            if second * second_after == -1:
                second = LINEAR
            step_differentiators(front, first, second, level, card, trial)
            first_after, second_after = modes_of(trial, card)
        first, second = first_after, second_after
        if abs(first) == SATURATED:
            hold(trial, AMPLIFIER_1, 0, card)
        if abs(second) == SATURATED:
            hold(trial, AMPLIFIER_2, 1, card)
        for i in range(EXTENDED):
            front[i] = trial[i]
        before = state[CONTROL]
        _back_step(state, front, wanted, level, card)
        mean += 0.5 * (before + state[CONTROL]) * length
        done += length
        while level > 0 and done % (length * DIVISION) == 0:
            length *= DIVISION
            level -= 1
    for i in range(FRONT):
        state[i] = front[i]
    return mean / _FINEST


@compiled
def outputs(
    state: Numbers, transducer: float, card: CardNumbers, work: Numbers, result: Numbers
) -> None:
    """Write the voltages of a card.

    Parameters
    ----------
    state, transducer, card, work
        As in `advance_card`.
    result : (9,) array
        Written: one voltage per name of `OUTPUTS` [V].
    """
    front = work[0]
    _load_front(state, transducer, 0.0, 0.0, card, front)
    result[0] = front[DISPLACEMENT]
    result[1] = product(card.taps[0], front)
    result[2] = product(card.taps[1], front)
    result[3] = state[DEVIATION]
    result[4] = state[RATE]
    result[5] = state[SURFACE]
    result[6] = state[COMPARATOR]
    result[7] = clamped_voltage(state[COMPARATOR], card)
    result[8] = state[CONTROL]


@compiled
def run_card(
    transducer: Numbers,
    demand: Numbers,
    step: float,
    substeps: int,
    card: CardNumbers,
    state: Numbers,
) -> Numbers:
    """Return the voltages of a card on its own, driven by samples of its inputs.

    Parameters
    ----------
    transducer, demand : (n,) array
        At equally spaced times [V]; the transducer is taken to be smooth between them.
    step : float
        Between samples [s].
    substeps : int
        Steps of the card between samples.
    card : CardNumbers
        The card.
    state : (16,) array
        At the first sample; changed.

    Returns
    -------
    (n, 9) array
        One column per name of `OUTPUTS` [V].
    """
    count = transducer.shape[0]
    work = np.empty((2, EXTENDED))
    result = np.empty((count, len(OUTPUTS)))
    outputs(state, transducer[0], card, work, result[0])
    for k in range(count - 1):
        # A parabola through this sample and the next, from where the slope of the last one left.
        slope = (transducer[k + 1] - transducer[k]) / step
        if 0 < k < count - 2:
            before = transducer[k] - transducer[k - 1]
            after = transducer[k + 2] - transducer[k + 1]
            curvature = (after - before) / (2.0 * step * step)
        else:
            curvature = 0.0
        start = slope - 0.5 * curvature * step
        for i in range(substeps):
            passed = i * step / substeps
            advance_card(
                state,
                transducer[k] + (start + 0.5 * curvature * passed) * passed,
                start + curvature * passed,
                curvature,
                demand[k],
                card,
                work,
            )
        outputs(state, transducer[k + 1], card, work, result[k + 1])
    return result
