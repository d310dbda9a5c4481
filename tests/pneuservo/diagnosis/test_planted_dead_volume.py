"""Closed chambers with something planted in them: is it found, named and measured?"""

from dataclasses import replace

import numpy as np
import pytest
import truth_dead_volume as truth
from reading_answers import assert_recovered, entry_of, named, separable

from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models.dead_volume import DeadVolumeModel
from pneuservo.rigs import load_rig

SEEDS = (1, 2)

LEAKS = [
    ("leakage.orifice", truth.hole(2e-9), {"area": 2e-9}),
    ("leakage.orifice", truth.hole(2e-8), {"area": 2e-8}),
    ("leakage.laminar", truth.gap(2e-18), {"conductance": 2e-18}),
    ("leakage.laminar", truth.gap(2e-17), {"conductance": 2e-17}),
    (
        "leakage.mixed",
        truth.hole_and_gap(1e-9, 1.5e-18),
        {"area": 1e-9, "conductance": 1.5e-18},
    ),
    ("leakage.pressure-opening", truth.pores(4e-7, 1.3), {"coefficient": 4e-7, "exponent": 1.3}),
]


def answer(*recordings, **options):
    return document(diagnose(recordings, **options))


def first_rate(leak):
    """How fast the pressure falls at 7 bar gauge, isothermal [Pa/s]."""
    return -truth.R * truth.WALL / truth.VOLUME * leak(truth.AMBIENT + 7e5, truth.WALL)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("effect", "leak", "values"), LEAKS, ids=[str(leak[2]) for leak in LEAKS])
def test_one_leak(effect, leak, values, seed):
    found = answer(truth.recording(truth.pressure_history(leak), seed))
    assert found["verdict"] == "missing-physics"
    assert named(found) == {effect}
    parameters = entry_of(found, effect)["parameters"]
    for parameter, value in values.items():
        assert_recovered(parameters[parameter], value)
    assert_recovered(parameters["pressure_rate_at_first"], first_rate(leak))
    assert [place["block"] for place in found["located"]] == ["dead-volume"]


@pytest.mark.parametrize(("released", "seed"), [(5.0, 1), (12.3, 2)])
def test_when_a_held_volume_was_left_alone(released, seed):
    leak = truth.pores(4e-7, 1.3)
    found = answer(truth.recording(truth.pressure_history(leak, released=released), seed))
    parameters = entry_of(found, "leakage.pressure-opening")["parameters"]
    assert_recovered(parameters["start"], released)
    assert_recovered(parameters["exponent"], 1.3)
    assert f"{released:.1f} s" in found["located"][0]["regime"]


@pytest.mark.parametrize(("excess", "seed"), [(20.0, 1), (-15.0, 2)])
def test_heat(excess, seed):
    conductance = 0.03
    pressure = truth.pressure_history(excess=excess, wall_conductance=conductance)
    found = answer(truth.recording(pressure, seed))
    assert named(found) == {"chamber.heat-transfer"}
    parameters = entry_of(found, "chamber.heat-transfer")["parameters"]
    assert_recovered(parameters["excess"], excess)
    mass = (truth.AMBIENT + 7e5) * truth.VOLUME / (truth.R * (truth.WALL + excess))
    assert_recovered(parameters["time_constant"], mass * truth.CV / conductance)


@pytest.mark.parametrize(("rate", "seed"), [(20.0, 1), (-20.0, 2)])
def test_a_drift_is_in_the_class_that_is_named(rate, seed):
    pressure = truth.pressure_history()
    found = answer(truth.recording(pressure + rate * np.arange(len(pressure)) / truth.RATE, seed))
    assert found["verdict"] == "missing-physics"
    (entry,) = found["missing"]
    assert "sensor.pressure-drift" in entry["class"]
    if rate > 0.0:
        # No leak makes a pressure rise.
        assert entry["effect"] == "sensor.pressure-drift"
        assert_recovered(entry["parameters"]["rate"], rate)
    else:
        # So slow a fall may be a leak: that is said, and what would tell.
        assert {"sensor.pressure-drift", "leakage.orifice"} <= separable(found)[0]
        assert found["cannot_separate"][0]["experiment"]


@pytest.mark.parametrize("seed", SEEDS)
def test_heat_and_a_leak_together(seed):
    pressure = truth.pressure_history(truth.hole(5e-10), excess=20.0, wall_conductance=0.03)
    found = answer(truth.recording(pressure, seed))
    assert named(found) == {"chamber.heat-transfer", "leakage.orifice"}
    # The catalogue's settling time is constant; the truth's heat conductance is, so that its time
    # falls with the mass, by a third here. What is measured is good to a tenth.
    excess = entry_of(found, "chamber.heat-transfer")["parameters"]["excess"]["value"]
    assert excess == pytest.approx(20.0, rel=0.1)
    area = entry_of(found, "leakage.orifice")["parameters"]["area"]["value"]
    assert area == pytest.approx(5e-10, rel=0.1)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("effect", "leak", "parameter", "value"),
    [
        ("leakage.orifice", truth.hole(2e-8), "area", 2e-8),
        ("leakage.laminar", truth.gap(3e-17), "conductance", 3e-17),
    ],
    ids=["orifice", "laminar"],
)
def test_a_leak_behind_the_valve(effect, leak, parameter, value, seed):
    found = answer(truth.filled_and_shut(seed, leak))
    assert named(found) == {effect}
    assert_recovered(entry_of(found, effect)["parameters"][parameter], value)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_valve_without_a_leak_is_consistent(seed):
    assert answer(truth.filled_and_shut(seed))["verdict"] == "consistent"


@pytest.mark.parametrize(("stated", "seed"), [(30e-6, 1), (70e-6, 2)])
def test_a_wrong_volume_is_a_wrong_parameter(stated, seed):
    recording = replace(truth.filled_and_shut(seed), conditions={"dead_volume_volume": stated})
    found = answer(recording)
    assert found["verdict"] == "parameter"
    assert named(found) == set()
    assert_recovered(found["corrected_parameters"]["dead-volume.volume"], truth.VOLUME)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wrong_supply_pressure_is_a_wrong_parameter(seed):
    found = answer(truth.filled_and_shut(seed, supply=7.5e5))
    assert found["verdict"] == "parameter"
    assert named(found) == set()
    assert_recovered(found["corrected_parameters"]["supply.pressure"], 7.5e5)


def test_what_is_fitted_does_not_depend_on_the_order_of_the_files():
    # Only filling tells the volume, but the leak-down is from the same one.
    filling = truth.filled_and_shut(1, volume=1.1 * truth.VOLUME)
    leaking = truth.recording(truth.pressure_history(truth.hole(2e-9)), 1)
    model, rig = DeadVolumeModel(), load_rig("dead-volume")
    cases = [model.prepare(recording, rig) for recording in (filling, leaking)]
    assert model.fitted_to(cases) == model.fitted_to(cases[::-1]) == model.fitted(cases[0])
    values = {"initial_pressure": 7e5, "leakage.orifice:area": 2e-9}
    volumes = [{"dead-volume.volume": part * rig["dead-volume.volume"]} for part in (1.0, 1.5)]
    small, large = (model.predict(cases[1], {**values, **volume}) for volume in volumes)
    assert large[-1] > small[-1] + 1e3
