"""What of a case is drawn by chance: noise, the servo's own parameters, the experiments."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pneuservo.challenge.effects import ConcealedEffect
from pneuservo.challenge.experiments import ANALOGUE, Experiment, experiment
from pneuservo.challenge.key import Wish
from pneuservo.challenge.noise import ChannelNoise, draw_noise
from pneuservo.challenge.truth.run import READINGS
from pneuservo.challenge.visibility import nuisances
from pneuservo.rigs import Rig, load_rig

USUAL_KINDS = (
    "sliding-mode",
    "relay",
    "proportional",
    "multilevel",
    "triangle",
    "hold",
    *ANALOGUE,
)
TELLING_KINDS = ("stop-test", "staircase", "triangle", "multilevel")
"""What is run after a hidden effect that every experiment shows alike."""
QUIET_KINDS = ("regulation", "small-steps")
"""What a servo does all day, and what shows little of it."""
ADDED_MASS = 5.0
"""Load that is added in some runs [kg]."""
_TRUE_SPREAD = 0.35
"""Spread of true parameters within what the rig's tolerances allow."""


# By what factor rigs differ from the built-in one.
_RIGS_DIFFER = {
    "load.mass": (0.7, 1.7),
    "piston.viscous_friction": (0.6, 1.5),
    "piston.coulomb_friction": (0.5, 4.0),
    "chamber.a.dead_volume": (0.7, 1.5),
    "chamber.b.dead_volume": (0.7, 1.5),
    "supply.pressure": (0.92, 1.15),
}


def draw_rig(rng: np.random.Generator) -> Rig:
    """Draw a servo of the same make as the built-in one; what is known of it is as well known."""
    rig = load_rig("single-axis")
    parameters = dict(rig.parameters)
    for key, span in _RIGS_DIFFER.items():
        factor = log_uniform(rng, span)
        known = parameters[key]
        value = float(f"{factor * known.value:.4g}")
        parameters[key] = replace(
            known, value=value, tolerance=known.tolerance * value / known.value
        )
    return replace(rig, parameters=parameters)


def log_uniform(rng: np.random.Generator, span: tuple[float, float]) -> float:
    """Draw a number whose logarithm is uniform between two bounds."""
    return float(np.exp(rng.uniform(*np.log(span))))


def draw_noise_levels(rng: np.random.Generator, wish: Wish) -> dict[str, ChannelNoise]:
    """Draw how noisy each transducer is that is recorded; converters of 12 to 16 bits."""
    bits = rng.choice([12, 14, 16])
    position = log_uniform(rng, (5e-6, 3e-5))
    pressure = log_uniform(rng, (200.0, 1500.0))
    return {
        name: draw_noise(position, 0.030 / 2.0**bits, rng)
        if name == "displacement"
        else draw_noise(pressure, 20.7e5 / 2.0**bits, rng)
        for name in READINGS
        if name not in (*wish.missing, "valve_voltage")
    }


def draw_true_values(rig: Rig, rng: np.random.Generator) -> dict[str, float]:
    """Draw a servo whose parameters lie within what the rig's tolerances allow."""
    return {
        key: rig[key] + float(rng.normal(0.0, _TRUE_SPREAD)) * rig.parameters[key].tolerance
        for key in nuisances(rig)
    }


def draw_experiments(
    effects: Sequence[ConcealedEffect],
    rng: np.random.Generator,
    position_noise: float,
    wish: Wish,
) -> dict[str, Experiment]:
    """Draw the experiments by the names of their recordings.

    Two of different kinds to be used; one or two to hold back, the first of a kind that was used;
    after a hidden effect two that would show it.
    """
    hidden = wish.visibility == "hidden" and wish.effects != ("none",)
    chosen = list(QUIET_KINDS) if hidden else []
    for effect in effects:
        telling = [kind for kind in effect.shown_by or USUAL_KINDS if kind not in chosen]
        if telling and not hidden:
            chosen.append(str(rng.choice(telling)))
    others = [kind for kind in USUAL_KINDS if kind not in chosen]
    chosen += [str(kind) for kind in rng.permutation(others)]
    kinds = {"used-1": chosen[0], "used-2": chosen[1], "held-back-1": chosen[0]}
    if rng.integers(2):
        kinds["held-back-2"] = chosen[2]
    if hidden:
        telling = [*effects[0].shown_by, *TELLING_KINDS]
        for number, kind in enumerate(list(dict.fromkeys(telling))[:2], 1):
            kinds[f"follow-up-{number}"] = kind
    plan, ids = {}, {effect.id for effect in effects}
    for name, kind in kinds.items():
        changes = {} if name == "used-1" else _changes(rng)
        # A parameter that is wrong is not set anew for a run.
        changes = {key: change for key, change in changes.items() if f"param.{key}" not in ids}
        trial = experiment(kind, rng, changes)
        heard = position_noise * rng.standard_normal(len(trial.control.noise))
        plan[name] = replace(trial, control=trial.control._replace(noise=heard))
    return plan


def _changes(rng: np.random.Generator) -> dict[str, float]:
    draw = rng.random()
    if draw < 0.2:
        return {"load.mass": ADDED_MASS}
    if draw < 0.4:
        return {"supply.pressure": float(rng.choice([-1.5e5, 0.5e5]))}
    return {}
