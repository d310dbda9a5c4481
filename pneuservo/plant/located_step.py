"""A step of the exponential method through every event inside it."""

import math

from pneuservo.plant.compilation import compiled, compiled_apart
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.plant.events import happen, margin, margins
from pneuservo.plant.exponential import CHAIN_LIKE, exponential_step, step_coefficients
from pneuservo.plant.lane_arrays import load_tuple
from pneuservo.plant.single_axis import MODES_LIKE, STATE_LIKE, card_rates, plant_rates

# A zero this close is reached along the tangent, whose error is its square times a rate of 1e4/s.
NEAR = 2e-8
# An event that has no slope to follow is located to this by halving [s].
TIME_TOLERANCE = 1e-12
MOST_TRIALS = 100
# A step with more events than this is taken to its end as it is, so that no input can hang a run.
MOST_EVENTS_PER_STEP = 100
# Time over which the slope of a margin is taken; margins are linear in the state [s].
_SLOPE_TIME = 1e-6


@compiled
def _along(state, rates, duration):
    """Return the state a little later, along its rates."""
    return (
        state[0] + duration * rates[0],
        state[1] + duration * rates[1],
        state[2] + duration * rates[2],
        state[3] + duration * rates[3],
        state[4] + duration * rates[4],
        state[5] + duration * rates[5],
        state[6] + duration * rates[6],
        state[7] + duration * rates[7],
        state[8] + duration * rates[8],
        state[9] + duration * rates[9],
    )


@compiled
def _all_rates(state, modes, inputs, law, plant, grid):
    of_card = (0.0, 0.0, 0.0, 0.0)
    if law.source == CARD_TAPS:
        of_card = card_rates(state, law)
    return plant_rates(state, modes, inputs, law, plant, grid) + of_card


@compiled
def _tangent(state, modes, inputs, law, plant, grid):
    """Return rates, margins and the slopes of the margins."""
    rates = _all_rates(state, modes, inputs, law, plant, grid)
    now = margins(state, modes, inputs, law, plant)
    later = margins(_along(state, rates, _SLOPE_TIME), modes, inputs, law, plant)
    slopes = (
        (later[0] - now[0]) / _SLOPE_TIME,
        (later[1] - now[1]) / _SLOPE_TIME,
        (later[2] - now[2]) / _SLOPE_TIME,
        (later[3] - now[3]) / _SLOPE_TIME,
    )
    return rates, now, slopes


@compiled
def _zero_of_cubic(before, slope_before, after, slope_after):
    """Return where the cubic through two ends of the unit interval comes to zero.

    `before` is not negative, `after` is. Newton from the end, within a bracket.
    """
    # before + share (slope + share (b + share c))
    c = slope_before + slope_after + 2.0 * (before - after)
    b = -(2.0 * slope_before + slope_after + 3.0 * (before - after))
    low, high, share = 0.0, 1.0, 1.0
    for _ in range(20):
        value = before + share * (slope_before + share * (b + share * c))
        if value < 0.0:
            high = share
        else:
            low = share
        following = share - value / (slope_before + share * (2.0 * b + 3.0 * share * c))
        if not low <= following <= high:
            following = 0.5 * (low + high)
        moved = abs(following - share)
        share = following
        if moved < 1e-5:
            break
    return share


@compiled
def _earliest(before, slopes_before, after, slopes_after, duration):
    """Return which margin comes to its zero first within a step, and when [s]."""
    event, reached = 0, math.inf
    for i in range(len(before)):
        if after[i] < 0.0:
            share = _zero_of_cubic(
                max(before[i], 0.0),
                duration * slopes_before[i],
                after[i],
                duration * slopes_after[i],
            )
            if share * duration < reached:
                event, reached = i, share * duration
    return event, reached


@compiled
def store(values, array):
    """Write a tuple into an array."""
    for i in range(len(values)):
        array[i] = values[i]


@compiled
def _locate(
    start, end, duration, modes, inputs, law, plant, grid, series, longest_step, coefficients
):
    """Return the state just at the first event of a step, which event, and when [s].

    `start` and `end` are the states at both ends of the step, the second beyond an event.
    """
    low, high, trial = 0.0, duration, duration
    event, reached, point = -1, duration, start
    before = slopes_before = (0.0, 0.0, 0.0, 0.0)
    for trials in range(MOST_TRIALS):
        if trials == 1:
            point = end
        elif trials > 1:
            if law.source == CARD_TAPS:
                step_coefficients(series, trial / longest_step, coefficients)
            chain = load_tuple(coefficients, CHAIN_LIKE)
            point = exponential_step(start, trial, chain, modes, inputs, law, plant, grid)
        rates, now, slopes = _tangent(point, modes, inputs, law, plant, grid)
        if trials == 0:
            before, slopes_before = now, slopes
            continue
        if trials == 1:
            event, trial = _earliest(before, slopes_before, now, slopes, duration)
            continue
        if now[event] < 0.0:
            high = trial
        else:
            low = trial
        correction = -now[event] / slopes[event]
        if high - low <= TIME_TOLERANCE or trials == MOST_TRIALS - 1:
            correction = high - trial
        elif not abs(correction) <= NEAR:
            trial += correction
            if not low < trial < high:
                trial = 0.5 * (low + high)
            continue
        reached = min(trial + correction, duration)
        point = _along(point, rates, correction)
        break
    return point, event, reached


@compiled_apart
def through_events(
    state, modes, end, duration, inputs, law, plant, grid, series, longest_step, coefficients
):
    """Advance the state over one step, through every event inside it.

    Parameters
    ----------
    state : (10,) array
        At the start of the step; changed.
    modes : (3,) array
        Changed at events.
    end : tuple of 10 floats
        The state at the end of the step if nothing happened, which is beyond an event.
    duration : float
        Length of the step [s].
    inputs, law, plant, grid
        As in `pneuservo.plant.single_axis.derivative`.
    series : (POWERS * ROWS, 8) array
        From `pneuservo.plant.exponential.step_series`.
    longest_step : float
        That of the series [s].
    coefficients : (ROWS * 8,) array
        Overwritten.

    Notes
    -----
    The zero of a margin is guessed on the cubic through both ends of the step, the step repeated
    up to there from the same start, and the rest gone along the tangent; where that does not
    get there, by halving. The state at the event so has the error of a step and not of an
    interpolation.
    """
    remaining = duration
    for _ in range(MOST_EVENTS_PER_STEP):
        start, modes_now = load_tuple(state, STATE_LIKE), load_tuple(modes, MODES_LIKE)
        point, event, reached = _locate(
            start,
            end,
            remaining,
            modes_now,
            inputs,
            law,
            plant,
            grid,
            series,
            longest_step,
            coefficients,
        )
        store(point, state)
        happen(event, state, modes, inputs, law, plant)
        remaining -= reached
        if remaining <= 0.0:
            return
        if law.source == CARD_TAPS:
            step_coefficients(series, remaining / longest_step, coefficients)
        chain = load_tuple(coefficients, CHAIN_LIKE)
        start, modes_now = load_tuple(state, STATE_LIKE), load_tuple(modes, MODES_LIKE)
        end = exponential_step(start, remaining, chain, modes_now, inputs, law, plant, grid)
        if margin(end, modes_now, inputs, law, plant) >= 0.0:
            break
    store(end, state)
