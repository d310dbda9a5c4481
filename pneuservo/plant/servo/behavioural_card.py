"""The servo with effects under the behavioural card; see `pneuservo.plant.behavioural_card`."""

import math

import numpy as np

from analog_card.behaviour_kernel import OUTPUTS as CARD_OUTPUTS
from analog_card.behaviour_kernel import outputs as card_outputs
from analog_card.differentiator_kernel import EXTENDED
from pneuservo.plant.behavioural_card import CONTROL, mean_voltage, write_voltages
from pneuservo.plant.compilation import compiled
from pneuservo.plant.servo.chain import moving_reading, piston_acceleration, reading
from pneuservo.plant.servo.drift import drifted
from pneuservo.plant.servo.events import settle
from pneuservo.plant.servo.layout import (
    COMMAND,
    INPUTS,
    MEMORY,
    OUTPUTS,
    PAST_COLUMNS,
    PAST_ROWS,
    TIME,
)
from pneuservo.plant.servo.memory import record
from pneuservo.plant.servo.run import advance, shut_spool, start, write_drive, write_output
from pneuservo.plant.single_axis import DISPLACEMENT, PRESSURE_A


@compiled
def run_servo_with_card(
    inputs, initial_state, card_state, sensitivity, steps, substeps, card, servo, grid
):
    """Return the outputs at every time of a run under the behavioural card.

    Parameters
    ----------
    inputs, initial_state, servo, grid
        As in `pneuservo.plant.servo.run.run_servo`, the times equally spaced and the demand [m] in
        the place of the command. The law of `servo` is open loop: the card's mean voltage is held
        over a step.
    card_state : (16,) array
        At the first time; changed.
    sensitivity : float
        Displacement transducer [V/m].
    steps, substeps : int
        Steps of the servo from one time to the next, and of the card in each.
    card : CardNumbers
        The card, for steps of this length.

    Returns
    -------
    (n, 15) array
        As `pneuservo.plant.servo.run.run_servo`, with the voltages of the card.
    """
    state = initial_state.copy()
    work, result = np.empty((3, state.shape[0])), np.empty_like(state)
    card_work, voltages = np.empty((2, EXTENDED)), np.empty(len(CARD_OUTPUTS))
    outputs = np.empty((inputs.shape[0], len(OUTPUTS)))
    modes, memory = np.zeros(3, np.int64), np.zeros(MEMORY)
    rows, drive = np.empty((PAST_ROWS, PAST_COLUMNS)), np.empty((2, INPUTS))
    delayed = servo.effects.spool.delay > 0.0 or servo.effects.line.delay > 0.0
    for k in range(inputs.shape[0]):
        interval = inputs[min(k + 1, inputs.shape[0] - 1), TIME] - inputs[k, TIME]
        write_drive(inputs, k, interval, drive)
        demand = inputs[k, COMMAND]
        now = drifted(servo, inputs[k, TIME])
        transducer = sensitivity * reading(state, 0.0, drive, 0.0, now)[0]
        card_outputs(card_state, transducer, card, card_work, voltages)
        drive[0, COMMAND] = voltages[CONTROL]
        if k == 0:
            start(state, modes, memory, rows, drive, now, grid)
        settle(state, modes, memory, rows, drive, 0.0, now)
        if delayed:
            record(state, modes, memory, rows, drive, 0.0, now, grid)
        write_output(state, modes, memory, rows, drive, now, grid, outputs[k])
        write_voltages(voltages, outputs[k])
        if k + 1 == inputs.shape[0] or not math.isfinite(state[DISPLACEMENT] + state[PRESSURE_A]):
            outputs[k + 1 :] = math.nan
            break
        duration = interval / steps
        for i in range(steps):
            elapsed = interval * i / steps
            second = piston_acceleration(state, modes, memory, drive, elapsed, now)
            drive[0, COMMAND] = mean_voltage(
                card_state,
                moving_reading(state, second, drive, elapsed, now),
                sensitivity,
                demand,
                duration,
                substeps,
                card,
                card_work,
            )
            settle(state, modes, memory, rows, drive, elapsed, now)
            advance(
                state,
                elapsed,
                interval * (i + 1) / steps,
                modes,
                memory,
                rows,
                drive,
                now,
                grid,
                work,
                result,
            )
            shut_spool(state)
    return outputs
