"""Output-error identification by multiple shooting over the compiled plant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import FitError, InputError
from pneuservo.identification.least_squares import PARAMETERS, rig_of
from pneuservo.identification.result import Identification, estimates
from pneuservo.identification.segments import (
    STATES,
    Segments,
    cut,
    run_segment,
    start_of,
)
from pneuservo.identification.whiteness import whiteness
from pneuservo.noise import effective_samples
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_MOST_EVALUATIONS = 40
# As many take some 320 MB.
_MOST_SENSITIVITIES = 4e7
_DIFFERENCE = 1e-3
# How closely segments have to meet, in units of the noise of each state.
_MEETING = 0.1
# Noise of the velocity and of pressures that were not measured, for scaling alone.
_VELOCITY_NOISE, _PRESSURE_NOISE = 1e-3, 1e3


def identify_output_error(
    recordings: Sequence[Recording],
    rig: Rig | str | None = None,
    parameters: Sequence[str] = PARAMETERS,
    segment: float = 0.5,
    continuous: bool = False,
) -> Identification:
    """Identify rig parameters by simulating the recordings, in segments that have to meet.

    Parameters
    ----------
    recordings : sequence of Recording
        Valve voltage and displacement; chamber pressures are compared too when they are there.
    rig : Rig or str, optional
        By default the one the recordings name; its values are the start.
    parameters : sequence of str, optional
        Rig parameters, or ``effect:parameter`` of an effect that the rig has.
    segment : float, optional
        Length of a segment [s].
    continuous : bool, optional
        As in `pneuservo.identification.segments.cut`.

    Returns
    -------
    Identification
        With 95 % intervals; a residual per output.

    Raises
    ------
    InputError
        When a channel or a parameter is missing.
    FitError
        When the fit does not reach finite values.

    Notes
    -----
    Multiple shooting (Bock 1981): parameters and the state at the start of every segment are
    unknowns, and that segments meet is asked for with a tenth of the noise. Sensitivities are
    differences of compiled runs: one run of the recording for each parameter and each of the four
    states. Noise of the outputs does not bias the values, unlike that of least squares.

    Examples
    --------
    >>> from pneuservo.identification import simulate_excitation
    >>> recording = simulate_excitation(duration=2.0, held=True)
    >>> found = identify_output_error([recording], parameters=["load.mass"])
    >>> bool(abs(found.parameters["load.mass"] - 1.825) < 0.01)
    True
    """
    from scipy.optimize import least_squares

    if not recordings:
        raise InputError("there is no recording to identify from")
    start, units = start_of(rig_of(recordings[0], rig), parameters)
    problem = _Problem([cut(r, rig_of(r, rig), segment, continuous) for r in recordings], start)
    if problem.rows * problem.columns > _MOST_SENSITIVITIES:
        raise InputError(
            f"{problem.rows} samples times {problem.columns} unknowns are more than the "
            f"{_MOST_SENSITIVITIES:.0e} sensitivities that fit into memory; cut the recordings "
            "with --window"
        )
    begin = problem.begin()
    # A rig that cannot be simulated as it is says why; later trials that cannot are stepped over.
    problem.all_rows(begin)
    try:
        with np.errstate(all="ignore"):
            found: Any = least_squares(
                problem.cost,
                begin,
                problem.slopes,
                bounds=problem.bounds(),
                x_scale="jac",
                max_nfev=_MOST_EVALUATIONS,
                xtol=1e-6,
                ftol=1e-8,
            )
    except (ValueError, np.linalg.LinAlgError) as problem_met:
        raise FitError(
            f"the fit of {', '.join(parameters)} from the rig's own values came to a point where "
            f"nothing can be simulated ({problem_met}); check units and signs of the recordings' "
            "channels, or start from a rig nearer to them with --rig"
        ) from problem_met
    return _summary(problem, found, units)


@dataclass(frozen=True)
class _Place:
    """Where one segment stands among the unknowns and the rows."""

    part: Segments
    k: int
    states: slice
    rows: slice
    meeting: slice | None


class _Problem:
    """Unknowns in units of their size: parameters, then the states of every segment."""

    def __init__(self, parts: Sequence[Segments], start: Mapping[str, float]):
        self.parts, self.names = parts, tuple(start)
        self.size = np.array([abs(value) or 1.0 for value in start.values()])
        self.start = np.array(list(start.values()))
        self.scales = [_state_scale(part) for part in parts]
        self.places: list[_Place] = []
        column, row = len(self.names), 0
        for part in parts:
            for k in range(len(part)):
                count = (part.bounds[k + 1] - part.bounds[k]) * len(part.measured)
                count += len(part.measured) if k + 1 == len(part) else 0
                states = slice(column, column + len(STATES))
                rows = slice(row, row + int(count))
                row = rows.stop
                meeting = None
                if k + 1 < len(part):
                    meeting = slice(row, row + len(STATES))
                    row = meeting.stop
                self.places.append(_Place(part, k, states, rows, meeting))
                column = states.stop
        self.columns, self.rows = column, row

    def begin(self) -> Array:
        """Return the unknowns that the rig and the filtered measurements give."""
        states = [place.part.states[place.k] / self._scale(place.part) for place in self.places]
        return np.concatenate((self.start / self.size, *states))

    def bounds(self) -> tuple[Array, Array]:
        """Return limits: parameters keep their sign, states are free."""
        low, high = np.full(self.columns, -np.inf), np.full(self.columns, np.inf)
        count = len(self.names)
        low[:count] = np.where(self.start >= 0.0, 0.0, -np.inf)
        high[:count] = np.where(self.start < 0.0, 0.0, np.inf)
        return low, high

    def values(self, vector: Array) -> dict[str, float]:
        """Return the parameters [SI]."""
        count = len(self.names)
        return dict(zip(self.names, (vector[:count] * self.size).tolist(), strict=True))

    def _scale(self, part: Segments) -> Array:
        return next(s for p, s in zip(self.parts, self.scales, strict=True) if p is part)

    def _rows_of(self, place: _Place, vector: Array, rig: Rig) -> Array:
        """Return the rows of one segment: outputs, then how it meets the next."""
        part, k, scale = place.part, place.k, self._scale(place.part)
        run = run_segment(part, k, rig, vector[place.states] * scale)
        first, last = part.bounds[k], part.bounds[k + 1]
        compared = run if k + 1 == len(part) else run[:-1]
        window = slice(first, first + len(compared))
        outputs = [
            (part.measured[name][window] - compared[:, STATES.index(name)]) / part.noise[name]
            for name in part.measured
        ]
        if place.meeting is None:
            return np.concatenate(outputs)
        following = slice(place.states.stop, place.states.stop + len(STATES))
        gap = (run[last - first] / scale - vector[following]) / _MEETING
        return np.concatenate((*outputs, gap))

    def cost(self, vector: Array) -> Array:
        """Return all rows in units of noise; NaN where such a rig cannot be simulated."""
        try:
            return self.all_rows(vector)
        except InputError:
            return np.full(self.rows, np.nan)

    def all_rows(self, vector: Array) -> Array:
        """Return all rows in units of noise."""
        values, rigs = self.values(vector), {}
        for part in self.parts:
            rigs[id(part)] = part.rig.with_values(values)
        return np.concatenate(
            [self._rows_of(place, vector, rigs[id(place.part)]) for place in self.places]
        )

    def slopes(self, vector: Array) -> Array:
        """Return the sensitivities: each state touches its own segment and the meeting before."""
        jacobian = np.zeros((self.rows, self.columns))
        here = self.cost(vector)
        for column in range(len(self.names)):
            moved = vector.copy()
            moved[column] += _DIFFERENCE * max(abs(vector[column]), 0.1)
            jacobian[:, column] = (self.cost(moved) - here) / (moved[column] - vector[column])
        values = self.values(vector)
        for place in self.places:
            rig = place.part.rig.with_values(values)
            rows = slice(place.rows.start, (place.meeting or place.rows).stop)
            for column in range(place.states.start, place.states.stop):
                moved = vector.copy()
                moved[column] += 1.0
                jacobian[rows, column] = self._rows_of(place, moved, rig) - here[rows]
            if place.meeting is not None:
                following = range(place.states.stop, place.states.stop + len(STATES))
                jacobian[list(range(place.meeting.start, place.meeting.stop)), following] = (
                    -1.0 / _MEETING
                )
        return jacobian


def _state_scale(part: Segments) -> Array:
    """Return the units of the states: the noise of each [SI]."""
    usual = {"velocity": _VELOCITY_NOISE}
    return np.array([part.noise.get(name, usual.get(name, _PRESSURE_NOISE)) for name in STATES])


def _residuals(problem: _Problem, fun: Array) -> dict[str, list[Array]]:
    found: dict[str, list[Array]] = {}
    for place in problem.places:
        part = place.part
        rows = fun[place.rows].reshape(len(part.measured), -1)
        for name, values in zip(part.measured, rows, strict=True):
            found.setdefault(name, []).append(values * part.noise[name])
    return found


def _summary(problem: _Problem, found: Any, units: Mapping[str, str]) -> Identification:
    pieces = _residuals(problem, found.fun)
    residual = {name: np.concatenate(values) for name, values in pieces.items()}
    outputs = np.concatenate([np.arange(p.rows.start, p.rows.stop) for p in problem.places])
    left = float(np.mean(found.fun[outputs] ** 2))
    samples = sum(len(values) for values in residual.values())
    judged = {name: whiteness(entry) for name, entry in residual.items()}
    worth = sum(
        len(values) if judged[name].white else effective_samples(values)
        for name, values in residual.items()
    )
    inflation = max(left, 1.0) * samples / worth
    information = found.jac.T @ found.jac / inflation
    count = len(problem.names)
    covariance = np.linalg.pinv(information)[:count, :count] * np.outer(problem.size, problem.size)
    values, correlation = estimates(problem.values(found.x), covariance, units)
    measured = {
        name: np.concatenate(
            [part.measured[name] for part in problem.parts if name in part.measured]
        )
        for name in residual
    }
    notes = [f"{len(problem.places)} segments, {len(outputs)} samples of {', '.join(residual)}"]
    if found.status == 0:
        notes.append(f"stopped after {_MOST_EVALUATIONS} evaluations; the values may still move")
    return Identification(
        "output-error",
        values,
        correlation,
        residual,
        judged,
        tuple(notes),
        {name: measured[name] - residual[name] for name in residual},
        np.concatenate([part.time for part in problem.parts]),
    )
