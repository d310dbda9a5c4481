"""Valve, hoses and chambers driven by the motion and command that were measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo import layout
from pneuservo.plant.servo.layout import Fed, Servo
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import NEUTRAL, ServoEffects
from pneuservo.plant.servo.starting import Samples, servo_inputs, servo_state
from pneuservo.plant.servo.transducers import read_pressures, true_motion, true_pressures
from pneuservo.plant.single_axis import PLANT_STATES, SPOOL, SingleAxis

# Against steps of 20 us the pressures of a random command differ by some 30 Pa (rms), a tenth of
# a transducer's noise.
LARGEST_STEP = 500e-6
# A small volume at the valve's end of a hose is stiff; delays, rate limits and stiction of the
# spool change the command inside a step.
_LARGEST_STEP_OF_FAST_EFFECTS = 100e-6


@dataclass(frozen=True)
class FedChambers:
    """What the chambers do under a measured motion.

    Parameters
    ----------
    pressure_a, pressure_b : (n,) array
        As the transducers read them [Pa].
    spool : (n,) array
        Fraction of full opening [-].
    supply_pressure : (n,) array
        At the valve [Pa].
    temperature_a, temperature_b : (n,) array
        Of the gas [K].
    mass_flow_a, mass_flow_b : (n,) array
        Into the chambers through the valve [kg/s].
    """

    pressure_a: Samples
    pressure_b: Samples
    spool: Samples
    supply_pressure: Samples
    temperature_a: Samples
    temperature_b: Samples
    mass_flow_a: Samples
    mass_flow_b: Samples


def fed_chambers(
    time: Samples,
    voltage: Samples,
    displacement: Samples,
    velocity: Samples,
    pressure_a: Samples,
    pressure_b: Samples,
    plant: SingleAxis,
    grid: NDArray[np.float64],
    effects: ServoEffects = NEUTRAL,
    *,
    acceleration: Samples | None = None,
    supply_pressure: Samples | float | None = None,
    spool: Samples | None = None,
    restarts: ArrayLike = (),
    ramped_voltage: bool = False,
    largest_step: float = LARGEST_STEP,
) -> FedChambers:
    """Simulate both chambers, and the spool unless it was measured, under a measured motion.

    Parameters
    ----------
    time : (n,) array
        Strictly increasing [s].
    voltage : (n,) array
        Command into the valve driver [V].
    displacement, velocity : (n,) array
        As the transducer reads them; velocity runs straight between samples [m], [m/s].
    pressure_a, pressure_b : (n,) array
        As read [Pa]. Only the first sample and those of `restarts` are used.
    plant : SingleAxis
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients.
    effects : ServoEffects, optional
        The baseline by default.
    acceleration : (n,) array, optional
        As read, for undoing a lag of the displacement transducer [m/s^2].
    supply_pressure : (n,) array or float, optional
        Of the source; the rig's by default [Pa].
    spool : (n,) array, optional
        Measured spool position, instead of simulating it [-].
    restarts : sequence of int, optional
        Samples at which the pressures are set to those read.
    ramped_voltage : bool, optional
        Whether the command runs straight between samples instead of being held.
    largest_step : float, optional
        Of the integration [s].

    Returns
    -------
    FedChambers
        Free running between restarts.

    Notes
    -----
    The kernel is that of the whole chain, `pneuservo.plant.servo.run.run_servo`, with the motion
    replaced: one copy of every equation.
    """
    sensor, gas = effects.sensor, plant.gas
    true_x, true_v = true_motion(displacement, velocity, acceleration, plant.piston.stroke, sensor)
    true_a, true_b = true_pressures(time, pressure_a, pressure_b, None, None, gas, sensor)
    supply = plant.supply_pressure if supply_pressure is None else supply_pressure
    inputs = servo_inputs(
        time,
        supply,
        command=voltage,
        fed_displacement=true_x,
        fed_velocity=true_v,
        fed_pressure_a=true_a,
        fed_pressure_b=true_b,
        fed_spool=0.0 if spool is None else spool,
    )
    again = np.zeros(len(time), dtype=bool)
    again[np.asarray(restarts, dtype=int)] = True
    start = np.zeros(PLANT_STATES)
    start[:] = [true_x[0], true_v[0], true_a[0], true_b[0], 0.0, 0.0]
    if spool is not None:
        start[SPOOL] = spool[0]
    else:
        start[SPOOL] = np.clip(voltage[0] / plant.valve.full_voltage, -1.0, 1.0)
    servo = Servo(plant, effects, OPEN_LOOP, Fed(True, False, spool is not None, ramped_voltage))
    state = servo_state(start, servo, float(inputs[0, layout.SUPPLY]))
    largest_step = min(largest_step, step_for(effects))
    out = run_servo(inputs, again, state, servo, grid, largest_step)
    flow_a, flow_b = out[:, layout.FLOW_A_OUT], out[:, layout.FLOW_B_OUT]
    read_a, read_b = read_pressures(
        time, out[:, _PRESSURE_A], out[:, _PRESSURE_B], flow_a, flow_b, gas, sensor
    )
    return FedChambers(
        read_a,
        read_b,
        out[:, _SPOOL],
        out[:, layout.SUPPLY_OUT],
        out[:, layout.TEMPERATURE_A_OUT],
        out[:, layout.TEMPERATURE_B_OUT],
        flow_a,
        flow_b,
    )


def step_for(effects: ServoEffects) -> float:
    """Return the longest integration step that the effects leave room for [s].

    Parameters
    ----------
    effects : ServoEffects
        The effects.
    """
    spool = effects.spool
    fast = (effects.line.frequency, spool.delay, spool.rate_limit, spool.stiction)
    return _LARGEST_STEP_OF_FAST_EFFECTS if any(fast) else LARGEST_STEP


_PRESSURE_A, _PRESSURE_B, _SPOOL = (
    layout.OUTPUTS.index(name) for name in ("pressure_a", "pressure_b", "spool")
)
