"""Evolutionary search for rig parameters, by the error of the simulated displacement."""

from collections.abc import Mapping, Sequence

import numpy as np

from pneuservo.arrays import Array
from pneuservo.errors import InputError
from pneuservo.identification.least_squares import PARAMETERS, rig_of
from pneuservo.identification.result import Estimate, Identification
from pneuservo.identification.segments import Segments, cut, run_segment, start_of
from pneuservo.identification.whiteness import whiteness
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_POPULATION = 10
_GENERATIONS = 40
_TOLERANCE = 1e-3
# What is looked through without limits given, as multiples of the rig's value.
_SPAN = (0.2, 5.0)


def identify_evolution(
    recordings: Sequence[Recording],
    rig: Rig | str | None = None,
    parameters: Sequence[str] = PARAMETERS,
    *,
    limits: Mapping[str, tuple[float, float]] | None = None,
    segment: float = 2.0,
    continuous: bool = False,
    generations: int = _GENERATIONS,
    seed: int = 0,
    jobs: int = 1,
) -> Identification:
    """Identify rig parameters by differential evolution.

    Parameters
    ----------
    recordings : sequence of Recording
        Valve voltage and displacement.
    rig : Rig or str, optional
        By default the one the recordings name.
    parameters : sequence of str, optional
        Rig parameters, or ``effect:parameter`` of an effect that the rig has.
    limits : mapping of str to (low, high), optional
        Where to look; from a fifth to five times the rig's value by default [SI].
    segment : float, optional
        The simulation starts anew from the filtered measurement so often [s].
    continuous : bool, optional
        As in `pneuservo.identification.segments.cut`.
    generations : int, optional
        At most.
    seed : int, optional
        Of the search.
    jobs : int, optional
        Processes; the answer does not depend on it.

    Returns
    -------
    Identification
        Without intervals: the search has none. `pneuservo.identification.identify_output_error`
        started there does.

    Raises
    ------
    InputError
        When a channel or a parameter is missing.

    Notes
    -----
    Cost (4.52) of the thesis, the sum of squared displacement errors, minimised by differential
    evolution (Storn and Price 1997) in place of the thesis' genetic algorithm, whose settings are
    not given.
    """
    from scipy.optimize import differential_evolution

    if not recordings:
        raise InputError("there is no recording to identify from")
    start, units = start_of(rig_of(recordings[0], rig), parameters)
    parts = [cut(r, rig_of(r, rig), segment, continuous) for r in recordings]
    bounds = [(limits or {}).get(name) or _around(name, value) for name, value in start.items()]
    cost = _Cost(parts, tuple(start))
    # A rig that cannot be simulated as it is says why; later trials that cannot are passed over.
    cost.modelled(start)
    found = differential_evolution(
        cost,
        bounds,
        popsize=_POPULATION,
        maxiter=generations,
        tol=_TOLERANCE,
        rng=seed,
        updating="deferred",
        workers=jobs,
        polish=False,
    )
    values = dict(zip(start, found.x.tolist(), strict=True))
    modelled = cost.modelled(values)
    residual = np.concatenate([part.measured["displacement"] for part in parts]) - modelled
    unknown = float("nan")
    return Identification(
        "evolution",
        {name: Estimate(value, unknown, unknown, units[name]) for name, value in values.items()},
        np.full((len(values), len(values)), np.nan),
        {"displacement": residual},
        {"displacement": whiteness(residual)},
        (f"{found.nfev} simulations, {found.nit} generations", "evolution gives no intervals"),
        {"displacement": modelled},
        np.concatenate([part.time for part in parts]),
    )


def _around(name: str, value: float) -> tuple[float, float]:
    if value == 0.0:
        raise InputError(f"{name} is 0 in the rig: give limits to search within")
    low, high = sorted((_SPAN[0] * value, _SPAN[1] * value))
    return low, high


class _Cost:
    """The sum of squared displacement errors; a class, so that processes can be sent it."""

    def __init__(self, parts: Sequence[Segments], names: tuple[str, ...]):
        self.parts, self.names = parts, names

    def __call__(self, vector: Array) -> float:
        values = dict(zip(self.names, vector.tolist(), strict=True))
        measured = np.concatenate([part.measured["displacement"] for part in self.parts])
        try:
            modelled = self.modelled(values)
        except InputError:
            # Values that no rig can have, or that cannot be simulated.
            return float("inf")
        # In mm^2, so that the tolerances of the search mean something.
        return float(np.sum((1e3 * (measured - modelled)) ** 2))

    def modelled(self, values: Mapping[str, float]) -> Array:
        pieces = []
        for part in self.parts:
            rig = part.rig.with_values(values)
            for k in range(len(part)):
                run = run_segment(part, k, rig, part.states[k])
                pieces.append(run[:, 0] if k + 1 == len(part) else run[:-1, 0])
        return np.concatenate(pieces)
