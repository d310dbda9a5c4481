"""What a servo without any further effect would have recorded on the same path."""

import math
from dataclasses import replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.model import Case, Values
from pneuservo.diagnosis.models.servo.between_samples import read_alike
from pneuservo.diagnosis.models.servo.breakaway import as_in
from pneuservo.diagnosis.models.servo.command import as_it_may_have_been
from pneuservo.diagnosis.models.servo.estimate import with_pressures
from pneuservo.diagnosis.models.servo.feed import SUPPLY, Feed
from pneuservo.diagnosis.models.servo.feeding import feed
from pneuservo.diagnosis.models.servo.noisy_command import COMMAND_BENDS, bent
from pneuservo.diagnosis.models.servo.run_observer import (
    COMMAND_DELAY,
    SPOOL_GAIN,
    SPOOL_ZERO,
    SUPPLY_LEVEL,
    ZERO_FORCE,
    supply_to_be_read,
)
from pneuservo.errors import InputError
from pneuservo.noise import wander
from pneuservo.recordings import Recording
from pneuservo.recordings.converter import converter_step, noise_of_steps
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState, simulate
from pneuservo.simulation.readings import in_parts

_STEP = 1e-4
"""Integration step [s]."""
_GAIN = 0.2
"""Of the controller that keeps to the path; more bends the command between two samples [V/V]."""
_AT_ONCE = 1e-6
"""What takes no longer takes no time [s]."""
_UNLIMITED = 1e6
"""Level of the controller: the valve driver limits the command [V]."""
_OWN = {
    ZERO_FORCE: 0.0,
    SUPPLY_LEVEL: 0.0,
    COMMAND_DELAY: 0.0,
    **dict.fromkeys(COMMAND_BENDS, 0.0),
    SPOOL_ZERO: 0.0,
    SPOOL_GAIN: 1.0,
}
"""What belongs to a recording alone, and what it is where nothing was fitted."""


def imitation_of(case: Case, values: Values, rng: np.random.Generator) -> Feed:
    """Return a recording as the rig of some values would have given it, or one like it.

    Parameters
    ----------
    case : Case
        Of the recording.
    values : mapping of str to float
        Of a fit: rig, effects and what belongs to the recording alone.
    rng : Generator
        Of the noise.

    Notes
    -----
    Fitted to a path that the observer kept it on, a rig may run away on its own: then it is
    imitated without its effects, or as it was before it was fitted. A recording that no rig can
    follow stands for its own copy: what it gains is pretended.
    """
    fed: Feed = case.inputs["feed"]
    own = {key: values.get(key, usual) for key, usual in _OWN.items()}
    fitted = case.rig.with_own_values(values)
    for rig in (fitted, replace(fitted, effects={}), replace(case.rig, effects={})):
        try:
            return imitated(fed, case.recording, rig, own, rng)
        except InputError:
            continue
    return fed


def imitated(
    fed: Feed,
    recording: Recording,
    rig: Rig,
    own: Values,
    rng: np.random.Generator,
) -> Feed:
    """Return a recording of a rig that follows the path of a real one.

    Parameters
    ----------
    fed : Feed
        The real recording.
    recording : Recording
        Where it comes from.
    rig : Rig
        The rig as fitted, with the effects found so far.
    own : mapping of str to float
        Force that the zeros of the pressure transducers pretend, pressure of the source where the
        supply was measured, what converters take, how the command bends, and zero and gain of the
        spool's transducer, as in `pneuservo.diagnosis.models.servo.run_observer`.
    rng : Generator
        Of the noise.

    Returns
    -------
    Feed
        Judged in the same places and with the same weights as the real one.

    Notes
    -----
    The command is the recorded one plus what a proportional controller adds to keep to the
    recorded path, so that small differences do not pile up. An ideal relay that runs on switches
    at moments of its own between two samples: that they are not known pretends an effect.
    """
    # The noise is that of the recording, and is added here: the loop that keeps to it hears none.
    rig = replace(rig, transducers={})
    supply, source = fed.supply, np.empty(0)
    if supply is not None:
        level = {SUPPLY_LEVEL: own[SUPPLY_LEVEL]}
        source = supply_to_be_read(fed, {**level, **rig.effect_values}, rig)
        # The chambers are driven by what was measured.
        others = {k: v for k, v in rig.effects.items() if not k.startswith("supply.")}
        rig = replace(rig, effects=others)
        if not others:
            # Its ripple makes no difference to what is pretended, and costs a compiled engine.
            rig, supply = rig.with_values({"supply.pressure": float(np.mean(supply))}), None
    channels = {name: recording[name] for name in ("demand",) if name in recording}
    run, channels["valve_voltage"] = _kept_to_the_path(fed, rig, own, supply, rng)
    for name in fed.noise:
        true = source if name == SUPPLY else run[name]
        if name == "spool":
            true = own[SPOOL_ZERO] + own[SPOOL_GAIN] * true
        channels[name] = _as_read(fed, recording[name], true, fed.noise[name], rng)
    noise_rms = dict(fed.noise)
    if "force" in recording:
        noise_rms["force"] = fed.force_rms
        channels["force"] = fed.force + fed.force_rms * rng.standard_normal(len(fed.time))
    copy = feed(replace(recording, channels=channels, noise_rms=noise_rms), rig)
    # What is known of the command between its samples is that of the real one.
    command = read_alike(fed, copy.voltage, rig)
    copy = replace(copy, supply=fed.supply, command=command, unseen=fed.unseen, spread=fed.spread)
    copy = with_pressures(copy, rig)
    motion = copy.motion.copy()
    motion[1:, fed.resting != 0] = 0.0
    return replace(
        fed,
        voltage=copy.voltage,
        command=command,
        reading=copy.reading,
        motion=motion,
        pressures=copy.pressures,
        pressure_rates=copy.pressure_rates,
        supply_reading=copy.supply_reading,
        spool_reading=copy.spool_reading,
        force=copy.force,
        # It comes to rest at times of its own; only what both tell is judged.
        held=np.where(fed.resting != 0, fed.held, copy.held),
        stuck=copy.stuck & fed.stuck,
        departures=as_in(fed.departures, copy.departures, fed.interval),
    )


def _as_read(
    fed: Feed, reading: Array, true: Array, noise: float, rng: np.random.Generator
) -> Array:
    """Return what a transducer makes of a channel, in the steps of its converter if it has any."""
    step = converter_step(reading)
    white = math.sqrt(max(noise**2 - noise_of_steps(step) ** 2, 0.0))
    read = true + white * rng.standard_normal(len(fed.time)) + noise * wander(fed.time, rng)
    return np.round(read / step) * step if step else read


def _kept_to_the_path(
    fed: Feed, rig: Rig, own: Values, supply: Array | None, rng: np.random.Generator
) -> tuple[dict[str, Array], Array]:
    """Return what a servo does that is kept to a path, and its command, both at the samples."""
    controller = Proportional(gain=_GAIN, level=_UNLIMITED)
    law = controller.law(rig)
    slope = law.gain * law.weight_displacement
    # In parts of an interval where the command runs on: within each it is held.
    held = fed.voltage[:, np.newaxis]
    if fed.ramped:
        command = bent(fed.command, fed.bends, own, rig["valve.full_voltage"])
        held = as_it_may_have_been(command, fed.voltage, rng)
    parts = held.shape[1]
    time = in_parts(fed.time, parts)
    late = own[COMMAND_DELAY]
    if late > _AT_ONCE:
        # Until converters have put it out, the command of before is held.
        parts, before = 2, np.append(fed.voltage[:1], fed.voltage[:-1])
        held = np.column_stack([before, fed.voltage])
        time = np.column_stack([fed.time, fed.time + late]).ravel()
    steps = (len(fed.time) - 1) * parts + 1
    time, held = time[:steps], held.ravel()[:steps]
    run = simulate(
        rig,
        time=time,
        controller=controller,
        demand=np.interp(time, fed.time, fed.motion[0]) + held / slope,
        external_force=np.interp(time, fed.time, fed.force) + own[ZERO_FORCE],
        supply_pressure=None if supply is None else np.interp(time, fed.time, supply),
        initial=_start(fed, rig),
        largest_step=_STEP,
    )
    found = {name: run[name][::parts] for name in fed.noise if name != SUPPLY}
    added = (run["valve_voltage"] - held)[::parts]
    if not fed.ramped:
        # Within an interval the piston goes on; what is recorded has to mean the same.
        moved = np.diff(found["displacement"], append=found["displacement"][-1])
        added -= 0.5 * slope * moved
    return found, fed.voltage + added


def _start(fed: Feed, rig: Rig) -> InitialState:
    full = rig["valve.full_voltage"]
    return InitialState(
        displacement=float(np.clip(fed.motion[0, 0], 0.0, rig["piston.stroke"])),
        pressure_a=float(fed.pressures[0, 0]),
        pressure_b=float(fed.pressures[1, 0]),
        spool=float(np.clip(fed.voltage[0] / full, -1.0, 1.0)),
    )
