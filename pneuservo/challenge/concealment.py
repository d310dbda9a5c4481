"""Hiding an effect: its size for a wanted visibility, and a baseline re-tuned to swallow it."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from pneuservo.challenge.effects.concealed import NONE, ConcealedEffect, Form
from pneuservo.challenge.experiments import Experiment
from pneuservo.challenge.noise import ChannelNoise
from pneuservo.challenge.truth.parameters import Truth
from pneuservo.challenge.visibility import (
    Sensitivity,
    distance,
    nuisances,
    perform,
    sensitivity,
    signature,
)
from pneuservo.errors import InputError
from pneuservo.rigs import Rig

LARGEST_RETUNING = 0.15
"""How far a re-tuned baseline may lie from the truth, relative ..."""
LARGEST_GEOMETRY_RETUNING = 0.01
"""... and for what is measured with a rule, a scale, a barometer or a thermometer."""
_MEASURED = (
    "piston.area_a", "piston.area_b", "piston.stroke", "ambient.pressure", "temperature",
)  # fmt: skip
_SIZE_TRIALS = 4
CLOSE = 1.5


@dataclass(frozen=True)
class Scene:
    """Where an effect is concealed.

    Parameters
    ----------
    baseline : Truth
        The truth without the effect.
    noise : mapping of str to ChannelNoise
        Noise of each recorded channel.
    rig : Rig
        Its tolerated parameters are what can hide an effect.
    """

    baseline: Truth
    noise: Mapping[str, ChannelNoise]
    rig: Rig


@dataclass(frozen=True)
class Concealed:
    """An effect of a chosen size in some experiments.

    Parameters
    ----------
    size : float
        Size of the effect [its unit].
    distance : float
        Its visibility in the recordings [-].
    found : Sensitivity
        Along the runs.
    seen : (n,) array
        Its whitened signature.
    """

    size: float
    distance: float
    found: Sensitivity
    seen: np.ndarray


def of_size(
    scene: Scene,
    effect: ConcealedEffect,
    form: Form,
    trials: Sequence[Experiment],
    size: float,
) -> Concealed:
    """Return an effect of a given size; see `size_for`.

    Raises
    ------
    InputError
        When the servo with such an effect cannot be simulated.
    """
    # A wrong parameter is judged by what all the others leave of it.
    free = nuisances(scene.rig)
    free.pop(effect.id.removeprefix("param."), None)
    runs = [perform(form.apply(scene.baseline, size), trial) for trial in trials]
    if not all(made.finite for made in runs):
        raise InputError(f"{effect.id} of {size:g} {effect.unit}: cannot be simulated; try less")
    found = sensitivity(scene.baseline, trials, runs, scene.noise, free)
    seen = signature(scene.baseline, trials, runs, scene.noise)
    far = distance(found, scene.baseline, trials, runs, scene.noise)
    return Concealed(size, far, found, seen)


def size_for(
    scene: Scene,
    effect: ConcealedEffect,
    form: Form,
    trials: Sequence[Experiment],
    wanted: float,
    close: float = CLOSE,
) -> Concealed:
    """Return the size at which an effect has a wanted visibility.

    Parameters
    ----------
    scene : Scene
        Where it is concealed.
    effect, form
        What is concealed.
    trials : sequence of Experiment
        The recordings it is judged in.
    wanted : float
        Visibility asked for; beyond the range of sizes the nearest size is taken [-].
    close : float, optional
        A visibility is good enough when it misses the one asked for by less than this factor.

    Returns
    -------
    Concealed
        Size, visibility, sensitivities.

    Raises
    ------
    InputError
        When nothing can be simulated at any size.
    """
    low, high = effect.smallest, effect.high
    size = effect.low
    best: Concealed | None = None
    for _ in range(_SIZE_TRIALS):
        try:
            tried = of_size(scene, effect, form, trials, size)
        except InputError:
            high, size = size, math.sqrt(low * size)
            continue
        if best is None or _miss(tried, wanted) < _miss(best, wanted):
            best = tried
        if effect.kind == NONE or _miss(best, wanted) < math.log(close):
            break
        # Most signatures grow in proportion to the size.
        step = min(max(wanted / max(tried.distance, 1e-3), 0.02), 30.0)
        following = min(max(size * step, low), high)
        if following == size:
            break
        size = following
    if best is None:
        raise InputError(f"{effect.id}: no size between {low:g} and {high:g} can be simulated")
    return best


def _miss(tried: Concealed, wanted: float) -> float:
    return abs(math.log(max(tried.distance, 1e-6) / wanted))


def retuned(hidden: Concealed) -> dict[str, float]:
    """Return how a baseline has to be re-tuned so that it swallows most of an effect.

    Parameters
    ----------
    hidden : Concealed
        The effect.

    Returns
    -------
    dict of str to float
        Parameter id of the rig to relative change from the truth.

    Notes
    -----
    The global optimum of the linearised problem within bounds (bounded least squares).
    """
    rest = hidden.found.without_starts(hidden.seen)
    bounds = np.array(
        [
            LARGEST_GEOMETRY_RETUNING if key in _MEASURED else LARGEST_RETUNING
            for key in hidden.found.keys
        ]
    )
    answer = lsq_linear(hidden.found.matrix, rest, (-bounds, bounds))
    return dict(zip(hidden.found.keys, answer.x.tolist(), strict=True))
