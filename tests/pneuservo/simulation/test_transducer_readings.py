"""Transducers with noise and a range: what is recorded, and what the controller hears."""

import dataclasses
import json

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.design_file import load_design
from analog_card.figures import card_figures
from pneuservo.command_line import main
from pneuservo.controllers import AnalogueCard, Proportional, SlidingMode, card_of
from pneuservo.errors import InputError
from pneuservo.rigs import Transducer, load_rig
from pneuservo.simulation import InitialState, simulate, simulate_batch, simulate_dead_volume

RIG = load_rig("single-axis")
SENSITIVITY = RIG["sensor.displacement.range"] / RIG["piston.stroke"]
FIGURES = AnalogueCard(card_figures(load_design()))
TIME = np.arange(0.0, 0.2, 1e-3)
DEMAND = np.where(TIME < 0.02, 0.015, 0.020)
LOOP = {"time": TIME, "demand": DEMAND, "initial": InitialState(0.015)}
NOISY = {"displacement": Transducer(noise=20e-6), "pressure": Transducer(noise=500.0)}


def with_transducers(**transducers):
    return dataclasses.replace(RIG, transducers=transducers)


@pytest.mark.parametrize(
    "controller",
    [SlidingMode(), FIGURES, card_of(load_design())],
    ids=["sliding mode", "card by its figures", "card by its behaviour"],
)
def test_exact_transducers_leave_the_loop_as_it_is(controller):
    exact = with_transducers(displacement=Transducer(), pressure=Transducer(0.0, 0.0, 2.17e6))
    plain = simulate(controller=controller, **LOOP)
    found = simulate(exact, controller=controller, **LOOP)
    for channel in ("displacement", "velocity", "pressure_a", "valve_voltage"):
        # Two integrators in steps of 20 us: 3e-6 of the range over the kinks of the tables, see
        # `LARGEST_STEP`; the card turns them into the voltage with its gain.
        scale = np.ptp(plain[channel])
        assert np.abs(found[channel] - plain[channel]).max() < 2e-5 * scale, channel


def test_the_controller_hears_what_is_recorded():
    run = simulate(with_transducers(**NOISY), controller=Proportional(0.5), seed=3, **LOOP)
    heard = np.clip(0.5 * SENSITIVITY * (DEMAND - run["displacement"]), -5.0, 5.0)
    np.testing.assert_allclose(run["valve_voltage"], heard, rtol=0.0, atol=1e-12)


def test_a_card_differentiates_the_noise():
    # Some 20 um, 7 mV, that come and go in 0.1 ms are 70 V/s; the filter takes 56 us.
    time = np.arange(0.0, 0.02, 1e-4)
    for controller in (FIGURES, card_of(load_design())):
        taps = [
            simulate(rig, time=time, controller=controller, demand=0.015)["card_velocity"]
            for rig in (with_transducers(**NOISY), with_transducers(displacement=Transducer()))
        ]
        assert np.std(taps[0]) > 0.1 > 20.0 * np.std(taps[1])


def test_noise_has_the_deviation_that_is_stated_and_follows_the_seed():
    rig = with_transducers(**NOISY)
    still = {"time": np.arange(2000) * 1e-3, "command": 0.0}
    runs = [simulate(rig, seed=seed, **still) for seed in (1, 1, 2)]
    for channel, deviation in (("displacement", 20e-6), ("pressure_a", 500.0)):
        one, same, other = (run[channel] for run in runs)
        np.testing.assert_array_equal(one, same)
        assert not np.array_equal(one, other)
        # 2000 samples know a deviation to 1/sqrt(4000), here within four of that.
        assert np.std(one) == pytest.approx(deviation, rel=4.0 / np.sqrt(4000.0))
    # Each transducer draws from a stream of its own.
    assert abs(np.corrcoef(runs[0]["pressure_a"], runs[0]["pressure_b"])[0, 1]) < 4.0 / np.sqrt(2e3)
    quieter = with_transducers(pressure=NOISY["pressure"])
    found = simulate(quieter, seed=1, **still)
    np.testing.assert_array_equal(found["pressure_a"], runs[0]["pressure_a"])
    assert np.ptp(found["displacement"]) == 0.0


def test_noise_of_the_pressures_moves_nothing():
    plain = simulate(with_transducers(pressure=Transducer()), controller=SlidingMode(), **LOOP)
    noisy = simulate(with_transducers(pressure=NOISY["pressure"]), controller=SlidingMode(), **LOOP)
    np.testing.assert_array_equal(noisy["displacement"], plain["displacement"])
    assert np.abs(noisy["pressure_a"] - plain["pressure_a"]).max() > 500.0


def test_beyond_its_range_a_transducer_stands_still():
    rig = with_transducers(displacement=Transducer(0.0, 0.0, 0.017), pressure=Transducer(0.0, 4e5))
    run = simulate(rig, controller=Proportional(0.5), **LOOP)
    assert run["displacement"].max() == 0.017
    assert np.all(run["velocity"][run["displacement"] == 0.017] == 0.0)
    assert run["pressure_a"].min() >= 4e5
    # The controller goes on pushing for 3 mm that it does not see, so that the piston runs away.
    assert run["valve_voltage"][-1] == pytest.approx(0.5 * SENSITIVITY * 0.003)


def test_a_batch_has_the_noise_of_its_runs_in_any_number_of_threads():
    rig = with_transducers(**NOISY)
    masses = np.array([1.7, 1.8, 1.9])
    values, channels = {"load.mass": masses}, ("displacement", "surface")
    batches = [
        simulate_batch(
            rig, values, controller=SlidingMode(), channels=channels, jobs=jobs, seed=5, **LOOP
        )
        for jobs in (1, 2)
    ]
    for name in channels:
        np.testing.assert_array_equal(batches[0][name], batches[1][name])
    for i, mass in enumerate(masses):
        one = simulate(
            rig.with_values({"load.mass": mass}), controller=SlidingMode(), seed=(5, i), **LOOP
        )
        np.testing.assert_array_equal(batches[0]["displacement"][i], one["displacement"])


def test_a_test_volume_has_its_transducer_too():
    volume = load_rig("dead-volume")
    noisy = dataclasses.replace(volume, transducers={"pressure": Transducer(500.0, 0.0, 5e5)})
    charge = {"time": np.arange(500) * 1e-3, "command": 5.0}
    plain, found = (simulate_dead_volume(rig, **charge) for rig in (volume, noisy))
    rising = plain["dead_volume_pressure"] < 4.9e5
    left = (found["dead_volume_pressure"] - plain["dead_volume_pressure"])[rising]
    assert np.std(left) == pytest.approx(500.0, rel=4.0 / np.sqrt(2.0 * rising.sum()))
    assert found["dead_volume_pressure"].max() == 5e5


def test_a_rig_file_states_them_and_the_command_line_seeds_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "noisy.toml").write_text(
        '[rig]\nkind = "single-axis"\n[transducers.displacement]\nnoise = "20 um"\n'
        'range = ["0 mm", "30 mm"]\n'
    )
    found = dataclasses.astuple(load_rig("noisy.toml").transducers["displacement"])
    assert found == pytest.approx((20e-6, 0.0, 0.03))
    arguments = ["simulate", "--rig", "noisy.toml", "--controller", "proportional", "--json"]
    arguments += ["--demand", "15,20 mm", "--hold", "0.1 s"]
    errors = []
    for seed in ("1", "1", "2"):
        done = CliRunner().invoke(main, [*arguments, "--seed", seed])
        assert done.exit_code == 0, done.output
        errors.append(json.loads(done.stdout)["steady_state_error"])
    assert errors[0] == errors[1] != errors[2]


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('[transducers.displacment]\nnoise = "1 um"', "Did you mean 'displacement'"),
        ('[transducers.displacement]\nnoise = "1 bar"', "a length is needed"),
        ('[transducers.displacement]\nnoise = "-1 um"', "0 or more"),
        ('[transducers.pressure]\nrange = ["5 bar", "1 bar"]', "has to be rising"),
        ("[transducers.pressure]\nrange = 3", "has to be a pair"),
        ("[transducers.pressure]\nnois = 3", "Did you mean 'noise'"),
        ("[transducers]\npressure = 3", "has to be a table"),
    ],
)
def test_unusable_transducers_are_refused(tmp_path, table, message):
    (tmp_path / "rig.toml").write_text(f'[rig]\nkind = "single-axis"\n{table}\n')
    with pytest.raises(InputError, match=message):
        load_rig(tmp_path / "rig.toml")


def test_other_rigs_and_seeds_are_refused(tmp_path):
    (tmp_path / "rig.toml").write_text('[rig]\nkind = "circuit"\n[transducers.pressure]\n')
    with pytest.raises(InputError, match="kind circuit"):
        load_rig(tmp_path / "rig.toml")
    with pytest.raises(InputError, match="seed is -1"):
        simulate(with_transducers(**NOISY), time=TIME, command=0.0, seed=-1)


def test_the_behaviour_of_the_card_takes_rounded_times_beside_noise():
    # At 3 kHz, written with a microsecond: off by a thousandth of the interval.
    time = np.round(np.arange(0.0, 0.02, 1.0 / 3000.0), 6)
    run = simulate(
        with_transducers(**NOISY), time=time, controller=card_of(load_design()), demand=0.015
    )
    assert np.isfinite(run["card_velocity"]).all()


def test_a_card_hears_no_noise_of_a_transducer_at_its_limit():
    time = np.arange(0.0, 0.1, 1e-3)
    short = Transducer(noise=20e-6, high=0.010)
    run = simulate(
        with_transducers(displacement=short), time=time, controller=card_of(load_design()),
        demand=0.015,
    )  # fmt: skip
    assert np.all(run["displacement"] == 0.010)
    assert np.std(run["card_velocity"][50:]) < 1e-4
