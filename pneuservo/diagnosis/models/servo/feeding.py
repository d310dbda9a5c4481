"""A recording of the servo turned into what its observer is fed with."""

import math
from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array, bridged
from pneuservo.diagnosis.models.servo.breakaway import NOWHERE
from pneuservo.diagnosis.models.servo.command import running_command, unseen
from pneuservo.diagnosis.models.servo.feed import CHANNELS, FOLLOWED, PRESSURES, SUPPLY, Feed
from pneuservo.diagnosis.models.servo.gaps import blind
from pneuservo.diagnosis.models.servo.motion import SLOWEST_MOTION
from pneuservo.diagnosis.models.servo.moved import moved_by, with_spread
from pneuservo.diagnosis.models.servo.noisy_command import made_of_noise
from pneuservo.diagnosis.models.servo.set_point import at_its_limit, at_once, gain_of_set_point
from pneuservo.diagnosis.models.servo.supply import smoothed_supply
from pneuservo.noise import noise_level
from pneuservo.recordings import Recording
from pneuservo.recordings.converter import converter_step, noise_of_steps
from pneuservo.rigs import Rig

FINEST = 1e-4
"""No transducer is taken to be better than this, as a share of stroke, supply pressure and full
opening, unless its noise is stated: in recordings without any noise, what is made of a command
between its samples and of a motion that is smoothed was explained by delays."""
PRESSURE_SMOOTHING = 3e-3
"""Time over which pressures are averaged where their rate is wanted [s]."""


def feed(recording: Recording, rig: Rig) -> Feed:
    """Return a recording as the observer of the servo is fed with it.

    Parameters
    ----------
    recording : Recording
        With valve voltage and displacement; pressures that it lacks are guessed roughly, see
        `pneuservo.diagnosis.models.servo.estimate`.
    rig : Rig
        The rig it was taken on.

    Returns
    -------
    Feed
        In SI.
    """
    time, interval = recording.time, recording.sampling_interval
    noise = {
        channel: recording.noise_rms.get(channel) or _noise(recording, channel, rig)
        for channel in CHANNELS
        if channel in recording
    }
    followed = ("valve_voltage", "demand", "force", *FOLLOWED, SUPPLY)
    there = [np.isfinite(recording[name]) for name in followed if name in recording]
    voltage = bridged(time, recording["valve_voltage"])
    set_point, gain = np.empty(0), 0.0
    if "demand" in recording:
        set_point = bridged(time, recording["demand"])
        gain = gain_of_set_point(time, voltage, set_point, bridged(time, recording["displacement"]))
    told = at_once(voltage, set_point, gain)
    force, force_rms = np.zeros_like(time), 0.0
    if "force" in recording:
        force = bridged(time, recording["force"])
        force_rms = recording.noise_rms.get("force") or noise_level(force, time)
    nowhere = np.full_like(time, np.nan)
    pressures = _pressures(recording, rig, float(force[0]))
    supply = recording.channels.get(SUPPLY, np.empty(0))
    loads = [rig[f"piston.area_{name[-1]}"] * noise.get(name, 0.0) for name in PRESSURES]
    spread_of_force = math.hypot(*loads, force_rms)
    fed = Feed(
        time=time,
        voltage=voltage,
        command=running_command(time, voltage, rig["valve.full_voltage"], told),
        unseen=unseen(voltage, told),
        blind=blind(time, np.logical_and.reduce(there)),
        set_point=set_point,
        gain_of_set_point=gain,
        reading=recording["displacement"],
        motion=np.zeros((3, len(time))),
        pressures=pressures,
        measured=tuple(name in recording for name in PRESSURES),
        read=np.array([np.isfinite(recording.channels.get(n, nowhere)) for n in PRESSURES]),
        pressure_rates=np.array([_rate(p, interval) for p in pressures]),
        supply=smoothed_supply(time, supply) if len(supply) else None,
        supply_reading=supply,
        spool_reading=recording.channels.get("spool", np.empty(0)),
        force=force,
        force_rms=force_rms,
        held=np.zeros(len(time), dtype=bool),
        reversal=SLOWEST_MOTION,
        velocity_rms=np.full_like(time, SLOWEST_MOTION),
        touching=np.zeros(len(time), dtype=bool),
        striking=np.zeros(len(time), dtype=bool),
        resting=np.zeros(len(time), dtype=np.int64),
        stuck=np.zeros(len(time), dtype=bool),
        departures=NOWHERE,
        spread=np.zeros((2, len(time))),
        noise=noise,
        spread_of_force=spread_of_force,
    )
    fed = moved_by(fed, rig, spread_of_force if all(fed.measured) else None)
    noise = fed.reading - fed.motion[0]
    if not made_of_noise(voltage, noise, np.isfinite(noise) & ~at_its_limit(voltage)):
        return fed
    known = unseen(voltage, told, of_noise=True)
    return with_spread(replace(fed, of_noise=True, unseen=known), rig)


def _noise(recording: Recording, channel: str, rig: Rig) -> float:
    """Return the noise of a channel of which nothing is stated [SI]."""
    largest = {"displacement": rig["piston.stroke"], "spool": 1.0}.get(
        channel, rig["supply.pressure"]
    )
    readings = recording[channel]
    # Of a piston that rests within one step it shows none.
    of_steps = noise_of_steps(converter_step(readings))
    return max(noise_level(readings, recording.time), of_steps, FINEST * largest)


def _pressures(recording: Recording, rig: Rig, force: float) -> Array:
    """Return both pressures, a missing one as it would be with the piston at rest."""
    from pneuservo.plant.single_axis import PRESSURE_A, PRESSURE_B
    from pneuservo.rigs.plant_numbers import single_axis
    from pneuservo.simulation.initial_state import InitialState

    time = recording.time
    known = {name: bridged(time, recording[name]) for name in PRESSURES if name in recording}
    start = InitialState(**{name: float(values[0]) for name, values in known.items()})
    plant = single_axis(rig)
    state = start.state(plant, 0.5 * plant.piston.stroke, force)
    places = dict(zip(PRESSURES, (PRESSURE_A, PRESSURE_B), strict=True))
    return np.array([known.get(n, np.full_like(time, state[places[n]])) for n in PRESSURES])


def _rate(samples: Array, interval: float) -> Array:
    from scipy.signal import savgol_filter

    window = max(5, 2 * round(PRESSURE_SMOOTHING / interval) + 1)
    return np.asarray(savgol_filter(samples, min(window, len(samples) | 1), 2, 1, interval))
