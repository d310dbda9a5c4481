"""A campaign: a closed loop, what varies in it, and which sample has which values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.campaign.axes import Axis, Grid, Random
from pneuservo.campaign.metrics import OF_SET_POINTS
from pneuservo.errors import InputError
from pneuservo.rigs import Rig

_MOST_SAMPLES = 1_000_000


@dataclass(frozen=True)
class Campaign:
    """Many runs of a closed loop.

    Attributes
    ----------
    rig : Rig
        The plant before anything is varied.
    controller : str
        Kind of the controller.
    options : mapping of str to anything
        What shapes it and does not vary, by the names of
        `pneuservo.loop_controller.TAKEN`; ``design`` is a loaded design.
    time, demand : (n,) array
        [s], [m].
    axes : tuple of Grid or Random
        What varies.
    trials : int
        How many samples are drawn at each point of the grid.
    seed : int
        Of what is drawn.
    metrics : tuple of str
        What is read off each run, names of `pneuservo.campaign.metrics.METRICS`.
    title : str
        What people call it.

    Notes
    -----
    Samples go through the grid once for each trial, the last axis fastest. What is drawn for a
    sample follows from seed and index only (`numpy.random.SeedSequence` with the index as spawn
    key), so that more trials leave those before as they are.
    """

    rig: Rig
    controller: str
    options: Mapping[str, Any]
    time: Array
    demand: Array
    axes: tuple[Axis, ...]
    trials: int = 1
    seed: int = 0
    metrics: tuple[str, ...] = OF_SET_POINTS
    title: str = ""

    def __post_init__(self) -> None:
        """Refuse what makes no campaign."""
        if self.seed < 0:
            raise InputError(f"seed is {self.seed}; it has to be 0 or more")
        if self.trials < 1:
            raise InputError(f"trials is {self.trials}; at least one is needed")
        noisy = any(transducer.noise for transducer in self.rig.transducers.values())
        drawn = noisy or any(isinstance(axis, Random) for axis in self.axes)
        if self.trials > 1 and not drawn:
            raise InputError(
                f"{self.trials} trials, but nothing is drawn: every trial would be the same. Vary "
                'a parameter by a distribution, such as "normal(1.825 kg, 3 %)", or leave trials '
                "out"
            )
        if self.trials * self.cells > _MOST_SAMPLES:
            raise InputError(
                f"{self.trials} trials at {self.cells} points of the grid are more than "
                f"{_MOST_SAMPLES} samples; take fewer values or trials"
            )

    def __len__(self) -> int:
        """Return the number of samples."""
        return self.trials * self.cells

    @property
    def grids(self) -> tuple[Grid, ...]:
        """Return the axes that make up the grid."""
        return tuple(axis for axis in self.axes if isinstance(axis, Grid))

    @cached_property
    def cells(self) -> int:
        """Return the number of points of the grid."""
        return math.prod(len(axis.values) for axis in self.grids)

    @property
    def varying(self) -> tuple[Axis, ...]:
        """Return the axes with more than one value."""
        return tuple(axis for axis in self.axes if isinstance(axis, Random) or len(axis.values) > 1)

    def values(self, index: int) -> dict[str, float]:
        """Return the values of a sample.

        Parameters
        ----------
        index : int
            Of the sample, from 0.

        Returns
        -------
        dict of str to float
            In SI by name of the parameter, in the order of the axes.
        """
        shape = [len(axis.values) for axis in self.grids]
        places = iter(np.unravel_index(index % self.cells, shape)) if shape else iter(())
        sequence = np.random.SeedSequence(self.seed, spawn_key=(index,))
        generator = np.random.default_rng(sequence)
        return {
            axis.name: axis.values[next(places)] if isinstance(axis, Grid) else axis.draw(generator)
            for axis in self.axes
        }
