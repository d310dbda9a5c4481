"""The servo's diagnosis: nothing where there is nothing, the right name where there is something.

The truth of the planted effects is that of `pneuservo.challenge`: other equations, other forms of
the laws, another integrator.
"""

import dataclasses

import numpy as np
import pytest
from servo_recordings import NOISE, recorded

from pneuservo.challenge.cases import make_case
from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis import diagnose, document, repaired_model
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.errors import InputError
from pneuservo.recordings import Recording, read_recording
from pneuservo.report.answer_files import answer_files
from pneuservo.rigs import load_rig
from pneuservo.simulation import replay, simulate


@pytest.mark.parametrize(("controller", "seed"), [(Proportional(), 1), (SlidingMode(), 2)])
def test_no_effect_raises_no_alarm(controller, seed):
    found = diagnose([recorded(load_rig("single-axis"), controller, seed)])
    assert found.verdict == "consistent", found.search.accepted
    assert document(found)["located"] == []


def test_a_wrong_mass_is_a_parameter_and_no_physics():
    rig = load_rig("single-axis")
    heavy = rig.with_values({"load.mass": 1.2 * rig["load.mass"]})
    run = recorded(heavy, Proportional(), 3, duration=2.0)
    found = diagnose([run])
    answer = document(found)
    assert answer["verdict"] == "parameter", found.search.accepted
    mass = answer["corrected_parameters"]["load.mass"]
    assert mass["value"] == pytest.approx(heavy["load.mass"], rel=0.02)
    assert [entry["block"] for entry in answer["located"]] == ["load"]
    # Two fits at a time give the same answer to the last digit.
    both = diagnose([run], jobs=2)
    assert document(both) == answer


def test_interference_in_one_reading_is_unexplained_and_put_in_its_transducer():
    run = recorded(load_rig("single-axis"), Proportional(), 4)
    line = 800.0 * np.sin(2.0 * np.pi * 37.2 * run.time)
    disturbed = run.channels | {"pressure_a": run["pressure_a"] + line}
    answer = document(diagnose([dataclasses.replace(run, channels=disturbed)]))
    assert answer["verdict"] == "unexplained", answer["missing"]
    assert [entry["block"] for entry in answer["located"]] == ["sensor.pressure"]
    assert "37.2 Hz" in answer["missing"][0]["statement"]


def resting(channels):
    """Return a recording of a piston that rests all the time."""
    time = np.arange(0.0, 2.0, 1e-3)
    run = simulate(
        load_rig("single-axis"), time=time, controller=Proportional(), demand=np.full(2000, 0.015)
    )
    rng = np.random.default_rng(7)
    noisy = {name: run[name] + rng.normal(0.0, NOISE[name], len(time)) for name in channels}
    return Recording("rest", time, noisy | {"valve_voltage": run["valve_voltage"]})


def test_a_piston_at_rest_is_judged_by_its_pressures_alone():
    found = diagnose([resting(NOISE)], [resting(NOISE)])
    answer = document(found)
    assert answer["verdict"] == "consistent"
    assert set(answer["fit"]["channels"]) == {"pressure_a", "pressure_b"}


def test_a_piston_at_rest_without_pressures_is_refused():
    with pytest.raises(InputError, match="does not move"):
        diagnose([resting(["displacement"])])


@pytest.mark.parametrize(
    ("effect", "blocks", "duration"),
    [
        ("leakage.chamber-a", {"chamber.a"}, 2.0),
        ("spool.hysteresis", {"valve.spool"}, 3.0),
    ],
)
def test_a_planted_effect_is_named_and_put_in_its_block(effect, blocks, duration, tmp_path):
    make_case(11, effect, "visible", tmp_path)
    used, held_back = (
        [
            read_recording(str(path)).slice(0.0, duration)
            for path in sorted(tmp_path.glob(f"{part}-*.csv"))
        ]
        for part in ("used", "held-back")
    )
    found = diagnose(used, held_back)
    answer = document(found)
    assert answer["verdict"] == "missing-physics"
    first = answer["missing"][0]
    assert effect in first["class"], (first["effect"], first["class"])
    assert answer["located"][0]["block"] in blocks
    # What was held back is predicted better too.
    before, after = (
        sum(
            entry[when]["held_back"] / entry["noise_rms"]
            for entry in answer["fit"]["channels"].values()
        )
        for when in ("before", "after")
    )
    assert after < before
    # The repaired rig is one that every command takes.
    file = tmp_path / "model.toml"
    file.write_text(answer_files(found, answer)["model.toml"])
    repaired = load_rig(file)
    assert first["effect"] in repaired.effects
    for key, value in found.repaired.shared.items():
        if key in repaired.parameters:
            assert repaired[key] == value, key
    assert replay(used[0], repaired)["displacement"].shape == used[0].time.shape


KNOTS = np.linspace(0.0, 4.0, 9)


@pytest.mark.parametrize(
    ("of", "block", "largest", "interval"),
    # A mass takes twice as long, and shows as well with half the samples.
    [(0, "load", 0.1, 2e-3), (2, "valve.flow", -0.1, 1e-3)],
    ids=["mass", "exhaust edges"],
)
def test_a_parameter_that_drifts_is_unexplained_and_put_in_its_block(of, block, largest, interval):
    rig = load_rig("single-axis")
    rising = {f"v{k}": largest * k / 8.0 for k in range(9)}
    drift = {"of": float(of), "low": 0.0, "high": 4.0, **rising}
    drifting = dataclasses.replace(rig, effects={"unexplained.drift": drift})
    found = diagnose([recorded(drifting, Proportional(), 5, interval=interval)])
    answer = document(found)
    assert answer["verdict"] == "unexplained", found.search.accepted
    assert answer["located"][0]["block"] == block
    form = "growing" if largest > 0.0 else "falling"
    assert f"({form})" in answer["missing"][0]["statement"]
    # Parameters within their tolerances take up the level; the first knot shows nearly nothing.
    fitted = answer["missing"][0]["parameters"]
    knots = np.arange(1, 9)
    slope, level = np.polyfit(knots, [fitted[f"v{k}"]["value"] for k in knots], 1)
    late, early = (1.0 + level + slope * knot for knot in (7, 1))
    expected = (1.0 + 7.0 / 8.0 * largest) / (1.0 + largest / 8.0)
    assert late / early == pytest.approx(expected, abs=0.015)
    model = repaired_model(found)
    assert model["effects"]["unexplained.drift"]["of"]["value"] == of
    # The values beside the table are those of its fit, and so are their intervals.
    for name, entry in model["parameters"].items():
        assert entry["low"] <= entry["value"] <= entry["high"], name


def test_what_drifts_in_every_recording_in_a_way_of_its_own_is_followed_in_each():
    rig, reference = load_rig("single-axis"), 5
    ways = (np.linspace(0.0, 0.03, 9), 0.02 * np.sin(np.arange(9.0)), np.linspace(0.02, 0.0, 9))
    recordings = []
    for seed, way in enumerate(ways):
        values = {f"v{k}": float(value) for k, value in enumerate(way)}
        drift = {"of": float(reference), "low": 0.0, "high": 4.0, **values}
        drifting = dataclasses.replace(rig, effects={"unexplained.drift": drift})
        recordings.append(recorded(drifting, Proportional(), 5 + seed))
    found = diagnose(recordings[:2], validate=recordings[2:])
    answer = document(found)
    assert answer["verdict"] == "unexplained", found.search.accepted
    assert answer["located"][0]["block"] == "sensor.displacement"
    assert "gain of all transducers" in answer["missing"][0]["statement"]
    assert "the recording in which it varies most" in answer["missing"][0]["statement"]
    # That of the recording held back is no better known from the others, and fitted to it.
    for name, entry in answer["fit"]["channels"].items():
        for which in ("used", "held_back"):
            before, after = (entry[when][which] / NOISE[name] for when in ("before", "after"))
            assert after**2 - 1.0 < 0.2 * (before**2 - 1.0)
            # Readings are not explained by transducers that read less of everything, noise too.
            assert after > 0.95
    assert answer["fit"]["channels"]["displacement"]["before"]["held_back"] > 1.5e-5


def test_a_supply_that_wanders_has_its_name():
    rig, supply = load_rig("single-axis"), 6
    recordings = []
    for seed in range(2):
        rng = np.random.default_rng(seed)
        walk = 0.003 * np.cumsum(rng.standard_normal(9))
        values = {f"v{k}": float(value) for k, value in enumerate(walk)}
        drift = {"of": float(supply), "low": 0.0, "high": 4.0, **values}
        wandering = dataclasses.replace(rig, effects={"unexplained.drift": drift})
        recording = recorded(wandering, Proportional(), 5 + seed, interval=2e-3)
        source = rig["supply.pressure"] * (1.0 + np.interp(recording.time, KNOTS, walk))
        recording.channels["supply_pressure"] = source + rng.normal(0.0, 500.0, len(source))
        recordings.append(recording)
    found = diagnose(recordings)
    answer = document(found)
    assert answer["verdict"] == "missing-physics"
    assert [entry["effect"] for entry in answer["missing"]] == ["supply.slow-drift"]
    assert answer["located"][0]["block"] == "supply"
    assert "the recording in which it varies most" in answer["missing"][0]["statement"]
    assert repaired_model(found)["effects"]["unexplained.drift"]["of"]["value"] == supply


def test_a_supply_that_was_not_recorded_wanders_in_the_chambers():
    rig, model = load_rig("single-axis"), ServoModel()
    rising = {f"v{k}": 0.05 * k / 8.0 for k in range(9)}
    drift = {"of": 6.0, "low": 0.0, "high": 4.0, **rising}
    wandering = dataclasses.replace(rig, effects={"unexplained.drift": drift})
    cases = model.cases(recorded(wandering, Proportional(), 5), rig)
    known = {f"unexplained.drift:{name}": value for name, value in drift.items()}
    for case in cases:
        if case.channel.startswith("pressure"):
            without, with_it = (case.measured - model.predict(case, v) for v in ({}, known))
            assert np.std(with_it) == pytest.approx(1.0, abs=0.1)
            assert np.sum(without**2) > np.sum(with_it**2) + 50.0


def test_a_drift_of_nothing_leaves_what_is_expected_as_it_is():
    # Code of its own follows a servo that does not drift.
    rig, model = load_rig("single-axis"), ServoModel()
    nothing = {f"unexplained.drift:v{k}": 0.0 for k in range(9)}
    nothing |= {"unexplained.drift:low": 0.0, "unexplained.drift:high": 4.0}
    for case in model.cases(recorded(rig, SlidingMode(), 5), rig):
        assert model.predict(case, nothing) == pytest.approx(model.predict(case, {}), abs=1e-6)
