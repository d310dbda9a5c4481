"""A closed test volume: behind one valve port, or left alone."""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from pneuservo.diagnosis.models.model import Array, Case, Model, Unknown, Values
from pneuservo.diagnosis.noise import noise_floor
from pneuservo.effects.chamber import settling_rate
from pneuservo.effects.leakage import laminar_leak, orifice_leak, power_leak
from pneuservo.plant.compilation import compiled
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_LONGEST_STEP = 0.05
"""Longest integration step [s]; the fastest leaks in use empty a volume in seconds."""


@compiled
def _rate(time, pressure, ambient, temperature, gas_constant, exponent, index, volume, leak, heat):
    area, conductance, coefficient, power = leak
    flow = orifice_leak(pressure, ambient, temperature, gas_constant, exponent, area)
    flow += laminar_leak(pressure, ambient, temperature, conductance)
    flow += power_leak(pressure, ambient, coefficient, power)
    excess, time_constant = heat
    return -index * gas_constant * temperature * flow / volume + settling_rate(
        time, pressure, temperature, excess, time_constant
    )


@compiled
def _decay(times, start, initial, ambient, temperature, gas_constant, exponent, index, volume,
           leak, heat, longest_step):  # fmt: skip
    """Integrate the pressure of a closed volume that is let go at `start` (classical RK4)."""
    pressure = np.empty(times.size)
    p = initial
    pressure[0] = p
    for k in range(1, times.size):
        t = max(times[k - 1], start)
        span = times[k] - t
        if span > 0.0:
            steps = int(np.ceil(span / longest_step))
            h = span / steps
            for _ in range(steps):
                a = t - start
                k1 = _rate(a, p, ambient, temperature, gas_constant, exponent, index, volume,
                           leak, heat)  # fmt: skip
                k2 = _rate(a + h / 2, p + h / 2 * k1, ambient, temperature, gas_constant, exponent,
                           index, volume, leak, heat)  # fmt: skip
                k3 = _rate(a + h / 2, p + h / 2 * k2, ambient, temperature, gas_constant, exponent,
                           index, volume, leak, heat)  # fmt: skip
                k4 = _rate(a + h, p + h * k3, ambient, temperature, gas_constant, exponent, index,
                           volume, leak, heat)  # fmt: skip
                p += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
                t += h
        pressure[k] = p
    return pressure


class DeadVolumeModel(Model):
    """Pressure of a closed volume from its own past and its leaks.

    Notes
    -----
    The gas is polytropic. The volume may be held from outside at first; from `start` on it is
    alone. Only leak over volume can be found from pressure alone, so the volume counts as known.
    """

    kind: ClassVar[str] = "dead-volume"
    channel: ClassVar[str] = "dead_volume_pressure"
    unit: ClassVar[str] = "Pa"
    block: ClassVar[str] = "dead-volume"
    required: ClassVar[tuple[str, ...]] = ("dead_volume_pressure",)
    fitted: ClassVar[tuple[str, ...]] = ()

    def prepare(self, recording: Recording, rig: Rig) -> Case:
        """Return the recording with its noise."""
        measured = recording[self.channel]
        noise = recording.noise_rms.get(self.channel) or noise_floor(measured, recording.time)
        return Case(recording, measured, {"time": recording.time}, noise, rig, np.isfinite(measured))

    def nuisances(self, case: Case, active: frozenset[str]) -> list[list[Unknown]]:
        """Return level, transducer zero, and when the volume was left alone."""
        level = float(np.nanmedian(case.measured[:5]))
        unknowns = [Unknown("initial_pressure", level, 1e3, 5e6, unit="Pa")]
        if not any(effect.startswith("leakage.") for effect in active):
            return [unknowns]
        lowest = float(np.nanmin(case.measured)) - case.rig["ambient.pressure"]
        if lowest < 0.2 * (level - case.rig["ambient.pressure"]):
            # A zero shift only shows when the pressure comes near the ambient.
            unknowns.append(Unknown("pressure_offset", 0.0, -5e3, 5e3, 1e3, "Pa"))
        released = self._release(case)
        if released is not None:
            latest = 0.9 * float(case.recording.time[-1])
            unknowns.append(Unknown("start", released, 0.0, latest, unit="s"))
        return [unknowns]

    def _release(self, case: Case) -> float | None:
        """Return when a volume that was held from outside was let go, None if it never was [s]."""
        time, pressure = case.recording.time[case.usable], case.measured[case.usable]
        level = float(np.median(pressure[: max(5, len(pressure) // 100)]))
        near = np.abs(pressure - level) < max(6.0 * case.noise_rms, 2e-3 * level)
        last = int(np.flatnonzero(near)[-1])
        after = slice(last, last + max(5, len(pressure) // 20))
        if last < 5 or len(pressure[after]) < 5:
            return None
        # Held, if it would have lost far more before that moment at the rate it had after it.
        rate = float(np.polyfit(time[after], pressure[after], 1)[0])
        lost = abs(pressure[last] - level) + case.noise_rms
        return float(time[last]) if abs(rate) * (time[last] - time[0]) > 5.0 * lost else None

    def predict(self, case: Case, values: Values) -> Array:
        """Return the pressure history [Pa]."""
        rig = case.rig
        leak = (
            values.get("leakage.orifice:area", 0.0) + values.get("leakage.mixed:area", 0.0),
            values.get("leakage.laminar:conductance", 0.0)
            + values.get("leakage.mixed:conductance", 0.0),
            values.get("leakage.pressure-opening:coefficient", 0.0),
            values.get("leakage.pressure-opening:exponent", 1.0),
        )
        heat = (
            values.get("chamber.heat-transfer:excess", 0.0),
            values.get("chamber.heat-transfer:time_constant", 1.0),
        )
        offset = values.get("pressure_offset", 0.0)
        time = case.inputs["time"]
        pressure = _decay(
            time,
            values.get("start", 0.0),
            values["initial_pressure"] - offset,
            rig["ambient.pressure"],
            rig["temperature"],
            rig["gas.constant"],
            rig["gas.isentropic_exponent"],
            rig["dead-volume.polytropic_index"],
            rig["dead-volume.volume"],
            leak,
            heat,
            _LONGEST_STEP,
        )
        drift = values.get("sensor.pressure-drift:rate", 0.0)
        reading: Array = pressure + offset + drift * time
        return reading

    def regimes(self, case: Case) -> dict[str, NDArray[np.bool_]]:
        """Return parts of the recording by pressure."""
        gauge = case.measured - case.rig["ambient.pressure"]
        top = np.nanmax(gauge)
        return {
            "at high pressure": gauge > 0.5 * top,
            "at low pressure": gauge <= 0.2 * top,
        }

    def regressors(self, case: Case) -> dict[str, Array]:
        """Return pressure and time."""
        return {"pressure": case.measured, "time": case.recording.time}
