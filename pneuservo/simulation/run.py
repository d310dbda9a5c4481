"""Running the compiled plant on a command, or under a controller."""

import math

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.arrays import Array
from pneuservo.controllers import AnalogueCard, Controller, SampledController
from pneuservo.errors import InputError
from pneuservo.plant import single_axis as places
from pneuservo.plant import single_run
from pneuservo.plant.control_law import CARD_TAPS, OPEN_LOOP, ControlLaw
from pneuservo.plant.exponential import step_limit
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation.behavioural_card import run_behaviour, stepped_card
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import (
    LARGEST_STEP,
    Driven,
    require_kind,
    require_samples,
    require_times,
)
from pneuservo.simulation.readings import (
    Seed,
)
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.sampled import simulate_sampled
from pneuservo.simulation.soundness import require_finite, require_sound

# Share of the shortest time constant of spool and card that a step may take.
_STEP_PER_TIME_CONSTANT = 0.5


def simulate(
    rig: Rig | str = "single-axis",
    *,
    time: ArrayLike,
    command: ArrayLike | None = None,
    controller: Controller | None = None,
    demand: ArrayLike | None = None,
    external_force: ArrayLike = 0.0,
    supply_pressure: ArrayLike | None = None,
    initial: InitialState | None = None,
    largest_step: float = LARGEST_STEP,
    seed: Seed = 0,
) -> Simulation:
    """Simulate the single axis: open loop on a command, or closed loop under a controller.

    Parameters
    ----------
    rig : Rig or str, optional
        A rig of kind ``single-axis``, or its name. Effects and transducers that it has are
        simulated.
    time : (n,) array
        Times of the result, strictly increasing [s].
    command : (n,) array or float, optional
        Voltage into the valve driver, each value held until the next time [V].
    controller : Controller, optional
        One of `pneuservo.controllers`; instead of a command.
    demand : (n,) array or float, optional
        Set point for the controller, each value held until the next time [m].
    external_force : (n,) array or float, optional
        Force at the rod, positive when it resists extension, held likewise [N].
    supply_pressure : (n,) array or float, optional
        Measured at the supply, straight between the times; the rig's constant by default [Pa].
    initial : InitialState, optional
        By default at rest at the first demand, or at mid-stroke without one.
    largest_step : float, optional
        The integration never takes a longer step; events are located inside it [s].
    seed : int or sequence of int, optional
        Of the transducers' noise, where the rig has any.

    Returns
    -------
    Simulation
        The run: every channel at every time, in SI.

    Raises
    ------
    InputError
        When the rig is not one this can simulate, or an argument cannot be used.

    Notes
    -----
    Fixed steps of an exponential Runge-Kutta method of order 4; stick and slip, end stops, spool
    limits and relay switching are located inside the step. Changes of command, demand and force
    fall between steps.
    With effects `pneuservo.plant.servo` takes over, and the channels are what transducers read. The
    controller hears the displacement that is recorded, but for wiper play and resolution, with a
    noise that runs on smoothly from time to time: its bandwidth is half their rate.

    Examples
    --------
    >>> run = simulate(time=[0.0, 0.05, 0.1], command=1.0)
    >>> bool(run["displacement"][2] > run["displacement"][1] > 0.015)
    True
    """
    rig = require_kind(rig, "single-axis", effects=True)
    times = require_times(time)
    law, held = _law_and_held(rig, controller, command, demand, times)
    force = require_samples("external_force", external_force, times)
    supply = None
    if supply_pressure is not None:
        supply = require_samples("supply_pressure", supply_pressure, times)
    driven = Driven(times, held, force, supply)
    start, plant = initial or InitialState(), plant_numbers.single_axis(rig)
    rest = 0.5 * plant.piston.stroke if controller is None else float(held[0])
    step = integration_step(largest_step, plant.valve.spool_frequency, law)
    if isinstance(controller, SampledController):
        return simulate_sampled(controller, rig, driven, start, step, seed)
    behaviour = controller.behaviour if isinstance(controller, AnalogueCard) else None
    if rig.effects or rig.transducers or supply is not None:
        # Imported when needed: its kernels make up a tenth of a new process' first run.
        from pneuservo.simulation.servo import run_with_effects

        columns, finite = run_with_effects(rig, driven, start, rest, law, behaviour, step, seed)
        require_finite(times, finite)
        return simulation_of(rig, times, columns, controller, law, held, force)
    grid, state = plant_numbers.valve_grid(rig.valve), start.state(plant, rest, float(force[0]))
    inputs = np.column_stack((held, force))
    if behaviour is not None:
        card = stepped_card(times, behaviour, law.sensitivity, step)
        outputs = run_behaviour(inputs, state, card, plant, grid)
    else:
        outputs = _run_baseline(times, inputs, state, law, plant, grid, largest_step)
    require_sound(times, outputs)
    columns = dict(zip(OUTPUTS, outputs.T, strict=True))
    return simulation_of(rig, times, columns, controller, law, held, force)


def _law_and_held(
    rig: Rig,
    controller: Controller | None,
    command: ArrayLike | None,
    demand: ArrayLike | None,
    times: Array,
) -> tuple[ControlLaw, Array]:
    """Return what commands the valve, and the command or demand that holds from time to time."""
    if (command is None) == (controller is None):
        raise InputError("give either a command or a controller with a demand")
    if controller is None:
        return OPEN_LOOP, require_samples("command", command, times)
    if demand is None:
        raise InputError(f"controller {controller.kind} needs a demand in m")
    # A sampled controller holds its voltage.
    law = OPEN_LOOP if isinstance(controller, SampledController) else controller.law(rig)
    return law, require_samples("demand", demand, times)


def _run_baseline(
    times: Array,
    inputs: Array,
    state: Array,
    law: ControlLaw,
    plant: SingleAxis,
    grid: Array,
    largest_step: float,
) -> Array:
    if law.source == CARD_TAPS:
        state = with_card_at_rest(state, law)
    step = min(float(largest_step), step_limit(plant, law))
    outputs: Array = single_run.run(times, inputs, state, law, plant, grid, step)
    return outputs


def integration_step(largest_step: float, spool_frequency: float, law: ControlLaw) -> float:
    """Return a step that spool and card allow [s].

    Parameters
    ----------
    largest_step : float
        What is asked for [s].
    spool_frequency : float
        Of the valve; 0 for a spool held still [rad/s].
    law : ControlLaw
        What commands the valve.

    Raises
    ------
    InputError
        When the step asked for is not above 0 s.
    """
    if not 0.0 < largest_step < math.inf:
        raise InputError(f"largest_step is {largest_step:g} s; it has to be greater than 0")
    fastest = spool_frequency
    if law.source == CARD_TAPS:
        shortest_velocity_lag = min(law.velocity_lag_1, law.velocity_lag_2)
        shortest_acceleration_lag = min(law.acceleration_lag_1, law.acceleration_lag_2)
        fastest = max(fastest, 1.0 / min(shortest_velocity_lag, shortest_acceleration_lag))
    if fastest == 0.0:
        return float(largest_step)
    return min(float(largest_step), _STEP_PER_TIME_CONSTANT / fastest)


def with_card_at_rest(state: Array, law: ControlLaw) -> Array:
    """Return the state of the plant with that of a card by its figures, which has settled."""
    full = np.zeros(places.STATES_WITH_CARD)
    full[: places.PLANT_STATES] = state
    full[places.CARD_LAGGED_1] = law.sensitivity * state[places.DISPLACEMENT]
    return full


def simulation_of(
    rig: Rig,
    times: Array,
    columns: dict[str, Array],
    controller: Controller | None,
    law: ControlLaw,
    held: Array,
    force: Array,
) -> Simulation:
    """Return the run that outputs of the kernels make.

    Parameters
    ----------
    rig : Rig
        The rig.
    times : (n,) array
        [s].
    columns : dict of str to (n,) array
        By `pneuservo.plant.outputs.OUTPUTS`, in SI; used up.
    controller : Controller or None
        What closed the loop.
    law : ControlLaw
        The same as the kernels take it.
    held : (n,) array
        Command [V] or demand [m].
    force : (n,) array
        At the rod [N].
    """
    surface = columns.pop("surface")
    taps = {name: columns.pop(name) for name in ("card_velocity", "card_acceleration")}
    channels = dict(columns)
    if force.any():
        channels["force"] = force
    if controller is None:
        return Simulation(rig, times, channels)
    channels = {"demand": held, **channels}
    if law.source == CARD_TAPS:
        channels["card_sensor"] = law.sensitivity * columns["displacement"]
        channels |= taps
        channels["card_surface"] = surface
        channels["card_output"] = columns["valve_voltage"]
    return Simulation(rig, times, channels, controller, surface)
