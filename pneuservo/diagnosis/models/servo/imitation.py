"""What a servo without any effect would have recorded on the same path."""

from dataclasses import replace

import numpy as np

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.servo.feed import Feed, feed
from pneuservo.plant import integrator
from pneuservo.plant.from_rig import single_axis, valve_grid
from pneuservo.plant.single_axis import PLANT_STATES, PRESSURE_A, PRESSURE_B, SPOOL
from pneuservo.recordings import Recording
from pneuservo.rigs import Rig

_STEP = 1e-4
"""Integration step [s]."""
_UNLIMITED = 1e6
"""Level of the controller: the valve driver limits the command [V]."""


def imitated(fed: Feed, recording: Recording, rig: Rig, rng: np.random.Generator) -> Feed:
    """Return a recording of the baseline that follows the path of a real one.

    Parameters
    ----------
    fed : Feed
        The real recording.
    recording : Recording
        Where it comes from.
    rig : Rig
        The fitted baseline.
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
    supply = float(np.mean(fed.supply)) if fed.supply is not None else rig["supply.pressure"]
    plant = single_axis(rig.with_values({"supply.pressure": supply}))
    law = Proportional(level=_UNLIMITED).law(rig)
    stiffness = law.gain * law.weight_displacement
    demand = fed.motion[0] + fed.voltage / stiffness
    state = np.zeros(PLANT_STATES)
    state[0] = fed.motion[0, 0]
    state[PRESSURE_A], state[PRESSURE_B] = fed.pressures[:, 0]
    state[SPOOL] = np.clip(fed.voltage[0] / plant.valve.full_voltage, -1.0, 1.0)
    inputs = np.column_stack((demand, fed.force))
    outputs = integrator.run(fed.time, inputs, state, law, plant, valve_grid(rig.valve), _STEP)
    columns = dict(zip(integrator.OUTPUTS, outputs.T, strict=True))
    channels = {"valve_voltage": columns["valve_voltage"]}
    for name in ("displacement", "pressure_a", "pressure_b"):
        channels[name] = columns[name] + rng.normal(0.0, fed.noise[name], len(fed.time))
    copy = feed(replace(recording, channels=channels, noise_rms=fed.noise), rig)
    return replace(
        copy,
        ramped=fed.ramped,
        supply=np.full_like(fed.time, supply),
        force=fed.force,
        held=fed.held,
        touching=fed.touching,
        reversal=fed.reversal,
        bandwidth=fed.bandwidth,
        spread=fed.spread,
    )
