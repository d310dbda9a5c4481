"""Running the single axis with effects beyond the baseline."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from analog_card.behaviour import CardBehaviour
from pneuservo.arrays import Array, Mask
from pneuservo.effects.servo import servo_effects
from pneuservo.plant.control_law import HELD_VOLTAGE, OPEN_LOOP, ControlLaw
from pneuservo.plant.servo import layout
from pneuservo.plant.servo.behavioural_card import run_servo_with_card
from pneuservo.plant.servo.chain import heard
from pneuservo.plant.servo.chamber_effects import has_energy_balance
from pneuservo.plant.servo.drift import (
    behind_reference,
    drifted,
    drifting_supply,
    read_by_reference,
)
from pneuservo.plant.servo.layout import Servo
from pneuservo.plant.servo.run import run_servo
from pneuservo.plant.servo.servo_effects import ServoEffects
from pneuservo.plant.servo.starting import resting_force, servo_inputs, servo_state
from pneuservo.plant.servo.transducers import (
    in_steps,
    play,
    read_pressures,
    true_motion,
    true_pressures,
)
from pneuservo.plant.single_axis import SingleAxis
from pneuservo.rigs import Rig
from pneuservo.rigs.plant_numbers import single_axis, valve_grid
from pneuservo.simulation.behavioural_card import SteppedCard, equally_spaced, stepped_card
from pneuservo.simulation.initial_state import InitialState
from pneuservo.simulation.inputs import Driven
from pneuservo.simulation.readings import (
    EXACT,
    Noise,
    Seed,
    draw_noise,
    in_parts,
    smooth_noise,
    within_range,
)

_LEAST_PARTS = 4
"""Straight parts of an interval that noise between its samples is followed in."""


def run_with_effects(
    rig: Rig,
    driven: Driven,
    initial: InitialState,
    rest: float,
    law: ControlLaw,
    behaviour: CardBehaviour | None,
    largest_step: float,
    seed: Seed,
) -> tuple[dict[str, Array], Mask]:
    """Return what the transducers read in a run, by channel, and where the state is finite.

    Parameters
    ----------
    rig : Rig
        With its effects and transducers.
    driven : Driven
        What drives the run.
    initial : InitialState
        Where it starts.
    rest : float
        Displacement where none is given [m].
    law : ControlLaw
        What commands the valve.
    behaviour : CardBehaviour or None
        Commands it instead of the law, whose transducer it has.
    largest_step : float
        [s].
    seed : int or sequence of int
        Of the transducers' noise.

    Returns
    -------
    dict of str to (n,) array
        The columns of `pneuservo.plant.servo.layout.OUTPUTS` that are channels or taps.
    (n,) array of bool
        False where the integration broke down.

    Raises
    ------
    InputError
        When a start is impossible, or the times do not suit the behaviour of a card.
    """
    # What changes in the course of a run counts from where that begins.
    time = driven.time if behaviour is None else equally_spaced(driven.time)
    driven = dataclasses.replace(driven, time=time - time[0])
    plant, effects = single_axis(rig), servo_effects(rig.effect_values)
    noise = draw_noise(rig, len(driven.time), seed)
    span = rig.transducers.get("displacement", EXACT)
    law_beside = law if behaviour is None else OPEN_LOOP
    servo = Servo(plant, effects, law_beside, displacement_range=(span.low, span.high))
    supply = driven.supply_pressure
    if supply is None:
        supply = np.full(len(driven.time), plant.supply_pressure)
        supply = drifting_supply(driven.time, supply, effects.unexplained_drift)
    hears = law.source != HELD_VOLTAGE and bool(noise.displacement.any())
    parts = _parts(driven.time, largest_step) if hears else 1
    finer = in_parts(driven.time, parts)
    held = np.arange(len(finer)) // parts
    place = rest if initial.displacement is None else initial.displacement
    own = float(driven.force[0]) + resting_force(place, plant, effects)
    inputs = servo_inputs(
        finer,
        np.interp(finer, driven.time, supply),
        command=driven.held[held],
        external_force=driven.force[held],
        displacement_noise=smooth_noise(driven.time, noise.displacement, finer),
    )
    state = servo_state(initial.state(plant, rest, own), servo, float(supply[0]))
    grid = valve_grid(rig.valve)
    if behaviour is None:
        out = run_servo(inputs, state, servo, grid, largest_step)
    else:
        card = stepped_card(finer, behaviour, law.sensitivity, largest_step)
        out = _run_beside_card(inputs, state, card, servo, grid)
    out = out[::parts]
    columns = dict(zip(layout.OUTPUTS, out.T, strict=True))
    finite: Mask = np.isfinite(out[:, :6]).all(axis=1)
    finite &= (columns["pressure_a"] > 0.0) & (columns["pressure_b"] > 0.0)
    arrived = columns["valve_voltage"]
    if law.source == HELD_VOLTAGE:
        # Sampled together with the readings, a held command has not reached the valve yet.
        arrived = np.append(arrived[:1], arrived[:-1])
    return _read(columns, arrived, rig, driven, noise, effects, plant), finite


def _parts(time: Array, largest_step: float) -> int:
    """Return into how many parts intervals are divided for the noise that a loop hears."""
    return max(_LEAST_PARTS, round(float(np.median(np.diff(time))) / largest_step))


def _run_beside_card(
    inputs: Array, state: Array, card: SteppedCard, servo: Servo, grid: Array
) -> Array:
    inputs[:, layout.TIME] = card.time
    reading, _, _ = heard(state, 0.0, servo)
    # The card has settled on a quiet reading; what noise does begins with the first sample.
    at_rest = card.at_rest(float(reading), inputs[0, layout.COMMAND])
    out: Array = run_servo_with_card(
        inputs, state, at_rest, card.sensitivity, card.steps, card.substeps, card.numbers,
        servo, grid,
    )  # fmt: skip
    return out


def _read(
    columns: dict[str, Array],
    arrived: Array,
    rig: Rig,
    driven: Driven,
    noise: Noise,
    effects: ServoEffects,
    plant: SingleAxis,
) -> dict[str, Array]:
    """Return the channels as they are recorded, those that nothing has left out."""
    sensor, transducers = effects.sensor, rig.transducers
    flow_a, flow_b = columns.pop("mass_flow_a"), columns.pop("mass_flow_b")
    place = columns["displacement"]
    if sensor.wiper_play > 0.0:
        place = play(place, sensor.wiper_play)
    place = place + noise.displacement
    reading = within_range(place, transducers.get("displacement", EXACT))
    for name in ("velocity", "acceleration"):
        columns[name] = np.where(reading == place, columns[name], 0.0)
    columns["displacement"] = in_steps(reading, sensor.displacement_step)
    pressures = read_pressures(
        driven.time,
        columns["pressure_a"],
        columns["pressure_b"],
        flow_a,
        flow_b,
        arrived,
        plant.gas,
        sensor,
    )
    for name, pressure, added in zip(
        ("pressure_a", "pressure_b"), pressures, (noise.pressure_a, noise.pressure_b), strict=True
    ):
        pressure = read_by_reference(
            driven.time, pressure, plant.ambient_pressure, effects.unexplained_drift
        )
        read = within_range(pressure + added, transducers.get("pressure", EXACT))
        columns[name] = in_steps(read, sensor.pressure_step)
    steady = effects.supply == ServoEffects().supply and not np.ptp(columns["supply_pressure"])
    if driven.supply_pressure is None and steady:
        del columns["supply_pressure"]
    if not has_energy_balance(effects.chamber):
        del columns["temperature_a"], columns["temperature_b"]
    return columns


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
        Lags, and what the command shifts, cannot be undone from one sample and are left.
    """
    begun = drifted(Servo(plant, _without_lags(rig.effect_values), OPEN_LOOP), 0.0)
    sensor = begun.effects.sensor
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
            pair = behind_reference(
                moment, np.array([reading]), plant.ambient_pressure, begun.effects.unexplained_drift
            )
            found = true_pressures(moment, pair, pair, np.zeros(1), sensor)
            known[name] = float(found[name == "pressure_b"][0])
    return dataclasses.replace(initial, **known)


def _without_lags(values: Mapping[str, float]) -> ServoEffects:
    effects = servo_effects(values)
    sensor = effects.sensor._replace(displacement_lag=0.0, pressure_lag=0.0, pressure_skew=0.0)
    return effects._replace(sensor=sensor)
