"""Pneumatic axes coupled through the links they drive and the frame these stand on.

Each axis is the chain of `pneuservo.plant.single_axis`, unchanged: what couples it to the others is
the force at its rod, which follows from the accelerations of all of them.
"""

from typing import NamedTuple

import numpy as np

from pneuservo.manipulator.linkage import (
    Linkage,
    base_coupling,
    base_force,
    gravity_torque,
    mass_matrix,
    velocity_torque,
)
from pneuservo.plant.compilation import compiled, compiled_apart
from pneuservo.plant.control_law import CARD_TAPS
from pneuservo.plant.copying import put
from pneuservo.plant.equal_steps import steps_between
from pneuservo.plant.events import settle
from pneuservo.plant.integrator import SMALLEST_OPENING, initial_modes
from pneuservo.plant.lane_arrays import load_tuple
from pneuservo.plant.outputs import OUTPUTS, output_values
from pneuservo.plant.piston import AT_REST, acceleration, is_moving, stop_margin
from pneuservo.plant.single_axis import (
    COMMAND,
    DISPLACEMENT,
    EXTERNAL_FORCE,
    MOTION,
    PLANT_STATES,
    SPOOL,
    SPOOL_RATE,
    STATE_LIKE,
    STATES_WITH_CARD,
    VELOCITY,
    card_rates,
    piston_force,
    plant_rates,
)

# Places in the frame's state, and in its row of outputs behind them.
SWAY, SWAY_RATE, SWAY_ACCELERATION = range(3)
ROD_FORCE_OUT = len(OUTPUTS)
# So many rounds of breaking away and coming to rest at one moment, and the rest waits for the next.
_MOST_ROUNDS = 30


class Coupling(NamedTuple):
    """What joins the axes: levers, links and frame."""

    linkage: Linkage
    levers: np.ndarray
    """(n,): rod displacement per joint angle [m/rad]."""
    middles: np.ndarray
    """(n,): rod displacement at joint angle 0 [m]."""
    gravity: float
    """[m/s^2]."""
    frame_mass: float
    """Without the links [kg]."""
    frame_stiffness: float
    """Horizontal [N/m]."""
    frame_damping: float
    """Horizontal [N s/m]."""


@compiled_apart
def coupled_accelerations(state, modes, frame, numbers, like, coupling):
    """Return the accelerations of rods and frame, and the forces at the rods.

    Parameters
    ----------
    state : (n, 10) array
        Of the axes; places as in `pneuservo.plant.single_axis`.
    modes : (n, 3) array of int
        Of the axes.
    frame : (2,) array
        Displacement and velocity of the frame [m], [m/s].
    numbers : (n, k) array
        The floats of law and plant of each axis.
    like : ControlLaw, SingleAxis
        How they are arranged, and what kind of law it is.
    coupling : Coupling
        What joins the axes.

    Returns
    -------
    accelerations : (n + 1,) array
        Of the rods and of the frame [m/s^2].
    forces : (n,) array
        At the rods, positive when they resist extension [N].

    Notes
    -----
    Lagrange's equations in the displacements of the rods and of the frame, rigid levers of
    constant length. A piston that rests has no acceleration; what its friction or stop has to
    hold is its driving force less the force at its rod.
    """
    n = state.shape[0]
    pushing, moved = np.zeros(n + 1), np.zeros(n)
    rates = np.zeros(n)
    for i in range(n):
        _, plant = load_tuple(numbers[i], like)
        force = piston_force(state[i], (0.0, 0.0), plant)
        moved[i] = plant.piston.mass
        pushing[i] = moved[i] * acceleration(force, modes[i, MOTION], plant.piston)
        if is_moving(modes[i, MOTION]):
            rates[i] = state[i, VELOCITY] / coupling.levers[i]
    angles = _joint_angles(state, coupling)
    masses, resisting = _mechanics(angles, rates, frame, coupling)
    joined = masses.copy()
    for i in range(n):
        joined[i, i] += moved[i]
        pushing[i] -= resisting[i]
        if not is_moving(modes[i, MOTION]):
            _hold(joined, i)
            pushing[i] = 0.0
    pushing[n] -= resisting[n]
    accelerations = np.linalg.solve(joined, pushing)
    forces = np.empty(n)
    for i in range(n):
        forces[i] = resisting[i]
        for j in range(n + 1):
            forces[i] += masses[i, j] * accelerations[j]
    return accelerations, forces


@compiled
def _joint_angles(state, coupling):
    angles = np.empty(state.shape[0])
    for i in range(state.shape[0]):
        angles[i] = (state[i, DISPLACEMENT] - coupling.middles[i]) / coupling.levers[i]
    return angles


@compiled_apart
def _mechanics(angles, rates, frame, coupling):
    """Return mass matrix of links and frame [kg], and what resists without acceleration [N]."""
    n = angles.shape[0]
    linkage, levers = coupling.linkage, coupling.levers
    masses, resisting = np.empty((n + 1, n + 1)), np.empty(n + 1)
    turning = mass_matrix(angles, linkage)
    swaying = base_coupling(angles, linkage)
    turned = velocity_torque(angles, rates, linkage)
    carried = gravity_torque(angles, coupling.gravity, linkage)
    for i in range(n):
        for j in range(n):
            masses[i, j] = turning[i, j] / (levers[i] * levers[j])
        masses[i, n] = masses[n, i] = swaying[i] / levers[i]
        resisting[i] = (turned[i] + carried[i]) / levers[i]
    masses[n, n] = linkage.mass + coupling.frame_mass
    resisting[n] = (
        base_force(angles, rates, linkage)
        + coupling.frame_stiffness * frame[SWAY]
        + coupling.frame_damping * frame[SWAY_RATE]
    )
    return masses, resisting


@compiled_apart
def write_rates(state, modes, frame, demands, numbers, like, grid, coupling, rate, frame_rate):
    """Write the rates of the states of all axes and of the frame.

    Parameters
    ----------
    state, modes, frame, numbers, like, coupling
        As in `coupled_accelerations`.
    demands : (n,) array
        Of the rods [m].
    grid : (4, 51, 101) array
        Discharge coefficients, of all valves.
    rate, frame_rate : (n, 10) array, (2,) array
        Written.
    """
    accelerations, forces = coupled_accelerations(state, modes, frame, numbers, like, coupling)
    n = state.shape[0]
    for i in range(n):
        law, plant = load_tuple(numbers[i], like)
        row, inputs = load_tuple(state[i], STATE_LIKE), (demands[i], forces[i])
        of_plant = plant_rates(row, modes[i], inputs, law, plant, grid)
        for k in range(PLANT_STATES):
            rate[i, k] = of_plant[k]
        if law.source == CARD_TAPS:
            of_card = card_rates(row, law)
            for k in range(STATES_WITH_CARD - PLANT_STATES):
                rate[i, PLANT_STATES + k] = of_card[k]
    frame_rate[SWAY], frame_rate[SWAY_RATE] = frame[SWAY_RATE], accelerations[n]


@compiled_apart
def _bring_to_rest(state, modes, frame, numbers, like, coupling):
    """Take the velocity out of pistons that have come to a stop or turn back.

    The blow is inelastic and passes through members and frame: what else moves keeps the momentum
    that friction or stop do not take.
    """
    n = state.shape[0]
    for i in range(n):
        _, plant = load_tuple(numbers[i], like)
        motion = modes[i, MOTION]
        if not is_moving(motion):
            continue
        beyond = stop_margin(motion, state[i, DISPLACEMENT], plant.piston) < 0.0
        if not beyond and motion * state[i, VELOCITY] >= 0.0:
            continue
        angles = _joint_angles(state, coupling)
        masses, _ = _mechanics(angles, np.zeros(n), frame, coupling)
        for j in range(n):
            _, other = load_tuple(numbers[j], like)
            masses[j, j] += other.piston.mass
            if not is_moving(modes[j, MOTION]):
                _hold(masses, j)
        blow = np.zeros(n + 1)
        blow[i] = 1.0
        change = np.linalg.solve(masses, blow)
        strength = -state[i, VELOCITY] / change[i]
        for j in range(n):
            if is_moving(modes[j, MOTION]):
                state[j, VELOCITY] += strength * change[j]
        frame[SWAY_RATE] += strength * change[n]
        state[i, VELOCITY] = 0.0
        state[i, DISPLACEMENT] = min(max(state[i, DISPLACEMENT], 0.0), plant.piston.stroke)
        # Until it is known whether it goes on: it must not take part in another's blow.
        modes[i, MOTION] = AT_REST


@compiled
def _hold(masses, i):
    """Leave a coordinate out of the equations: it does not move."""
    for j in range(masses.shape[0]):
        masses[i, j] = masses[j, i] = 0.0
    masses[i, i] = 1.0


@compiled_apart
def _settle_axes(state, modes, frame, demands, numbers, like, coupling):
    """Bring the modes of all axes into line with their states, one change after another."""
    n = state.shape[0]
    _bring_to_rest(state, modes, frame, numbers, like, coupling)
    for _ in range(_MOST_ROUNDS):
        _, forces = coupled_accelerations(state, modes, frame, numbers, like, coupling)
        changed = False
        for i in range(n):
            law, plant = load_tuple(numbers[i], like)
            before = modes[i, MOTION]
            inputs = np.empty(2)
            inputs[COMMAND], inputs[EXTERNAL_FORCE] = demands[i], forces[i]
            settle(state[i], modes[i], inputs, law, plant)
            if modes[i, MOTION] != before:
                # The forces at all rods are others now.
                changed = True
                break
        if not changed:
            return


@compiled
def _go(start, step, rate, result):
    """Write where a state gets to along a rate."""
    for i in range(start.size):
        result.flat[i] = start.flat[i] + step * rate.flat[i]


@compiled
def _sum(kept, total, weight, rate):
    """Add a weighted rate to what is kept of a sum."""
    for i in range(total.size):
        total.flat[i] = kept * total.flat[i] + weight * rate.flat[i]


@compiled
def _write_outputs(state, modes, frame, demands, numbers, like, coupling, outputs, frames):
    """Write the outputs of all axes and of the frame at one time."""
    n = state.shape[0]
    accelerations, forces = coupled_accelerations(state, modes, frame, numbers, like, coupling)
    for i in range(n):
        law, plant = load_tuple(numbers[i], like)
        row = load_tuple(state[i], STATE_LIKE)
        values = output_values(row, modes[i], (demands[i], forces[i]), law, plant)
        for place in range(len(values)):
            outputs[i, place] = values[place]
        outputs[i, ROD_FORCE_OUT] = forces[i]
    frames[SWAY], frames[SWAY_RATE] = frame[SWAY], frame[SWAY_RATE]
    frames[SWAY_ACCELERATION] = accelerations[n]


@compiled
def _modes_at_start(state, numbers, like):
    """Return the modes of all axes before the forces at their rods are known."""
    modes = np.zeros((state.shape[0], 3), np.int64)
    for i in range(state.shape[0]):
        _, plant = load_tuple(numbers[i], like)
        put(initial_modes(state[i], np.zeros(2), plant), modes[i])
        if state[i, VELOCITY] == 0.0:
            # Whether it breaks away depends on the force at its rod.
            modes[i, MOTION] = AT_REST
    return modes


@compiled
def run_figure(
    time, demands, initial_state, numbers, like, grid, coupling, largest_step, outputs, frames
):
    """Write the outputs of all axes and of the frame at every time of a run.

    Parameters
    ----------
    time : (m,) array
        Strictly increasing [s].
    demands : (m, n) array
        Of the rods; a row holds until the next time [m].
    initial_state : (n, 10) array
        Of the axes, in SI.
    numbers, like, grid, coupling
        As in `write_rates`.
    largest_step : float
        The intervals are divided into equal steps no longer than this [s].
    outputs : (m, n, 11) array
        Written: `pneuservo.plant.outputs.OUTPUTS` and the force at the rod [N].
    frames : (m, 3) array
        Written: displacement, velocity and acceleration of the frame, in SI.

    Notes
    -----
    Classical Runge-Kutta. A piston that stops, breaks away or strikes within a step does so at
    its end.
    """
    n, width = initial_state.shape
    state, frame = initial_state.copy(), np.zeros(2)
    work, frame_work = np.zeros((3, n, width)), np.zeros((3, 2))
    modes = _modes_at_start(state, numbers, like)
    for k in range(time.shape[0]):
        held = demands[k]
        _settle_axes(state, modes, frame, held, numbers, like, coupling)
        _write_outputs(state, modes, frame, held, numbers, like, coupling, outputs[k], frames[k])
        if k + 1 == time.shape[0]:
            break
        steps, step = steps_between(time[k], time[k + 1], largest_step)
        for _ in range(steps):
            _advance(
                state, step, modes, frame, held, numbers, like, grid, coupling, work, frame_work
            )
            _settle_axes(state, modes, frame, held, numbers, like, coupling)


@compiled
def _advance(state, step, modes, frame, held, numbers, like, grid, coupling, work, frame_work):
    """Advance the states of axes and frame by one step, the modes staying as they are."""
    stage, rate, total = work[0], work[1], work[2]
    frame_stage, frame_rate, frame_total = frame_work[0], frame_work[1], frame_work[2]
    _go(state, 0.0, state, stage)
    _go(frame, 0.0, frame, frame_stage)
    for part in range(4):
        write_rates(
            stage, modes, frame_stage, held, numbers, like, grid, coupling, rate, frame_rate
        )
        # The first rate begins the sum anew.
        kept, weight = (0.0 if part == 0 else 1.0), (1.0 if part in (0, 3) else 2.0)
        ahead = step if part == 2 else 0.5 * step
        _sum(kept, total, weight, rate)
        _sum(kept, frame_total, weight, frame_rate)
        _go(state, ahead, rate, stage)
        _go(frame, ahead, frame_rate, frame_stage)
    _go(state, step / 6.0, total, state)
    _go(frame, step / 6.0, frame_total, frame)
    for i in range(state.shape[0]):
        shut = abs(state[i, SPOOL]) < SMALLEST_OPENING
        if shut and abs(state[i, SPOOL_RATE]) < SMALLEST_OPENING:
            state[i, SPOOL], state[i, SPOOL_RATE] = 0.0, 0.0
