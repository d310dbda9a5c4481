"""Replaying the command of a recording through the model of its rig."""

from collections.abc import Callable

import numpy as np

from pneuservo.arrays import bridged
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig, load_rig
from pneuservo.rigs.plant_numbers import single_axis
from pneuservo.simulation.dead_volume import simulate_dead_volume
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import require_kind
from pneuservo.simulation.readings import Seed
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.run import simulate


def replay(
    recording: Recording,
    rig: Rig | str | None = None,
    port: str | None = None,
    warn: Callable[[str], None] = lambda message: None,
    seed: Seed = 0,
) -> Simulation:
    """Simulate what the rig should have done under the command that was recorded.

    Parameters
    ----------
    recording : Recording
        Needs ``valve_voltage``; each sample is held until the next.
    rig : Rig or str, optional
        The rig; by default the one the recording names. The recording's conditions are applied,
        its supply pressure drives the valve where it was measured.
    port : str, optional
        Where a test volume is connected, ``"a"`` or ``"b"``; by default told from whether the
        recorded pressure rises with the command.
    warn : callable, optional
        Called with a sentence about anything that was assumed.
    seed : int or sequence of int, optional
        Of the transducers' noise, where the rig has any.

    Returns
    -------
    Simulation
        At the recording's times, from the state of its first sample as far as that was recorded,
        and otherwise from rest.

    Raises
    ------
    InputError
        When there is no complete command, or the rig cannot be simulated.
    """
    if rig is None:
        rig = recording.rig
    if isinstance(rig, str):
        rig = load_rig(rig)
    rig = rig.with_conditions(recording.conditions)
    _require_command(recording)
    if rig.kind == "dead-volume":
        start = _first(recording, "dead_volume_pressure", warn)
        return simulate_dead_volume(
            rig,
            time=recording.time,
            command=recording["valve_voltage"],
            port=port or _port(recording, warn),
            initial_pressure=start,
            seed=seed,
        )
    if port is not None:
        raise InputError(f"a port belongs to a test volume; rig {rig.name} is of kind {rig.kind}")
    first_sample = initial_state(recording, rig, warn)
    if rig.effects:
        from pneuservo.simulation.servo import state_behind

        rig = require_kind(rig, "single-axis", effects=True)
        first_sample = state_behind(first_sample, rig, single_axis(rig))
    return simulate(
        rig,
        time=recording.time,
        command=recording["valve_voltage"],
        external_force=_force(recording, warn),
        supply_pressure=_supply(recording, warn),
        initial=first_sample,
        seed=seed,
    )


def _require_command(recording: Recording) -> None:
    if "valve_voltage" not in recording:
        raise InputError(
            f"{recording.name}: there is no channel valve_voltage to replay; "
            f"there are: {', '.join(recording.channels) or 'none'}"
        )
    missing = np.flatnonzero(~np.isfinite(recording["valve_voltage"]))
    if len(missing):
        raise InputError(
            f"{recording.name}: valve_voltage is missing at {recording.time[missing[0]]:g} s "
            f"(sample {missing[0]}, {len(missing)} in all); a command has to be complete to be "
            "replayed: cut the recording, or fill the gap"
        )


def _first(recording: Recording, channel: str, warn: Callable[[str], None]) -> float | None:
    if channel not in recording:
        return None
    value = float(recording[channel][0])
    if np.isfinite(value):
        return value
    warn(f"{recording.name}: {channel} is missing at the first sample; the start is assumed")
    return None


def initial_state(recording: Recording, rig: Rig, warn: Callable[[str], None]) -> InitialState:
    """Return the state of a recording's first sample, as far as it was recorded.

    Parameters
    ----------
    recording : Recording
        A recording of the single axis.
    rig : Rig
        Its rig, for the stroke.
    warn : callable
        Called with a sentence about a sample that is missing.

    Returns
    -------
    InitialState
        What was not recorded is left to rest and the balance of forces.
    """
    displacement = _first(recording, "displacement", warn)
    if displacement is not None:
        # Noise may put a piston at its stop a little beyond it.
        displacement = min(max(displacement, 0.0), rig["piston.stroke"])
    spool = _first(recording, "spool", warn)
    return InitialState(
        displacement=displacement,
        velocity=_first(recording, "velocity", warn) or 0.0,
        pressure_a=_first(recording, "pressure_a", warn),
        pressure_b=_first(recording, "pressure_b", warn),
        spool=min(max(spool or 0.0, -1.0), 1.0),
    )


def _force(recording: Recording, warn: Callable[[str], None]) -> np.ndarray | float:
    if "force" not in recording:
        return 0.0
    force = recording["force"]
    if not np.isfinite(force).all():
        warn(f"{recording.name}: force has missing samples; no external force is assumed there")
        force = np.where(np.isfinite(force), force, 0.0)
    return force


def _supply(recording: Recording, warn: Callable[[str], None]) -> np.ndarray | None:
    if "supply_pressure" not in recording:
        return None
    supply = recording["supply_pressure"]
    known = np.isfinite(supply)
    if not known.any():
        warn(f"{recording.name}: supply_pressure is missing throughout; the rig's is assumed")
        return None
    if not known.all():
        warn(f"{recording.name}: supply_pressure has missing samples; a straight line fills them")
    return bridged(recording.time, supply)


def _port(recording: Recording, warn: Callable[[str], None]) -> str:
    if "dead_volume_pressure" in recording:
        pressure, command = recording["dead_volume_pressure"], recording["valve_voltage"]
        change = np.nansum(np.diff(pressure) * np.sign(command[:-1]))
        if change:
            return "a" if change > 0.0 else "b"
    warn(f"{recording.name}: nothing tells the port of the test volume; port a is assumed")
    return "a"
