"""Sensitivities that are kept from a similar fit, so that only new unknowns cost simulations."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.problem import Problem
from pneuservo.diagnosis.side_by_side import side_by_side

_STEP = 1e-4
"""Step of a difference, in units of the unknown's typical size ..."""
_OF_EFFECTS = (1e-3, 1e-2, 0.1)
"""... and of a parameter of an effect. It may be a threshold, which a small step moves past one
moment of a run or two, and next to nothing that was recorded: a cushion that began 0.6 um later
said nothing of what begins a millimetre later. The larger ones are for those that show nothing."""
STRAYED = 0.1
"""Share of its size, or of what it has shrunk to, by which a parameter moves before its sensitivity
is worked out anew: that of a spool at half its frequency has nothing in common with what it began
with."""
_LEAST_SIZE = 0.1
_MOVED, _LEAST_MOVING = 0.02, 0.01
"""The same for parameters of an effect that is fitted for the first time."""


class Known(Protocol):
    """A fit whose sensitivities are kept."""

    @property
    def keys(self) -> Sequence[str]:
        """Name of each column."""

    @property
    def sensitivity(self) -> Array:
        """Columns of weighted residuals and distances."""

    @property
    def vector(self) -> Array:
        """Values of the unknowns, each in its typical size."""

    @property
    def units(self) -> Array:
        """Typical size of each unknown [SI]."""

    def row_scale(self) -> Array:
        """Return what each residual counts as one."""


class SteadySensitivity:
    """The Jacobian of a problem, most of whose columns are worked out once or known already.

    Parameters
    ----------
    problem : Problem
        What is fitted.
    known : Fit or None
        A fit of the same recordings with fewer unknowns.

    Notes
    -----
    A chord method: what the rig's parameters do hardly changes with their values, so those
    columns stay until a parameter has strayed; those of an effect that `known` lacks stay only
    while none of its own parameters moves.
    """

    def __init__(self, problem: Problem, known: Known | None):
        self._problem = problem
        rows = sum(int(np.count_nonzero(case.usable)) for case in problem.cases)
        self._matrix = np.zeros((rows + len(problem.tolerated), len(problem.unknowns)))
        place = {} if known is None else {key: i for i, key in enumerate(known.keys)}
        missing = [i for i, key in enumerate(problem.keys) if key not in place]
        # Without a fit to start from the first call fills everything.
        self._each = [] if known is None else missing
        self._worked_out_at = np.full(len(problem.unknowns), np.inf)
        # What begins at zero is an offset, and linear.
        self._may_stray = problem.start != 0.0
        if known is not None:
            factor = known.row_scale() / problem.row_scale()
            for column, key in enumerate(problem.keys):
                if key in place:
                    old = known.sensitivity[:rows, place[key]]
                    # What is typical of an effect's size is where its fit begins: now elsewhere.
                    larger = float(problem.units[column] / known.units[place[key]])
                    self._matrix[:rows, column] = old * factor * larger
                    self._worked_out_at[column] = known.vector[place[key]] / larger
        for row, column in enumerate(problem.tolerated):
            self._matrix[rows + row, column] = problem.units[column] / problem.sigma[row]

    def __call__(self, vector: Array) -> Array:
        """Return the Jacobian at a vector of unknowns."""
        far = STRAYED * np.clip(np.abs(vector), _LEAST_SIZE, 1.0)
        strayed = self._may_stray & (np.abs(vector - self._worked_out_at) > far)
        strayed |= np.isinf(self._worked_out_at)
        moving = self._each if self._has_moved(vector) else []
        columns = sorted({*np.flatnonzero(strayed).tolist(), *moving})
        if columns:
            here = self._problem.cost_vector(vector)
            _, high = self._problem.bounds

            def slope(column: int) -> Array:
                found = np.zeros_like(here)
                for step in _OF_EFFECTS if ":" in self._problem.keys[column] else (_STEP,):
                    moved = vector.copy()
                    moved[column] += step if moved[column] + step <= high[column] else -step
                    found = (self._problem.cost_vector(moved) - here) / (moved - vector)[column]
                    if found.any():
                        break
                return found

            for column, found in zip(columns, side_by_side(slope, columns), strict=True):
                self._matrix[:, column] = found
                self._worked_out_at[column] = vector[column]
        return self._matrix.copy()

    def _has_moved(self, vector: Array) -> bool:
        """Return whether a parameter of an effect is not where its sensitivity was worked out."""
        mine = vector[self._each]
        least = _MOVED * np.clip(np.abs(mine), _LEAST_MOVING, 1.0)
        return bool(np.any(np.abs(mine - self._worked_out_at[self._each]) > least))
