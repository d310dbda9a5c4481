"""A parameter that drifts is that of the rig, and nothing while its table is empty or level."""

import dataclasses
import itertools

import numpy as np
import pytest
import swinging_servo
from swinging_servo import BASELINE, RIG, TIME

from analog_card.design_file import load_design
from pneuservo.controllers import card_of
from pneuservo.effects.unexplained import DRIFT
from pneuservo.errors import InputError
from pneuservo.plant.control_law import OPEN_LOOP
from pneuservo.plant.servo.drift import (
    DRIFTING,
    behind_drift,
    behind_reference,
    read_by_reference,
    with_factor,
)
from pneuservo.plant.servo.layout import Servo
from pneuservo.plant.servo.servo_effects import NEUTRAL
from pneuservo.plant.servo.unexplained_effects import INTERVALS, Table
from pneuservo.rigs import plant_numbers
from pneuservo.simulation import InitialState, simulate

# Pressures at rest would follow the mass.
START = InitialState(0.012, pressure_a=3e5, pressure_b=3.2e5)
PARAMETERS = (
    ("load.mass",),
    ("piston.coulomb_friction",),
    ("valve.flow.area_b_e", "valve.flow.area_a_e"),
    ("valve.flow.area_s_a", "valve.flow.area_s_b"),
)


def drift(which, values, high=0.3):
    return {"of": which, "low": 0.0, "high": high} | {f"v{k}": v for k, v in enumerate(values)}


def run(effects, rig=RIG):
    return swinging_servo.run(effects, start=START, rig=rig)


def assert_same(found, expected):
    swinging_servo.assert_same(found, expected, 1e-9)


def numbered(value, counter):
    """Fill every number with another one, whatever it is a number of."""
    if isinstance(value, tuple):
        filled = [numbered(part, counter) for part in value]
        return value._make(filled) if hasattr(value, "_make") else tuple(filled)
    return float(next(counter))


def flat(value):
    if isinstance(value, tuple):
        return [number for part in value for number in flat(part)]
    return [value]


@pytest.mark.parametrize("which", range(len(PARAMETERS)), ids=DRIFTING[: len(PARAMETERS)])
def test_a_level_drift_is_a_parameter_of_another_value(which):
    changed = RIG.with_values({name: 1.07 * RIG[name] for name in PARAMETERS[which]})
    level = run({"unexplained.drift": drift(which, [0.07] * (INTERVALS + 1))})
    expected = run(BASELINE, changed)
    assert_same(level, expected)
    # ... and it does something: more than the tolerance above, by far.
    assert np.ptp(expected["displacement"] - run(BASELINE)["displacement"]) > 1e-6


def test_a_level_drift_of_the_transducer_is_its_wrong_gain():
    level = run({"unexplained.drift": drift(4, [0.01] * (INTERVALS + 1))})
    assert_same(level, run({"sensor.position-gain": {"gain": 0.01}}))


def test_a_level_drift_of_the_reference_is_a_wrong_gain_of_every_transducer():
    level = run({"unexplained.drift": drift(5, [0.01] * (INTERVALS + 1))})
    alone = run({"sensor.position-gain": {"gain": 0.01}})
    ambient = RIG["ambient.pressure"]
    assert level["displacement"] == pytest.approx(alone["displacement"], rel=1e-9)
    for name in ("pressure_a", "pressure_b"):
        assert level[name] - ambient == pytest.approx(1.01 * (alone[name] - ambient))
    table = Table(5.0, 0.0, 1.0, *np.linspace(0.0, 0.04, INTERVALS + 1))
    time, pressure = np.linspace(0.0, 1.0, 5), np.linspace(2e5, 5e5, 5)
    read = read_by_reference(time, pressure, ambient, table)
    assert read[-1] == pytest.approx(ambient + 1.04 * (5e5 - ambient))
    assert behind_reference(time, read, ambient, table) == pytest.approx(pressure)
    other = table._replace(over=4.0)
    assert read_by_reference(time, pressure, ambient, other) is pressure
    assert behind_reference(time, pressure, ambient, other) is pressure


def test_a_drift_begins_where_the_parameter_still_has_its_value():
    rising = np.linspace(0.0, 0.5, INTERVALS + 1)
    drifting = run({"unexplained.drift": drift(2, rising)})
    constant = run(BASELINE)
    apart = np.abs(drifting["pressure_a"] - constant["pressure_a"])
    early, late = apart[TIME < 0.02].max(), apart[TIME > 0.2].max()
    assert early < 0.05 * late


def test_a_drift_of_nothing_leaves_every_number_in_its_place():
    servo = numbered(Servo(plant_numbers.single_axis(RIG), NEUTRAL, OPEN_LOOP), itertools.count(1))
    # Rounding of the transducer's gain alone, which stands as a difference from one.
    expected = pytest.approx(flat(servo), rel=1e-12)
    for which in range(len(DRIFTING)):
        assert flat(with_factor(servo, which, 1.0)) == expected, DRIFTING[which]


def test_under_the_card_a_mass_that_drifts_is_another_mass():
    time = np.arange(0.0, 0.1, 1e-4)
    heavier = RIG.with_values({"load.mass": 1.3 * RIG["load.mass"]})
    found, expected, lighter = (
        simulate(
            dataclasses.replace(rig, effects=effects),
            time=time,
            controller=card_of(load_design()),
            demand=np.where(time < 0.5e-4, 0.015, 0.024),
            initial=START,
        )
        for rig, effects in (
            (RIG, {"unexplained.drift": drift(0, [0.3] * (INTERVALS + 1))}),
            (heavier, BASELINE),
            (RIG, BASELINE),
        )
    )
    assert_same(found, expected)
    assert np.ptp(expected["displacement"] - lighter["displacement"]) > 1e-5


def test_what_a_drifting_transducer_read_is_undone():
    time = np.linspace(0.0, 1.0, 2001)
    place = 0.02 + 0.01 * np.sin(2.0 * np.pi * time)
    # Straight over the whole time: the table's knots leave no corners in the gain.
    gain = 1.0 + 0.04 * time
    table = Table(4.0, 0.0, 1.0, *np.linspace(0.0, 0.04, INTERVALS + 1))
    reading = gain * place
    rate = np.gradient(reading, time)
    found = behind_drift(time, np.array([reading, rate, np.gradient(rate, time)]), table)
    inner = slice(3, -3)
    speed = np.gradient(place, time)
    assert np.abs(found[0] - place)[inner].max() < 1e-12
    # Differences of second order in 0.5 ms: 1e-6 of 63 mm/s and of 0.39 m/s^2 a few times over.
    assert np.abs(found[1] - speed)[inner].max() < 1e-6
    assert np.abs(found[2] - np.gradient(speed, time))[inner].max() < 1e-4


def test_other_drifts_leave_the_motion_as_it_was_read():
    motion = np.ones((3, 4))
    table = Table(0.0, 0.0, 1.0, *np.linspace(0.0, 0.5, INTERVALS + 1))
    assert behind_drift(np.arange(4.0), motion, table) is motion


def test_a_drift_of_nothing_that_is_known_is_refused():
    with pytest.raises(InputError, match="of is 9; it has to be one of: 0 moved mass"):
        run({DRIFT.id: drift(9, [0.1] * (INTERVALS + 1))})


def test_a_drift_counts_from_where_a_run_begins():
    rig = dataclasses.replace(
        RIG, effects={"unexplained.drift": drift(0, np.linspace(0.0, 0.2, INTERVALS + 1))}
    )
    command = np.sin(20.0 * TIME)
    early, late = (
        simulate(rig, time=first + TIME, command=command, initial=START) for first in (0.0, 64.0)
    )
    for name in ("displacement", "pressure_a", "pressure_b"):
        np.testing.assert_allclose(late[name], early[name], rtol=1e-9)
