"""Assertions of closed loops: they pass what is within, and say of what is not where and when."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analog_card.errors import InputError as QuantityError
from pneuservo.controllers import DigitalSlidingMode, Proportional, SlidingMode
from pneuservo.errors import InputError
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import Simulation, simulate, step_demand
from pneuservo.simulation.metrics import control_effort
from pneuservo.testing import (
    assert_chatter_below,
    assert_control_effort_below,
    assert_no_sustained_oscillation,
    assert_overshoot_below,
    assert_robust,
    assert_settles_within,
    assert_steady_state_error_below,
    close_loop,
    closed_loops,
)

TIME = np.arange(1000) * 1e-3
DEMAND = np.where(TIME < 0.5, 0.01, 0.02)


def answer(rate=20.0, overshoot=0.0, error=0.0, swing=0.0):
    """Return a made-up run: an exponential with a first-order overshoot, an error, a swing."""
    since = np.maximum(TIME - 0.5, 0.0)
    progress = 1.0 - np.exp(-rate * since)
    # Peaks at 1 where rate * since is 1, and is gone long before the end.
    bump = overshoot * math.e * rate * since * np.exp(-rate * since)
    displacement = 0.01 + (0.01 - error) * (progress + bump)
    voltage = swing / 2 * np.sin(2 * np.pi * 100.0 * TIME)
    channels = {"demand": DEMAND, "displacement": displacement, "valve_voltage": voltage}
    return Simulation(load_rig("single-axis"), TIME, channels, SlidingMode())


def test_settling_time_is_measured_and_told():
    run = answer(rate=20.0)
    # ln(50)/20 = 0.1956 s to 2 %, and one sample more at the most.
    assert_settles_within(run, "196.7 ms")
    with pytest.raises(AssertionError) as failed:
        assert_settles_within(run, "195 ms")
    lines = str(failed.value).splitlines()
    assert lines[0] == (
        "step from 10 to 20 mm at t = 0.5 s: settles after 196 ms, 195 ms is allowed, to 2 % of "
        "the step"
    )
    assert lines[1:] == [
        "  rig: single-axis",
        "  controller: sliding-mode, settling_time = 0.07, damping = 1, boundary_layer = 5, "
        "level = 5",
    ]
    # ln(20)/20 = 0.1498 s to 5 %.
    assert_settles_within(run, 0.151, band="5 %")
    with pytest.raises(AssertionError, match=r"has not settled when it ends at t = 0\.999 s"):
        assert_settles_within(answer(rate=3.0), "10 s")


def test_every_step_counts_and_every_failure_is_told():
    time, demand = step_demand([0.015, 0.024, 0.006], 0.5, 1000.0)
    run = simulate(time=time, demand=demand, controller=SlidingMode())
    first, second = (step.settling_time for step in run.step_responses())
    assert_settles_within(run, max(first, second))
    with pytest.raises(AssertionError) as failed:
        assert_settles_within(run, (first + second) / 2)
    assert str(failed.value).count("settles after") == 1
    with pytest.raises(AssertionError) as failed:
        assert_settles_within(run, "10 ms")
    assert str(failed.value).count("settles after") == 2


def test_overshoot():
    run = answer(overshoot=0.1)
    # 1 - e**-1 + 0.1 e at the peak of the bump is below 1; the peak of the sum lies later.
    progress = 1.0 - np.exp(-np.linspace(0, 10, 10001)) * (
        1.0 - 0.1 * math.e * np.linspace(0, 10, 10001)
    )
    expected = progress.max() - 1.0
    assert_overshoot_below(run, expected + 1e-4)
    with pytest.raises(AssertionError, match=r"overshoots by .* %, .* % is allowed"):
        assert_overshoot_below(run, expected - 1e-3)
    # What is left of the approach in the last fifth, e**-40, is rounding.
    assert_overshoot_below(answer(rate=100.0), 1e-12)


def test_a_loop_that_does_nothing_passes_neither():
    lazy = answer(rate=0.0)
    with pytest.raises(AssertionError, match="has not settled"):
        assert_settles_within(lazy, "1 s")
    with pytest.raises(AssertionError, match="does not answer"):
        assert_overshoot_below(lazy, "5 %")


def test_steady_state_error_either_way():
    for error in (1e-4, -1e-4):
        run = answer(rate=100.0, error=error)
        assert_steady_state_error_below(run, "0.101 mm")
        with pytest.raises(AssertionError, match=r"100 .m is left when it ends at t = 0\.999 s"):
            assert_steady_state_error_below(run, "0.099 mm")


def test_chatter_of_a_channel():
    run = answer(swing=0.2)
    # The line through ten periods adds a tenth at the most.
    assert_chatter_below(run, "0.22 V")
    with pytest.raises(AssertionError, match=r"valve_voltage swings by .* from t = 0\.4 to 0\.499"):
        assert_chatter_below(run, "0.15 V")
    assert_chatter_below(answer(rate=100.0), "1 um", channel="displacement")
    with pytest.raises(QuantityError, match="limit: '1 um' has the unit of a length"):
        assert_chatter_below(run, "1 um")


def test_control_effort():
    run = answer(swing=2.0)
    assert_control_effort_below(run, 0.71)
    with pytest.raises(AssertionError, match=r"707 mV rms from t = 0 to 0\.999 s, 700 mV"):
        assert_control_effort_below(run, "0.7 V")
    assert control_effort(run.time, run["valve_voltage"]) == pytest.approx(math.sqrt(0.5), rel=1e-3)


def test_sustained_oscillations_of_real_loops():
    quiet = close_loop("sliding-mode", demand="15,24 mm")
    assert_no_sustained_oscillation(quiet)
    relay = close_loop("sliding-mode", demand="15,24 mm", boundary_layer=0.0, rate="5 kHz")
    with pytest.raises(AssertionError, match=r"oscillates at \d+(\.\d)? Hz, \d+ periods from t = "):
        assert_no_sustained_oscillation(relay)
    # It moves the piston by micrometres.
    assert_no_sustained_oscillation(relay, stroke="1 mm")
    swinging = close_loop(Proportional(gain=5.0), demand="15,24 mm", hold="1 s")
    cycle = swinging.limit_cycle()
    with pytest.raises(AssertionError, match=rf"oscillates at {cycle.frequency:.4g} Hz"):
        assert_no_sustained_oscillation(swinging)


def test_a_recording_is_judged_like_a_simulation():
    run = close_loop("sliding-mode", demand="15,24 mm", values={"load.mass": "6.8 kg"})
    recording = run.to_recording("bench")
    assert_settles_within(recording, "150 ms")
    with pytest.raises(AssertionError) as failed:
        assert_settles_within(recording, "50 ms")
    assert "rig: single-axis, load_mass = 6.8" in str(failed.value)
    assert "controller: bench" in str(failed.value)
    holed = np.array(recording["displacement"])
    holed[3] = math.nan
    channels = {**recording.channels, "displacement": holed}
    with pytest.raises(InputError, match=r"1 of \d+ samples are missing, the first at t = 0\.003"):
        assert_settles_within(replace(recording, channels=channels), "150 ms")


@pytest.mark.parametrize(
    ("assertion", "says"),
    [
        (lambda run: assert_settles_within(run, "70 mm"), "limit"),
        (lambda run: assert_settles_within(run, "1 s", band=1), "band is 1; it has to be between"),
        (lambda run: assert_settles_within(run, "1 s", band=1e300), "band is 1e.300"),
        (lambda run: assert_settles_within(run, "1 s", band=0.0), "band is 0"),
        (lambda run: assert_settles_within(None, "1 s"), "None is no run; give a simulation"),
        (lambda run: assert_control_effort_below("run.csv", 1.0), "'run.csv' is no run"),
        (lambda run: assert_overshoot_below(run, -0.1), "cannot be below 0"),
        (lambda run: assert_chatter_below(run, 1.0, channel="card_output"), "card_output"),
    ],
)
def test_mistakes_are_no_failures(assertion, says):
    with pytest.raises((InputError, QuantityError), match=says):
        assertion(answer())


def test_a_run_that_says_nothing_passes_nothing():
    still = Recording("still", TIME, {"demand": DEMAND * 0.0, "displacement": DEMAND})
    for assertion in (assert_settles_within, assert_overshoot_below):
        with pytest.raises(InputError, match="no step to judge"):
            assertion(still, 1.0)
    with pytest.raises(InputError, match="no channel 'demand'"):
        assert_settles_within(Recording("open", TIME, {"displacement": DEMAND}), 1.0)
    with pytest.raises(InputError, match="nothing is asserted"):
        assert_robust({"one": still})
    with pytest.raises(InputError, match="no run"):
        assert_robust({}, assert_no_sustained_oscillation)
    with pytest.raises(InputError, match="share is 0"):
        assert_robust({"one": still}, assert_no_sustained_oscillation, share=0.0)


def test_robust_over_a_set_names_what_fails():
    runs = {"first": answer(20.0), "second": answer(10.0), "third": answer(40.0, overshoot=0.4)}
    checks = (
        lambda run: assert_settles_within(run, "250 ms"),
        lambda run: assert_overshoot_below(run, "2 %"),
    )
    with pytest.raises(AssertionError) as failed:
        assert_robust(runs, *checks)
    text = str(failed.value)
    assert text.startswith("2 of 3 rigs fail, all have to pass\nsecond:\n  step from 10")
    assert "third:\n  step from 10 to 20 mm at t = 0.5 s: overshoots" in text
    assert "first" not in text
    with pytest.raises(AssertionError, match=r"2 of 3 rigs fail, 50 % have to pass"):
        assert_robust(runs.items(), *checks, share=0.5)
    assert_robust(runs.items(), *checks, share=1 / 3)


def test_loops_of_a_set_are_those_of_one_rig_each():
    varied = dict(closed_loops("sliding-mode", {"load.mass": "1.8, 7 kg"}, demand="15,24 mm"))
    assert list(varied) == ["load.mass 1.8 kg", "load.mass 7 kg"]
    alone = close_loop("sliding-mode", demand="15,24 mm", values={"load.mass": 7.0})
    one = varied["load.mass 7 kg"]
    np.testing.assert_array_equal(one["displacement"], alone["displacement"])
    # The same controller as an object, and shaped by an option.
    own = dict(closed_loops(SlidingMode(0.09), {"load.mass": "7 kg"}, demand="15,24 mm"))
    shaped = closed_loops(
        "sliding-mode", {"load.mass": "7 kg"}, demand="15,24 mm", settling_time="90 ms"
    )
    ((name, run),) = shaped
    assert name == "load.mass 7 kg"
    np.testing.assert_array_equal(run["displacement"], own[name]["displacement"])
    assert run.settling_time() > one.settling_time()


@pytest.mark.parametrize("controller", ["digital-sliding-mode", DigitalSlidingMode()])
def test_trials_of_a_noisy_rig_differ(tmp_path, controller):
    (tmp_path / "noisy.toml").write_text(
        '[rig]\nkind = "single-axis"\n[transducers.displacement]\nnoise = "20 um"\n'
    )

    def displacements(seed):
        loops = closed_loops(
            controller,
            {"load.mass": "1.825 kg"},
            rig=str(tmp_path / "noisy.toml"),
            demand="15,24 mm",
            hold="0.05 s",
            trials=3,
            seed=seed,
        )
        return [run["displacement"].tolist() for _, run in loops]

    first, second, third = displacements(0)
    assert first != second != third != first
    assert displacements(0) == [first, second, third]
    assert displacements(1)[0] != first


def test_loops_that_cannot_be():
    with pytest.raises(InputError, match="shaped already"):
        close_loop(SlidingMode(), damping=0.7)
    with pytest.raises(InputError, match="shaped already"):
        next(closed_loops(SlidingMode(), {"controller.level": "1, 2 V"}))
    for loop in (close_loop, lambda *given, **named: next(closed_loops(*given, {}, **named))):
        with pytest.raises(InputError, match=r"demand is \[15, 24\]; give a text .*15,24,6,15 mm"):
            loop("sliding-mode", demand=[15, 24])
        for controller in (3, None, SlidingMode):
            with pytest.raises(InputError, match=r"controller is .*; give the name of one"):
                loop(controller)
    with pytest.raises(InputError, match=r"load\.mass"):
        close_loop("sliding-mode", values={"load.mas": 1.0})
    with pytest.raises(InputError, match=r"rig with load\.mass -1 kg: .*load\.mass is -1"):
        list(closed_loops("sliding-mode", {"load.mass": "-1 kg"}))
