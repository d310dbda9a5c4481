"""A closed test volume: behind one valve port, or left alone."""

from collections.abc import Callable, Mapping
from typing import ClassVar

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.diagnosis.models.leaking_volume import Leak, run_leaking_volume
from pneuservo.diagnosis.models.model import Case, Model, Unknown, Values
from pneuservo.diagnosis.models.plausible import require_absolute, require_times
from pneuservo.effects.leakage import LEAKS
from pneuservo.noise import noise_floor
from pneuservo.plant.dead_volume import PORT_A, PORT_B
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.rigs.plant_numbers import dead_volume, valve_grid

_LONGEST_STEP = 0.02
"""Longest integration step [s]; the fastest leaks in use empty a volume in seconds."""

_LONGEST = 40_000.0
"""A leak is followed for up to eleven hours [s]: two million steps each time it is simulated."""

_EARLY = 0.25
"""Share of the whole loss that counts as its beginning."""
_FEWEST = 12
_HELD = 0.5
"""A held start has to fit so much better than a smooth one."""


class DeadVolumeModel(Model):
    """Pressure of a closed volume from the valve's command, its own past and its leaks.

    Notes
    -----
    The gas is polytropic. Without a valve the volume may be held from outside at first; from
    `start` on it is alone. Only leak over volume can be found from pressure alone, so the volume
    then counts as known.
    """

    kind: ClassVar[str] = "dead-volume"
    channel: ClassVar[str] = "dead_volume_pressure"
    unit: ClassVar[str] = "Pa"
    block: ClassVar[str] = "dead-volume"
    blocks: ClassVar[Mapping[str, str]] = {"ambient": "valve.flow", "": "supply"}
    required: ClassVar[tuple[str, ...]] = ("dead_volume_pressure",)

    def completed(self, recording: Recording, rig: Rig) -> Recording:
        """Return the recording with its time, from which a drift counts, from its first sample."""
        return recording.from_its_start()

    def prepare(self, recording: Recording, rig: Rig) -> Case:
        """Return the recording with its noise and the opening of the valve."""
        require_absolute(recording, self.channel)
        require_times(recording, span=_LONGEST)
        measured, time = recording[self.channel], recording.time
        noise = recording.noise_rms.get(self.channel) or noise_floor(measured, time)
        full = rig["valve.full_voltage"]
        voltage = np.zeros(len(time))
        if "valve_voltage" in recording:
            voltage = np.clip(_held(recording["valve_voltage"]), -full, full)
        inputs = {"time": time, "opening": voltage / full, "port": _port(measured, voltage)}
        return Case(recording, measured, inputs, noise, rig, np.isfinite(measured))

    def fitted(self, case: Case) -> tuple[str, ...]:
        """Return the volume where the valve's known flow reveals it."""
        return ("dead-volume.volume", "supply.pressure") if self._has_valve(case) else ()

    @staticmethod
    def _has_valve(case: Case) -> bool:
        return bool(np.any(case.inputs["opening"]))

    def nuisances(self, case: Case, active: frozenset[str]) -> list[Unknown]:
        """Return level, transducer zero, and when the volume was left alone."""
        level = float(np.median(case.measured[case.usable][:5]))
        unknowns = [Unknown("initial_pressure", level, 1e3, 5e6, unit="Pa")]
        if not active & _LEAK_IDS:
            return unknowns
        lowest = float(np.nanmin(case.measured)) - case.rig["ambient.pressure"]
        if lowest < 0.2 * (level - case.rig["ambient.pressure"]):
            # A zero shift only shows when the pressure comes near the ambient.
            unknowns.append(Unknown("pressure_offset", 0.0, -5e3, 5e3, 1e3, "Pa"))
        released = None if self._has_valve(case) else self._release(case)
        if released is not None:
            latest = 0.9 * float(case.recording.time[-1])
            unknowns.append(Unknown("start", released, 0.0, latest, unit="s"))
        return unknowns

    def _release(self, case: Case) -> float | None:
        """Return when a volume that was held from outside was let go, None if it never was [s].

        A volume that was never held loses its first pressure along a smooth curve; one that was
        held stays level and then turns off.
        """
        time, pressure = case.recording.time[case.usable], case.measured[case.usable]
        level = float(np.median(pressure[:5]))
        lost = np.flatnonzero(level - pressure > _EARLY * (level - pressure.min()))
        early = slice(0, max(_FEWEST, int(lost[0]) + 1 if len(lost) else len(time)))
        t, p = time[early], pressure[early]
        smooth = float(np.sum((p - np.polynomial.Polynomial.fit(t, p, 2)(t)) ** 2))
        misfit = {turn: _misfit_of_turn(t, p, turn) for turn in np.linspace(t[0], t[-1], 60)[1:-3]}
        turn = min(misfit, key=lambda moment: misfit[moment])
        held = misfit[turn] < _HELD * smooth and turn > 2.0 * case.recording.sampling_interval
        return float(turn) if held else None

    def predict(self, case: Case, values: Values) -> Array:
        """Return the pressure history [Pa]."""
        get, time = values.get, case.inputs["time"]
        rig = case.rig.with_values({k: v for k, v in values.items() if k in case.rig.parameters})
        offset = get("pressure_offset", 0.0)
        pressure = run_leaking_volume(
            time,
            case.inputs["opening"],
            get("start", 0.0),
            values["initial_pressure"] - offset,
            case.inputs["port"],
            dead_volume(rig),
            valve_grid(rig.valve),
            _leak(values),
            get("chamber.heat-transfer:excess", 0.0),
            get("chamber.heat-transfer:time_constant", 0.0),
            _LONGEST_STEP,
        )
        drift = get("sensor.pressure-drift:rate", 0.0)
        reading: Array = pressure + offset + drift * time
        return reading

    def derived(
        self, case: Case, effect: str
    ) -> dict[str, tuple[str, Callable[[Values, Values], float]]]:
        """Return how fast a leak empties the volume at first, and when it began."""
        # Behind a valve the pressure at first is that before filling: nothing leaks then.
        if effect not in _LEAK_IDS or self._has_valve(case):
            return {}

        def fall(shared: Values, own: Values) -> float:
            values = {**shared, **own}
            start = own["initial_pressure"] - values.get("pressure_offset", 0.0)
            moments = np.array([0.0, 1e-3])
            rig = case.rig
            if values.get("chamber.heat-transfer:time_constant", 0.0):
                # The leak alone, once the gas has settled.
                rig = rig.with_values({"dead-volume.polytropic_index": 1.0})
            pressure = run_leaking_volume(
                moments, np.zeros(2), 0.0, start, PORT_A, dead_volume(rig),
                valve_grid(case.rig.valve), _leak(values), 0.0, 0.0, _LONGEST_STEP,
            )  # fmt: skip
            return float(np.diff(pressure)[0] / 1e-3)

        found: dict[str, tuple[str, Callable[[Values, Values], float]]] = {
            "pressure_rate_at_first": ("Pa/s", fall)
        }
        if any(unknown.key == "start" for unknown in self.nuisances(case, frozenset([effect]))):
            found["start"] = ("s", lambda shared, own: own["start"])
        return found

    def regimes(self, case: Case) -> dict[str, Mask]:
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


def _misfit_of_turn(time: Array, pressure: Array, turn: float) -> float:
    """Return the squares left by a level that turns into a straight line [Pa^2]."""
    columns = np.column_stack([np.ones(len(time)), np.maximum(time - turn, 0.0)])
    left = np.linalg.lstsq(columns, pressure, rcond=None)[1]
    return float(left[0]) if len(left) else np.inf


_LEAK_IDS = frozenset(effect.id for effect in LEAKS)


def _leak(values: Values) -> Leak:
    get = values.get
    return Leak(
        get("leakage.orifice:area", 0.0) + get("leakage.mixed:area", 0.0),
        get("leakage.laminar:conductance", 0.0) + get("leakage.mixed:conductance", 0.0),
        get("leakage.pressure-opening:coefficient", 0.0),
        get("leakage.pressure-opening:exponent", 1.0),
    )


def _held(command: Array) -> Array:
    """Return a command that stays as it was last seen where it is missing."""
    there = np.isfinite(command)
    last = np.maximum.accumulate(np.where(there, np.arange(len(command)), 0))
    # Before the first that was seen it is taken to have been that already.
    return np.asarray(command[np.maximum(last, np.argmax(there))])


def _port(pressure: Array, voltage: Array) -> int:
    """Return the port the volume is on: the one whose opening moves the pressure as it did."""
    change = np.nansum(np.diff(pressure) * np.sign(voltage[:-1]))
    return PORT_A if change >= 0.0 else PORT_B
