"""Running an animated figure: every axis under its own controller, none knowing of the others."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.animated_figure.figure import AnimatedFigure
from pneuservo.animated_figure.kernel import ROD_FORCE_OUT, run_figure
from pneuservo.animated_figure.result import FigureRun
from pneuservo.arrays import Array
from pneuservo.controllers import AnalogueCard, ContinuousController, Controller, SampledController
from pneuservo.errors import InputError
from pneuservo.manipulator.linkage import gravity_torque
from pneuservo.plant.control_law import ControlLaw
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.plant.single_axis import STATES_WITH_CARD, SingleAxis
from pneuservo.rigs import plant_numbers
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import require_kind, require_samples, require_times
from pneuservo.simulation.run import integration_step, simulation_of, with_card_at_rest
from pneuservo.simulation.soundness import require_sound

# Halving it changes no displacement of the built-in arm, stepping, by more than 2 um.
LARGEST_STEP = 50e-6


def simulate_figure(
    figure: AnimatedFigure,
    *,
    time: ArrayLike,
    controller: Controller,
    demands: Mapping[str, ArrayLike],
    initial: Mapping[str, InitialState] | None = None,
    largest_step: float = LARGEST_STEP,
) -> FigureRun:
    """Simulate a figure whose axes have a controller each, all with the same settings.

    Parameters
    ----------
    figure : AnimatedFigure
        The figure.
    time : (n,) array
        Times of the result, strictly increasing [s].
    controller : Controller
        That of every axis, on the axis' own transducer: a continuous one, a card by its figures,
        not a relay.
    demands : mapping of str to (n,) array or float
        By axis, of the rod, each value held until the next time; an axis without one is held
        at mid-stroke [m].
    initial : mapping of str to InitialState, optional
        By axis, where it does not start at rest at its first demand, carrying its member.
    largest_step : float, optional
        The integration never takes a longer step [s].

    Returns
    -------
    FigureRun
        Every axis as a run of its own with the force at its rod, and the frame.

    Raises
    ------
    InputError
        When the controller cannot be used, a demand is outside the stroke or of no axis, or the
        motion is not finite.

    Notes
    -----
    Starts at rest at the first demands, the frame upright. Assumptions: rigid members in one
    vertical plane, levers of constant length, joints without friction of their own beside that
    of the pistons, a frame that only sways horizontally. What the axes' rigs have in effects is
    left out, see `AnimatedFigure.left_out`.

    Examples
    --------
    >>> from pneuservo.animated_figure import load_figure
    >>> from pneuservo.controllers import SlidingMode
    >>> run = simulate_figure(
    ...     load_figure("arm").only("shoulder"),
    ...     time=np.linspace(0.0, 0.4, 41),
    ...     controller=SlidingMode(),
    ...     demands={"shoulder": 0.030},
    ... )
    >>> round(float(run.axes["shoulder"]["displacement"][-1]), 4)
    0.03
    """
    times = require_times(time)
    continuous = _require_usable(controller)
    for name in (*demands, *(initial or {})):
        if name not in figure.axes:
            raise InputError(f"there is no axis {name!r}; the axes are: {', '.join(figure.axes)}")
    held = np.column_stack([_demand(figure, name, demands, times) for name in figure.axes])
    rigs = [require_kind(axis.rig, "single-axis", effects=True) for axis in figure.axes.values()]
    plants = [plant_numbers.single_axis(rig) for rig in rigs]
    laws = [continuous.law(rig) for rig in rigs]
    numbers = np.array([_floats((law, plant)) for law, plant in zip(laws, plants, strict=True)])
    steps = [
        integration_step(largest_step, plant.valve.spool_frequency, law)
        for law, plant in zip(laws, plants, strict=True)
    ]
    outputs = np.empty((len(times), len(plants), len(OUTPUTS) + 1))
    frames = np.empty((len(times), 3))
    run_figure(
        times,
        held,
        _start(figure, initial or {}, held[0], plants, laws),
        numbers,
        (laws[0], plants[0]),
        plant_numbers.valve_grid(_valve(figure)),
        figure.coupling,
        min(steps),
        outputs,
        frames,
    )
    runs = {}
    for place, (name, axis) in enumerate(figure.axes.items()):
        require_sound(times, outputs[:, place])
        columns = dict(zip(OUTPUTS, outputs[:, place].T, strict=False))
        force = outputs[:, place, ROD_FORCE_OUT]
        runs[name] = simulation_of(
            axis.rig, times, columns, controller, laws[place], held[:, place], force
        )
    return FigureRun(figure, times, runs, *frames.T)


def _require_usable(controller: Controller) -> ContinuousController:
    if isinstance(controller, SampledController):
        raise InputError(
            f"controller {controller.kind} is sampled; the axes of a figure take a continuous one"
        )
    if isinstance(controller, AnalogueCard) and controller.behaviour is not None:
        raise InputError("the axes of a figure take the card by its figures")
    return controller


def _demand(
    figure: AnimatedFigure, name: str, demands: Mapping[str, ArrayLike], times: Array
) -> Array:
    axis = figure.axes[name]
    values = require_samples(f"demand of {name}", demands.get(name, axis.middle), times)
    stroke = axis.rig["piston.stroke"]
    if values.min() < 0.0 or values.max() > stroke:
        raise InputError(
            f"demand of {name} goes from {1e3 * values.min():g} to {1e3 * values.max():g} mm; its "
            f"stroke is 0 to {1e3 * stroke:g} mm"
        )
    return values


def _start(
    figure: AnimatedFigure,
    initial: Mapping[str, InitialState],
    places: Array,
    plants: list[SingleAxis],
    laws: list[ControlLaw],
) -> Array:
    """Return the states of the axes, by default at rest with pressures that carry the members."""
    coupling = figure.coupling
    angles = (places - coupling.middles) / coupling.levers
    carried = gravity_torque(angles, coupling.gravity, coupling.linkage) / coupling.levers
    states = np.zeros((len(plants), STATES_WITH_CARD))
    for i, (name, plant, law) in enumerate(zip(figure.axes, plants, laws, strict=True)):
        if math.isinf(law.gain):
            raise InputError(
                "a relay on every axis of a figure is not simulated; give a boundary layer"
            )
        start = initial.get(name, InitialState())
        state = start.state(plant, float(places[i]), float(carried[i]))
        states[i] = with_card_at_rest(state, law)
    return states


def _valve(figure: AnimatedFigure) -> str:
    valves = {axis.rig.valve for axis in figure.axes.values()}
    if len(valves) > 1:
        raise InputError(
            f"figure {figure.name}: the axes have the valves {', '.join(sorted(valves))}; all "
            "have to have the same"
        )
    return valves.pop()


def _floats(value: object) -> list[float]:
    """Return the floats of nested tuples in order."""
    if isinstance(value, tuple):
        return [number for entry in value for number in _floats(entry)]
    return [value] if isinstance(value, float) else []
