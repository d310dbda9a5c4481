"""One charge or discharge of a dead volume at a held command."""

from dataclasses import dataclass

import numpy as np

from pneuservo.arrays import Array, Mask
from pneuservo.errors import InputError
from pneuservo.noise import noise_floor
from pneuservo.plant.dead_volume import PORT_A, PORT_B
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.recordings import Recording
from pneuservo.recordings.time_checks import FEWEST_SAMPLES
from pneuservo.rigs import Rig, load_rig

LEAK = "leak"
_CHANNEL = "dead_volume_pressure"
# A command that moves by more than this is not a held one [V].
_HELD = 0.01
# Pressures closer than this share of the upstream pressure count as equal: the rate is noise there.
_EQUAL = 2e-3


@dataclass(frozen=True)
class Transient:
    """One charge or discharge of a dead volume.

    Parameters
    ----------
    name : str
        For messages and legends.
    path : str
        Flow path, one of `pneuservo.plant.flow_paths.FLOW_PATHS`, or `LEAK` for a volume
        without a command.
    command : float
        Magnitude of the held command, at most the full voltage; NaN for a leak [V].
    time : (n,) array
        [s].
    pressure : (n,) array
        Absolute pressure of the volume [Pa].
    noise_rms : float
        Of the pressure [Pa].
    rig : Rig
        Of kind ``dead-volume``, with the conditions of the recording.
    """

    name: str
    path: str
    command: float
    time: Array
    pressure: Array
    noise_rms: float
    rig: Rig

    @property
    def charging(self) -> bool:
        """Return whether the volume is being filled."""
        return self.path.startswith("s_")

    @property
    def port(self) -> int:
        """Return the valve port the volume is on, as the kernels name it."""
        return PORT_A if self.path in ("s_a", "a_e") else PORT_B

    @property
    def opening(self) -> float:
        """Return the spool's fraction of full opening, with the sign that opens the path [-]."""
        sign = 1.0 if self.path in ("s_a", "b_e") else -1.0
        return sign * min(self.command / self.rig["valve.full_voltage"], 1.0)

    @property
    def area(self) -> float:
        """Return the geometric area that is open; 1 for a leak, whose area is unknown [m^2]."""
        if self.path == LEAK:
            return 1.0
        return abs(self.opening) * self.rig[f"valve.flow.area_{self.path}"]

    def pressure_ratio(self, pressure: Array) -> Array:
        """Return downstream over upstream pressure, at most 1 [-].

        Parameters
        ----------
        pressure : (n,) array
            Absolute pressure of the volume [Pa].
        """
        if self.charging:
            ratio = pressure / self.rig["supply.pressure"]
        else:
            ratio = self.rig["ambient.pressure"] / np.maximum(pressure, 1.0)
        return np.minimum(ratio, 1.0)

    def upstream(self, pressure: Array) -> Array:
        """Return the upstream pressure [Pa].

        Parameters
        ----------
        pressure : (n,) array
            Absolute pressure of the volume [Pa].
        """
        if self.charging:
            return np.full_like(pressure, self.rig["supply.pressure"])
        return pressure


def transient_of(recording: Recording, rig: Rig | str | None = None) -> Transient:
    """Return a recording of a dead volume as one transient.

    Parameters
    ----------
    recording : Recording
        ``dead_volume_pressure``, and ``valve_voltage`` unless the volume only leaks.
    rig : Rig or str, optional
        By default the one the recording names; its conditions are applied.

    Returns
    -------
    Transient
        Which path it is follows from the sign of the command and whether the pressure rises.

    Raises
    ------
    InputError
        When the recording is of another rig, lacks the pressure, or the command is not held.

    Examples
    --------
    >>> from pneuservo.calibration.experiment import simulate_transient
    >>> transient_of(simulate_transient("b_e", 5.0)).path
    'b_e'
    """
    rig = load_rig(rig or recording.rig) if not isinstance(rig, Rig) else rig
    if rig.kind != "dead-volume":
        raise InputError(
            f"{recording.name}: rig {rig.name} is of kind {rig.kind}; a calibration needs a "
            "recording of a dead-volume rig. Name one with --rig, or in the sidecar"
        )
    if _CHANNEL not in recording:
        raise InputError(
            f"{recording.name}: there is no channel {_CHANNEL}; there are: "
            f"{', '.join(recording.channels) or 'none'}"
        )
    rig = rig.with_conditions(recording.conditions)
    good = np.isfinite(recording[_CHANNEL])
    time, pressure = recording.time[good], recording[_CHANNEL][good]
    if len(time) < FEWEST_SAMPLES or float(pressure.min()) <= 0.0:
        raise InputError(
            f"{recording.name}: {len(time)} readings of {_CHANNEL}, the lowest "
            f"{float(pressure.min(initial=np.inf)):g} Pa; at least {FEWEST_SAMPLES} above 0 Pa "
            "absolute are needed. Check the unit, and gauge = true in the sidecar"
        )
    command = _held_command(recording)
    noise = recording.noise_rms.get(_CHANNEL) or noise_floor(pressure, time)
    path = LEAK
    if command:
        rising = float(np.mean(pressure[-5:]) - np.mean(pressure[:5])) > 0.0
        path = {(True, True): "s_a", (True, False): "s_b", (False, True): "b_e"}.get(
            (rising, command > 0.0), "a_e"
        )
    size = min(abs(command), rig["valve.full_voltage"]) if command else float("nan")
    return Transient(recording.name, path, size, time, pressure, noise, rig)


def _held_command(recording: Recording) -> float:
    if "valve_voltage" not in recording:
        return 0.0
    voltage = recording["valve_voltage"]
    voltage = voltage[np.isfinite(voltage)]
    if not len(voltage):
        return 0.0
    middle = float(np.median(voltage))
    if float(np.ptp(voltage)) > _HELD:
        raise InputError(
            f"{recording.name}: valve_voltage goes from {voltage.min():g} V to {voltage.max():g} V;"
            " a calibration needs one held command per recording. Cut it with --window START:END"
        )
    return middle if abs(middle) > _HELD else 0.0


def in_flow(transient: Transient) -> Mask:
    """Return which samples still flow: the pressures on both sides are not equal yet.

    Parameters
    ----------
    transient : Transient
        The transient.
    """
    ratio = transient.pressure_ratio(transient.pressure)
    noise = 4.0 * transient.noise_rms * float(np.max(ratio / transient.pressure))
    flowing = ratio < 1.0 - max(_EQUAL, noise)
    if not flowing.all():
        # Once the end is reached, noise must not let single samples in again.
        flowing[int(np.argmin(flowing)) :] = False
    return flowing


__all__ = ["FLOW_PATHS", "LEAK", "Transient", "in_flow", "transient_of"]
