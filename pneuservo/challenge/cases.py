"""Writing one case: recordings of a truth, the rig file the diagnosis is given, and the key."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from analog_card.files import write_whole
from pneuservo.challenge.concealment import CLOSE, Concealed, Scene, of_size, retuned, size_for
from pneuservo.challenge.draws import (
    draw_experiments,
    draw_noise_levels,
    draw_rig,
    draw_true_values,
    log_uniform,
)
from pneuservo.challenge.dress import draw_habit, write_dressed
from pneuservo.challenge.effects import NONE, PARAMETER, ConcealedEffect, Form, concealed
from pneuservo.challenge.experiments import ANALOGUE, RATE, Experiment
from pneuservo.challenge.key import Key, Wish
from pneuservo.challenge.noise import ChannelNoise, converted, noise
from pneuservo.challenge.truth.parameters import Truth
from pneuservo.challenge.truth.rig import rig_value, truth_of, with_rig_values
from pneuservo.challenge.truth.run import READINGS, Run
from pneuservo.challenge.visibility import perform, visibility_class
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.rigs.rig_file import rig_document

RIG_FILE = "rig.toml"
USED, HELD_BACK, FOLLOW_UP = "used", "held-back", "follow-up"
"""How the names of recordings begin."""
_DISTANCES = {"visible": (31.0, 600.0), "faint": (4.4, 9.0), "hidden": (20.0, 80.0)}
"""Visibilities that are drawn; of a hidden effect in the experiments that would show it."""
_HIDDEN, _HIDDEN_CLOSE = 2.9, 1.25
"""... and in those that do not show it: below 4 with room for what is missed."""


def make_case(
    seed: int | Sequence[int],
    effect_id: str,
    visibility: str,
    folder: str | Path,
    **wishes: Any,
) -> Key:
    """Write one case with one effect into a folder.

    Parameters
    ----------
    seed : int or sequence of int
        Draws everything.
    effect_id : str
        What is concealed; ``"none"`` for nothing.
    visibility : str
        ``visible``, ``faint`` or ``hidden``.
    folder : str or Path
        Where ``used-1.csv``, ``used-2.csv``, ``held-back-1.csv``, their sidecars and ``rig.toml``
        go. The key is returned, not written.
    **wishes
        Further fields of `Wish`.

    Returns
    -------
    Key
        What the case conceals.

    Raises
    ------
    InputError
        When the effect is not known.
    """
    return write_case(seed, Wish((effect_id,), visibility, **wishes), folder)


def write_case(seed: int | Sequence[int], wish: Wish, folder: str | Path) -> Key:
    """Write one case into a folder and return its key; see `make_case`."""
    rng = np.random.default_rng(seed)
    rig = draw_rig(rng)
    effects = [concealed(name) for name in wish.effects]
    forms = [effect.forms[wish.form % len(effect.forms)] for effect in effects]
    levels = draw_noise_levels(rng, wish)
    true_values = draw_true_values(rig, rng)
    baseline = with_rig_values(truth_of(rig), true_values)
    plan = draw_experiments(effects, rng, levels["displacement"].total, wish)
    scene = Scene(baseline, levels, rig)
    hidden: list[Concealed] = []
    follow_up: list[float] = []
    truth = baseline
    for effect, form in zip(effects, forms, strict=True):
        wanted = log_uniform(rng, _DISTANCES[wish.visibility])
        found, further = _sized(scene, effect, form, plan, wish, wanted, rng)
        hidden.append(found)
        follow_up.append(further)
        truth = form.apply(truth, found.size)
    given = _given_rig(rig, effects, true_values, hidden, wish)
    recorded = {name: level.times(wish.louder) for name, level in levels.items()}
    _write(truth, plan, given, recorded, rng, Path(folder))
    distances = tuple(found.distance / wish.louder for found in hidden)
    return Key(
        effects=wish.effects,
        kinds=tuple(effect.kind for effect in effects),
        blocks=tuple(effect.blocks for effect in effects),
        forms=tuple(form.name for form in forms),
        sizes=tuple(found.size for found in hidden),
        units=tuple(effect.unit for effect in effects),
        shared=any(form.shared for form in forms),
        distances=distances,
        follow_up=tuple(follow_up),
        visibility=visibility_class(min(distances)),
        stratum=wish.stratum,
        retuned=given is not rig,
        missing=wish.missing,
        experiments={name: trial.kind for name, trial in plan.items()},
        noise={name: level.total for name, level in recorded.items()},
        parameters={name: rig_value(truth, name) for name in true_values},
    )


def _sized(
    scene: Scene,
    effect: ConcealedEffect,
    form: Form,
    plan: Mapping[str, Experiment],
    wish: Wish,
    wanted: float,
    rng: np.random.Generator,
) -> tuple[Concealed, float]:
    """Return an effect of a fitting size, and how visible it is in the experiments that follow."""
    used = [trial for name, trial in plan.items() if name.startswith(USED)]
    further = [trial for name, trial in plan.items() if name.startswith(FOLLOW_UP)]
    if effect.kind == PARAMETER or not effect.scales:
        # How far a parameter is off counts against its tolerance, not against the noise.
        size = log_uniform(rng, (effect.low, effect.high))
        further_distance = of_size(scene, effect, form, further, size).distance if further else 0.0
        return of_size(scene, effect, form, used, size), further_distance
    if not further:
        # How far beyond visible matters little.
        close = 3.0 if wish.visibility == "visible" else CLOSE
        return size_for(scene, effect, form, used, wanted, close), 0.0
    telling = size_for(scene, effect, form, further, wanted)
    found = of_size(scene, effect, form, used, telling.size)
    if found.distance > _HIDDEN * _HIDDEN_CLOSE:
        found = size_for(scene, effect, form, used, _HIDDEN, _HIDDEN_CLOSE)
        telling = of_size(scene, effect, form, further, found.size)
    return found, telling.distance


def _given_rig(
    rig: Rig,
    effects: Sequence[ConcealedEffect],
    true_values: dict[str, float],
    hidden: Sequence[Concealed],
    wish: Wish,
) -> Rig:
    """Return the rig that the diagnosis is given: the nominal one, or one that hides the effect."""
    if not wish.retune or any(effect.kind in (NONE, PARAMETER) for effect in effects):
        return rig
    # Of a pair the first is hidden.
    changes = retuned(hidden[0])
    return rig.with_values(
        {key: true_values[key] * (1.0 + change) for key, change in changes.items()}
    )


def _write(
    truth: Truth,
    plan: Mapping[str, Experiment],
    rig: Rig,
    levels: dict[str, ChannelNoise],
    rng: np.random.Generator,
    folder: Path,
) -> None:
    # All of them before the first is written: a case that is drawn anew leaves nothing behind.
    runs = {name: perform(truth, trial) for name, trial in plan.items()}
    for name, made in runs.items():
        if not made.finite:
            raise InputError(f"{name}: the servo with these effects cannot be simulated")
    given = replace(rig, title="servo under test")
    write_whole(folder / RIG_FILE, tomli_w.dumps(rig_document(given)))
    stated = bool(rng.integers(2))
    habit = draw_habit(rng, list(levels))
    for name, trial in plan.items():
        recording = _recorded(name, runs[name], trial, rig, levels, rng, stated)
        write_dressed(recording, habit, rig, RIG_FILE, folder / f"{name}.csv")


def _recorded(
    name: str,
    made: Run,
    trial: Experiment,
    rig: Rig,
    levels: dict[str, ChannelNoise],
    rng: np.random.Generator,
    stated: bool,
) -> Recording:
    samples = len(made.readings)
    # What drives the valve knows its voltage exactly.
    channels = {"valve_voltage": made.readings[:, READINGS.index("valve_voltage")]}
    for channel, level in levels.items():
        values = made.readings[:, READINGS.index(channel)]
        channels[channel] = converted(values + noise(level, samples, RATE, rng), level)
    if trial.kind in ANALOGUE:
        channels["demand"] = trial.control.demand[:: len(trial.control.demand) // samples]
    conditions = {key.replace(".", "_"): rig[key] + change for key, change in trial.changes.items()}
    return Recording(
        name,
        np.arange(samples) / RATE,
        channels,
        conditions=conditions,
        noise_rms={key: level.total for key, level in levels.items()} if stated else {},
        title="ten seconds on the rig",
    )
