"""Runs side by side in lanes: their numbers packed for the kernel, and shared out over threads."""

import math
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import ContinuousController
from pneuservo.errors import InputError
from pneuservo.plant.batch_run import run_batch
from pneuservo.plant.control_law import CARD_TAPS, OPEN_LOOP, ControlLaw, is_relay
from pneuservo.plant.exponential import step_limit
from pneuservo.plant.lanes import WIDTH
from pneuservo.plant.single_axis import STATES_WITH_CARD, SingleAxis
from pneuservo.rigs import Rig, plant_numbers
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import require_kind
from pneuservo.simulation.run import with_card_at_rest

# A boundary layer is off by a few hundredths of a micrometre in most runs. A relay's events cost
# more than the steps between them: half the step costs a third more, and the worst of many runs is
# off by 8 um instead of 160 um.
SMOOTH_STEP, RELAY_STEP = 100e-6, 50e-6
# Pieces of the work for each thread, for an even load at the end.
_SHARES_PER_THREAD = 4


@dataclass(frozen=True)
class Trials:
    """What the kernels need of many runs.

    Parameters
    ----------
    laws, plants : list
        Of each run.
    states : (n, 10) array
        At the first time, in SI.
    grid : (4, 51, 101) array
        Discharge coefficients, the same for all.
    """

    laws: list[ControlLaw]
    plants: list[SingleAxis]
    states: Array
    grid: Array

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.plants)


def trials_of(
    rigs: Sequence[Rig],
    controllers: Sequence[ContinuousController | None],
    inputs: Array,
    initial: InitialState,
) -> Trials:
    """Return what the kernels need of some runs.

    Parameters
    ----------
    rigs : sequence of Rig
        All of kind ``single-axis`` with one valve.
    controllers : sequence of Controller or None
        As many; None for a replayed command.
    inputs : (k, 2) array
        Held voltage [V] or demand [m], and external force [N], the same for all.
    initial : InitialState
        Where all start; what it leaves open follows for each rig.

    Raises
    ------
    InputError
        When a rig or a start is impossible, or the controllers cannot run side by side.
    """
    laws = [
        OPEN_LOOP if controller is None else controller.law(rig)
        for controller, rig in zip(controllers, rigs, strict=True)
    ]
    if len({(law.source, math.isinf(law.gain)) for law in laws}) != 1:
        raise InputError(
            "the controllers of a batch have to be of one kind, all relays or none; "
            "simulate each kind in a batch of its own"
        )
    plants = [
        plant_numbers.single_axis(require_kind(rig, "single-axis", effects=True)) for rig in rigs
    ]
    states = np.zeros((len(rigs), STATES_WITH_CARD))
    for i, (law, plant, controller) in enumerate(zip(laws, plants, controllers, strict=True)):
        rest = 0.5 * plant.piston.stroke if controller is None else float(inputs[0, 0])
        state = initial.state(plant, rest, float(inputs[0, 1]))
        if law.source == CARD_TAPS:
            state = with_card_at_rest(state, law)
        states[i, : len(state)] = state
    return Trials(laws, plants, states, plant_numbers.valve_grid(rigs[0].valve))


def usual_step(law: ControlLaw) -> float:
    """Return the longest step of a batch under a kind of law [s]."""
    return RELAY_STEP if is_relay(law) else SMOOTH_STEP


def shortest_limit(trials: Trials, largest_step: float) -> float:
    """Return the step that all runs take: the wished one, or shorter where one needs it [s].

    Raises
    ------
    InputError
        When the wished step is not one.
    """
    if not 0.0 < largest_step < math.inf:
        raise InputError(f"largest_step is {largest_step:g} s; it has to be greater than 0")
    limits = map(step_limit, trials.plants, trials.laws)
    return min(float(largest_step), *limits)


def run_trials(
    trials: Trials, times: Array, inputs: Array, places: Sequence[int], step: float, jobs: int
) -> Array:
    """Return chosen outputs of many runs.

    Parameters
    ----------
    trials : Trials
        The runs.
    times : (k,) array
        [s].
    inputs : (k, 2) array
        As in `trials_of`.
    places : sequence of int
        Among `pneuservo.plant.outputs.OUTPUTS`.
    step : float
        The longest [s].
    jobs : int
        Threads.

    Returns
    -------
    (len(places), n, k) array
        In SI.
    """
    blocks = -(-len(trials) // WIDTH)
    # The last block is filled up with copies of the last run.
    order = np.minimum(np.arange(blocks * WIDTH), len(trials) - 1)
    numbers = [floats_of(each) for each in zip(trials.laws, trials.plants, strict=True)]
    packed_numbers, packed_states = (
        np.ascontiguousarray(array[order].reshape(blocks, WIDTH, -1).transpose(0, 2, 1))
        for array in (np.array(numbers), trials.states)
    )
    columns = np.array(places, dtype=np.int64)
    # Run by run, so that a part of them is one piece of memory as all are: the kernel would else be
    # compiled for either.
    outputs = np.empty((blocks * WIDTH, len(places), len(times)))

    def run(part: slice) -> None:
        run_batch(
            times,
            inputs,
            packed_states[part],
            packed_numbers[part],
            trials.laws[0],
            trials.plants[0],
            trials.grid,
            step,
            columns,
            outputs[part.start * WIDTH : part.stop * WIDTH],
        )

    share = -(-blocks // (max(jobs, 1) * _SHARES_PER_THREAD))
    parts = [slice(i, min(i + share, blocks)) for i in range(0, blocks, share)]
    if jobs <= 1 or len(parts) == 1:
        for part in parts:
            run(part)
    else:
        # The kernel lets go of the interpreter, so that threads run beside each other.
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(run, parts))
    return outputs[: len(trials)].transpose(1, 0, 2)


def processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def floats_of(values: tuple[Any, ...]) -> list[float]:
    """Return the floats of nested tuples, in the order in which the kernel loads them."""
    found: list[float] = []
    for value in values:
        if isinstance(value, float):
            found.append(value)
        elif isinstance(value, tuple):
            found += floats_of(value)
    return found
