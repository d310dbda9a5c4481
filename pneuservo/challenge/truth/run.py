"""A run of the truth: ticks of a controller, variable steps between, samples of what is read."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import ndtri

from pneuservo.challenge.truth import layout as at
from pneuservo.challenge.truth.compilation import truth_kernel
from pneuservo.challenge.truth.control import STORED, Control, command_at, driving
from pneuservo.challenge.truth.integrator import advance
from pneuservo.challenge.truth.parameters import Array, Truth
from pneuservo.challenge.truth.servo import boundary_pressures, servo_rates
from pneuservo.challenge.truth.spool import hysteresis
from pneuservo.challenge.truth.transducers import read_position, read_pressures

READINGS = ("valve_voltage", "displacement", "pressure_a", "pressure_b", "supply_pressure")


@dataclass(frozen=True)
class Run:
    """A run, without noise.

    Parameters
    ----------
    readings : (n, 5) array
        What the transducers read at each sample, in the order of `READINGS` [SI].
    commands : (ticks,) array
        Voltage that drives the valve in every tick [V].
    motion : (n, 4) array
        Displacement, velocity, acceleration and spool as they are [SI].
    states : (segments, STATES) array
        The state at the start of every segment.
    """

    readings: Array
    commands: Array
    motion: Array
    states: Array

    @property
    def finite(self) -> bool:
        """Return whether the run stayed finite."""
        return bool(np.all(np.isfinite(self.readings)))


def start_state(truth: Truth, position: float, share_b: float = 0.75) -> Array:
    """Return a state at rest.

    Parameters
    ----------
    truth : Truth
        The servo.
    position : float
        Displacement [m].
    share_b : float, optional
        Pressure of chamber b over that of the supply [-].

    Returns
    -------
    (STATES,) array
        Chamber a balances chamber b, the atmosphere and the weight.
    """
    network, chambers = truth.network, truth.chambers
    y = np.zeros(at.STATES)
    p_b = share_b * network.supply_pressure
    weight = truth.load.mass * truth.load.gravity
    spring = truth.load.spring * (position - truth.load.spring_at)
    rest = network.ambient_pressure * (chambers.area_a - chambers.area_b)
    p_a = (p_b * chambers.area_b + rest - weight + spring) / chambers.area_a
    y[[at.POSITION, at.LOAD_POSITION, at.LAG_1, at.LAG_2]] = position
    if truth.load.joint_stiffness > 0.0:
        hung = (truth.load.mass - truth.load.rod_mass) * truth.load.gravity
        y[at.LOAD_POSITION] += 0.5 * truth.load.joint_gap + hung / truth.load.joint_stiffness
    y[[at.PRESSURE_A, at.LAG_A]] = p_a
    y[[at.PRESSURE_B, at.LAG_B]] = p_b
    y[[at.GAS_A, at.GAS_B, at.WALL_A, at.WALL_B]] = network.temperature
    y[at.SUPPLY], y[at.EXHAUST] = network.supply_pressure, network.ambient_pressure
    y[at.AGE] = y[at.SPOOL_AGE] = 1.0
    y[at.HOSES : at.HOSES + at.CELLS] = p_a
    y[at.HOSES + 2 * at.CELLS : at.HOSES + 3 * at.CELLS] = p_b
    return y


@cache
def relay_field() -> tuple[Array, Array]:
    """Return centres (standard normal) and relative widths of the relays of the hysteresis."""
    order = (np.arange(at.RELAYS) + 0.5) / at.RELAYS
    # The golden section spreads the widths evenly over the centres.
    widths = 0.4 + 1.2 * np.mod(np.arange(at.RELAYS) * 0.6180339887, 1.0)
    return ndtri(order), widths


def run(truth: Truth, control: Control, y: Array, rate: float, segment: float) -> Run:
    """Run the truth.

    Parameters
    ----------
    truth : Truth
        The servo.
    control : Control
        What drives it, and for how many ticks.
    y : (STATES,) array
        The state at the start.
    rate : float
        Samples per second; a whole number of ticks each [Hz].
    segment : float
        Time between the states that are kept [s].

    Returns
    -------
    Run
        What was read, and what was.
    """
    every = round(1.0 / (rate * control.tick))
    samples = len(control.demand) // every
    per_segment = round(segment * rate)
    centres, widths = relay_field()
    kept = np.zeros(at.KEPT)
    kept[at.WIPER] = y[at.POSITION]
    readings, motion = np.empty((samples, len(READINGS))), np.empty((samples, 4))
    commands = np.empty(len(control.demand))
    states = np.empty((math.ceil(samples / per_segment), at.STATES))
    relays = -np.ones(at.RELAYS)
    _run(
        truth, control, y.copy(), kept, relays, centres, widths,
        every, per_segment, readings, commands, motion, states,
    )  # fmt: skip
    return Run(readings, commands, motion, states)


def replay(truth: Truth, commands: Array, tick: float, states: Array, rate: float) -> Array:
    """Run the truth on stored commands in segments that start where they are told to.

    Parameters
    ----------
    truth : Truth
        The servo.
    commands : (ticks,) array
        Voltage of every tick [V].
    tick : float
        Its length [s].
    states : (segments, STATES) array
        The state at the start of each segment; they share the ticks evenly.
    rate : float
        Samples per second [Hz].

    Returns
    -------
    (n, 5) array
        What the transducers read, in the order of `READINGS` [SI].
    """
    every = round(1.0 / (rate * tick))
    ticks = len(commands) // len(states)
    none = np.zeros(1)
    parts = []
    for index, state in enumerate(states):
        part = commands[index * ticks : (index + 1) * ticks]
        control = Control(STORED, tick, part, none, none, none)
        start = state.copy()
        # A soft buffer may have let the piston deeper than 500 N press it into a hard stop.
        deepest = 500.0 / truth.load.stop_stiffness
        start[at.POSITION] = min(max(state[at.POSITION], -deepest), truth.chambers.stroke + deepest)
        parts.append(run(truth, control, start, rate, ticks * tick).readings)
        assert len(parts[-1]) == ticks // every
    return np.concatenate(parts)


@truth_kernel
def _delayed(index, tick, time, delay, shares):
    """Return the command share that reaches the spool at a time inside a tick."""
    if delay == 0.0:
        return shares[index]
    earlier = math.floor((time - delay) / tick + 1e-9)
    return shares[max(earlier, 0)]


@truth_kernel
def _jets(y, kept, truth, exhaust):
    """Keep which exhaust jets are attached."""
    valve = truth.valve
    if valve.attached_gain == 0.0:
        return
    for side in range(2):
        ratio = exhaust / y[at.PRESSURE_A + side]
        if ratio > valve.detach_ratio:
            kept[at.ATTACHED_A + side] = 0.0
        elif ratio < valve.attach_ratio:
            kept[at.ATTACHED_A + side] = 1.0


@truth_kernel
def _run(
    truth, control, y, kept, relays, centres, widths,
    every, per_segment, readings, commands, motion, states,
):  # fmt: skip
    """Fill readings, commands, motion and states."""
    work, trial, flows = np.zeros((7, at.STATES)), y.copy(), np.zeros(2)
    shares = np.zeros(len(commands))
    tick, step = control.tick, 1e-5
    stroke, full = truth.chambers.stroke, truth.spool.full_voltage
    fraction = truth.spool.delay % tick
    for index in range(len(commands)):
        time = index * tick
        if not math.isfinite(y[at.POSITION]):
            readings[index // every :] = math.nan
            return
        supply, exhaust = boundary_pressures(time, y, truth.network)
        _jets(y, kept, truth, exhaust)
        share = shares[index - 1] if index > 0 else 0.0
        # Samples and controllers need the flows and the acceleration of this moment.
        servo_rates(time, share, y, kept, truth, work[0], flows)
        kept[at.ACCELERATION] = work[0, at.SPEED]
        reading = read_position(time, y, kept, truth.sensors, stroke)
        volts = command_at(index, y, kept, reading, control, stroke)
        commands[index] = driving(index, volts, kept[at.COMMAND], control)
        kept[at.COMMAND] = volts
        shares[index] = hysteresis(
            commands[index] / full, truth.spool, kept, relays, centres, widths
        )
        if index % every == 0:
            sample = index // every
            p_a, p_b = read_pressures(time, y, work[0], flows, volts, truth.sensors, truth.network)
            readings[sample, 0], readings[sample, 1] = volts, reading
            readings[sample, 2], readings[sample, 3] = p_a, p_b
            readings[sample, 4] = supply
            motion[sample, 0], motion[sample, 1] = y[at.POSITION], y[at.SPEED]
            motion[sample, 2], motion[sample, 3] = work[0, at.SPEED], y[at.SPOOL]
            if sample % per_segment == 0:
                # A row at once would take two seconds more to compile.
                for place in range(at.STATES):
                    states[sample // per_segment, place] = y[place]
        # The command changes inside a tick when it is late by a part of one.
        middle = time + fraction
        if fraction > 1e-9:
            share = _delayed(index, tick, time + 0.5 * fraction, truth.spool.delay, shares)
            step = advance(time, middle, share, y, kept, truth, work, trial, flows, step)
        share = _delayed(index, tick, middle + 0.5 * (tick - fraction), truth.spool.delay, shares)
        step = advance(middle, time + tick, share, y, kept, truth, work, trial, flows, step)
