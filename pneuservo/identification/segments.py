"""A recording cut into segments, each simulated from a state of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pneuservo.arrays import Array
from pneuservo.effects import effect_by_id
from pneuservo.errors import InputError
from pneuservo.identification.signals import CUTOFF_FREQUENCY, even, filtered
from pneuservo.naming import require_known
from pneuservo.noise import noise_floor
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState, simulate
from pneuservo.simulation.readings import EXACT

OUTPUTS = ("displacement", "pressure_a", "pressure_b")
STATES = ("displacement", "velocity", "pressure_a", "pressure_b")
_SEGMENT = 0.5
_MOST_SEGMENTS = 40
# Fewer samples say little of where a segment starts.
_FEWEST = 8
# Against the default step displacement moves by less than 0.02 um.
_LARGEST_STEP = 4e-4
# A continuous command is held for so many parts of a sample, each at its mean.
_PARTS = 4
# Their laws count time from the start of a recording, which a segment does not know.
_BY_THE_CLOCK = (
    "unexplained.drift",
    "supply.slow-drift",
    "supply.ripple",
    "friction.run-in",
    "sensor.noise-colour",
)
# No chamber of the rig gets near vacuum [Pa].
_LOWEST_PRESSURE = 1e4


@dataclass(frozen=True)
class Segments:
    """A recording, cut up.

    Parameters
    ----------
    name : str
        Of the recording.
    rig : Rig
        In the conditions of the recording, its transducers without noise.
    time : (n,) array
        Evenly spaced [s].
    command, force : (n,) array
        What drives the rig: valve voltage [V] and external force [N].
    continuous : bool
        Whether the command runs on between samples instead of being held.
    measured : mapping of str to (n,) array
        The outputs that were recorded [SI].
    noise : mapping of str to float
        Of each of them [SI].
    bounds : (m + 1,) array of int
        First sample of each segment, and the last sample.
    spool : (m, 2) array
        Opening [-] and its rate [1/s] at the start of each.
    states : (m, 4) array
        First guess of the rest of the state there, places as in `STATES` [SI].
    """

    name: str
    rig: Rig
    time: Array
    command: Array
    force: Array
    continuous: bool
    measured: Mapping[str, Array]
    noise: Mapping[str, float]
    bounds: NDArray[np.int64]
    spool: Array
    states: Array

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.bounds) - 1


def cut(
    recording: Recording, rig: Rig, segment: float = _SEGMENT, continuous: bool = False
) -> Segments:
    """Cut a recording into segments.

    Parameters
    ----------
    recording : Recording
        ``valve_voltage`` and ``displacement``; pressures are compared too when they are there.
    rig : Rig
        Of kind ``single-axis``, in the conditions of the recording.
    segment : float, optional
        Length of each [s].
    continuous : bool, optional
        Whether the command runs on between samples, as that of an analogue controller does, instead
        of being held as by a converter.

    Returns
    -------
    Segments
        At most forty; longer ones for a longer recording.

    Raises
    ------
    InputError
        When a channel is missing, a segment would hold hardly any sample, or the rig has an effect
        that counts time from the start of the recording.

    Notes
    -----
    The first guess of a state is the filtered measurement; without pressures it is the balance of
    forces. The spool follows the command alone and is worked out once.
    """
    _require_no_clock(rig)
    outputs = tuple(name for name in OUTPUTS if name in recording)
    extra = ("force",) if "force" in recording else ()
    required = tuple(dict.fromkeys(("valve_voltage", "displacement", *outputs, *extra)))
    time, samples = even(recording, required)
    interval = float(time[1] - time[0])
    _require_segment(recording.name, segment, interval)
    length = max(_FEWEST, round(segment / interval), -(-len(time) // _MOST_SEGMENTS))
    bounds = np.arange(0, max(len(time) - length // 2, 1), length)
    bounds = np.append(bounds, len(time) - 1)
    measured = {name: samples[name] for name in outputs}
    noise = {
        name: recording.noise_rms.get(name) or noise_floor(values, time)
        for name, values in measured.items()
    }
    return Segments(
        recording.name,
        _without_noise(rig),
        time,
        samples["valve_voltage"],
        samples.get("force", np.zeros_like(time)),
        continuous,
        measured,
        noise,
        bounds,
        _spool(rig, samples["valve_voltage"], interval)[bounds[:-1]],
        _first_states(rig, measured, interval)[bounds[:-1]],
    )


def _require_segment(name: str, segment: float, interval: float) -> None:
    # What is used unless said is lengthened to what a slow recording needs.
    shortest = min(_FEWEST * interval, _SEGMENT)
    if segment < shortest * (1.0 - 1e-9):
        raise InputError(
            f"{name}: a segment of {segment:g} s is {segment / interval:.3g} samples; it has to be "
            f"{_FEWEST} samples or more, {_FEWEST * interval:.3g} s. Give a longer --segment"
        )


def _require_no_clock(rig: Rig) -> None:
    clocked = [name for name in _BY_THE_CLOCK if name in rig.effects]
    if clocked:
        raise InputError(
            f"rig {rig.name} has the effects {', '.join(clocked)}, which count time from the start "
            "of a recording; segments start anew and can have all others. Remove them from the "
            "rig, or identify by least squares"
        )


def _without_noise(rig: Rig) -> Rig:
    """Return a rig whose model is exact: the noise of the recording is in the recording."""
    quiet = {name: replace(entry, noise=0.0) for name, entry in rig.transducers.items()}
    kept = {name: entry for name, entry in quiet.items() if entry != EXACT}
    return replace(rig, transducers=kept)


def start_of(rig: Rig, names: Sequence[str]) -> tuple[dict[str, float], dict[str, str]]:
    """Return where an identification starts, and the units of what it looks for.

    Parameters
    ----------
    rig : Rig
        The rig.
    names : sequence of str
        Rig parameters, or ``effect:parameter`` of an effect that the rig has.

    Returns
    -------
    values : dict of str to float
        As the rig has them [SI].
    units : dict of str to str
        SI units.

    Raises
    ------
    InputError
        When the rig has no such parameter; the message names the nearest one.
    """
    known = {**{key: entry.value for key, entry in rig.parameters.items()}, **rig.effect_values}
    values, units = {}, {}
    for name in names:
        require_known(name, known, f"rig {rig.name}: parameter")
        values[name] = float(known[name])
        units[name] = _unit(rig, name)
    if not values:
        raise InputError("there is no parameter to identify")
    return values, units


def _unit(rig: Rig, name: str) -> str:
    if name in rig.parameters:
        return rig.parameters[name].unit
    effect, _, parameter = name.partition(":")
    entries = effect_by_id(effect, rig.kind).parameters
    return next(entry.unit for entry in entries if entry.name == parameter)


def run_segment(segments: Segments, k: int, rig: Rig, state: Array) -> Array:
    """Return what the model has in a segment, to the first sample of the next one.

    Parameters
    ----------
    segments : Segments
        The recording.
    k : int
        Which segment.
    rig : Rig
        With the values to try.
    state : (4,) array
        At its first sample, places as in `STATES` [SI].

    Returns
    -------
    (n, 4) array
        Places as in `STATES` [SI].
    """
    first, last = segments.bounds[k], segments.bounds[k + 1]
    time, command, force = _driven(segments, slice(first, last + 1))
    stroke = rig["piston.stroke"]
    opening, rate = segments.spool[k]
    initial = InitialState(
        displacement=float(np.clip(state[0], 0.0, stroke)),
        velocity=float(state[1]),
        pressure_a=max(float(state[2]), _LOWEST_PRESSURE),
        pressure_b=max(float(state[3]), _LOWEST_PRESSURE),
        spool=float(opening),
        spool_rate=float(rate),
    )
    run = simulate(
        rig,
        time=time,
        command=command,
        external_force=force,
        initial=initial,
        largest_step=_LARGEST_STEP,
    )
    every = _PARTS if segments.continuous else 1
    return np.column_stack([run[name][::every] for name in STATES])


def _driven(segments: Segments, part: slice) -> tuple[Array, Array, Array]:
    """Return times and what drives the rig at them, each value held until the next."""
    time, command, force = segments.time[part], segments.command[part], segments.force[part]
    if not segments.continuous:
        return time, command, force
    fine = np.linspace(time[0], time[-1], _PARTS * (len(time) - 1) + 1)
    middle = fine + 0.5 * (fine[1] - fine[0])
    return fine, np.interp(middle, time, command), np.interp(middle, time, force)


def _spool(rig: Rig, command: Array, interval: float) -> Array:
    """Return opening and rate of the spool under a held command, equation (4.32)."""
    from scipy.signal import cont2discrete

    full = rig["valve.full_voltage"]
    w, damping = 2.0 * np.pi * rig["valve.spool.frequency"], rig["valve.spool.damping"]
    a = np.array([[0.0, 1.0], [-w * w, -2.0 * damping * w]])
    b = np.array([[0.0], [w * w]])
    step, drive, *_ = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), interval)
    states = np.zeros((len(command), 2))
    target = np.clip(command / full, -1.0, 1.0)
    for k in range(len(command) - 1):
        states[k + 1] = step @ states[k] + drive[:, 0] * target[k]
        states[k + 1, 0] = np.clip(states[k + 1, 0], -1.0, 1.0)
    return states


def _first_states(rig: Rig, measured: Mapping[str, Array], interval: float) -> Array:
    cutoff = min(CUTOFF_FREQUENCY, 0.2 / interval)
    x = filtered(measured["displacement"], interval, cutoff)
    velocity = np.gradient(x, interval)
    area_a, area_b = rig["piston.area_a"], rig["piston.area_b"]
    load = rig["ambient.pressure"] * (area_a - area_b) - rig["load.mass"] * rig["load.gravity"]
    pressures = {
        name: filtered(measured[name], interval, cutoff)
        for name in ("pressure_a", "pressure_b")
        if name in measured
    }
    usual = np.full_like(x, 0.75 * rig["supply.pressure"])
    pressure_a = pressures.get("pressure_a")
    if pressure_a is None:
        pressure_a = (pressures.get("pressure_b", usual) * area_b + load) / area_a
    pressure_b = pressures.get("pressure_b", (pressure_a * area_a - load) / area_b)
    return np.column_stack((x, velocity, pressure_a, pressure_b))
