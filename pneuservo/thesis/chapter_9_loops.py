"""The loops of section 9.3 of the thesis, their step responses, and what is read off them."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from analog_card.design import Design
from analog_card.design_file import load_design
from analog_card.tuning import tune
from pneuservo.controllers import (
    AnalogueCard,
    Controller,
    DigitalSlidingMode,
    HybridSlidingMode,
    card_of,
)
from pneuservo.rigs import load_rig
from pneuservo.simulation import Simulation, simulate, step_demand
from pneuservo.thesis.slow_oscillation import slow_range

# The demand of the step responses: mid-stroke, near either end, and back [m]. The thesis shows
# set points in the middle and near an end and states neither figures nor times.
SET_POINTS = (0.015, 0.024, 0.006, 0.015)
HOLD, RATE = 0.5, 5000.0
PLACES = ("24 mm", "6 mm", "15 mm")
MID_STROKE = PLACES[-1]
# Share of a hold, at its end, that counts as settled.
_SETTLED = 0.4
# What is seen in a plot of the stroke: a three-hundredth of it [m].
SEEN = 0.1e-3
# The boundary layer of the thesis, printed as 5000 m/s2 [m/s2].
LAYER = 5.0
SETTLING_TIME = 0.07
# Of the card soldered for short settling times [m/s2].
FAST_LAYER = 10.0
# The fast range of the recommended card, as `analog_card.tuning` names it [ohm].
_FAST = {
    "acceleration_resistance": 1e6,
    "displacement_resistance": 39e3,
    "velocity_resistance": 100e3,
}


@dataclass(frozen=True)
class Hold:
    """The settled end of a hold.

    Attributes
    ----------
    error : float
        Demand less displacement, mean [m].
    chatter : float
        Range of the displacement [m].
    acceleration : float
        Root mean square, which an ideal loop would have zero [m/s2].
    voltage : float
        Standard deviation [V].
    slow : float
        Range of the displacement below 60 Hz [m].
    """

    error: float
    chatter: float
    acceleration: float
    voltage: float
    slow: float


def digital(layer: float = LAYER, sampling_time: float = 1e-3) -> DigitalSlidingMode:
    """Return set-up (a): velocity and acceleration by differences."""
    return DigitalSlidingMode(boundary_layer=layer, sampling_time=sampling_time)


def with_accelerometer(layer: float = LAYER, sampling_time: float = 1e-3) -> DigitalSlidingMode:
    """Return set-up (b): acceleration measured."""
    return DigitalSlidingMode(boundary_layer=layer, sampling_time=sampling_time, accelerometer=True)


def hybrid(layer: float = LAYER, sampling_time: float = 1e-3) -> HybridSlidingMode:
    """Return set-up (c): the card's differentiators, the law in the computer."""
    return HybridSlidingMode(boundary_layer=layer, sampling_time=sampling_time)


def analogue(settling_time: float = SETTLING_TIME) -> AnalogueCard:
    """Return set-up (d), the card by its figures."""
    return AnalogueCard(tune(settling_time=settling_time, boundary_layer=LAYER).figures)


def fast_analogue(settling_time: float) -> AnalogueCard:
    """Return set-up (d) with the card soldered for short settling times.

    Parameters
    ----------
    settling_time : float
        Of the surface [s].

    Notes
    -----
    Its boundary layer is the narrowest that P3 then reaches.
    """
    turned = tune(settling_time=settling_time, boundary_layer=FAST_LAYER, design=_fast_design())
    return AnalogueCard(turned.figures)


def real_card() -> AnalogueCard:
    """Return set-up (d) with everything that real op-amps do to the card."""
    return card_of(tune(settling_time=SETTLING_TIME, boundary_layer=LAYER).design)


@cache
def step_run(controller: Controller, mass: float | None = None, seed: int = 0) -> Simulation:
    """Return the run of a controller over the set points.

    Parameters
    ----------
    controller : Controller
        By settings that do not change.
    mass : float, optional
        Moved; the rig's by default [kg].
    seed : int, optional
        Of the noise.
    """
    rig = load_rig("single-axis")
    if mass is not None:
        rig = rig.with_values({"load.mass": mass})
    time, demand = step_demand(SET_POINTS, HOLD, RATE)
    return simulate(rig, time=time, demand=demand, controller=controller, seed=seed)


def holds(run: Simulation) -> dict[str, Hold]:
    """Return the settled ends of the three holds that follow a step, by place."""
    found = {}
    samples = len(run) // len(SET_POINTS)
    for k, place in enumerate(PLACES, 1):
        hold = slice(k * samples, (k + 1) * samples)
        end = slice((k + 1) * samples - round(_SETTLED * samples), (k + 1) * samples)
        error = run["demand"][end] - run["displacement"][end]
        time = run.time[hold] - run.time[k * samples]
        found[place] = Hold(
            error=float(np.mean(error)),
            chatter=float(np.ptp(error)),
            acceleration=float(np.sqrt(np.mean(run["acceleration"][end] ** 2))),
            voltage=float(np.std(run["valve_voltage"][end])),
            slow=slow_range(time, run["displacement"][hold], HOLD * (1.0 - _SETTLED)),
        )
    return found


def mean_of(found: dict[str, Hold], name: str) -> float:
    """Return the mean magnitude of a figure over the three places."""
    return float(np.mean([abs(getattr(hold, name)) for hold in found.values()]))


def chattering(run: Simulation) -> float:
    """Return the strongest frequency of the acceleration at the last set point [Hz].

    Parameters
    ----------
    run : Simulation
        Of a controller that chatters. Of the voltage itself noise would be counted too.
    """
    end = round(_SETTLED * len(run) / len(SET_POINTS))
    wave = run["acceleration"][-end:]
    spectrum = np.abs(np.fft.rfft((wave - np.mean(wave)) * np.hanning(end)))
    return float(np.argmax(spectrum) * (len(run) - 1) / run.time[-1] / end)


def _fast_design() -> Design:
    design = load_design()
    amplifier = replace(design.soldered.surface_amplifier, **_FAST)
    return replace(design, soldered=replace(design.soldered, surface_amplifier=amplifier))
