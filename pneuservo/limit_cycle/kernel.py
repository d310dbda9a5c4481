"""The compiled plant under a controller that looks at it in ticks: filters, sampler and surface."""

import math

import numpy as np

from pneuservo.arrays import Array
from pneuservo.plant.compilation import compiled
from pneuservo.plant.control_law import ControlLaw, limited
from pneuservo.plant.events import settle
from pneuservo.plant.integrator import advance, initial_modes
from pneuservo.plant.piston import acceleration
from pneuservo.plant.single_axis import (
    COMMAND,
    DISPLACEMENT,
    MOTION,
    PLANT_STATES,
    SPOOL,
    SPOOL_FREE,
    SPOOL_LIMIT,
    SPOOL_RATE,
    VELOCITY,
    SingleAxis,
    piston_force,
)

# Columns of the result of `run_in_ticks`.
OUTPUTS = ("displacement", "velocity", "acceleration", "surface", "valve_voltage")


@compiled
def limited_switch(surface: float, level: float, layer: float) -> float:
    """Return the voltage for a value of the surface: a relay with a boundary layer [V].

    Parameters
    ----------
    surface : float
        [m/s2].
    level : float
        Largest voltage [V].
    layer : float
        Surface value at which the level is reached; 0 for a relay [m/s2].
    """
    if abs(surface) >= layer:
        return math.copysign(level, surface)
    return level * surface / layer


@compiled
def linear_step(
    state: Array,
    inputs: Array,
    a: Array,
    b: Array,
    c: Array,
    d: Array,
    work: Array,
    outputs: Array,
) -> None:
    """Write the outputs of a discrete linear system and advance it by one step.

    Parameters
    ----------
    state : (n,) array
        Changed.
    inputs : (m,) array
        At this step.
    a, b, c, d : array
        next = a state + b inputs, outputs = c state + d inputs.
    work : (n,) array
        Overwritten.
    outputs : (p,) array
        Written.
    """
    for i in range(outputs.shape[0]):
        total = 0.0
        for j in range(state.shape[0]):
            total += c[i, j] * state[j]
        for j in range(inputs.shape[0]):
            total += d[i, j] * inputs[j]
        outputs[i] = total
    for i in range(state.shape[0]):
        total = 0.0
        for j in range(state.shape[0]):
            total += a[i, j] * state[j]
        for j in range(inputs.shape[0]):
            total += b[i, j] * inputs[j]
        work[i] = total
    for i in range(state.shape[0]):
        state[i] = work[i]


@compiled
def run_in_ticks(
    ticks: int,
    tick: float,
    hold: int,
    demand: float,
    initial_state: Array,
    path: tuple[Array, Array, Array, Array],
    path_state: Array,
    surface: tuple[Array, Array, Array, Array, Array],
    level: float,
    layer: float,
    law: ControlLaw,
    plant: SingleAxis,
    grid: Array,
) -> Array:
    """Return what the plant does under a controller that acts in ticks.

    Parameters
    ----------
    ticks : int
        How many.
    tick : float
        Length of one, and the plant's integration step [s].
    hold : int
        Ticks from one decision of the controller to the next.
    demand : float
        [m].
    initial_state : (6,) array
        Of the plant.
    path : tuple of (n, n), (n, 3), (3, n), (3, 3) array
        Analogue part of the signals, from error, velocity and acceleration to what the controller
        gets, for steps of one tick.
    path_state : (n,) array
        At the first tick; changed.
    surface : tuple of array and state
        What forms the surface with its sign turned from the three, for steps of one decision:
        four matrices and the state at the first.
    level, layer : float
        As in `limited_switch`.
    law : ControlLaw
        `pneuservo.plant.control_law.OPEN_LOOP`: the voltage is held over a tick.
    plant, grid
        As in `pneuservo.plant.single_axis.derivative`. A spool frequency of 0 stands for a spool
        that follows at once.

    Returns
    -------
    (ticks, 5) array
        One column per name of `OUTPUTS`, in SI, each row just after its time.
    """
    state = initial_state.copy()
    work, result = np.empty((3, PLANT_STATES)), np.empty(PLANT_STATES)
    outputs = np.empty((ticks, len(OUTPUTS)))
    held = np.zeros(2)
    modes = initial_modes(state, held, plant)
    a, b, c, d = path
    surface_a, surface_b, surface_c, surface_d, surface_state = surface
    path_work, surface_work = np.empty_like(path_state), np.empty_like(surface_state)
    seen, received, sigma = np.empty(3), np.empty(3), np.zeros(1)
    for k in range(ticks):
        seen[0] = state[DISPLACEMENT] - demand
        seen[1] = state[VELOCITY]
        seen[2] = acceleration(piston_force(state, held, plant), modes[MOTION], plant.piston)
        linear_step(path_state, seen, a, b, c, d, path_work, received)
        if k % hold == 0:
            linear_step(
                surface_state,
                received,
                surface_a,
                surface_b,
                surface_c,
                surface_d,
                surface_work,
                sigma,
            )
            held[COMMAND] = limited_switch(-sigma[0], level, layer)
            if plant.valve.spool_frequency == 0.0:
                state[SPOOL] = limited(held[COMMAND] / plant.valve.full_voltage, 1.0)
                state[SPOOL_RATE] = 0.0
                modes[SPOOL_LIMIT] = SPOOL_FREE
        outputs[k, 0] = state[DISPLACEMENT]
        outputs[k, 1] = seen[1]
        outputs[k, 2] = seen[2]
        outputs[k, 3] = -sigma[0]
        outputs[k, 4] = held[COMMAND]
        settle(state, modes, held, law, plant)
        advance(state, tick, modes, held, law, plant, grid, work, result)
    return outputs
