"""What these recordings could show, and what they cannot tell apart."""

import math
from collections.abc import Sequence

import numpy as np

from pneuservo.arrays import Array
from pneuservo.diagnosis.fit import Fit, orthonormal
from pneuservo.diagnosis.judge import LEAST_GAIN
from pneuservo.diagnosis.search import Search
from pneuservo.diagnosis.side_by_side import side_by_side
from pneuservo.diagnosis.signatures import change_by
from pneuservo.diagnosis.units import written
from pneuservo.effects import Effect

DETECTABLE = 4.0
"""An effect shows when its signature is this many standard deviations long: what is shorter is
hidden by the measure of the trial, too (`docs/challenge.md`)."""
NAMEABLE = LEAST_GAIN**0.5
"""Length of the shortest signature that innovations are explained by."""
SMALLEST = 1e-3
"""Share of its usual size down to which an effect matters where no least is known of real parts: of
leaks there are all sizes, and recordings of a piston at rest show a hundredth of the usual ones."""
SAME_DIRECTION = 0.95
"""Signatures with a larger cosine count as one."""

_RUNAWAY = 1e12
_ABSORBED = "absorbed by the parameters that are fitted with it"
_TOO_SMALL = "too small to show even as large as it can be"
_USUAL_TOO_SMALL = "too small to show even at its usual size"


def not_visible(search: Search) -> list[dict[str, str]]:
    """Return the effects that could be present at a plausible size without showing.

    Parameters
    ----------
    search : Search
        A finished search.

    Returns
    -------
    list of dict
        ``effect``, ``why`` and the ``experiment`` that would show it.
    """
    possible = search.compatible(search.accepted)
    effects = [effect for effect in search.model.effects if effect.id in possible]
    reasons = (_faint if search.model.steady else _within_noise)(search, effects)
    return [
        {"effect": effect.id, "why": reasons[effect.id], "experiment": effect.experiment}
        for effect in effects
        if effect.id in reasons
    ]


def _within_noise(search: Search, effects: Sequence[Effect]) -> dict[str, str]:
    """Return why some effects would not show though as large as they can be."""
    chosen = search.chosen
    basis = orthonormal(chosen.jacobian)
    spread = chosen.rms * float(np.sqrt(chosen.samples / chosen.all_effective))
    reasons = {}
    for effect in effects:
        signature = _signature_at_full_size(search, chosen, effect)
        whole = float(np.linalg.norm(signature))
        rest = float(np.linalg.norm(signature - basis @ (basis.T @ signature)))
        if rest / spread < DETECTABLE:
            absorbed = whole > 2.0 * rest and whole / spread >= DETECTABLE
            reasons[effect.id] = _ABSORBED if absorbed else _TOO_SMALL
    return reasons


def _faint(search: Search, effects: Sequence[Effect]) -> dict[str, str]:
    """Return why some effects, as small as real ones may be, would not be named.

    For a search that has worked out how each would show at the size with which its fit begins.
    """
    usual = search.pretence.visible(search.baseline)
    shows = [effect for effect in effects if usual[effect.id].distinct >= NAMEABLE]
    found = side_by_side(lambda effect: _at_its_smallest(search, effect), shows)
    reasons = {
        effect.id: _below(effect, smallest, usual[effect.id].distinct)
        for effect, smallest in zip(shows, found, strict=True)
        if smallest[1] < NAMEABLE
    }
    for effect in effects:
        shown = usual[effect.id]
        if shown.distinct < NAMEABLE:
            reasons[effect.id] = _ABSORBED if shown.length >= NAMEABLE else _USUAL_TOO_SMALL
    return reasons


def _usual(effect: Effect) -> float:
    """Return by how much an effect's usual size differs from none."""
    size = effect.parameters[0]
    return size.starts[0] - size.neutral


def _at_its_smallest(search: Search, effect: Effect) -> tuple[float, float]:
    """Return how small an effect may be, and how much of it no refit would absorb then."""
    parameter, usual = effect.parameters[0], _usual(effect)
    smallest = min(parameter.least or SMALLEST * abs(usual), abs(usual))
    if parameter.inverse:
        smallest = min(parameter.high, parameter.most)
    values = {effect.key(p.name): p.starts[0] for p in effect.parameters[1:]}
    values[effect.key(parameter.name)] = parameter.neutral + math.copysign(smallest, usual)
    base = search.baseline
    change = base.counted(change_by(search.model, search.cases, base, values))
    return smallest, float(np.linalg.norm(base.beyond_refit(change)))


def _below(effect: Effect, smallest: tuple[float, float], distinct: float) -> str:
    """Return beyond what size an effect would not be named, as a power law goes between two."""
    (least, faintest), usual = smallest, abs(_usual(effect))
    rise = math.log(usual / least) / math.log(distinct / max(faintest, 1e-6 * distinct))
    limit = usual * (NAMEABLE / distinct) ** rise
    parameter = effect.parameters[0]
    size = f"{limit:.1g} {written(parameter.unit)}".strip()
    reach = f"up to {size}" if parameter.inverse else f"from {size} on"
    return f"shows only {reach} ({parameter.name.replace('_', ' ')})"


def lookalikes(search: Search, parameter: str) -> list[str]:
    """Return what would change the recordings in the same way as a rig parameter.

    Parameters
    ----------
    search : Search
        A finished search.
    parameter : str
        A fitted rig parameter.

    Returns
    -------
    list of str
        Effect ids and ``param.`` ids, the parameter itself first.
    """
    chosen = search.chosen
    if search.model.steady:
        return _same_direction(search, parameter)
    mine = _sensitivity(search, chosen, parameter)
    alike = [f"param.{parameter}"]
    for other in search.model.fitted_to(search.cases):
        if other != parameter and cosine(mine, _sensitivity(search, chosen, other)) > (
            SAME_DIRECTION
        ):
            alike.append(f"param.{other}")
    for effect in search.model.effects:
        if effect.id not in search.accepted:
            signature = _signature_at_full_size(search, chosen, effect)
            if cosine(mine, signature) > SAME_DIRECTION:
                alike.append(effect.id)
    return alike


def _same_direction(search: Search, parameter: str) -> list[str]:
    base = search.baseline
    columns = dict(zip(base.keys, base.jacobian.T, strict=True))
    mine, scale = columns[parameter], base.row_scale()
    alike = [f"param.{parameter}"]
    alike += [
        f"param.{key}"
        for key, column in columns.items()
        if key in base.shared and key != parameter and cosine(mine, column) > SAME_DIRECTION
    ]
    alike += [
        name
        for name, variants in search.pretence.signatures.items()
        if name not in search.accepted and cosine(mine, variants[0][:, 0] / scale) > SAME_DIRECTION
    ]
    return alike


def _signature_at_full_size(search: Search, found: Fit, effect: Effect) -> Array:
    size = effect.parameters[0]
    full = size.high if abs(size.high) >= abs(size.low) else size.low
    values = {effect.key(p.name): p.starts[0] for p in effect.parameters[1:]}
    values[effect.key(size.name)] = full
    return change_by(search.model, search.cases, found, values, _RUNAWAY)


def _sensitivity(search: Search, found: Fit, parameter: str) -> Array:
    value = found.shared[parameter]
    step = 1e-4 * (abs(value) or search.cases[0].rig.parameters[parameter].tolerance or 1.0)
    changed = {parameter: value + step}
    return change_by(search.model, search.cases, found, changed, _RUNAWAY)


def cosine(one: Array, other: Array) -> float:
    """Return how much two signatures point the same way, whatever their sign: 0 to 1."""
    sizes = float(np.linalg.norm(one) * np.linalg.norm(other))
    return abs(float(one @ other)) / sizes if sizes else 0.0
