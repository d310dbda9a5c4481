"""A piston pushed by an outside drive at a held chamber pressure: the force at its rod."""

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from pneuservo.arrays import Array, Mask, bridged
from pneuservo.diagnosis.models.model import Case, Model, Unknown, Values
from pneuservo.diagnosis.models.plausible import require_absolute
from pneuservo.noise import noise_floor
from pneuservo.plant.compilation import compiled
from pneuservo.plant.presliding import presliding_state
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_GLITCH = 5
"""Samples of the median that removes single wrong readings of the displacement."""
_SMOOTHING = 9
"""Samples of the quadratic smoothing of the displacement: shorter than any reversal."""
_UNSURE = 1
"""Samples on either side of a reversal that are not judged."""
_GAP = 3.0
"""A step in time this many times the usual one is a gap."""


@compiled
def _follow(displacement, play):
    """Return the displacement without the wandering of noise: a pointer with some play."""
    followed = np.empty(displacement.size)
    position = displacement[0]
    for k in range(displacement.size):
        if displacement[k] > position + play:
            position = displacement[k] - play
        elif displacement[k] < position - play:
            position = displacement[k] + play
        followed[k] = position
    return followed


def condition_displacement(displacement: Array, time: Array) -> Array:
    """Return the displacement with single wrong readings, noise and missing samples removed.

    Parameters
    ----------
    displacement : (n,) array
        As recorded; NaN where a sample is missing [m].
    time : (n,) array
        Time of each sample; nothing is smoothed across a gap [s].

    Returns
    -------
    (n,) array
        Smoothed; constant while the piston rests, so that its direction is well defined [m].
    """
    from scipy.ndimage import median_filter
    from scipy.signal import savgol_filter

    filled = bridged(time, displacement)
    steps = np.diff(time)
    pieces = np.split(filled, np.flatnonzero(steps > _GAP * np.median(steps)) + 1)
    cleaned = [median_filter(piece, _GLITCH, mode="nearest") for piece in pieces]
    smooth = [
        savgol_filter(piece, _SMOOTHING, 2) if len(piece) >= _SMOOTHING else piece
        for piece in cleaned
    ]
    # The noise that is left moves the smoothed curve by about a third of what was removed.
    removed = np.concatenate(cleaned) - np.concatenate(smooth)
    spread = float(np.median(np.abs(removed))) / 0.6745
    followed: Array = _follow(np.concatenate(smooth), 2.0 * spread / 3.0)
    return followed


class SealTesterModel(Model):
    """Force at the rod from displacement and chamber pressure.

    Notes
    -----
    Quasi-static: force = gauge pressure x piston area + load-cell zero - friction, friction
    against the motion. The drive is slow, so inertia is left out; with one speed per direction
    a viscous part cannot be told from Coulomb friction.
    """

    kind: ClassVar[str] = "seal-tester"
    channel: ClassVar[str] = "force"
    unit: ClassVar[str] = "N"
    block: ClassVar[str] = "piston"
    blocks: ClassVar[Mapping[str, str]] = {"ambient": "piston", "sensor.force": "load"}
    required: ClassVar[tuple[str, ...]] = ("displacement", "pressure_a", "force")

    def prepare(self, recording: Recording, rig: Rig) -> Case:
        """Return the recording with its direction of motion worked out."""
        force, time = recording["force"], recording.time
        noise = recording.noise_rms.get("force") or noise_floor(force, time)
        displacement = condition_displacement(recording["displacement"], time)
        require_absolute(recording, "pressure_a")
        gauge = bridged(time, recording["pressure_a"]) - rig["ambient.pressure"]
        ends = np.percentile(displacement, [1.0, 99.0])
        middle, half = float(ends.mean()), max(float(np.ptp(ends)) / 2.0, 1e-6)
        inputs = {
            "time": time,
            "displacement": displacement,
            "speed": np.abs(np.gradient(displacement, time)),
            "gauge_pressure": gauge,
            "middle": middle,
            "stroke_share": (displacement - middle) / half,
        }
        usable = np.isfinite(force) & ~_at_reversal(displacement)
        return Case(recording, force, inputs, noise, rig, usable)

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return what the test itself decides, and what is known only within tolerances."""
        return (
            "piston.diameter",
            "piston.coulomb_friction",
            "sensor.force.offset",
        )

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return the friction that was built up before the recording began."""
        return [Unknown("initial_presliding", 0.0, -1.0, 1.0)]

    def predict(self, case: Case, values: Values) -> Array:
        """Return the force at the rod [N]."""
        get, inputs = values.get, case.inputs
        pressure, share = inputs["gauge_pressure"], inputs["stroke_share"]
        state = presliding_state(
            inputs["displacement"],
            get("friction.presliding:travel", 0.0),
            get("friction.presliding:exponent", 1.0),
            values["initial_presliding"],
        )
        # A fit simulates thousands of times, most of it without what most of the terms are for.
        level = values["piston.coulomb_friction"]
        if rise := get("friction.pressure:slope", 0.0):
            level = level + rise * pressure
        if excess := get("friction.stribeck:excess", 0.0):
            level = level + excess * np.exp(-inputs["speed"] / get("friction.stribeck:speed", 1.0))
        along: Array | float = 1.0
        if slope := get("friction.position:slope", 0.0):
            along = along + slope * share
        if curvature := get("friction.position:curvature", 0.0):
            along = along + curvature * share**2
        if rate := get("friction.run-in:rate", 0.0):
            along = along + rate * inputs["time"]
        friction = level * along * state
        if difference := get("friction.asymmetric:difference", 0.0):
            friction = friction + difference * np.abs(state)
        gauge = pressure
        if gain := get("sensor.pressure-gain-a:gain", 0.0):
            gauge = pressure * (1.0 + gain)
        force: Array = gauge * (math.pi / 4.0 * values["piston.diameter"] ** 2) - friction
        if stiffness := get("load.spring:stiffness", 0.0):
            force = force - stiffness * (inputs["displacement"] - inputs["middle"])
        if gain := get("sensor.force-gain:gain", 0.0):
            force = force * (1.0 + gain)
        return force + values["sensor.force.offset"]

    def regimes(self, case: Case) -> dict[str, Mask]:
        """Return parts of the recording by motion, place and pressure."""
        displacement, share = case.inputs["displacement"], case.inputs["stroke_share"]
        direction = self._direction(case)
        since = _distance_since_reversal(displacement, direction)
        moving = since > 2e-3
        return {
            "within 2 mm after a reversal": ~moving,
            "sliding in the extending direction": moving & (direction > 0),
            "sliding in the retracting direction": moving & (direction < 0),
            "in the retracted fifth of the recorded stroke": share < -0.6,
            "in the extended fifth of the recorded stroke": share > 0.6,
            "above 4 bar gauge": case.inputs["gauge_pressure"] > 4e5,
            "below 2 bar gauge": case.inputs["gauge_pressure"] < 2e5,
        }

    def circumstances(self, case: Case) -> dict[str, tuple[float, str]]:
        """Return the sampling interval and how fast the piston was driven."""
        speed = case.inputs["speed"]
        driven = float(np.median(speed[speed > 0.0])) if np.any(speed) else 0.0
        return super().circumstances(case) | {"speed of the drive": (driven, "m/s")}

    def closeup(self, case: Case) -> slice:
        """Return a quarter of the recording: two or three strokes of a usual run."""
        return slice(0, max(200, len(case.measured) // 4))

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return place with direction, speed, pressure and time."""
        displacement, direction = case.inputs["displacement"], self._direction(case)
        return {
            "displacement": displacement,
            "displacement and direction": displacement + 10.0 * direction,
            "speed": case.inputs["speed"],
            "pressure": case.inputs["gauge_pressure"],
            "pressure and direction": case.inputs["gauge_pressure"] + 1e8 * direction,
            "time": case.recording.time,
        }

    @staticmethod
    def _direction(case: Case) -> Array:
        displacement = case.inputs["displacement"]
        return _last_nonzero_sign(np.diff(displacement, prepend=displacement[0]))


def _at_reversal(displacement: Array) -> Mask:
    """Return the samples beside a reversal, whose moment is known to no better than a sample."""
    from scipy.ndimage import binary_dilation

    direction = _last_nonzero_sign(np.diff(displacement, prepend=displacement[0]))
    turned = np.diff(direction, prepend=direction[0]) != 0
    beside: Mask = binary_dilation(turned, iterations=_UNSURE)
    return beside


def _last_nonzero_sign(step: Array) -> Array:
    index = np.where(step != 0.0, np.arange(len(step)), 0)
    last: Array = np.sign(step[np.maximum.accumulate(index)])
    return last


def _distance_since_reversal(displacement: Array, direction: Array) -> Array:
    turned = np.diff(direction, prepend=direction[0]) != 0
    start = np.maximum.accumulate(np.where(turned, np.arange(len(turned)), 0))
    distance: Array = np.abs(displacement - displacement[start])
    return distance
