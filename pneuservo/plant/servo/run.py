"""Fixed Runge-Kutta steps of the servo with effects, with events located inside a step."""

import math

import numpy as np

from pneuservo.plant.analogue_card import differentiator_output
from pneuservo.plant.control_law import CARD_TAPS, HELD_VOLTAGE, limited
from pneuservo.plant.copying import put
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.integrator import (
    MOST_EVENTS_PER_STEP,
    MOST_TRIALS,
    SMALLEST_OPENING,
    TIME_TOLERANCE,
)
from pneuservo.plant.outputs import (
    ACCELERATION_OUT,
    CARD_ACCELERATION_OUT,
    CARD_VELOCITY_OUT,
    DISPLACEMENT_OUT,
    PRESSURE_A_OUT,
    PRESSURE_B_OUT,
    SPOOL_OUT,
    SURFACE_OUT,
    VELOCITY_OUT,
    VOLTAGE_OUT,
)
from pneuservo.plant.piston import acceleration
from pneuservo.plant.servo.chain import commanded_voltage, derivative, heard, surface
from pneuservo.plant.servo.compilation import compiled, compiled_apart, compiled_whole
from pneuservo.plant.servo.drift import drifted
from pneuservo.plant.servo.drive import given
from pneuservo.plant.servo.events import margin, margin_apart, motion_at_start, settle
from pneuservo.plant.servo.layout import (
    DISPLACEMENT_NOISE,
    FLOW_A_OUT,
    FLOW_B_OUT,
    INPUTS,
    MEMORY,
    OUTPUTS,
    PAST_COLUMNS,
    PAST_ROWS,
    SERVO_STATES,
    SUPPLY,
    SUPPLY_OUT,
    TEMPERATURE_A,
    TEMPERATURE_A_OUT,
    TEMPERATURE_B,
    TEMPERATURE_B_OUT,
    TIME,
)
from pneuservo.plant.servo.mechanics import force_and_piston
from pneuservo.plant.servo.memory import begin, record, remember
from pneuservo.plant.servo.pneumatics import flows_at_cylinder
from pneuservo.plant.servo.valve_side import supply_at_valve, temperature_of, valve_flows
from pneuservo.plant.single_axis import (
    CARD_DERIVATIVE_1,
    CARD_DERIVATIVE_2,
    DISPLACEMENT,
    MOTION,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    RELAY_SIGN,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
)

# Classical Runge-Kutta: where each stage lies, and the weight of its rate.
_STAGE_AT = (0.0, 0.5, 0.5, 1.0)
_WEIGHT = (1.0, 2.0, 2.0, 1.0)


@compiled
def step_through(state, step, modes, memory, rows, drive, elapsed, servo, grid, work, result):
    """Write the state one step later, modes and memory staying as they are.

    Parameters
    ----------
    state, modes, memory, rows, drive, elapsed, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    step : float
        Length of the step [s].
    work : (3, n) array
        Overwritten.
    result : (n,) array
        Written: the state after the step; must not be `state` itself.

    Notes
    -----
    One call of the derivative in a loop: it is long, and compiled in place.
    """
    stage, rate, total = work[0], work[1], work[2]
    long = state.shape[0] > PLANT_STATES
    for i in range(PLANT_STATES):
        stage[i], total[i] = state[i], 0.0
    if long:
        for i in range(PLANT_STATES, SERVO_STATES):
            stage[i], total[i] = state[i], 0.0
    for k in range(4):
        at = elapsed + _STAGE_AT[k] * step
        derivative(stage, modes, memory, rows, drive, at, servo, grid, rate)
        weight, ahead = _WEIGHT[k], _STAGE_AT[min(k + 1, 3)] * step
        for i in range(PLANT_STATES):
            total[i] += weight * rate[i]
            stage[i] = state[i] + ahead * rate[i]
        if long:
            for i in range(PLANT_STATES, SERVO_STATES):
                total[i] += weight * rate[i]
                stage[i] = state[i] + ahead * rate[i]
    for i in range(PLANT_STATES):
        result[i] = state[i] + step / 6.0 * total[i]
    if long:
        for i in range(PLANT_STATES, SERVO_STATES):
            result[i] = state[i] + step / 6.0 * total[i]


@compiled
def advance(state, start, end, modes, memory, rows, drive, servo, grid, work, result):
    """Advance the state from one moment of an interval to another, through every event.

    Parameters
    ----------
    state : array
        Changed.
    start, end : float
        Since the last sample [s].
    modes, memory, rows
        Changed.
    drive, servo, grid, work, result
        As in `step_through`; `result` is overwritten.

    Notes
    -----
    Events are located as in `pneuservo.plant.integrator.locate_event`, by regula falsi with
    Illinois weights on steps repeated from the same start.
    """
    elapsed, remaining = start, end - start
    events, trials, kept = 0, 0, 0
    locating, last = False, False
    before = after = margin_before = margin_after = 0.0
    trial = remaining
    while True:
        step_through(state, trial, modes, memory, rows, drive, elapsed, servo, grid, work, result)
        if not last:
            found = margin(result, modes, memory, rows, drive, elapsed + trial, servo)
            if not locating:
                if not found < 0.0 or events == MOST_EVENTS_PER_STEP:
                    put(result, state)
                    remember(state, modes, memory, rows, drive, elapsed + trial, trial, servo, grid)
                    return
                locating, trials, kept = True, 0, 0
                before, after, margin_after = 0.0, trial, found
                margin_before = margin_apart(state, modes, memory, rows, drive, elapsed, servo)
            elif found < 0.0:
                after, margin_after = trial, found
                if kept == -1:
                    margin_before *= 0.5
                kept = -1
            else:
                before, margin_before = trial, found
                if kept == 1:
                    margin_after *= 0.5
                kept = 1
            width = after - before
            last = width <= TIME_TOLERANCE or trials == MOST_TRIALS
            trials += 1
            trial = after
            if not last:
                share = 0.5
                if margin_before != 0.0:
                    share = margin_after / (margin_after - margin_before)
                trial -= width * min(max(share, 0.01), 0.99)
            continue
        put(result, state)
        elapsed += trial
        remember(state, modes, memory, rows, drive, elapsed, trial, servo, grid)
        settle(state, modes, memory, rows, drive, elapsed, servo)
        remaining -= trial
        events += 1
        locating = last = False
        if remaining <= 0.0:
            return
        trial = remaining


@compiled_apart
def write_output(state, modes, memory, rows, drive, servo, grid, output):
    """Write the outputs just after a sample.

    Parameters
    ----------
    state, modes, memory, rows, drive, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    output : (15,) array
        Written: places as in `layout.OUTPUTS`, NaN where there is none.
    """
    law = servo.law
    force, held = force_and_piston(state, modes, memory, drive, 0.0, servo)
    second = acceleration(force, modes[MOTION], held)
    displacement, velocity, heard_second = heard(state, second, servo)
    for i in range(output.shape[0]):
        output[i] = math.nan
    output[DISPLACEMENT_OUT], output[VELOCITY_OUT] = displacement, velocity
    output[ACCELERATION_OUT] = heard_second
    output[PRESSURE_A_OUT], output[PRESSURE_B_OUT] = state[PRESSURE_A], state[PRESSURE_B]
    output[SPOOL_OUT] = state[SPOOL]
    command = commanded_voltage(state, modes, memory, drive, 0.0, servo)
    output[VOLTAGE_OUT] = limited(command, law.level)
    if law.source != HELD_VOLTAGE:
        output[SURFACE_OUT] = surface(state, modes, memory, drive, 0.0, servo)
    if law.source == CARD_TAPS:
        output[CARD_VELOCITY_OUT] = differentiator_output(
            state[CARD_DERIVATIVE_1], law.velocity_time_constant
        )
        output[CARD_ACCELERATION_OUT] = differentiator_output(
            state[CARD_DERIVATIVE_2], law.acceleration_time_constant
        )
    supply = supply_at_valve(state, drive, 0.0, servo)
    output[SUPPLY_OUT] = supply
    output[TEMPERATURE_A_OUT] = temperature_of(state, TEMPERATURE_A, servo)
    output[TEMPERATURE_B_OUT] = temperature_of(state, TEMPERATURE_B, servo)
    flow_a, flow_b, _ = valve_flows(state[SPOOL], state, memory, supply, servo, grid)
    output[FLOW_A_OUT], output[FLOW_B_OUT] = flows_at_cylinder(
        flow_a, flow_b, state, memory, rows, given(drive, TIME, 0.0), servo
    )


@compiled
def write_drive(inputs, k, interval, drive):
    """Write the inputs of an interval and their rates: what is not held runs straight.

    Parameters
    ----------
    inputs : (n, 5) array
        As in `run_servo`.
    k : int
        The sample at which the interval begins.
    interval : float
        Its length [s].
    drive : (2, 5) array
        Written.
    """
    following = min(k + 1, inputs.shape[0] - 1)
    for i in range(INPUTS):
        drive[0, i] = inputs[k, i]
        drive[1, i] = 0.0
        if i in (SUPPLY, DISPLACEMENT_NOISE, TIME) and interval > 0.0:
            drive[1, i] = (inputs[following, i] - inputs[k, i]) / interval


@compiled_apart
def start(state, modes, memory, rows, drive, servo, grid):
    """Write modes, memory and past at the start of a run.

    Parameters
    ----------
    state, modes, memory, rows, drive, servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    """
    modes[MOTION], modes[RELAY_SIGN], modes[SPOOL_LIMIT] = 0, 1, SPOOL_FREE
    if abs(state[SPOOL]) >= 1.0:
        modes[SPOOL_LIMIT] = 1 if state[SPOOL] > 0.0 else -1
    begin(state, modes, memory, rows, drive, servo, grid)
    motion_at_start(state, modes, memory, drive, servo)


@compiled
def shut_spool(state):
    """Bring a spool that has all but reached its middle to rest there.

    Parameters
    ----------
    state : array
        Changed.
    """
    if abs(state[SPOOL]) < SMALLEST_OPENING and abs(state[SPOOL_RATE]) < SMALLEST_OPENING:
        state[SPOOL] = 0.0
        state[SPOOL_RATE] = 0.0


@compiled_whole
def run_servo(inputs, initial_state, servo, grid, largest_step):
    """Return the outputs at every time of a run.

    Parameters
    ----------
    inputs : (n, 5) array
        Columns as in `layout`; the last is the time, strictly increasing [s]. Command and external
        force hold until the next row, supply and noise run straight to it.
    initial_state : (6,) or (27,) array
        In SI; six when no effect and no card has a state of its own.
    servo, grid
        As in `pneuservo.plant.servo.chain.derivative`.
    largest_step : float
        The intervals are divided into equal steps no longer than this [s].

    Returns
    -------
    (n, 15) array
        One column per name of `layout.OUTPUTS`, in SI, each row just after its time: motion as
        the displacement transducer has it but for noise and range, pressures as they are. NaN
        where there is none.
    """
    state = initial_state.copy()
    work, result = np.empty((3, state.shape[0])), np.empty_like(state)
    outputs = np.empty((inputs.shape[0], len(OUTPUTS)))
    modes, memory = np.zeros(3, np.int64), np.zeros(MEMORY)
    rows, drive = np.empty((PAST_ROWS, PAST_COLUMNS)), np.empty((2, INPUTS))
    write_drive(inputs, 0, 0.0, drive)
    start(state, modes, memory, rows, drive, drifted(servo, inputs[0, TIME]), grid)
    delayed = servo.effects.spool.delay > 0.0 or servo.effects.line.delay > 0.0
    for k in range(inputs.shape[0]):
        interval = inputs[min(k + 1, inputs.shape[0] - 1), TIME] - inputs[k, TIME]
        write_drive(inputs, k, interval, drive)
        now = drifted(servo, inputs[k, TIME])
        settle(state, modes, memory, rows, drive, 0.0, now)
        if delayed:
            record(state, modes, memory, rows, drive, 0.0, now, grid)
        write_output(state, modes, memory, rows, drive, now, grid, outputs[k])
        steps, _ = steps_between(0.0, interval, largest_step)
        if k + 1 == inputs.shape[0] or not math.isfinite(state[DISPLACEMENT] + state[PRESSURE_A]):
            outputs[k + 1 :] = math.nan
            break
        for i in range(steps):
            advance(
                state,
                interval * i / steps,
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
