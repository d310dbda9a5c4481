"""What a servo without any further effect would have recorded on the same path."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.model import Array
from pneuservo.diagnosis.models.recent import Recent
from pneuservo.diagnosis.models.servo.command import held_command, jumping
from pneuservo.diagnosis.models.servo.estimate import with_pressures
from pneuservo.diagnosis.models.servo.feed import SUPPLY, Feed, feed
from pneuservo.diagnosis.models.servo.run_observer import SUPPLY_LEVEL, supply_to_be_read
from pneuservo.diagnosis.noise import wander
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig
from pneuservo.simulation import InitialState, Simulation, simulate

_STEP = 1e-4
"""Integration step [s]."""
_GAIN = 0.2
"""Of the controller that keeps to the path; more bends the command between two samples [V/V]."""
_UNLIMITED = 1e6
"""Level of the controller: the valve driver limits the command [V]."""


def imitated(
    fed: Feed,
    recording: Recording,
    rig: Rig,
    zero_force: float,
    level: float,
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
    zero_force : float
        Force that the zeros of the pressure transducers pretend [N].
    level : float
        Pressure of the source, where the supply was measured [Pa].
    rng : Generator
        Of the noise.

    Returns
    -------
    Feed
        Judged in the same places and with the same weights as the real one.

    Notes
    -----
    The command is the recorded one plus what a proportional controller adds to keep to the
    recorded path, so that small differences do not pile up.
    """
    supply, source = fed.supply, np.empty(0)
    if supply is not None:
        source = supply_to_be_read(fed, {SUPPLY_LEVEL: level, **rig.effect_values}, rig)
        # The chambers are driven by what was measured.
        others = {k: v for k, v in rig.effects.items() if not k.startswith("supply.")}
        rig = replace(rig, effects=others)
        if not others:
            # Its ripple makes no difference to what is pretended, and costs a compiled engine.
            rig, supply = rig.with_values({"supply.pressure": float(np.mean(supply))}), None
    controller = Proportional(gain=_GAIN, level=_UNLIMITED)
    law = controller.law(rig)
    run = simulate(
        rig,
        time=fed.time,
        controller=controller,
        demand=fed.motion[0] + fed.voltage / (law.gain * law.weight_displacement),
        external_force=fed.force + zero_force,
        supply_pressure=supply,
        initial=_start(fed, rig),
        largest_step=_STEP,
    )
    channels = {name: recording[name] for name in ("demand",) if name in recording}
    jumps = jumping(channels["demand"]) if channels else np.zeros(len(fed.time) - 1, np.bool_)
    slope = law.gain * law.weight_displacement
    channels["valve_voltage"] = _as_sampled(fed.ramped, run, slope, jumps)
    for name in fed.noise:
        noise = rng.standard_normal(len(fed.time)) + wander(fed.time, rng)
        true = source if name == SUPPLY else run[name]
        channels[name] = true + fed.noise[name] * noise
    copy = feed(replace(recording, channels=channels, noise_rms=fed.noise), rig)
    copy = with_pressures(replace(copy, supply=fed.supply, force=fed.force), rig)
    motion = copy.motion.copy()
    motion[1:, fed.resting != 0] = 0.0
    return replace(
        fed,
        voltage=copy.voltage,
        command=copy.command if fed.ramped else held_command(copy.voltage),
        reading=copy.reading,
        motion=motion,
        pressures=copy.pressures,
        pressure_rates=copy.pressure_rates,
        supply_reading=copy.supply_reading,
        spool_reading=copy.spool_reading,
        # It comes to rest at times of its own; only what both tell is judged.
        held=np.where(fed.resting != 0, fed.held, copy.held),
        stuck=copy.stuck & fed.stuck,
        done=Recent(),
    )


def _as_sampled(ramped: bool, run: Simulation, gain: float, jumps: NDArray[np.bool_]) -> Array:
    """Return the command as a recording that is read in this way has it [V].

    Between two samples the demand is held and the displacement goes on, so that the command runs
    away from where it was sampled; what is recorded has to mean the same. With the set point it
    jumps at once.
    """
    moved = np.diff(run["displacement"], append=run["displacement"][-1])
    mean: Array = run["valve_voltage"] - 0.5 * gain * moved
    if ramped:
        before = np.append(mean[:1], np.where(jumps, mean[1:], mean[:-1]))
        mean = 0.5 * (mean + before)
    return mean


def _start(fed: Feed, rig: Rig) -> InitialState:
    full = rig["valve.full_voltage"]
    return InitialState(
        displacement=float(np.clip(fed.motion[0, 0], 0.0, rig["piston.stroke"])),
        pressure_a=float(fed.pressures[0, 0]),
        pressure_b=float(fed.pressures[1, 0]),
        spool=float(np.clip(fed.voltage[0] / full, -1.0, 1.0)),
    )
