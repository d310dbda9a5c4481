"""How recordings differ from the session of recordings that their rig was fitted to."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, rms
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.unknowns import values_in
from pneuservo.diagnosis.visibility import SAME_DIRECTION, cosine, lookalikes
from pneuservo.intervals import CONFIDENCE
from pneuservo.rigs import Rig, Session

_STEP = 1e-4
"""Of a parameter, relative, that its sensitivity is taken from."""
_ROUNDING = 1e-6
"""Relative difference of what was written to a file and read again, and of equal clocks."""


def session_of(model: Model, cases: Sequence[Case], found: Fit) -> Session:
    """Return what recordings say of the session they were taken in.

    Parameters
    ----------
    model : Model
        The rig's model.
    cases : sequence of Case
        The recordings.
    found : Fit
        A fit of all of them.

    Returns
    -------
    Session
        For each fitted parameter of the rig the value that each recording, on its own, would give
        it, followed by all others that it can tell from that one; and under which circumstances
        each was taken.

    Notes
    -----
    Recordings of one session differ from each other by more than the intervals of a fit say: a
    zero wanders, a seal warms up. Only their scatter tells whether another session is different.
    """
    misfit = {cases[0].channel: rms(found.residuals)}
    recordings = tuple(case.recording.name for case in cases)
    values: dict[str, tuple[float, ...]] = {}
    units: dict[str, str] = {}
    freedom: dict[str, int] = {}
    circumstances = [model.circumstances(case) for case in cases]
    for name, (_, unit) in circumstances[0].items():
        values[name] = tuple(each[name][0] for each in circumstances)
        units[name], freedom[name] = unit, len(cases) - 1
    per_recording = _sensitivities(model, cases, found)
    for key in model.fitted_to(cases):
        if key in per_recording[0] and all(np.any(columns[key]) for columns in per_recording):
            values[key] = tuple(
                found.shared[key] + _wanted(key, model.fitted_to(cases), columns, left)
                for columns, left in zip(per_recording, found.residuals, strict=True)
            )
            units[key] = cases[0].rig.parameters[key].unit
            freedom[key] = max(len(cases) - len(_alike_in_all(key, per_recording)), 0)
    return Session(recordings, misfit, values, units, freedom)


def between_sessions(search: Search, rig: Rig) -> dict[str, Any] | None:
    """Return how recordings differ from the session that their rig was fitted to.

    Parameters
    ----------
    search : Search
        A finished search.
    rig : Rig
        The rig as its file states it.

    Returns
    -------
    dict or None
        ``trained_on``; ``misfit``, by channel ``trained`` and ``here``, with nothing shared fitted
        anew; and ``differences``, the surest parameters first, then circumstances. None when the
        rig was not fitted to a session, or when the model judges several channels at once.
    """
    there, model, cases = rig.session, search.model, search.cases
    if there is None or not there.values or model.steady:
        return None
    kept = {key: cases[0].rig[key] for key in model.fitted_to(cases)}
    as_trained = fit(model, cases, Hypothesis(), fixed=kept, reference=cases[0])
    here = session_of(model, cases, as_trained)
    per_recording = _sensitivities(model, cases, as_trained)
    found = []
    for name, values in here.values.items():
        if name not in there.values:
            continue
        # Nothing shared was fitted to the recordings here.
        freedom = there.freedom[name] + len(values) - 1
        difference = _difference(there.values[name], values, freedom)
        if difference is None or difference["low"] <= 0.0 <= difference["high"]:
            continue
        if np.isclose(np.mean(there.values[name]), np.mean(values), rtol=_ROUNDING, atol=0.0):
            continue
        found.append(
            {
                "what": name,
                "kind": "parameter" if name in kept else "circumstance",
                "unit": here.units[name],
                "trained": float(np.mean(there.values[name])),
                "here": float(np.mean(values)),
                "difference": difference,
                "class": _class(search, name, per_recording) if name in kept else [],
            }
        )
    return {
        "trained_on": list(there.recordings),
        "misfit": {
            channel: {"trained": there.misfit.get(channel), "here": level, "unit": cases[0].unit}
            for channel, level in here.misfit.items()
        },
        "differences": sorted(found, key=_order),
    }


def _order(entry: dict[str, Any]) -> tuple[bool, float]:
    size = entry["difference"]
    return entry["kind"] != "parameter", (size["high"] - size["low"]) / abs(size["value"])


def _difference(
    there: Sequence[float], here: Sequence[float], freedom: int
) -> dict[str, float] | None:
    """Return the difference of two means and its 95 % interval, or None when nothing can scatter.

    Student's t with the scatter of both sets together (Student 1908).
    """
    from scipy.stats import t

    if freedom < 1:
        return None
    value = float(np.mean(here) - np.mean(there))
    scatter = sum(float(np.sum((np.asarray(v) - np.mean(v)) ** 2)) for v in (there, here))
    spread = float(np.sqrt(scatter / freedom * (1.0 / len(there) + 1.0 / len(here))))
    half = spread * float(t.ppf(0.5 + 0.5 * CONFIDENCE, freedom))
    return {"value": value, "low": value - half, "high": value + half}


def _sensitivities(model: Model, cases: Sequence[Case], found: Fit) -> list[dict[str, Array]]:
    """Return what each fitted value does to each recording, usable samples only.

    Parameters of the rig that were measured anew for a recording are left out.
    """
    first = cases[0].rig
    keys = [
        key
        for key in found.shared
        if key not in first.parameters or all(case.rig[key] == first[key] for case in cases)
    ]
    per_recording = []
    for case, own in zip(cases, found.own, strict=True):
        values = values_in(case, cases[0], found.shared, own)
        before = model.predict(case, values)
        columns = {}
        for key in keys:
            known = first.parameters.get(key)
            step = _STEP * (abs(values[key]) or (known and known.tolerance) or 1.0)
            after = model.predict(case, {**values, key: values[key] + step})
            columns[key] = (after - before)[case.usable] / step
        per_recording.append(columns)
    return per_recording


def _wanted(key: str, fitted: Sequence[str], columns: Mapping[str, Array], left: Array) -> float:
    """Return the change of a parameter that one recording asks for by what is left of it.

    Effects stay as they are: another session has no other fit of them.
    """
    basis = [columns[key]]
    for column in (columns[other] for other in fitted if other in columns):
        if all(cosine(column, other) <= SAME_DIRECTION for other in basis):
            basis.append(column)
    sizes = np.array([float(np.linalg.norm(column)) or 1.0 for column in basis])
    change = np.linalg.lstsq(np.column_stack(basis) / sizes, left, rcond=None)[0]
    return float(change[0] / sizes[0])


def _alike_in_all(key: str, per_recording: Sequence[Mapping[str, Array]]) -> set[str]:
    """Return the values that no recording on its own can tell from one, that one among them."""
    alike = (
        {
            other
            for other, column in columns.items()
            if cosine(columns[key], column) > SAME_DIRECTION
        }
        for columns in per_recording
    )
    return {key}.union(set.intersection(*alike))


def _class(search: Search, key: str, per_recording: Sequence[Mapping[str, Array]]) -> list[str]:
    """Return what no recording on its own can tell from a parameter, the parameter first."""
    alike = _alike_in_all(key, per_recording)
    found: dict[str, None] = {}
    for parameter in (key, *sorted(alike - {key})):
        found.update(dict.fromkeys(lookalikes(search, parameter)))
    return list(found)
