"""Least squares on the force balance, with the four measures."""

from dataclasses import replace

import numpy as np
import pytest

from pneuservo.errors import InputError
from pneuservo.identification import (
    identify_each,
    identify_least_squares,
    simulate_excitation,
)
from pneuservo.identification.least_squares import PARAMETERS
from pneuservo.identification.signals import even, filtered, force_balance
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig

# Section 4.3.2.1 of the thesis.
SYNTHETIC = {
    "load.mass": 7.0,
    "piston.viscous_friction": 100.0,
    "piston.coulomb_friction": 15.0,
}
RIG = load_rig("single-axis")
AREA_A, AREA_B, AMBIENT = 490.87e-6, 412.33e-6, 1.013e5


def shaken(mass, viscous, coulomb, difference=0.0, rate=500.0, duration=10.0):
    """A recording worked out by hand: two sines, and the pressure a that this motion takes."""
    time = np.arange(round(duration * rate)) / rate
    x, v, a = 0.015, 0.0, 0.0
    for amplitude, frequency in ((3e-3, 2.0), (1e-3, 7.3)):
        w = 2.0 * np.pi * frequency
        x = x + amplitude * np.sin(w * time)
        v = v + amplitude * w * np.cos(w * time)
        a = a - amplitude * w * w * np.sin(w * time)
    force = mass * (a - 9.81) + viscous * v + coulomb * np.sign(v) + difference
    pressure_b = np.full_like(time, 5e5)
    pressure_a = (force + pressure_b * AREA_B + AMBIENT * (AREA_A - AREA_B)) / AREA_A
    channels = {"displacement": x, "pressure_a": pressure_a, "pressure_b": pressure_b}
    return Recording("shaken", time, channels)


def values(found):
    return [found.parameters[name] for name in PARAMETERS]


def test_a_motion_without_friction_gives_the_mass():
    found = identify_least_squares([shaken(7.0, 0.0, 0.0)])
    # The centred second difference is low by (w h)^2/12 at each frequency: 0.07 % at 7.3 Hz.
    assert found.parameters["load.mass"] == pytest.approx(7.0, rel=1e-3)
    assert found.parameters["piston.viscous_friction"] == pytest.approx(0.0, abs=0.5)


@pytest.mark.parametrize("truth", [(1.825, 102.53, 1.013), (7.0, 100.0, 15.0)])
def test_mass_and_friction_of_a_motion_worked_out_by_hand(truth):
    found = identify_least_squares([shaken(*truth)])
    # The filter takes up to 0.1 % of motion at 7 Hz, and a little of every reversal.
    assert values(found) == pytest.approx(truth, rel=5e-3)


def test_each_direction_by_itself_finds_what_differs_between_them():
    # (4.54): 4 N more when extending, 4 N less when retracting.
    recording = shaken(7.0, 100.0, 15.0, difference=4.0)
    found = {way: entry for (_, way), entry in identify_each([recording]).items()}
    extending = found["extending"].parameters["piston.coulomb_friction"]
    retracting = found["retracting"].parameters["piston.coulomb_friction"]
    # Half of the samples of before.
    assert extending == pytest.approx(19.0, rel=0.01)
    assert retracting == pytest.approx(11.0, rel=0.01)


def test_three_positions_give_one_answer_where_friction_is_the_same():
    recordings = [
        simulate_excitation(centre=centre, duration=8.0, seed=k)
        for k, centre in enumerate((0.012, 0.015, 0.018))
    ]
    found = identify_each(recordings)
    assert len(found) == 6
    # Table 4.6 of the thesis from data simulated with table 4.7: 8 s instead of its 60 s, so that
    # chance adds some 2 % of friction to the 1.5 % that the filter costs.
    for entry in found.values():
        assert entry.parameters["load.mass"] == pytest.approx(1.825, abs=0.015)
        assert entry.parameters["piston.viscous_friction"] == pytest.approx(102.5, abs=5.0)
        assert entry.parameters["piston.coulomb_friction"] == pytest.approx(1.013, abs=0.35)


def test_500_points_recover_all_three_of_the_thesis():
    rig = RIG.with_values(SYNTHETIC)
    found = [
        values(
            identify_least_squares(
                [simulate_excitation(rig, duration=4.0, amplitude=0.004, seed=seed, held=True)],
                rig,
                most_points=500,
            )
        )
        for seed in range(6)
    ]
    mean, spread = np.mean(found, axis=0), np.std(found, axis=0)
    # Standard deviations over 20 seeds: 0.007 kg, 2.9 N s/m, 0.23 N. Three of them of the mean of
    # six; noise of the displacement takes 0.01 kg off the mass.
    assert abs(mean[0] - 7.0) < 0.01 + 3.0 * 0.007 / np.sqrt(6.0)
    assert abs(mean[1] - 100.0) < 3.0 * 2.9 / np.sqrt(6.0)
    assert abs(mean[2] - 15.0) < 3.0 * 0.23 / np.sqrt(6.0)
    # Twice the standard deviations: of six values more than that has a chance below 1 %.
    assert np.all(spread < [0.014, 5.8, 0.46])


def test_the_filter_delays_nothing():
    time = np.arange(2000) / 500.0
    slow = np.sin(2.0 * np.pi * 5.0 * time)
    middle = slice(200, -200)
    # Forwards and backwards: 1/(1 + (5/50)^4) of the amplitude, no phase; the digital filter's
    # frequency is warped by up to (pi 50/500)^2/3 = 3 % at its cut-off, four times that in f^4.
    assert filtered(slow, 2e-3)[middle] == pytest.approx(slow[middle] / (1 + 1e-4), abs=2e-5)


def test_samples_are_made_even_and_whole():
    recording = shaken(1.8, 100.0, 1.0, duration=1.0)
    time = recording.time.copy()
    time[1:-1] += 2e-4 * np.sin(np.arange(len(time) - 2))
    gap = recording["displacement"].copy()
    gap[100:103] = np.nan
    jittered = replace(recording, time=time, channels={**recording.channels, "displacement": gap})
    steps, samples = even(jittered, ("displacement",))
    assert np.diff(steps) == pytest.approx(np.median(np.diff(time)))
    assert np.isfinite(samples["displacement"]).all()


def test_the_piston_at_its_stop_is_left_out():
    recording = shaken(7.0, 100.0, 15.0)
    x = recording["displacement"] - 0.0135
    balance = force_balance(
        replace(recording, channels={**recording.channels, "displacement": np.maximum(x, 0.0)}),
        RIG,
    )
    touching = x[1:-1] < 0.0
    assert touching.any()
    assert not balance.free[touching].any()


def test_a_recording_at_rest_is_refused():
    still = shaken(7.0, 100.0, 15.0)
    still = replace(still, channels={**still.channels, "displacement": np.full(len(still), 0.015)})
    with pytest.raises(InputError, match="at least 30 are needed"):
        identify_least_squares([still])


def test_a_missing_pressure_is_named():
    recording = shaken(7.0, 100.0, 15.0)
    channels = {name: recording[name] for name in ("displacement", "pressure_a")}
    with pytest.raises(InputError, match="pressure_b is not there"):
        identify_least_squares([replace(recording, channels=channels)])


def test_an_unknown_direction_is_refused():
    with pytest.raises(InputError, match="direction"):
        identify_least_squares([shaken(7.0, 100.0, 15.0)], direction="up")
