"""Many runs at once, with parameters of rig or controller that differ from run to run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from pneuservo.arrays import Array
from pneuservo.controllers import (
    AnalogueCard,
    ContinuousController,
    Controller,
    SampledController,
)
from pneuservo.errors import InputError
from pneuservo.naming import require_known
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.rigs import Rig
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import LARGEST_STEP, require_kind, require_samples, require_times
from pneuservo.simulation.single_runs import SingleRuns
from pneuservo.simulation.trials import (
    processors,
    run_trials,
    shortest_limit,
    trials_of,
    usual_step,
)


@dataclass(frozen=True)
class Batch:
    """What many runs gave.

    Parameters
    ----------
    rig : Rig
        The rig before its parameters were varied.
    values : mapping of str to (n,) array
        Parameter id to the value in each run, in SI.
    time : (k,) array
        [s].
    channels : mapping of str to (n, k) array
        The chosen channels of all runs, in SI, each sample just after its time. NaN where the
        state of a run is not finite, or a pressure not positive.
    """

    rig: Rig
    values: Mapping[str, Array]
    time: Array
    channels: Mapping[str, Array]

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(next(iter(self.channels.values())))

    def __getitem__(self, channel: str) -> Array:
        """Return a channel of all runs."""
        return self.channels[channel]


def simulate_batch(
    rig: Rig | str = "single-axis",
    values: Mapping[str, ArrayLike] | None = None,
    *,
    time: ArrayLike,
    command: ArrayLike | None = None,
    controller: Controller | Sequence[Controller] | None = None,
    demand: ArrayLike | None = None,
    external_force: ArrayLike = 0.0,
    initial: InitialState | None = None,
    channels: Sequence[str] = ("displacement",),
    largest_step: float | None = None,
    jobs: int | None = None,
    seed: int = 0,
) -> Batch:
    """Simulate the single axis many times, with parameters that differ from run to run.

    Parameters
    ----------
    rig : Rig or str, optional
        A rig of kind ``single-axis``, or its name. Effects and transducers that it has are
        simulated.
    values : mapping of str to (n,) array or float, optional
        Parameter id to its value in each run, in SI; a number stands for all runs.
    time, command, demand, external_force, initial
        As in `pneuservo.simulation.simulate`; the same in all runs.
    controller : Controller or sequence of Controller, optional
        One for all runs, or one for each; side by side either all relays or none, and all of one
        kind.
    channels : sequence of str, optional
        What is kept of each run: names of `pneuservo.plant.outputs.OUTPUTS`.
    largest_step : float, optional
        The integration never takes a longer step; events are located inside it. By default
        100 us, under a relay 50 us [s].
    jobs : int, optional
        Threads; by default one for each processor. The result does not depend on it.
    seed : int, optional
        Of the transducers' noise; run i has that of ``simulate(..., seed=(seed, i))``.

    Returns
    -------
    Batch
        The chosen channels of all runs.

    Raises
    ------
    InputError
        When an argument cannot be used.

    Notes
    -----
    The equations are those of `simulate`, eight runs side by side in the lanes of the processor.
    Rigs with effects or transducers, cards with their behaviour and sampled controllers do not fit
    into lanes: they are simulated run by run, some seventy times slower, in steps no longer than
    those of `simulate`.
    At the default step the displacement is mostly within 0.03 um of the exact one under a boundary
    layer and 0.2 um under a relay; runs that are about to lose stability amplify that, to 10 um.
    Repeat with half the step to see by how much each run moves.

    Examples
    --------
    >>> runs = simulate_batch(
    ...     values={"piston.viscous_friction": [90.0, 110.0]}, time=[0.0, 0.05], command=1.0
    ... )
    >>> runs["displacement"].shape
    (2, 2)
    >>> bool(runs["displacement"][0, 1] > runs["displacement"][1, 1])
    True
    """
    rig = require_kind(rig, "single-axis", effects=True)
    times = require_times(time)
    inputs = _inputs(times, command, controller, demand, external_force)
    several = list(controller) if isinstance(controller, Sequence) else []
    alone = None if isinstance(controller, Sequence) else controller
    columns = _columns(values or {}, len(several) or None)
    count = len(next(iter(columns.values()))) if columns else len(several or (1,))
    rigs = [
        rig.with_values({key: float(column[i]) for key, column in columns.items()})
        for i in range(count)
    ]
    controllers: list[Controller | None] = [*several] or [alone] * count
    places, start, jobs = places_of(channels), initial or InitialState(), jobs or processors()
    if fit_into_lanes(controllers, rig):
        trials = trials_of(rigs, controllers, inputs, start)
        if largest_step is None:
            largest_step = usual_step(trials.laws[0])
        step = shortest_limit(trials, largest_step)
        outputs = run_trials(trials, times, inputs, places, step, jobs)
    else:
        longest = LARGEST_STEP if largest_step is None else min(largest_step, LARGEST_STEP)
        single = SingleRuns(times, inputs, start, channels, longest, seed)
        outputs = single.run(rigs, controllers, jobs)
    return Batch(rig, columns, times, dict(zip(channels, outputs, strict=True)))


def fit_into_lanes(
    controllers: Sequence[Controller | None], rig: Rig
) -> TypeGuard[Sequence[ContinuousController | None]]:
    """Return whether runs can be simulated side by side.

    Parameters
    ----------
    controllers : sequence of Controller or None
        Sampled ones and the behaviour of a card do not fit.
    rig : Rig
        Its effects and transducers do not fit.
    """
    if rig.effects or rig.transducers:
        return False
    return not any(
        isinstance(controller, SampledController)
        or (isinstance(controller, AnalogueCard) and controller.behaviour is not None)
        for controller in controllers
    )


def places_of(channels: Sequence[str]) -> list[int]:
    """Return the places of channels among the kernels' outputs.

    Raises
    ------
    InputError
        When there is none, or one is not known.
    """
    if not channels:
        raise InputError(f"no channel is asked for; there are: {', '.join(OUTPUTS)}")
    for name in channels:
        require_known(name, OUTPUTS, "channels of a batch")
    return [OUTPUTS.index(name) for name in channels]


def _inputs(
    times: Array,
    command: ArrayLike | None,
    controller: object | None,
    demand: ArrayLike | None,
    external_force: ArrayLike,
) -> Array:
    if (command is None) == (controller is None):
        raise InputError("give either a command or a controller with a demand")
    if controller is None:
        held = require_samples("command", command, times)
    elif demand is None:
        raise InputError("a controller needs a demand in m")
    else:
        held = require_samples("demand", demand, times)
    return np.column_stack((held, require_samples("external_force", external_force, times)))


def _columns(values: Mapping[str, ArrayLike], count: int | None) -> dict[str, Array]:
    """Return the values of all runs, each parameter as many."""
    arrays = {key: np.asarray(value, dtype=float) for key, value in values.items()}
    for key, array in arrays.items():
        if array.ndim > 1 or array.size == 0:
            raise InputError(f"values of {key} have the shape {array.shape}; one for each run")
        if array.ndim == 1 and count is None:
            count = len(array)
        if array.ndim == 1 and len(array) != count:
            raise InputError(f"{len(array)} values of {key} are given for {count} runs")
    return {key: np.broadcast_to(array, (count or 1,)).copy() for key, array in arrays.items()}
