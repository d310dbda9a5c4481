"""Running the compiled plant on a command, or under a controller."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneuservo.controllers import AnalogueCard, Controller
from pneuservo.effects.servo import servo_effects
from pneuservo.errors import InputError
from pneuservo.plant import dead_volume as dead_volume_kernels
from pneuservo.plant import from_rig, single_run
from pneuservo.plant import single_axis as places
from pneuservo.plant.control_law import CARD_TAPS, OPEN_LOOP, ControlLaw
from pneuservo.plant.exponential import step_limit
from pneuservo.plant.outputs import OUTPUT_PRESSURE_A, OUTPUT_PRESSURE_B, OUTPUTS
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import Rig
from pneuservo.simulation.behavioural_card import run_behaviour
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import (
    LARGEST_STEP,
    Samples,
    require_kind,
    require_samples,
    require_times,
)
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.servo import run_with_effects

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
) -> Simulation:
    """Simulate the single axis: open loop on a command, or closed loop under a controller.

    Parameters
    ----------
    rig : Rig or str, optional
        A rig of kind ``single-axis``, or its name. Its effects, if it has any, are simulated.
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
    With effects `pneuservo.plant.servo` takes over, and the channels are what transducers read.

    Examples
    --------
    >>> run = simulate(time=[0.0, 0.05, 0.1], command=1.0)
    >>> bool(run["displacement"][2] > run["displacement"][1] > 0.015)
    True
    """
    rig = require_kind(rig, "single-axis", effects=True)
    times = require_times(time)
    if (command is None) == (controller is None):
        raise InputError("give either a command or a controller with a demand")
    if controller is None:
        law, held = OPEN_LOOP, require_samples("command", command, times)
    elif demand is None:
        raise InputError(f"controller {controller.kind} needs a demand in m")
    else:
        law, held = controller.law(rig), require_samples("demand", demand, times)
    plant = from_rig.single_axis(rig)
    force = require_samples("external_force", external_force, times)
    rest = 0.5 * plant.piston.stroke if controller is None else float(held[0])
    grid = from_rig.valve_grid(rig.valve)
    step = _step(largest_step, plant.valve.spool_frequency, law)
    behaviour = controller.behaviour if isinstance(controller, AnalogueCard) else None
    if rig.effects or supply_pressure is not None:
        if behaviour is not None:
            raise InputError(
                "the card's behavioural model drives the baseline only: simulate the card by its "
                "figures, or leave out [effects] and the measured supply pressure"
            )
        supply = None
        if supply_pressure is not None:
            supply = require_samples("supply_pressure", supply_pressure, times)
        columns, finite = run_with_effects(
            servo_effects(rig.effect_values),
            times,
            held,
            force,
            supply,
            initial or InitialState(),
            rest,
            law,
            plant,
            grid,
            step,
        )
        _require_finite(times, finite)
        return _result(rig, times, columns, controller, law, held, force)
    state = (initial or InitialState()).state(plant, rest, float(force[0]))
    inputs = np.column_stack((held, force))
    if behaviour is not None:
        outputs = run_behaviour(times, inputs, state, behaviour, law.sensitivity, plant, grid, step)
    else:
        outputs = _run_baseline(times, inputs, state, law, plant, grid, largest_step)
    _require_sound(times, outputs)
    columns = dict(zip(OUTPUTS, outputs.T, strict=True))
    return _result(rig, times, columns, controller, law, held, force)


def simulate_dead_volume(
    rig: Rig | str = "dead-volume",
    *,
    time: ArrayLike,
    command: ArrayLike,
    port: str = "a",
    initial_pressure: float | None = None,
    largest_step: float = LARGEST_STEP,
) -> Simulation:
    """Simulate a closed test volume behind one port of the valve.

    Parameters
    ----------
    rig : Rig or str, optional
        A rig of kind ``dead-volume``, or its name.
    time : (n,) array
        Times of the result, strictly increasing [s].
    command : (n,) array or float
        Voltage into the valve driver, held until the next time; the spool follows at once [V].
    port : str, optional
        ``"a"`` is charged by a positive command, ``"b"`` by a negative one.
    initial_pressure : float, optional
        Absolute pressure at the first time; the ambient pressure by default [Pa].
    largest_step : float, optional
        The integration never takes a longer step [s].

    Returns
    -------
    Simulation
        The run: ``dead_volume_pressure``, ``valve_voltage`` and ``spool`` at every time, in SI.

    Raises
    ------
    InputError
        When the rig is not one this can simulate, or an argument cannot be used.

    Examples
    --------
    >>> run = simulate_dead_volume(time=[0.0, 1.0], command=5.0)
    >>> round(run["dead_volume_pressure"][1])
    650000
    """
    rig = require_kind(rig, "dead-volume")
    times = require_times(time)
    voltage = require_samples("command", command, times)
    ports = {"a": dead_volume_kernels.PORT_A, "b": dead_volume_kernels.PORT_B}
    if port not in ports:
        raise InputError(f"port is {port!r}; the valve has the ports 'a' and 'b'")
    plant = from_rig.dead_volume(rig)
    start = plant.ambient_pressure if initial_pressure is None else float(initial_pressure)
    if not 0.0 < start < math.inf:
        raise InputError(f"initial pressure is {start:g} Pa; it has to be greater than 0")
    pressure = dead_volume_kernels.run_dead_volume(
        times,
        voltage,
        start,
        ports[port],
        plant,
        from_rig.valve_grid(rig.valve),
        _step(largest_step, 0.0, OPEN_LOOP),
    )
    _require_finite(times, np.isfinite(pressure[:, np.newaxis]).all(axis=1))
    full = plant.valve.full_voltage
    channels = {
        "valve_voltage": voltage,
        "spool": np.clip(voltage / full, -1.0, 1.0),
        "dead_volume_pressure": pressure,
    }
    return Simulation(rig, times, channels)


def _run_baseline(
    times: Samples,
    inputs: Samples,
    state: Samples,
    law: ControlLaw,
    plant: SingleAxis,
    grid: Samples,
    largest_step: float,
) -> Samples:
    if law.source == CARD_TAPS:
        state = with_card_at_rest(state, law)
    step = min(float(largest_step), step_limit(plant, law))
    outputs: Samples = single_run.run(times, inputs, state, law, plant, grid, step)
    return outputs


def _require_sound(times: Samples, outputs: Samples) -> None:
    pressures = outputs[:, [OUTPUT_PRESSURE_A, OUTPUT_PRESSURE_B]]
    states = outputs[:, : places.PLANT_STATES]
    _require_finite(times, np.all(np.isfinite(states), axis=1) & np.all(pressures > 0.0, axis=1))


def _step(largest_step: float, spool_frequency: float, law: ControlLaw) -> float:
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


def with_card_at_rest(state: NDArray[np.float64], law: ControlLaw) -> NDArray[np.float64]:
    """Return the state of the plant with that of a card by its figures, which has settled."""
    full = np.zeros(places.STATES_WITH_CARD)
    full[: places.PLANT_STATES] = state
    full[places.CARD_LAGGED_1] = law.sensitivity * state[places.DISPLACEMENT]
    return full


def _require_finite(times: NDArray[np.float64], finite: NDArray[np.bool_]) -> None:
    if not finite.all():
        k = int(np.argmin(finite))
        raise InputError(
            f"the simulated state stops being finite, or a pressure positive, at t = {times[k]:g} "
            "s: the parameters make the rig faster than the integration step; check them, or give "
            "a smaller largest_step"
        )


def _result(
    rig: Rig,
    times: NDArray[np.float64],
    columns: dict[str, NDArray[np.float64]],
    controller: Controller | None,
    law: ControlLaw,
    held: NDArray[np.float64],
    force: NDArray[np.float64],
) -> Simulation:
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
