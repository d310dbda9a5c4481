"""The single-axis servo as three blocks, each followed from what was measured round it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.model import Array, Case, Model, Unknown, Values
from pneuservo.diagnosis.models.servo.charging import charging_flow
from pneuservo.diagnosis.models.servo.feed import Feed, feed, held_command
from pneuservo.diagnosis.models.servo.follow_chambers import follow_chambers
from pneuservo.diagnosis.models.servo.follow_piston import follow_piston
from pneuservo.diagnosis.models.servo.imitation import imitated
from pneuservo.diagnosis.models.servo.regimes import regimes_of, regressors_of
from pneuservo.effects import Effect
from pneuservo.effects.servo import servo_effects
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.from_rig import single_axis, valve_grid
from pneuservo.plant.servo.fed_chambers import step_for
from pneuservo.plant.servo.layout import Fed, Servo
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.starting import servo_state
from pneuservo.plant.servo.transducers import true_motion, true_pressures
from pneuservo.plant.single_axis import (
    DISPLACEMENT,
    PLANT_STATES,
    PRESSURE_A,
    PRESSURE_B,
    SPOOL,
    VELOCITY,
    SingleAxis,
)
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_PISTON_ONLY = ("friction.", "load.", "endstop.", "piston.viscous", "piston.coulomb")
_CHAMBERS_ONLY = (
    "spool.",
    "valve.",
    "supply.",
    "line.",
    "chamber.",
    "leakage.",
    "gas.",
    "temperature",
)
_ONLY_NOISE = ("sensor.noise-colour", "sensor.quantisation")
_KEPT = 4
"""Results kept per block."""
_TOGETHER = 0.2
"""Both chambers are wrong when each has at least this share of what is left of them."""


class ServoModel(Model):
    """Displacement from pressures; pressures from command and motion.

    Notes
    -----
    Each block is a filter that is fed with what was measured round it and is told, at every
    sample, how wrong it was: what is left are innovations, white and of the size of the noise
    when nothing is missing. Every channel counts in its own noise.
    """

    kind: ClassVar[str] = "single-axis"
    channel: ClassVar[str] = "displacement"
    unit: ClassVar[str] = "m"
    block: ClassVar[str] = "piston"
    required: ClassVar[tuple[str, ...]] = (
        "valve_voltage",
        "displacement",
        "pressure_a",
        "pressure_b",
    )
    steady: ClassVar[bool] = True

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Return the effects that change what is expected; noise explains nothing."""
        return tuple(effect for effect in super().effects if effect.id not in _ONLY_NOISE)

    def cases(self, recording: Recording, rig: Rig) -> list[Case]:
        """Return the recording once per judged channel, each in units of its noise."""
        fed = _likelier_command(feed(recording, rig), rig)
        found = []
        for channel, unit in (("displacement", "m"), ("pressure_a", "Pa"), ("pressure_b", "Pa")):
            noise = fed.noise[channel]
            usable = np.isfinite(recording[channel])
            if channel == "displacement":
                usable = usable & ~fed.held
            found.append(
                Case(
                    recording,
                    recording[channel] / noise,
                    {"feed": fed},
                    1.0,
                    rig,
                    usable,
                    channel,
                    unit,
                    noise,
                )
            )
        return found

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return every parameter that is known within a tolerance only."""
        measured_supply = case.inputs["feed"].supply is not None
        return tuple(
            key
            for key, parameter in case.rig.parameters.items()
            if parameter.tolerance and not (measured_supply and key == "supply.pressure")
        )

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return nothing: what a filter starts from is forgotten."""
        return []

    def predict(self, case: Case, values: Values) -> Array:
        """Return the judged channel as expected from its surroundings and its own past."""
        fed: Feed = case.inputs["feed"]
        if case.channel == "displacement":
            left = _once(fed, "piston", _CHAMBERS_ONLY, values, case.rig, _piston)
        else:
            both = _once(fed, "chambers", _PISTON_ONLY, values, case.rig, _chambers)
            left = both[0 if case.channel == "pressure_a" else 1]
        expected: Array = case.measured - left / case.scale
        return expected

    def suspects(
        self, cases: Sequence[Case], residuals: Sequence[Array], noise: Sequence[float]
    ) -> dict[str, float]:
        """Return piston, chambers or valve by which channels are wrong, and wrong together."""
        excess = dict.fromkeys(("displacement", "pressure_a", "pressure_b"), 0.0)
        for case, left, level in zip(cases, residuals, noise, strict=True):
            excess[case.channel] += max(float(np.sum(left**2)) - len(left) * level**2, 0.0)
        both = (excess["pressure_a"], excess["pressure_b"])
        if min(both) > _TOGETHER * sum(both):
            shares = {"piston": excess["displacement"], "valve.flow": sum(both)}
        else:
            shares = {
                "piston": excess["displacement"],
                "chamber.a": excess["pressure_a"],
                "chamber.b": excess["pressure_b"],
            }
        total = sum(shares.values())
        if total <= 0.0:
            return {self.block: 1.0}
        return {block: share / total for block, share in shares.items()}

    def imitate(
        self, cases: Sequence[Case], values: Sequence[Values], rng: np.random.Generator
    ) -> list[Case]:
        """Return the recordings as the rig without effects would have given them."""
        found: list[Case] = []
        copies: dict[int, Feed] = {}
        for case, mine in zip(cases, values, strict=True):
            fed: Feed = case.inputs["feed"]
            if id(fed) not in copies:
                parameters = {key: v for key, v in mine.items() if key in case.rig.parameters}
                rig = case.rig.with_values(parameters)
                copies[id(fed)] = imitated(fed, case.recording, rig, rng)
            copy = copies[id(fed)]
            reading = copy.reading
            if case.channel != "displacement":
                reading = copy.pressures[0 if case.channel == "pressure_a" else 1]
            found.append(replace(case, measured=reading / case.scale, inputs={"feed": copy}))
        return found

    def regimes(self, case: Case) -> dict[str, NDArray[np.bool_]]:
        """Return parts of the recording by motion, place, opening, pressure ratio and time."""
        return regimes_of(case.inputs["feed"], case.rig)

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return motion, pressures, command and time."""
        return regressors_of(case.inputs["feed"])


def _likelier_command(ramped: Feed, rig: Rig) -> Feed:
    """Return the feed whose command, running on or held between samples, fits better.

    A controller that samples holds its command; an analogue one, or a recorder, does not.
    """
    held = held_command(ramped, rig)
    sharp = replace(ramped, spread=held.spread, done={})
    left = [float(np.sum(_chambers(fed, {}, rig) ** 2)) for fed in (sharp, held)]
    return held if left[1] < left[0] else ramped


def _once(fed: Feed, block: str, idle: tuple[str, ...], values: Values, rig: Rig, run: Any) -> Any:
    """Return the result of a block, run anew only when a value that it heeds has changed."""
    heeded = tuple(sorted((k, v) for k, v in values.items() if not k.startswith(idle)))
    results = fed.done.setdefault(block, {})
    assert isinstance(results, dict)
    if heeded not in results:
        while len(results) >= _KEPT:
            results.pop(next(iter(results)))
        results[heeded] = run(fed, values, rig)
    return results[heeded]


def _numbers(values: Values, rig: Rig) -> tuple[SingleAxis, ServoEffects]:
    parameters = {key: value for key, value in values.items() if key in rig.parameters}
    effects = {key: value for key, value in values.items() if ":" in key}
    return single_axis(rig.with_values(parameters)), servo_effects(effects)


def _truth(fed: Feed, plant: SingleAxis, effects: ServoEffects) -> tuple[Array, Array]:
    """Return motion and pressures behind what faulty transducers read."""
    sensor, stroke = effects.sensor, plant.piston.stroke
    place, speed = true_motion(fed.motion[0], fed.motion[1], fed.motion[2], stroke, sensor)
    slope = 1.0 + sensor.displacement_gain
    flows: tuple[Array | None, Array | None] = (None, None)
    if sensor.static_share:
        flows = (
            charging_flow(fed.pressures[0], fed.pressure_rates[0], place, speed, plant, "a"),
            charging_flow(fed.pressures[1], fed.pressure_rates[1], place, speed, plant, "b"),
        )
    # A shift in time is undone with the smoothed rate: shifting the reading would smooth its noise.
    shift = sensor.pressure_lag - sensor.pressure_skew
    readings = fed.pressures + shift * fed.pressure_rates
    still = sensor._replace(pressure_lag=0.0, pressure_skew=0.0, hum=0.0)
    pressures = true_pressures(fed.time, readings[0], readings[1], *flows, plant.gas, still)
    return np.array([place, speed, fed.motion[2] / slope]), np.array(pressures)


def _piston(fed: Feed, values: Values, rig: Rig) -> Array:
    plant, effects = _numbers(values, rig)
    motion, pressures = _truth(fed, plant, effects)
    left: Array = follow_piston(
        fed.time,
        fed.reading,
        fed.motion,
        motion,
        pressures,
        fed.force,
        fed.held,
        fed.bandwidth,
        fed.reversal,
        plant,
        effects,
    )
    return left


def _chambers(fed: Feed, values: Values, rig: Rig) -> Array:
    plant, effects = _numbers(values, rig)
    motion, pressures = _truth(fed, plant, effects)
    servo = Servo(plant, effects, OPEN_LOOP, Fed(motion=True, ramped_command=fed.ramped))
    supply = fed.supply if fed.supply is not None else np.full_like(fed.time, plant.supply_pressure)
    start = np.zeros(PLANT_STATES)
    start[SPOOL] = np.clip(fed.voltage[0] / plant.valve.full_voltage, -1.0, 1.0)
    start[[PRESSURE_A, PRESSURE_B]] = pressures[:, 0]
    start[[DISPLACEMENT, VELOCITY]] = motion[:2, 0]
    left: Array = follow_chambers(
        fed.time,
        fed.voltage,
        fed.ramped,
        motion[:2],
        pressures,
        supply,
        np.array([fed.noise["pressure_a"], fed.noise["pressure_b"]]) ** 2,
        fed.spread,
        servo,
        valve_grid(rig.valve),
        servo_state(start, servo, float(supply[0])),
        step_for(effects),
    )
    # What is left counts as the transducer reads it.
    left[0] *= 1.0 + effects.sensor.pressure_a_gain
    left[1] *= 1.0 + effects.sensor.pressure_b_gain
    return left
