"""What a fit has to find, and the values that a model takes of it in each recording."""

import itertools
from collections.abc import Sequence

import numpy as np

from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import Case, Model, Unknown
from pneuservo.diagnosis.models.model import Values
from pneuservo.rigs import Parameter
from pneuservo.rigs.added_weight import MOVED_MASS, with_added_weight

_LEAST_SHARE = 1e-3
"""Share of where it starts that a positive parameter keeps: nothing divides by nothing."""
_ANEW = "error of "
"""How the name of a recording's own error of a parameter begins, where that was measured anew."""


def own_unknowns(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis, reference: Case
) -> list[list[Unknown]]:
    """Return the unknowns of each case; in a joint model a recording's stand with its first.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.
    reference : Case
        The recording that shared values are stated for.
    """
    seen: set[int] = set()
    found = []
    for case in cases:
        own = model.nuisances(case, hypothesis.effects | set(case.rig.effects))
        if not model.joint or id(case.recording) not in seen:
            own += _measured_anew(model, case, reference)
        seen.add(id(case.recording))
        found.append(own)
    return found


def _measured_anew(model: Model, case: Case, reference: Case) -> list[Unknown]:
    """Return the errors of parameters that were measured anew, each as well as the first time."""
    found = []
    for key in model.fitted(case):
        before, now = reference.rig.parameters[key], case.rig[key]
        if not before.tolerance or before.free or before.value == now:
            continue
        if _is_a_zero(before):
            error = Unknown(_ANEW + key, 0.0, -np.inf, np.inf, before.tolerance, before.unit)
            found.append(error)
        else:
            sigma = before.tolerance / abs(before.value)
            found.append(Unknown(_ANEW + key, 0.0, _LEAST_SHARE - 1.0, np.inf, sigma))
    return found


def baseline_unknowns(model: Model, cases: Sequence[Case], hypothesis: Hypothesis) -> list[Unknown]:
    """Return the unknowns of the rig itself.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.
    """
    found = []
    case = cases[0]
    guess = model.first_guess(case)
    for key in model.fitted_to(cases):
        parameter = case.rig.parameters[key]
        known = parameter.tolerance and not parameter.free and key not in hypothesis.loosened
        start = guess.get(key, parameter.value) if parameter.free else parameter.value
        # Signs are part of what is known; only zero-centred values may change theirs.
        low = _LEAST_SHARE * start if parameter.value > 0.0 and start > 0.0 else -np.inf
        sigma = parameter.tolerance if known else None
        found.append(Unknown(key, start, low, np.inf, sigma, parameter.unit))
    return found


def effect_unknowns(
    model: Model, cases: Sequence[Case], hypothesis: Hypothesis
) -> list[list[Unknown]]:
    """Return the unknowns of the effects, once per combination of their starts.

    Parameters
    ----------
    model, cases, hypothesis
        What is fitted to what.
    """
    switched = [effect for effect in model.effects if effect.id in hypothesis.effects]
    parameters = [(effect.key(p.name), p) for effect in switched for p in effect.parameters]
    tried = [starts for effect in switched for starts in model.starts(effect, cases).values()]
    return [
        [
            Unknown(key, start, p.low, p.high, None, p.unit)
            for (key, p), start in zip(parameters, starts, strict=True)
        ]
        for starts in itertools.product(*tried)
    ]


def values_in(case: Case, first: Case, shared: Values, own: Values) -> dict[str, float]:
    """Return the values that a model takes for one recording.

    Parameters
    ----------
    case : Case
        The recording.
    first : Case
        The one that the shared values are stated for.
    shared, own : mapping of str to float
        Fitted values of all recordings and of this one.

    Notes
    -----
    Where a parameter was measured anew for a recording, 5 kg added for example, a fit that
    corrects it does so by the same factor everywhere, but for the error of that measurement, which
    is the recording's own: 5 kg are weighed better than what they are added to. A zero, or what may
    as well be one, is corrected by as much everywhere. What hangs on the rod is another share of
    another mass (`pneuservo.rigs.added_weight`).
    """
    here, mine = dict(shared), dict(own)
    before, now = first.rig.parameters, case.rig.parameters
    measured_anew = any(key.startswith(_ANEW) for key in own)
    if MOVED_MASS in now:
        here = with_added_weight(here, now[MOVED_MASS].value / before[MOVED_MASS].value)
    for key in shared:
        if key not in now:
            continue
        nominal, reference = now[key].value, before[key].value
        error = mine.pop(_ANEW + key, 0.0) if measured_anew else 0.0
        if _is_a_zero(before[key]):
            here[key] += nominal - reference + error
        elif nominal != reference:
            here[key] *= (1.0 + error) * nominal / reference
    return {**case.rig.effect_values, **here, **mine}


def _is_a_zero(parameter: Parameter) -> bool:
    """Return whether a value is no larger than what it is known by."""
    return abs(parameter.value) <= parameter.tolerance


def values_in_each(
    cases: Sequence[Case], first: Case, shared: Values, own: Sequence[Values]
) -> list[dict[str, float]]:
    """Return the values that a model takes for each of several recordings.

    Parameters
    ----------
    cases : sequence of Case
        The recordings.
    first, shared, own
        As for `values_in`, the last one per recording.
    """
    return [values_in(case, first, shared, mine) for case, mine in zip(cases, own, strict=True)]
