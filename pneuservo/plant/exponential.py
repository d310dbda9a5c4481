"""One step of an exponential Runge-Kutta method of order 4.

Displacement, velocity and the four filter states of a card by its figures are a linear chain that
the acceleration drives. They are advanced exactly for a course of the acceleration through its
values at the stages (Cox and Matthews 2002, J. Comput. Phys. 176, ETDRK4); pressures and spool
with the weights of the classical Runge-Kutta method, which is what the same formulas are without a
linear part. The filters, the fastest part of the loop, so set no limit to the step.
"""

import numpy as np

from pneuservo.plant.compilation import compiled, compiled_apart
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.plant.integrator import SMALLEST_OPENING
from pneuservo.plant.lane_arrays import load_row, store_row
from pneuservo.plant.lanes import WIDTH, both, select
from pneuservo.plant.single_axis import (
    CARD_DERIVATIVE_1,
    CARD_DERIVATIVE_2,
    CARD_LAGGED_1,
    CARD_LAGGED_2,
    DISPLACEMENT,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    SPOOL_RATE,
    VELOCITY,
    plant_rates,
)

# The chain behind the acceleration: velocity, input less first lagged signal, and the other states.
CHAIN_STATES = 5
# Coefficients of a step, in this order. Over the whole step the four filter states follow from the
# states of the chain up to themselves; over half of it only the two derivatives are needed.
WHOLE_ROWS = ((1, 0, 2), (2, 2, 3), (3, 5, 4), (4, 9, 5))
FORCED = 14
HALF_ROWS = ((2, 26, 3), (4, 29, 5))
HALF_FORCED = 34
COEFFICIENTS = 36
CHAIN_LIKE = (0.0,) * COEFFICIENTS
# The same in whole rows of lanes.
ROWS = -(-COEFFICIENTS // WIDTH)
# Powers of the step kept; enough for steps of `LONGEST_STEP` time constants (4^30/30! is 4e-15).
POWERS = 31
LONGEST_STEP = 4.0
SPOOL_SHARE = 0.5


@compiled
def _chain_matrix(law):
    """Return the rates of the chain per state [1/s]."""
    matrix = np.zeros((CHAIN_STATES, CHAIN_STATES))
    matrix[1, 0] = law.sensitivity
    matrix[1, 1] = -1.0 / law.velocity_lag_1
    matrix[2, 1] = 1.0 / (law.velocity_lag_1 * law.velocity_lag_2)
    matrix[2, 2] = -1.0 / law.velocity_lag_2
    matrix[3, 2] = -law.velocity_time_constant / law.acceleration_lag_1
    matrix[3, 3] = -1.0 / law.acceleration_lag_1
    for column in range(CHAIN_STATES):
        matrix[4, column] = matrix[3, column] / law.acceleration_lag_2
    matrix[4, 4] = -1.0 / law.acceleration_lag_2
    return matrix


@compiled_apart
def step_series(law, longest_step):
    """Return the coefficients of a step as power series of its length.

    Parameters
    ----------
    law : ControlLaw
        With `CARD_TAPS`; otherwise there are no filters, and none of this is used.
    longest_step : float
        Unit of the length; no step may be longer [s].

    Returns
    -------
    (POWERS * ROWS, 8) array
        For every power of the share of the longest step, lowest first, all coefficients.
    """
    series = np.zeros((POWERS, ROWS * WIDTH))
    matrix = _chain_matrix(law) * longest_step
    for column in range(CHAIN_STATES):
        term = np.zeros(CHAIN_STATES)
        term[column] = 1.0
        for power in range(POWERS):
            for row, start, count in WHOLE_ROWS:
                if column < count:
                    series[power, start + column] = term[row]
            for row, start, count in HALF_ROWS:
                if column < count:
                    series[power, start + column] = term[row] * 0.5**power
            if column == 0 and power + 1 < POWERS:
                _add_forced(series[power + 1], term, power, longest_step)
            following = np.zeros(CHAIN_STATES)
            for row in range(CHAIN_STATES):
                for i in range(CHAIN_STATES):
                    following[row] += matrix[row, i] * term[i] / (power + 1.0)
            term = following
    return series.reshape(POWERS * ROWS, WIDTH)


@compiled
def _add_forced(coefficients, term, power, longest_step):
    """Write what an acceleration adds, from a term of the response to a velocity."""
    for row in range(1, CHAIN_STATES):
        first = longest_step * term[row] / (power + 1.0)
        second = first / (power + 2.0)
        third = second / (power + 3.0)
        place = FORCED + 3 * (row - 1)
        coefficients[place] = first - 3.0 * second + 4.0 * third
        coefficients[place + 1] = 2.0 * second - 4.0 * third
        coefficients[place + 2] = 4.0 * third - second
    share = 0.5 ** (power + 1.0)
    coefficients[HALF_FORCED] = longest_step * term[2] / (power + 1.0) * share
    coefficients[HALF_FORCED + 1] = longest_step * term[4] / (power + 1.0) * share


@compiled
def step_coefficients(series, share, coefficients):
    """Write the coefficients of a step.

    Parameters
    ----------
    series : (POWERS * ROWS, 8) array
        From `step_series`.
    share : float
        Length of the step over the longest one [-].
    coefficients : (ROWS * 8,) array
        Written.
    """
    for row in range(ROWS):
        total = load_row(series, (POWERS - 1) * ROWS + row)
        for power in range(POWERS - 2, -1, -1):
            total = total * share + load_row(series, power * ROWS + row)
        store_row(coefficients, row, total)


@compiled
def exponential_step(state, step, chain, modes, inputs, law, plant, grid):
    """Return the state one step later, the modes staying as they are.

    Parameters
    ----------
    state : tuple of 10 floats or Lanes
        Before the step; the last four are not looked at without a card.
    step : float
        Length of the step [s].
    chain : tuple of 36 floats or Lanes
        From `step_coefficients`; not looked at without a card.
    modes, inputs, law, plant, grid
        As in `pneuservo.plant.single_axis.derivative`, as tuples or arrays.

    Returns
    -------
    tuple of 10 floats or Lanes
        After the step.
    """
    half = 0.5 * step
    x, v = state[DISPLACEMENT], state[VELOCITY]
    free = _free_card(state, chain, law)
    k1 = plant_rates(state, modes, inputs, law, plant, grid)
    a1 = k1[VELOCITY]
    card = _card_at_half(state, free, chain, a1, law)
    stage = _stage(x + half * (v + 0.5 * half * a1), v + half * a1, state, half, k1, card)
    k2 = plant_rates(stage, modes, inputs, law, plant, grid)
    a2 = k2[VELOCITY]
    card = _card_at_half(state, free, chain, a2, law)
    stage = _stage(x + half * (v + 0.5 * half * a2), v + half * a2, state, half, k2, card)
    k3 = plant_rates(stage, modes, inputs, law, plant, grid)
    a3 = k3[VELOCITY]
    card = _card_before_end(state, free, chain, a1, a3, law)
    stage = _stage(x + step * (v + 0.5 * half * (a1 + a3)), v + step * a3, state, step, k3, card)
    k4 = plant_rates(stage, modes, inputs, law, plant, grid)
    a4, between = k4[VELOCITY], a2 + a3

    sixth = step / 6.0
    x += step * (v + sixth * (a1 + between))
    v += sixth * (a1 + 2.0 * between + a4)
    spool = _weighted(state, sixth, k1, k2, k3, k4, SPOOL)
    spool_rate = _weighted(state, sixth, k1, k2, k3, k4, SPOOL_RATE)
    at_null = both(abs(spool) < SMALLEST_OPENING, abs(spool_rate) < SMALLEST_OPENING)
    of_plant = (
        x,
        v,
        _weighted(state, sixth, k1, k2, k3, k4, PRESSURE_A),
        _weighted(state, sixth, k1, k2, k3, k4, PRESSURE_B),
        select(at_null, 0.0, spool),
        select(at_null, 0.0, spool_rate),
    )
    return of_plant + _card_at_end(x, state, free, chain, (a1, between, a4), law)


@compiled
def _card_states(state):
    return (
        state[CARD_LAGGED_1],
        state[CARD_DERIVATIVE_1],
        state[CARD_LAGGED_2],
        state[CARD_DERIVATIVE_2],
    )


@compiled
def _free_card(state, chain, law):
    """Return what the card's states would be without acceleration.

    First the two derivatives half a step later, then the four states of the chain a step later.
    """
    v, z2 = state[VELOCITY], state[CARD_LAGGED_2]
    d1, d2 = state[CARD_DERIVATIVE_1], state[CARD_DERIVATIVE_2]
    if law.source != CARD_TAPS:
        return d1, d2, d1, d1, d1, d2
    y1 = law.sensitivity * state[DISPLACEMENT] - state[CARD_LAGGED_1]
    return (
        chain[26] * v + chain[27] * y1 + chain[28] * d1,
        chain[29] * v + chain[30] * y1 + chain[31] * d1 + chain[32] * z2 + chain[33] * d2,
        chain[0] * v + chain[1] * y1,
        chain[2] * v + chain[3] * y1 + chain[4] * d1,
        chain[5] * v + chain[6] * y1 + chain[7] * d1 + chain[8] * z2,
        chain[9] * v + chain[10] * y1 + chain[11] * d1 + chain[12] * z2 + chain[13] * d2,
    )


@compiled
def _card_at_half(state, free, chain, acceleration, law):
    """Return the two derivatives of the card at a stage half a step later."""
    if law.source != CARD_TAPS:
        return state[CARD_DERIVATIVE_1], state[CARD_DERIVATIVE_2]
    return free[0] + chain[34] * acceleration, free[1] + chain[35] * acceleration


@compiled
def _card_before_end(state, free, chain, first, third, law):
    """Return the two derivatives of the card at the last stage."""
    if law.source != CARD_TAPS:
        return state[CARD_DERIVATIVE_1], state[CARD_DERIVATIVE_2]
    push_1, push_2 = chain[34], chain[35]
    whole_1 = chain[17] + 2.0 * (chain[18] - push_1) + chain[19]
    whole_2 = chain[23] + 2.0 * (chain[24] - push_2) + chain[25]
    return (
        free[3] + whole_1 * first + 2.0 * push_1 * third,
        free[5] + whole_2 * first + 2.0 * push_2 * third,
    )


@compiled
def _card_at_end(displacement, state, free, chain, accelerations, law):
    """Return the four states of the card at the end of the step."""
    if law.source != CARD_TAPS:
        return _card_states(state)
    a1, between, a4 = accelerations
    y1 = free[2] + chain[14] * a1 + chain[15] * between + chain[16] * a4
    return (
        law.sensitivity * displacement - y1,
        free[3] + chain[17] * a1 + chain[18] * between + chain[19] * a4,
        free[4] + chain[20] * a1 + chain[21] * between + chain[22] * a4,
        free[5] + chain[23] * a1 + chain[24] * between + chain[25] * a4,
    )


@compiled
def _stage(displacement, velocity, state, step, rates, derivatives):
    """Return the state at a stage; the lagged signals of the card have no part in the rates."""
    return (
        displacement,
        velocity,
        state[PRESSURE_A] + step * rates[PRESSURE_A],
        state[PRESSURE_B] + step * rates[PRESSURE_B],
        state[SPOOL] + step * rates[SPOOL],
        state[SPOOL_RATE] + step * rates[SPOOL_RATE],
        state[CARD_LAGGED_1],
        derivatives[0],
        state[CARD_LAGGED_2],
        derivatives[1],
    )


@compiled
def _weighted(state, sixth, k1, k2, k3, k4, place):
    return state[place] + sixth * (k1[place] + 2.0 * (k2[place] + k3[place]) + k4[place])


def step_limit(plant, law):
    """Return the longest step that makes sense for a rig under a law [s].

    Parameters
    ----------
    plant : SingleAxis
        Its spool is resolved in steps of no more than half its time constant.
    law : ControlLaw
        The filters of its card, if it has one, are within the series of the coefficients.
    """
    limit = SPOOL_SHARE / plant.valve.spool_frequency
    if law.source == CARD_TAPS:
        velocity_lag = min(law.velocity_lag_1, law.velocity_lag_2)
        acceleration_lag = min(law.acceleration_lag_1, law.acceleration_lag_2)
        limit = min(limit, LONGEST_STEP * min(velocity_lag, acceleration_lag))
    return limit
