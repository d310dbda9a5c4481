"""Running the single axis under a controller that samples it."""

import heapq
import math
from collections.abc import Iterator

import numpy as np

from pneuservo.arrays import Array
from pneuservo.controllers import SampledController
from pneuservo.errors import InputError
from pneuservo.plant.outputs import OUTPUTS
from pneuservo.rigs import Rig
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import Driven
from pneuservo.simulation.readings import EXACT, Seed, draw_noise, within_range
from pneuservo.simulation.result import Simulation
from pneuservo.simulation.sampled_loop import SampledLoop
from pneuservo.simulation.soundness import require_sound

# What happens at one time happens in this order: the inputs change, the controller samples, its
# output follows, the result is written.
_INPUT, _SAMPLE, _OUTPUT, _WRITE = range(4)
# Times are told apart down to this [s], so that rounding puts none before another.
_INSTANT = 1e-9
_SHORTEST_SAMPLING = 1e-6


def simulate_sampled(
    controller: SampledController,
    rig: Rig,
    driven: Driven,
    initial: InitialState,
    step: float,
    seed: Seed,
) -> Simulation:
    """Simulate the single axis under a controller that samples it.

    Parameters
    ----------
    controller : SampledController
        What closes the loop; it samples for the first time at the first time.
    rig : Rig
        A rig of kind ``single-axis`` without effects.
    driven : Driven
        The demand [m] and the external force [N].
    initial : InitialState
        By default at rest at the first demand.
    step : float
        The plant never takes a longer step [s].
    seed : int or sequence of int
        Of the noise of transducers and converters.

    Returns
    -------
    Simulation
        The run, with the taps of differentiators if the controller has them; the surface is
        only known to the controller.

    Raises
    ------
    InputError
        When the rig or the controller cannot be used.
    """
    if rig.effects or driven.supply_pressure is not None:
        raise InputError(
            f"rig {rig.name}: controller {controller.kind} samples, and drives the baseline only; "
            f"leave out {', '.join(rig.effects) or 'the measured supply pressure'}, or take a "
            "continuous controller"
        )
    delay = _delay(controller)
    noise = draw_noise(rig, len(driven.time), seed)
    loop = SampledLoop(controller, rig, initial, driven, step, seed)
    outputs = _run(loop, driven, controller.sampling_time, delay)
    channels = {"demand": driven.held, **dict(zip(OUTPUTS, outputs.T, strict=True))}
    if driven.force.any():
        channels["force"] = driven.force
    for name in ("displacement", "pressure_a", "pressure_b"):
        transducer = rig.transducers.get(name.partition("_")[0], EXACT)
        channels[name] = within_range(channels[name] + getattr(noise, name), transducer)
    unknown = {"surface"}
    if controller.differentiators is None:
        unknown |= {"card_velocity", "card_acceleration"}
    kept = {name: values for name, values in channels.items() if name not in unknown}
    return Simulation(rig, driven.time, kept, controller)


def _run(loop: SampledLoop, driven: Driven, period: float, delay: float) -> Array:
    """Return the outputs at every time, each row just after it."""
    result = np.empty((len(driven.time), len(OUTPUTS)))
    start, now, wanted = float(driven.time[0]), 0, 0.0
    for instant, what, k in _schedule(driven.time - start, period, delay):
        if instant > now:
            loop.advance((instant - now) * _INSTANT)
            now = instant
        if what == _INPUT:
            loop.demand = float(driven.held[k])
            loop.hold(force=float(driven.force[k]))
        elif what == _SAMPLE:
            wanted = loop.decide(start + now * _INSTANT)
        elif what == _OUTPUT:
            loop.hold(voltage=wanted)
        else:
            result[k] = loop.advance(0.0)
            require_sound(driven.time[k : k + 1], result[k : k + 1])
    return result


def _schedule(time: Array, period: float, delay: float) -> Iterator[tuple[int, int, int]]:
    """Return what happens when, in order: instant, what, and its number."""
    instants = [round(t / _INSTANT) for t in time]
    samples = range(math.floor(time[-1] / period + 1e-9) + 1)
    taken = [round(k * period / _INSTANT) for k in samples]
    after = round(delay / _INSTANT)
    return heapq.merge(
        [(t, _INPUT, k) for k, t in enumerate(instants)],
        [(t, _SAMPLE, k) for k, t in enumerate(taken)],
        [(t + after, _OUTPUT, k) for k, t in enumerate(taken) if t + after <= instants[-1]],
        [(t, _WRITE, k) for k, t in enumerate(instants)],
    )


def _delay(controller: SampledController) -> float:
    """Return the time from a sample to its output, which has to end before the next sample [s]."""
    period = controller.sampling_time
    if not _SHORTEST_SAMPLING <= period < math.inf:
        raise InputError(
            f"controller {controller.kind}: sampling time is {period:g} s; it has to be "
            f"{_SHORTEST_SAMPLING:g} s or more"
        )
    count = len(controller.inputs)
    delay = controller.board.delay(count) if controller.board else 0.0
    if delay >= period:
        raise InputError(
            f"controller {controller.kind}: its board takes {delay:g} s for {count} inputs, more "
            f"than the sampling time of {period:g} s; sample more slowly"
        )
    return delay
