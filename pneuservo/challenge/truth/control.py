"""What drives the valve: a stored command, or a controller that is run in ticks."""

from typing import NamedTuple

import numpy as np

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel
from pneuservo.challenge.truth.parameters import Array

CONVERTER = 1e-4  # [V]
STORED, SLIDING, PROPORTIONAL, CENTRING = 0, 1, 2, 3


class Control(NamedTuple):
    """A controller and what it is given, one value per tick."""

    kind: int
    tick: float  # [s]
    demand: Array  # [m]; of a stored command the voltage [V]
    noise: Array  # on the displacement that the controller reads [m]
    levels: Array  # sizes of random voltages [V]
    spans: Array  # and how long each lasts [s]
    gain: float = 333.33  # voltage per displacement error [V/m]
    weight_position: float = 3265.3  # [1/s^2]
    weight_speed: float = 114.286  # [1/s]
    boundary: float = 5.0  # [m/s^2]; 0: relay
    level: float = 5.0  # [V]
    continuous: bool = False  # ticks stand for a voltage that runs on


@truth_kernel
def driving(index, volts, before, control):
    """Return the voltage that drives the valve in this tick [V].

    Of one that runs on, what it will be in the middle of the tick, unless it has just jumped.
    """
    if not control.continuous or index == 0:
        return volts
    if control.demand[index] != control.demand[index - 1]:
        return volts
    return min(max(volts + 0.5 * (volts - before), -control.level), control.level)


@truth_kernel
def command_at(index, y, kept, reading, control, stroke):
    """Return the voltage that holds from this tick on [V]."""
    demand = control.demand[index]
    if control.kind == STORED:
        return demand
    if control.kind == PROPORTIONAL:
        volts = control.gain * (demand - reading - control.noise[index])
    elif control.kind == SLIDING:
        surface = -control.weight_position * (y[at.POSITION] - demand)
        surface -= control.weight_speed * y[at.SPEED] + kept[at.ACCELERATION]
        if control.boundary > 0.0:
            volts = control.level * surface / control.boundary
        else:
            volts = control.level if surface >= 0.0 else -control.level
    else:
        volts = kept[at.COMMAND]
        if index * control.tick >= kept[at.NEXT_SWITCH]:
            switch = int(kept[at.SWITCHES]) % len(control.levels)
            kept[at.SWITCHES] += 1.0
            kept[at.NEXT_SWITCH] += control.spans[switch]
            volts = np.copysign(control.levels[switch], 0.5 * stroke - y[at.POSITION])
    # Steps of a converter of some 16 bits, so that few digits state the voltage exactly.
    return round(min(max(volts, -control.level), control.level) / CONVERTER) * CONVERTER
