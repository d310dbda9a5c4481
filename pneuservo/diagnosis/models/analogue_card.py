"""The analogue card as four stages, each followed from what was measured ahead of it."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from analog_card.figures import CardFigures, card_figures
from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.card_feed import (
    EDGE,
    CardFeed,
    card_feed,
    signal_of,
    spectrum,
    without_noise,
)
from pneuservo.diagnosis.models.card_stages import (
    DIFFERENTIATORS,
    SENSITIVITY,
    differentiator,
    differentiator_response,
    inside_layer,
    layer_gain,
    output,
    surface,
)
from pneuservo.diagnosis.models.card_tolerances import stage_errors
from pneuservo.diagnosis.models.model import Case, Model, Unknown, Values
from pneuservo.diagnosis.models.recent import Recent
from pneuservo.effects import Effect
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig
from pneuservo.rigs.rig import tolerance_of_another

_STAGES = {
    "card_velocity": ("card_sensor",),
    "card_acceleration": ("card_velocity",),
    "card_surface": ("demand", "card_sensor", "card_velocity", "card_acceleration"),
    "card_output": ("card_surface",),
}
"""What each judged channel is fed with."""
_NEARLY_MOST = 0.5
"""Share of the largest change that counts as large as well."""
_EVERYWHERE = ("card.opamp-slew", "card.opamp-bandwidth", "card.offset", "card.supply-sag")
_HEEDED = {
    "card_velocity": (
        "card.differentiator-gain-1",
        "card.differentiator-rolloff-1",
        "card.capacitor-leak",
        "card.intermediate-clipping",
    ),
    "card_acceleration": (
        "card.differentiator-gain-2",
        "card.differentiator-rolloff-2",
        "card.capacitor-leak",
        "card.intermediate-clipping",
    ),
    "card_surface": (SENSITIVITY, "card.weight-loading", "card.ground-hum"),
    "card_output": (
        "card.boundary-slope",
        "card.rail-asymmetry",
        "card.switch-hysteresis",
        "card.output-load",
    ),
}
"""Effects and rig parameters that a stage has, beside those that all have."""
_OWN = "/"
"""Stands between recording, stage and name of an unknown that only they have."""
_LINEARITY = 2e-4
"""What a recorder of 12 bit is linear to, of its range: no smaller misfit is the card's."""
_NEAR_LIMIT = 0.8
"""Share of the swing from which on an op-amp's own limit can be told."""


class AnalogueCardModel(Model):
    """Every tap of the card from the taps ahead of it.

    Notes
    -----
    A stage's figures are known within the tolerances that the design states of its parts, and its
    op-amp's offset within those of the op-amp: each stage has these errors as unknowns of its own,
    which end at the tolerance. What a stage is fed with carries noise, which a differentiator
    magnifies: both sides are whitened by what the noises of its input and output make of its
    nominal response.
    """

    kind: ClassVar[str] = "analogue-card"
    channel: ClassVar[str] = "card_output"
    unit: ClassVar[str] = "V"
    block: ClassVar[str] = "card.surface"
    required: ClassVar[tuple[str, ...]] = ("card_sensor",)
    steady: ClassVar[bool] = True

    def require_channels(self, recording: Recording) -> None:
        """Refuse a recording that holds no stage whole, input and output."""
        super().require_channels(recording)
        if not _whole_stages(recording):
            wanted = "; ".join(f"{tap} with {', '.join(ins)}" for tap, ins in _STAGES.items())
            raise InputError(
                f"{recording.source or recording.name}: rig {self.kind!r} needs the output of at "
                f"least one stage together with its inputs ({wanted}); the recording has "
                f"{', '.join(recording.channels)}. Map the missing ones in the sidecar's [channels]"
            )

    def cases(self, recording: Recording, rig: Rig) -> list[Case]:
        """Return the recording once per stage that was recorded whole, in units of its noise."""
        feed = card_feed(recording)
        rig = _on_transducer(rig, feed.nominal.figures.transducer_gain)
        found = []
        for channel in _whole_stages(recording):
            inputs = {"feed": feed, "weight": _weight(channel, feed), "done": Recent()}
            if channel in DIFFERENTIATORS:
                source = DIFFERENTIATORS[channel][1]
                recorded = spectrum(feed.signals[source])
                response = differentiator_response(channel, {}, feed, feed.frequency(feed.size))
                inputs["differentiated"] = signal_of(response * recorded, feed.size)
                inputs["clean"] = without_noise(recorded, feed.noise[source])
            unusable = feed.unusable(channel, *_STAGES[channel])
            if "demand" in _STAGES[channel]:
                unusable |= feed.jumps()
            case = Case(
                recording,
                recording[channel],
                inputs,
                1.0,
                rig,
                ~unusable,
                channel,
                "V",
                feed.noise[channel],
            )
            found.append(replace(case, measured=_weighed(case, feed.signals[channel])))
        return found

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return the transducer's sensitivity, which turns the demand into a voltage."""
        return (SENSITIVITY,)

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return the errors of a stage that its parts' tolerances allow."""
        # Each stage of each recording has names of its own, by which sensitivities are kept.
        prefix = f"{case.recording.name}{_OWN}{case.channel}{_OWN}"
        return [replace(error, key=prefix + error.key) for error in _errors(case)]

    def predict(self, case: Case, values: Values) -> Array:
        """Return the judged tap as its inputs, recorded, should make it [units of its noise]."""
        mine = _heeded(case, values)
        done: Recent = case.inputs["done"]
        return done.get(tuple(sorted(mine.items())), lambda: _weighed(case, _stage(case, mine)))

    def channel_in_si(self, case: Case, values: Values) -> Array:
        """Return the judged tap as its inputs, recorded, should make it, unweighed [V]."""
        return _stage(case, _heeded(case, values))

    def imitate(
        self, cases: Sequence[Case], values: Sequence[Values], rng: np.random.Generator
    ) -> list[Case]:
        """Return the taps as a card without effects would have given them, with their noise."""
        return [
            replace(
                case, measured=self.predict(case, mine) + rng.standard_normal(len(case.measured))
            )
            for case, mine in zip(cases, values, strict=True)
        ]

    def suspects(
        self, cases: Sequence[Case], residuals: Sequence[Array], noise: Sequence[float]
    ) -> dict[str, float]:
        """Return the stages whose taps are wrong."""
        shares: dict[str, float] = {}
        for case, left, level in zip(cases, residuals, noise, strict=True):
            if float(np.sum(left**2)) <= len(left) * level**2:
                continue
            excess = np.clip(left**2 - level**2, 0.0, None)
            for block, part in _by_block(case, excess).items():
                shares[block] = shares.get(block, 0.0) + part
        total = sum(shares.values())
        if total <= 0.0:
            return {self.block: 1.0}
        return {block: share / total for block, share in shares.items()}

    def block_of(self, effect: Effect, cases: Sequence[Case], values: Sequence[Values]) -> str:
        """Return the first stage whose tap an effect changes most, where it may be any stage's.

        What a stage does to its tap the stages behind it pass on.
        """
        if effect.id not in _EVERYWHERE:
            return effect.block
        shares: dict[str, float] = {}
        for case, mine in zip(cases, values, strict=True):
            change = self.predict(case, mine) - self.predict(case, {**mine, **effect.neutral})
            for block, part in _by_block(case, change[case.usable] ** 2).items():
                shares[block] = shares.get(block, 0.0) + part
        most = max(shares.values())
        return next(block for block, share in shares.items() if share >= _NEARLY_MOST * most)

    def regimes(self, case: Case) -> dict[str, Mask]:
        """Return parts of the recording by the size of taps and output, and by time."""
        feed: CardFeed = case.inputs["feed"]
        signals, figures = feed.signals, feed.nominal.figures
        elapsed = np.arange(feed.size)
        found = {"in the last third of the recording": elapsed > 2 * feed.size // 3}
        if "demand" in signals:
            after = np.convolve(feed.jumps(), np.ones(EDGE))[: feed.size] > 0.5
            found["just after a jump of the demand"] = after
        limit = _NEAR_LIMIT * figures.surface_limit
        for channel, phrase in (
            ("card_velocity", "the velocity tap"),
            ("card_acceleration", "the acceleration tap"),
            ("card_surface", "the surface"),
        ):
            if channel in signals:
                found[f"with {phrase} near the swing of its op-amp"] = (
                    np.abs(signals[channel]) > limit
                )
        if "card_surface" in signals and "card_output" in signals:
            inside = inside_layer(feed)
            found["inside the boundary layer"] = inside
            found["with the output at its upper level"] = ~inside & (signals["card_surface"] > 0.0)
            found["with the output at its lower level"] = ~inside & (signals["card_surface"] < 0.0)
        return found

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return the recorded taps and time."""
        feed: CardFeed = case.inputs["feed"]
        named = {name.replace("_", " "): signal for name, signal in feed.signals.items()}
        return {**named, "time": case.recording.time}


def _on_transducer(rig: Rig, gain: float) -> Rig:
    """Return a rig that says nothing of its own about the transducer with that of the design."""
    parameter = rig.parameters[SENSITIVITY]
    built_in = load_rig(AnalogueCardModel.kind).parameters[SENSITIVITY]
    if parameter != built_in or math.isclose(gain, built_in.value):
        return rig
    designed = replace(parameter, value=gain, tolerance=tolerance_of_another(parameter, gain))
    return replace(rig, parameters={**rig.parameters, SENSITIVITY: designed})


def _by_block(case: Case, energy: Array) -> dict[str, float]:
    """Return the energy of a tap's usable samples by the block that they tell of."""
    if case.channel in DIFFERENTIATORS:
        return {"card.differentiator": float(np.sum(energy))}
    if case.channel == "card_surface":
        return {"card.surface": float(np.sum(energy))}
    inside = inside_layer(case.inputs["feed"])[case.usable]
    return {
        "card.boundary-layer": float(np.sum(energy[inside])),
        "card.relay": float(np.sum(energy[~inside])),
    }


def _errors(case: Case) -> list[Unknown]:
    feed: CardFeed = case.inputs["feed"]
    figures, found = feed.nominal.figures, [Unknown("amplifier_error", 0.0, -1.0, 2.0, 1.0)]
    for name, (sigma, most) in stage_errors(feed.nominal.design)[case.channel].items():
        scale, unit = 1.0, "V" if name == "offset" else ""
        if unit and case.channel == "card_surface":
            # Where other weights are stated than the design's, offsets go with the gain of noise.
            scale = _noise_gain(figures) / _noise_gain(card_figures(feed.nominal.design))
        found.append(Unknown(name, 0.0, -scale * most, scale * most, scale * sigma, unit))
    if case.channel == "card_output":
        return [*found, Unknown("softness", 1.0, 0.0, 1.6, 0.5)]
    low, high = feed.nominal.swing
    signal = feed.signals[case.channel]
    for name, reached in (
        ("upper_error", signal.max() / high),
        ("lower_error", signal.min() / low),
    ):
        if reached > _NEAR_LIMIT:
            found.append(Unknown(name, 0.0, -0.7, 2.2, 1.0, "V"))
    return found


def _noise_gain(figures: CardFigures) -> float:
    weights = (figures.weight_displacement, figures.weight_velocity, figures.weight_acceleration)
    return 1.0 + sum(weights)


def _whole_stages(recording: Recording) -> list[str]:
    return [
        channel
        for channel, inputs in _STAGES.items()
        if all(name in recording for name in (channel, *inputs))
    ]


def _heeded(case: Case, values: Values) -> dict[str, float]:
    """Return the values that a stage depends on, its own errors by their bare names."""
    heeded = (*_EVERYWHERE, *_HEEDED[case.channel])
    return {
        key.rpartition(_OWN)[2]: value
        for key, value in values.items()
        if _OWN in key or key.startswith(heeded)
    }


def _stage(case: Case, values: Values) -> Array:
    feed: CardFeed = case.inputs["feed"]
    if case.channel in DIFFERENTIATORS:
        recorded, clean = case.inputs["differentiated"], case.inputs["clean"]
        return differentiator(case.channel, recorded, clean, values, feed)
    return surface(values, feed) if case.channel == "card_surface" else output(values, feed)


def _weight(channel: str, feed: CardFeed) -> Array:
    """Return what a stage's misfit is multiplied with, per frequency or per sample [1/V].

    The noises of its inputs, as the nominal stage passes them on, and of its output make up what
    a perfect model leaves; weighed it is white and of size one.
    """
    noise, figures = feed.noise, feed.nominal.figures
    if channel in DIFFERENTIATORS:
        source = DIFFERENTIATORS[channel][1]
        frequency = np.pi * np.arange(feed.size - 2 * EDGE) / (feed.size - 2 * EDGE) / feed.interval
        response = differentiator_response(channel, {}, feed, frequency)
        passed = np.asarray(np.abs(response) * noise[source], np.float64)
    elif channel == "card_surface":
        passed = np.sqrt(
            (figures.weight_displacement * noise["card_sensor"]) ** 2
            + (figures.weight_velocity * noise["card_velocity"]) ** 2
            + (figures.weight_acceleration * noise["card_acceleration"]) ** 2
        )
    else:
        passed = np.where(inside_layer(feed), layer_gain(feed) * noise["card_surface"], 0.0)
    range_used = float(np.max(np.abs(feed.signals[channel])))
    own = np.hypot(noise[channel], _LINEARITY * range_used)
    weight: Array = 1.0 / np.hypot(own, passed)
    return weight


def _weighed(case: Case, signal: Array) -> Array:
    from scipy.fft import dct, idct

    weight = case.inputs["weight"]
    if case.channel not in DIFFERENTIATORS:
        weighed: Array = signal * weight
        return weighed
    # The ends, where the past or future of the stage is not known, would spread: they are cut
    # first. What is beyond is taken as the mirror image, which shifts no level.
    inner = dct(signal[EDGE:-EDGE], norm="ortho")
    return np.pad(idct(weight * inner, norm="ortho"), EDGE)
