"""How visible an effect is in some recordings, once a re-tuned baseline has hidden what it can."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from pneuservo.challenge.experiments import RATE, Experiment
from pneuservo.challenge.noise import ChannelNoise, whitened
from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.parameters import Array, Truth
from pneuservo.challenge.truth.rig import rig_value, with_rig_values
from pneuservo.challenge.truth.run import READINGS, Run, replay, run, start_state
from pneuservo.errors import InputError
from pneuservo.rigs import Rig

SEGMENT = 0.5
"""A simulation that is compared starts afresh this often [s]: errors of flow add up in position."""
VISIBLE, FAINT = 10.0, 4.0
"""Distances from which an effect is visible, and from which it is faint."""
# Where a segment starts is not known exactly either: state, and by how much it is moved [SI].
_START_STEPS = {
    at.POSITION: 1e-5,
    at.SPEED: 1e-3,
    at.PRESSURE_A: 100.0,
    at.PRESSURE_B: 100.0,
}
_RELATIVE_STEP = 0.01
_TOLD_APART = 1e-4
"""Beside the strongest, what a segment starts with has to show by this share to be moved."""
_REFITS = 20
_LARGEST_REFIT = 0.5
_SETTLED = 0.05
"""A refit has come to its end when the square of the distance falls by no more than this share."""


def visibility_class(distance: float) -> str:
    """Return ``visible``, ``faint`` or ``hidden``.

    Parameters
    ----------
    distance : float
        Norm of the projected, whitened signature [-].

    Examples
    --------
    >>> visibility_class(12.0), visibility_class(5.0), visibility_class(1.0)
    ('visible', 'faint', 'hidden')
    """
    if distance >= VISIBLE:
        return "visible"
    return "faint" if distance >= FAINT else "hidden"


def nuisances(rig: Rig) -> dict[str, float]:
    """Return the parameters that a re-tuned baseline may move, and their relative tolerances."""
    return {
        key: parameter.tolerance / abs(parameter.value)
        for key, parameter in rig.parameters.items()
        if parameter.tolerance > 0.0
    }


@dataclass(frozen=True)
class Sensitivity:
    """How the readings of some runs depend on the baseline's parameters.

    Parameters
    ----------
    keys : list of str
        The parameters.
    tolerances : (keys,) array
        How far each may be moved, one standard deviation, relative [-].
    matrix : (n, keys) array
        Whitened change of the readings per relative change, starts of segments taken out.
    starts : list of (rows, 4) array
        Whitened change of the readings by what a segment may start with, segment by segment [1/SI].
    """

    keys: list[str]
    tolerances: Array
    matrix: Array
    starts: list[Array]

    @cached_property
    def bases(self) -> list[Array]:
        """Return orthonormal directions that the start of each segment spans."""
        return [np.linalg.qr(part / _lengths(part))[0] for part in self.starts]

    def without_starts(self, signature: Array) -> Array:
        """Return a whitened signature with what other starts of segments explain taken out."""
        rest = signature.copy()
        # Without any segment all is one part, and nothing is taken out.
        for basis, part in zip(self.bases, self._by_segment(rest), strict=False):
            part -= basis @ (basis.T @ part)
        return rest

    def restarted(self, runs: Sequence[Run], signature: Array) -> list[Run]:
        """Return runs whose segments start where they explain most of what is left.

        Parameters
        ----------
        runs : sequence of Run
            As they start now.
        signature : (n,) array
            Whitened, of what the baseline leaves of them [-].
        """
        segments = zip(self.starts, self._by_segment(signature), strict=True)
        moved = [replace(made, states=made.states.copy()) for made in runs]
        states = [state for made in moved for state in made.states]
        for state, (changes, left) in zip(states, segments, strict=True):
            lengths = _lengths(changes)
            share, *_ = np.linalg.lstsq(changes / lengths, left, rcond=_TOLD_APART)
            state[list(_START_STEPS)] += share / lengths
        return moved

    def nearer(self, one: Array, other: Array) -> Array:
        """Return of two whitened signatures in each segment the smaller one.

        Parameters
        ----------
        one, other : (n,) array
            Of other starts of the same segments: one that was moved into a stop explains nothing.
        """
        pairs = zip(self._by_segment(one), self._by_segment(other), strict=True)
        return np.concatenate([a if a @ a < b @ b else b for a, b in pairs])

    def _by_segment(self, values: Array) -> list[Array]:
        """Return views of the values of each segment."""
        return np.split(values, np.cumsum([len(part) for part in self.starts[:-1]], dtype=int))


def perform(truth: Truth, trial: Experiment) -> Run:
    """Return the run of an experiment on a truth.

    Parameters
    ----------
    truth : Truth
        The servo.
    trial : Experiment
        The experiment.

    Returns
    -------
    Run
        Ten seconds without noise.
    """
    ready = _set_up(truth, trial)
    return run(ready, trial.control, start_state(ready, trial.start), RATE, SEGMENT)


def signature(
    baseline: Truth,
    trials: Sequence[Experiment],
    runs: Sequence[Run],
    noise: Mapping[str, ChannelNoise],
) -> Array:
    """Return what the baseline leaves unexplained of some runs, over the noise.

    Parameters
    ----------
    baseline : Truth
        The truth without the effect.
    trials, runs : sequence
        Experiments and what came of them with the effect.
    noise : mapping of str to ChannelNoise
        Noise of each channel that is recorded.

    Returns
    -------
    (n,) array
        Channel by channel within each segment, segment by segment [-].
    """
    parts = []
    for trial, made in zip(trials, runs, strict=True):
        again = _replayed(baseline, trial, made.commands, made.states)
        parts.append(_whitened(made.readings - again, noise))
    return np.concatenate(parts)


def sensitivity(
    baseline: Truth,
    trials: Sequence[Experiment],
    runs: Sequence[Run],
    noise: Mapping[str, ChannelNoise],
    tolerances: Mapping[str, float],
) -> Sensitivity:
    """Return how readings along some runs depend on the baseline's parameters.

    Parameters
    ----------
    baseline, trials, runs, noise
        As for `signature`.
    tolerances : mapping of str to float
        Parameters of the rig that may be moved, and how far, relative [-].

    Returns
    -------
    Sensitivity
        By forward differences of a hundredth.
    """
    columns, starts = [], []
    for trial, made in zip(trials, runs, strict=True):
        base = _replayed(baseline, trial, made.commands, made.states)
        moved = []
        for key in tolerances:
            value = rig_value(baseline, key) * (1.0 + _RELATIVE_STEP)
            other = with_rig_values(baseline, {key: value})
            again = _replayed(other, trial, made.commands, made.states)
            moved.append(_whitened(again - base, noise) / _RELATIVE_STEP)
        columns.append(np.stack(moved, axis=1))
        starts += _start_changes(baseline, trial, made, base, noise)
    found = Sensitivity(
        list(tolerances), np.array(list(tolerances.values())), np.concatenate(columns), starts
    )
    cleaned = np.stack([found.without_starts(column) for column in found.matrix.T], axis=1)
    return replace(found, matrix=cleaned)


def distance(
    found: Sensitivity,
    baseline: Truth,
    trials: Sequence[Experiment],
    runs: Sequence[Run],
    noise: Mapping[str, ChannelNoise],
) -> float:
    """Return how visible an effect is: the norm of what a re-tuned baseline leaves of it.

    Parameters
    ----------
    found : Sensitivity
        Along the same runs.
    baseline, trials, runs, noise
        As for `signature`.

    Returns
    -------
    float
        d' of signal detection [-].

    Raises
    ------
    InputError
        When the baseline cannot be run along the runs.

    Notes
    -----
    Tolerances count as measurements of the parameters. Least squares, for a single linear
    projection would count the curvature of what is absorbed as visible; with one Jacobian, in a
    trust region, for against a stop full steps lead away. Starts of segments move as well: a zero
    that is off by a millimetre, beside a dead volume that is as much smaller, would otherwise count
    as 51 where 7 of it shows.
    """

    def left(moved: Array) -> Array:
        values = {
            key: rig_value(baseline, key) * (1.0 + part)
            for key, part in zip(found.keys, moved.tolist(), strict=True)
        }
        now = with_rig_values(baseline, values)
        seen = signature(now, trials, runs, noise)
        if np.all(np.isfinite(seen)):
            again = signature(now, trials, found.restarted(runs, seen), noise)
            seen = found.nearer(again, seen)
        return np.concatenate([found.without_starts(seen), moved / found.tolerances])

    if not np.all(np.isfinite(signature(baseline, trials, runs, noise))):
        raise InputError("the servo without the effect cannot be run from where that has led it")
    slopes = np.concatenate([-found.matrix, np.diag(1.0 / found.tolerances)])
    closest = least_squares(
        left,
        np.zeros(len(found.keys)),
        jac=lambda _: slopes,
        bounds=(-_LARGEST_REFIT, _LARGEST_REFIT),
        x_scale="jac",
        ftol=_SETTLED,
        max_nfev=_REFITS,
    )
    return math.sqrt(2.0 * closest.cost)


def _start_changes(
    baseline: Truth, trial: Experiment, made: Run, base: Array, noise: Mapping[str, ChannelNoise]
) -> list[Array]:
    moved = []
    for state, step in _START_STEPS.items():
        starts = made.states.copy()
        starts[:, state] += step
        again = _replayed(baseline, trial, made.commands, starts)
        moved.append(_whitened(again - base, noise) / step)
    return np.split(np.stack(moved, axis=1), len(made.states))


def _lengths(columns: Array) -> Array:
    return np.asarray(np.linalg.norm(columns, axis=0).clip(1e-300))


def _replayed(baseline: Truth, trial: Experiment, commands: Array, states: Array) -> Array:
    ready = _set_up(baseline, trial)
    return replay(ready, commands, trial.control.tick, states, RATE)


def _set_up(truth: Truth, trial: Experiment) -> Truth:
    values = {key: rig_value(truth, key) + change for key, change in trial.changes.items()}
    return with_rig_values(truth, values)


def _whitened(readings: Array, noise: Mapping[str, ChannelNoise]) -> Array:
    parts = np.split(readings, round(len(readings) / (RATE * SEGMENT)))
    return np.concatenate(
        [
            whitened(part[:, READINGS.index(name)], level, RATE)
            for part in parts
            for name, level in noise.items()
        ]
    )
