"""Closed-loop step responses of the non-linear plant under the controller of a loop."""

import math

import control
import numpy as np

from pneuservo.arrays import Array
from pneuservo.limit_cycle.kernel import OUTPUTS, run_in_ticks
from pneuservo.limit_cycle.linear_simulation import DURATION, START_ERROR, StepCourse
from pneuservo.limit_cycle.loop import Loop, signal_path, surface_filter
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation import InitialState
from pneuservo.simulation.inputs import require_kind

# Step of the plant and of an analogue controller: a switching comes up to one late [s].
TICK = 5e-6
# The same of a digital controller, whose switchings fall between steps; at most [s].
LARGEST_TICK = 20e-6


def simulate_nonlinear(
    rig: Rig | str,
    loop: Loop,
    displacement: float = 0.015,
    start_error: float = START_ERROR,
    duration: float = DURATION,
    grid: Array | None = None,
) -> StepCourse:
    """Simulate the non-linear plant under the controller of a loop, from rest.

    Parameters
    ----------
    rig : Rig or str
        A rig of kind ``single-axis``, or its name.
    loop : Loop
        Weights, level, boundary layer and signals; of its servo only the valve's dynamics are
        used, and its asymmetry is not: the plant has its own.
    displacement : float, optional
        The demand [m].
    start_error : float, optional
        Demand less displacement at the start [m].
    duration : float, optional
        [s].
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].

    Returns
    -------
    StepCourse
        At every tick: 5 us of an analogue controller, up to 20 us of a digital one, which the
        surface holds between samples.

    Raises
    ------
    InputError
        When the rig is not one this can simulate, or the start is outside the stroke.

    Notes
    -----
    The same equations as `pneuservo.simulation.simulate`. An analogue controller acts once in
    each tick, which costs the frequency of a 200 Hz cycle about 0.3 %; its filters and
    differentiators are discretised by the bilinear rule, without delay.
    """
    rig = require_kind(rig, "single-axis")
    plant = _with_valve_of(loop, plant_numbers.single_axis(rig))
    tick, hold = _ticks(loop)
    start = displacement - start_error
    state = InitialState(displacement=start).state(plant, start, 0.0)
    path = signal_path(loop.signals)
    if path.nstates:
        path = control.sample_system(path, tick, method="bilinear")
    surface = surface_filter(loop)
    at_start = np.array([-start_error, 0.0, 0.0])
    path_state, received = _at_rest(path, at_start)
    surface_state, _ = _at_rest(surface, received)
    count = round(duration / tick) + 1
    columns = run_in_ticks(
        count,
        tick,
        hold,
        float(displacement),
        state,
        _matrices(path),
        path_state,
        (*_matrices(surface), surface_state),
        float(loop.level),
        float(loop.boundary_layer),
        OPEN_LOOP,
        plant,
        plant_numbers.valve_grid(rig.valve) if grid is None else grid,
    )
    channel = dict(zip(OUTPUTS, columns.T, strict=True))
    return StepCourse(
        np.arange(count, dtype=float) * tick,
        channel["surface"],
        displacement - channel["displacement"],
        channel["valve_voltage"],
        loop.signals.sampled,
    )


def _with_valve_of(loop: Loop, plant: SingleAxis) -> SingleAxis:
    """Return the plant with the valve of a loop; frequency 0 is a spool that follows at once."""
    frequency = loop.servo.valve_frequency
    spool = 2.0 * math.pi * frequency if math.isfinite(frequency) else 0.0
    valve = plant.valve._replace(
        spool_frequency=spool, spool_damping=float(loop.servo.valve_damping)
    )
    return plant._replace(valve=valve)


def _ticks(loop: Loop) -> tuple[float, int]:
    """Return the length of a tick [s] and how many there are to a decision."""
    period = loop.signals.sampling_time
    if not period:
        return TICK, 1
    hold = math.ceil(period / LARGEST_TICK - 1e-9)
    return period / hold, hold


def _at_rest(system: control.StateSpace, inputs: Array) -> tuple[Array, Array]:
    """Return the state of a discrete system after a long time at constant inputs, and outputs."""
    n = system.nstates
    state = np.linalg.solve(np.eye(n) - system.A, system.B @ inputs) if n else np.zeros(0)
    return state, system.C @ state + system.D @ inputs


def _matrices(system: control.StateSpace) -> tuple[Array, Array, Array, Array]:
    a, b, c, d = (
        np.ascontiguousarray(matrix, dtype=float)
        for matrix in (system.A, system.B, system.C, system.D)
    )
    return a, b, c, d
