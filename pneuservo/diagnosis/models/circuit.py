"""An electronic circuit that behaves as a mass on a spring, seen at its terminals."""

import math
from typing import ClassVar

import numpy as np

from pneuservo.arrays import Array, Mask, bridged
from pneuservo.diagnosis.models.even_samples import even_interval
from pneuservo.diagnosis.models.model import Case, Model, Unknown, Values
from pneuservo.effects.circuit import damping_beyond_linear, stiffness_beyond_linear
from pneuservo.noise import noise_floor
from pneuservo.plant.compilation import compiled
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_OVERSAMPLING = 4
"""Input points per sample: two per integration step, two steps per sample."""
_DIVERGED = 1e6
"""Output beyond which a trial response counts as run away [V]."""


@compiled
def _acceleration(x, v, drive, w, damping, stiffness, extra_damping):
    quadratic, cubic, quintic = stiffness
    dry, cubic_damping = extra_damping
    restoring = x + stiffness_beyond_linear(x, quadratic, cubic, quintic)
    return (
        w * w * (drive - restoring)
        - 2.0 * damping * w * v
        - w * damping_beyond_linear(v, dry, cubic_damping)
    )


@compiled
def _response(drive, per_sample, interval, x, v, w, damping, stiffness, extra, limit):
    """Integrate the output (classical RK4), the drive given at every half step."""
    count = (drive.size - 1) // per_sample + 1
    output = np.empty(count)
    output[0] = x
    h = 2.0 * interval / per_sample
    for k in range(count - 1):
        for j in range(k * per_sample, (k + 1) * per_sample, 2):
            a1 = _acceleration(x, v, drive[j], w, damping, stiffness, extra)
            v2 = v + h / 2 * a1
            a2 = _acceleration(x + h / 2 * v, v2, drive[j + 1], w, damping, stiffness, extra)
            v3 = v + h / 2 * a2
            a3 = _acceleration(x + h / 2 * v2, v3, drive[j + 1], w, damping, stiffness, extra)
            v4 = v + h * a3
            a4 = _acceleration(x + h * v3, v4, drive[j + 2], w, damping, stiffness, extra)
            x += h / 6 * (v + 2 * v2 + 2 * v3 + v4)
            v += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        if not abs(x) < limit:
            output[k + 1 :] = limit
            return output
        output[k + 1] = x
    return output


class CircuitModel(Model):
    """Output of a second-order circuit from its input.

    Notes
    -----
    The input is taken as limited to half the sampling rate and is interpolated accordingly.
    """

    kind: ClassVar[str] = "circuit"
    channel: ClassVar[str] = "circuit_output"
    unit: ClassVar[str] = "V"
    block: ClassVar[str] = "circuit"
    required: ClassVar[tuple[str, ...]] = ("circuit_input", "circuit_output")

    def prepare(self, recording: Recording, rig: Rig) -> Case:
        """Return the recording with its input between the samples."""
        from scipy.signal import resample_poly

        time, output = recording.time, recording[self.channel]
        interval = even_interval(recording, self.kind)
        signal = bridged(time, recording["circuit_input"])
        fine = resample_poly(
            signal - signal[0], _OVERSAMPLING, 1, window=("kaiser", 8.0), padtype="line"
        )
        drive = fine[: (len(signal) - 1) * _OVERSAMPLING + 1] + signal[0]
        noise = recording.noise_rms.get(self.channel) or noise_floor(output, time)
        inputs = {"drive": drive, "interval": interval, "signal": signal}
        return Case(recording, output, inputs, noise, rig, np.isfinite(output))

    def first_guess(self, case: Case) -> dict[str, float]:
        """Return gain, frequency and damping from a second-order difference equation."""
        y = bridged(case.recording.time, np.where(case.usable, case.measured, np.nan))
        u, interval = case.inputs["signal"], case.inputs["interval"]
        y, u = y - y.mean(), u - u.mean()
        columns = np.column_stack([y[1:-1], y[:-2], u[2:], u[1:-1], u[:-2]])
        weights = np.linalg.lstsq(columns, y[2:], rcond=None)[0]
        poles = np.roots([1.0, -weights[0], -weights[1]]).astype(complex)
        rates = np.log(np.where(np.abs(poles) < 1e-6, 1e-6, poles)) / interval
        w = math.sqrt(abs(rates[0] * rates[1]))
        guess = {
            "circuit.frequency": w / (2.0 * math.pi),
            "circuit.damping": min(5.0, max(1e-3, -float(np.real(np.sum(rates))) / (2.0 * w))),
            "circuit.gain": float(np.sum(weights[2:]) / (1.0 - weights[0] - weights[1])),
        }
        return {key: value for key, value in guess.items() if np.isfinite(value) and value}

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return what the test itself decides, and what is known only within tolerances."""
        return (
            "circuit.gain",
            "circuit.frequency",
            "circuit.damping",
            "circuit.input_offset",
        )

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return the state at the first sample."""
        good = case.measured[case.usable]
        span = 10.0 * max(float(np.ptp(good)), 1e-9)
        slope = max(float(np.max(np.abs(np.diff(good)))), 1e-9) / case.inputs["interval"]
        rate = float(np.gradient(good[:3])[0]) / case.inputs["interval"]
        return [
            Unknown("initial_output", float(good[0]), good[0] - span, good[0] + span, unit="V"),
            Unknown("initial_rate", rate, -100 * slope, 100 * slope, unit="V/s"),
        ]

    def predict(self, case: Case, values: Values) -> Array:
        """Return the output voltage [V]."""
        get = values.get
        drive = values["circuit.gain"] * (case.inputs["drive"] - get("circuit.input_offset", 0.0))
        stiffness = (
            get("circuit.quadratic-stiffness:coefficient", 0.0),
            get("circuit.cubic-stiffness:coefficient", 0.0),
            get("circuit.quintic-stiffness:coefficient", 0.0),
        )
        extra = (
            get("circuit.dry-damping:level", 0.0),
            get("circuit.cubic-damping:coefficient", 0.0),
        )
        output: Array = _response(
            drive,
            _OVERSAMPLING,
            case.inputs["interval"],
            values["initial_output"],
            values["initial_rate"],
            2.0 * math.pi * values["circuit.frequency"],
            values["circuit.damping"],
            stiffness,
            extra,
            _DIVERGED,
        )
        return output

    def regimes(self, case: Case) -> dict[str, Mask]:
        """Return parts of the recording by amplitude."""
        size = np.abs(case.measured - np.nanmean(case.measured))
        usual = float(np.sqrt(np.nanmean(size**2)))
        return {
            "where the output swings by more than twice its rms": size > 2.0 * usual,
            "where the output swings by less than half its rms": size < 0.5 * usual,
        }

    def closeup(self, case: Case) -> slice:
        """Return about fifteen periods round the largest output."""
        middle = int(np.nanargmax(np.abs(case.measured)))
        half = int(7.5 / (self.first_guess(case)["circuit.frequency"] * case.inputs["interval"]))
        return slice(max(0, middle - half), middle + half)

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return output, its rate, the input and time."""
        rate = np.gradient(case.measured, case.inputs["interval"])
        return {
            "output": case.measured,
            "output rate": rate,
            "input": case.inputs["signal"],
            "time": case.recording.time,
        }
