"""Running the single axis with effects beyond the baseline."""

import dataclasses
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from pneuservo.effects.servo import servo_effects
from pneuservo.plant.control_law import ControlLaw
from pneuservo.plant.servo import layout
from pneuservo.plant.servo.chamber_effects import has_energy_balance
from pneuservo.plant.servo.layout import Fed, Servo
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.starting import resting_force, servo_inputs, servo_state
from pneuservo.plant.servo.transducers import (
    read_displacement,
    read_pressures,
    true_motion,
    true_pressures,
)
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import Rig
from pneuservo.simulation.initial_state import InitialState

Samples = NDArray[np.float64]


def run_with_effects(
    effects: ServoEffects,
    time: Samples,
    held: Samples,
    force: Samples,
    supply_pressure: Samples | None,
    initial: InitialState,
    rest: float,
    law: ControlLaw,
    plant: SingleAxis,
    grid: Samples,
    largest_step: float,
) -> tuple[dict[str, Samples], NDArray[np.bool_]]:
    """Return what the transducers read in a run, by channel, and where the state is finite.

    Parameters
    ----------
    effects : ServoEffects
        The effects.
    time : (n,) array
        [s].
    held : (n,) array
        Command [V] or demand [m].
    force : (n,) array
        At the rod [N].
    supply_pressure : (n,) array or None
        Of the source; None for the rig's [Pa].
    initial : InitialState
        Where it starts.
    rest : float
        Displacement where none is given [m].
    law : ControlLaw
        What commands the valve.
    plant : SingleAxis
        The numbers of the rig.
    grid : (4, 51, 101) array
        Discharge coefficients.
    largest_step : float
        [s].

    Returns
    -------
    dict of str to (n,) array
        The columns of `pneuservo.plant.servo.layout.OUTPUTS` that are channels or taps.
    (n,) array of bool
        False where the integration broke down.
    """
    servo = Servo(plant, effects, law, Fed())
    supply = np.full(len(time), plant.supply_pressure)
    if supply_pressure is not None:
        supply = supply_pressure
    place = rest if initial.displacement is None else initial.displacement
    start = initial.state(plant, rest, float(force[0]) + resting_force(place, plant, effects))
    inputs = servo_inputs(time, supply, command=held, external_force=force)
    state = servo_state(start, servo, float(supply[0]))
    out = run_servo(inputs, np.zeros(len(time), dtype=bool), state, servo, grid, largest_step)
    columns: dict[str, Samples] = dict(zip(layout.OUTPUTS, out.T, strict=True))
    finite: NDArray[np.bool_] = np.isfinite(out[:, :6]).all(axis=1)
    flow_a, flow_b = columns.pop("mass_flow_a"), columns.pop("mass_flow_b")
    for name in ("driving_force", "friction_force"):
        del columns[name]
    columns["displacement"] = read_displacement(columns["displacement"], effects.sensor)
    columns["pressure_a"], columns["pressure_b"] = read_pressures(
        time,
        columns["pressure_a"],
        columns["pressure_b"],
        flow_a,
        flow_b,
        plant.gas,
        effects.sensor,
    )
    if supply_pressure is None and effects.supply == ServoEffects().supply:
        del columns["supply_pressure"]
    if not has_energy_balance(effects.chamber):
        del columns["temperature_a"], columns["temperature_b"]
    return columns, finite


def state_behind(initial: InitialState, rig: Rig, plant: SingleAxis) -> InitialState:
    """Return the state behind the readings of the first sample.

    Parameters
    ----------
    initial : InitialState
        As read.
    rig : Rig
        The rig, with the errors its transducers have.
    plant : SingleAxis
        Its numbers.

    Returns
    -------
    InitialState
        Lags cannot be undone from one sample and are left.
    """
    sensor = _without_lags(rig.effect_values).sensor
    moment = np.zeros(1)
    known: dict[str, float] = {}
    if initial.displacement is not None:
        stroke = plant.piston.stroke
        place, velocity = true_motion(
            np.array([initial.displacement]),
            np.array([initial.velocity]),
            None,
            stroke,
            sensor,
        )
        known["displacement"] = float(np.clip(place[0], 0.0, stroke))
        known["velocity"] = float(velocity[0])
    for name in ("pressure_a", "pressure_b"):
        reading = getattr(initial, name)
        if reading is not None:
            pair = np.array([reading])
            found = true_pressures(moment, pair, pair, None, None, plant.gas, sensor)
            known[name] = float(found[name == "pressure_b"][0])
    return dataclasses.replace(initial, **known)


def _without_lags(values: Mapping[str, float]) -> ServoEffects:
    effects = servo_effects(values)
    sensor = effects.sensor._replace(displacement_lag=0.0, pressure_lag=0.0, pressure_skew=0.0)
    return effects._replace(sensor=sensor)
