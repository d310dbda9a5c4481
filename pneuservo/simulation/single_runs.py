"""Many runs one by one: what does not fit side by side into lanes."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import Controller
from pneuservo.rigs import Rig
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.run import simulate
from pneuservo.simulation.soundness import BrokenRunError


@dataclass(frozen=True)
class SingleRuns:
    """What is the same in all runs.

    Parameters
    ----------
    times : (k,) array
        [s].
    inputs : (k, 2) array
        Held voltage [V] or demand [m], and external force [N].
    initial : InitialState
        Where all start.
    channels : sequence of str
        What is kept, names of `pneuservo.plant.outputs.OUTPUTS`.
    largest_step : float
        [s].
    seed : int
        Run i has the noise of the seed (seed, i).
    """

    times: Array
    inputs: Array
    initial: InitialState
    channels: Sequence[str]
    largest_step: float
    seed: int

    def run(
        self, rigs: Sequence[Rig], controllers: Sequence[Controller | None], jobs: int
    ) -> Array:
        """Return the channels of all runs.

        Parameters
        ----------
        rigs : sequence of Rig
            One for each run.
        controllers : sequence of Controller or None
            As many; None for a replayed command.
        jobs : int
            Threads; the kernels let go of the interpreter.

        Returns
        -------
        (channels, n, k) array
            In SI; NaN for a run that breaks down, and for what a run does not have.
        """
        outputs = np.full((len(self.channels), len(rigs), len(self.times)), np.nan)
        with ThreadPoolExecutor(jobs) as pool:
            for i, rows in enumerate(pool.map(self._one, range(len(rigs)), rigs, controllers)):
                outputs[:, i] = rows
        return outputs

    def _one(self, index: int, rig: Rig, controller: Controller | None) -> Array:
        rows = np.full((len(self.channels), len(self.times)), np.nan)
        try:
            run = simulate(
                rig,
                time=self.times,
                command=self.inputs[:, 0] if controller is None else None,
                controller=controller,
                demand=None if controller is None else self.inputs[:, 0],
                external_force=self.inputs[:, 1],
                initial=self.initial,
                largest_step=self.largest_step,
                seed=(self.seed, index),
            )
        except BrokenRunError:
            return rows
        for row, name in zip(rows, self.channels, strict=True):
            if name in run:
                row[:] = run[name]
            elif name == "surface" and run.surface is not None:
                row[:] = run.surface
        return rows
