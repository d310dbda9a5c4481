"""The plant while a sampled controller holds its voltage, a card's differentiators beside it."""

import numpy as np

from pneuservo.plant.analogue_card import differentiator_output, differentiator_rates
from pneuservo.plant.compilation import compiled
from pneuservo.plant.events import settle
from pneuservo.plant.integrator import advance
from pneuservo.plant.outputs import output_values
from pneuservo.plant.single_axis import DISPLACEMENT, PLANT_STATES

# States of the two stages, and the offsets of the four stages of a Runge-Kutta step.
TAPS = 4
_STAGE_AT = (0.0, 0.5, 0.5, 1.0)
_WEIGHT = (1.0, 2.0, 2.0, 1.0)


@compiled
def advance_taps(taps, before, after, step, card, work):
    """Advance the differentiators by one step.

    Parameters
    ----------
    taps : (4,) array
        Lagged input and derivative of each stage; changed.
    before, after : float
        Transducer voltage at both ends of the step, straight between them [V].
    step : float
        [s].
    card : ControlLaw
        Its time constants.
    work : (3, 4) array
        Overwritten.
    """
    stage, rate, total = work[0], work[1], work[2]
    for i in range(TAPS):
        stage[i], total[i] = taps[i], 0.0
    for k in range(4):
        signal = before + _STAGE_AT[k] * (after - before)
        rate[0], rate[1] = differentiator_rates(
            signal, stage[0], stage[1], card.velocity_lag_1, card.velocity_lag_2
        )
        rate[2], rate[3] = differentiator_rates(
            differentiator_output(stage[1], card.velocity_time_constant),
            stage[2],
            stage[3],
            card.acceleration_lag_1,
            card.acceleration_lag_2,
        )
        ahead = _STAGE_AT[min(k + 1, 3)] * step
        for i in range(TAPS):
            total[i] += _WEIGHT[k] * rate[i]
            stage[i] = taps[i] + ahead * rate[i]
    for i in range(TAPS):
        taps[i] += step / 6.0 * total[i]


@compiled
def hold_voltage(state, modes, taps, noise, held, duration, steps, card, law, plant, grid):
    """Advance plant and differentiators, and return the outputs at the end.

    Parameters
    ----------
    state : (6,) array
        Of the plant, in SI; changed.
    modes : (3,) array of int
        Changed.
    taps : (4,) array
        As in `advance_taps`; changed.
    noise : (n,) array
        Added to the transducer voltage over each step [V]; empty when nothing reads the taps.
    held : (2,) array
        Voltage into the valve driver [V] and external force [N].
    duration : float
        [s]; 0 only brings the modes into line with what is held.
    steps : int
        Equal steps of it.
    card : ControlLaw
        Time constants of the differentiators and gain of the transducer.
    law : ControlLaw
        `pneuservo.plant.control_law.OPEN_LOOP`.
    plant, grid
        As in `pneuservo.plant.single_axis.derivative`.

    Returns
    -------
    tuple of 10 floats
        In the order of `pneuservo.plant.outputs.OUTPUTS`.
    """
    work, result = np.empty((3, PLANT_STATES)), np.empty(PLANT_STATES)
    taps_work = np.empty((3, TAPS))
    settle(state, modes, held, law, plant)
    if duration > 0.0:
        step = duration / steps
        for k in range(steps):
            before = card.sensitivity * state[DISPLACEMENT]
            advance(state, step, modes, held, law, plant, grid, work, result)
            if noise.shape[0] > 0:
                after = card.sensitivity * state[DISPLACEMENT]
                advance_taps(taps, before + noise[k], after + noise[k], step, card, taps_work)
    return output_values(state, modes, held, law, plant)
