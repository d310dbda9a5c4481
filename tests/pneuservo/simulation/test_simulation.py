"""The simulation as users call it."""

import dataclasses
import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from analog_card.figures import CardFigures
from analog_card.tuning import tune
from pneuservo.animated_figure import load_figure, simulate_figure
from pneuservo.controllers import AnalogueCard, Proportional, SlidingMode, StateFeedback
from pneuservo.errors import InputError
from pneuservo.recordings import CHANNELS, Recording, read_recording, write_recording
from pneuservo.rigs import load_rig
from pneuservo.simulation import (
    InitialState,
    limit_cycle,
    replay,
    simulate,
    simulate_batch,
    simulate_dead_volume,
    step_demand,
    step_responses,
)

TIME = np.arange(0.0, 0.1, 1e-3)
DEFAULT_CARD = tune(settling_time=0.07).figures


def steps(controller, rate=1e3, hold=0.5):
    time, demand = step_demand([0.015, 0.024], hold=hold, rate=rate)
    return simulate(time=time, controller=controller, demand=demand)


def card(**changes):
    return AnalogueCard(CardFigures(**{**vars(DEFAULT_CARD), **changes}))


def test_start_at_rest_in_balance():
    run = simulate(time=TIME, command=0.0)
    assert run["pressure_b"][0] == pytest.approx(0.75 * 6.5e5)
    # From the force balance by hand: (201.012 + 7.956 - 17.903) N on 490.87 mm2.
    assert run["pressure_a"][0] == pytest.approx(389234.882963, rel=1e-9)
    for name in ("displacement", "pressure_a", "pressure_b"):
        assert np.ptp(run[name]) == 0.0


def test_one_known_pressure_balances_the_other():
    run = simulate(time=TIME, command=0.0, initial=InitialState(pressure_a=389234.882963))
    assert run["pressure_b"][0] == pytest.approx(487500.0, rel=1e-9)
    loaded = simulate(time=TIME, command=0.0, external_force=50.0)
    assert loaded["displacement"][-1] == loaded["displacement"][0]
    assert loaded["pressure_a"][0] - run["pressure_a"][0] == pytest.approx(50.0 / 490.87e-6)


def test_result_knows_what_made_it():
    run = steps(SlidingMode())
    assert len(run) == len(run.time) == 1000
    assert "demand" in run
    assert "force" not in run
    assert set(run.channels) <= set(CHANNELS)
    assert run.controller.kind == "sliding-mode"
    assert run.rig.kind == "single-axis"


def test_sliding_mode_answers_as_designed():
    run = steps(SlidingMode(settling_time=0.07, boundary_layer=5.0))
    (step,) = run.step_responses()
    # Two poles at 57 rad/s reach 63 % after 38 ms and 2 % after 102 ms; the boundary layer lags.
    assert step.rise_time == pytest.approx(0.038, abs=0.01)
    assert step.settling_time == run.settling_time() == pytest.approx(0.12, abs=0.02)
    assert step.overshoot < 1e-3
    assert abs(run.steady_state_error()) < 2e-6
    assert run.limit_cycle() is None


def test_relay_has_a_limit_cycle_and_an_error():
    run = steps(SlidingMode(boundary_layer=0.0), rate=1e4)
    assert set(np.unique(run["valve_voltage"])) == {-5.0, 5.0}
    assert run.limit_cycle().frequency == pytest.approx(212.3, rel=1e-2)
    assert run.steady_state_error() == pytest.approx(-0.17e-3, rel=0.05)


def test_proportional_and_state_feedback_act_on_transducer_volts():
    run = simulate(
        time=TIME, controller=Proportional(gain=1.0), demand=0.02, initial=InitialState(0.015)
    )
    assert run["valve_voltage"][0] == pytest.approx(5e-3 * 10.0 / 0.03)
    run = simulate(
        time=TIME,
        controller=StateFeedback(0.2, 0.03, 0.0),
        demand=0.02,
        initial=InitialState(0.015, velocity=0.1),
    )
    assert run["valve_voltage"][0] == pytest.approx((0.2 * 5e-3 - 0.03 * 0.1) * 10.0 / 0.03)


def test_card_with_fast_differentiators_is_the_ideal_controller():
    ideal = steps(SlidingMode(), hold=0.1)
    slow = steps(card(), hold=0.1)
    fast = steps(card(velocity_breaks=(4e4, 4e4), acceleration_breaks=(4e4, 4e4)), hold=0.1)
    distance = [np.abs(run["displacement"] - ideal["displacement"]).max() for run in (slow, fast)]
    # What the differentiators leave behind goes with their lag, 14 times shorter.
    assert distance[1] < 0.1 * distance[0]
    assert distance[1] < 2e-5


def test_card_taps_are_those_of_the_figures():
    run = steps(card(), hold=0.1)
    figures = DEFAULT_CARD
    demand = run["demand"] * 10.0 / 0.03
    surface = (
        figures.weight_displacement * (demand - run["card_sensor"])
        + figures.weight_velocity * run["card_velocity"]
        - figures.weight_acceleration * run["card_acceleration"]
    )
    np.testing.assert_allclose(run["card_surface"], np.clip(surface, -13.0, 13.0), atol=1e-12)
    output = np.clip(figures.output_gain * run["card_surface"], -figures.level, figures.level)
    np.testing.assert_allclose(run["card_output"], output, atol=1e-12)
    # Well below the breaks the first tap is -RC S v.
    assert run["card_velocity"].min() == pytest.approx(
        -figures.rc_velocity * 10.0 / 0.03 * run["velocity"].max(), rel=0.02
    )


@pytest.mark.parametrize(
    ("changes", "outputs"),
    [
        ({"output_gain": math.inf}, {-5.0, 5.0}),
        ({"output_gain": 0.0}, {0.0}),
        ({"level": 0.0}, {0.0}),
        ({"surface_limit": 0.0}, {0.0}),
    ],
)
def test_limits_of_the_card(changes, outputs):
    run = steps(card(**{"level": 5.0, **changes}), hold=0.1)
    assert {float(value) for value in np.unique(run["card_output"])} == outputs


def test_a_run_reads_back_and_replays_to_itself(tmp_path):
    rig = load_rig("single-axis").with_values({"load.mass": 3.0, "supply.pressure": 7e5})
    run = simulate(rig, time=TIME, command=2.0 * np.sin(60.0 * TIME), external_force=3.0)
    path = write_recording(run.to_recording("sine"), tmp_path / "sine.csv")
    back = read_recording(path)
    assert back.conditions == pytest.approx({"load_mass": 3.0, "supply_pressure": 7e5})
    again = replay(back)
    for name in run.channels:
        np.testing.assert_array_equal(again[name], run[name])


def test_the_supply_is_recorded_where_it_varies():
    rig = load_rig("single-axis")
    rising = {f"v{k}": 0.01 * k for k in range(9)}
    drift = {"of": 6.0, "low": 0.0, "high": float(TIME[-1]), **rising}
    drifting = dataclasses.replace(rig, effects={"unexplained.drift": drift})
    supply = simulate(drifting, time=TIME, command=1.0).channels["supply_pressure"]
    share = TIME / TIME[-1]
    np.testing.assert_allclose(supply, rig["supply.pressure"] * (1.0 + 0.08 * share), rtol=1e-9)
    assert "supply_pressure" not in simulate(rig, time=TIME, command=1.0).channels


def test_replay_starts_where_the_recording_does():
    first = {"displacement": 0.031, "velocity": -0.05, "pressure_a": 5e5, "spool": -0.2}
    channels = {name: np.full(100, value) for name, value in first.items()}
    channels["valve_voltage"] = np.full(100, -1.0)
    channels["pressure_b"] = np.full(100, np.nan)
    warnings = []
    run = replay(Recording("r", TIME, channels), warn=warnings.append)
    assert run["displacement"][0] == 0.03  # a little beyond the stop is noise
    assert run["velocity"][0] == -0.05
    assert run["pressure_a"][0] == 5e5
    assert run["spool"][0] == -0.2
    assert len(warnings) == 1
    assert "pressure_b is missing" in warnings[0]


@pytest.mark.parametrize(("voltage", "start", "port"), [(5.0, 1e5, "a"), (-5.0, 1e5, "b")])
def test_replay_tells_the_port_of_a_test_volume(voltage, start, port):
    run = simulate_dead_volume(time=TIME, command=voltage, port=port, initial_pressure=start)
    recording = run.to_recording()
    np.testing.assert_array_equal(
        replay(recording)["dead_volume_pressure"], run["dead_volume_pressure"]
    )
    other = replay(recording, port="b" if port == "a" else "a")
    assert not np.array_equal(other["dead_volume_pressure"], run["dead_volume_pressure"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"command": [0.0, math.nan, 0.0]}, "command is nan at sample 1"),
        ({"command": [0.0, 0.0]}, "command has the shape"),
        ({}, "either a command or a controller"),
        ({"controller": SlidingMode()}, "needs a demand"),
        ({"command": 0.0, "rig": "circuit"}, "kind circuit; single-axis is needed"),
        ({"command": 0.0, "time": [0.0, 2.0, 1.0]}, "does not increase: 2 s is followed by 1 s"),
        ({"command": 0.0, "time": [0.0]}, "two or more times"),
        ({"command": 0.0, "time": [0.0, 1.0, 1e9]}, "Check the unit"),
        ({"command": 0.0, "initial": InitialState(displacement=0.031)}, "from 0 to 0.03 m"),
        ({"command": 0.0, "initial": InitialState(pressure_a=-1.0)}, "greater than 0"),
        ({"command": 0.0, "initial": InitialState(spool=2.0)}, "from -1 to 1"),
        ({"command": 0.0, "largest_step": 0.0}, "largest_step"),
    ],
)
def test_unusable_arguments_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        simulate(**{"time": [0.0, 0.1, 0.2], **arguments})


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"load.mass": 0.0}, "load.mass is 0 kg; it has to be greater than 0"),
        ({"gas.isentropic_exponent": 1.0}, "gas.isentropic_exponent is 1; .* greater than 1"),
        ({"load.mass": 1e-9}, "stops being finite"),
        ({"valve.spool.frequency": 1e12}, "is 1e.12 Hz; .* 100000 Hz at most"),
    ],
)
def test_impossible_rigs_are_refused(values, message):
    rig = load_rig("single-axis").with_values(values)
    with pytest.raises(InputError, match=message):
        simulate(rig, time=TIME, command=1.0)


def test_a_spool_that_no_valve_has_is_refused_wherever_it_would_be_stepped_through():
    fast = {"valve.spool.frequency": 1e12}
    with pytest.raises(InputError, match=r"valve\.spool\.frequency is 1e\+12 Hz"):
        simulate_batch(values=fast, time=TIME, command=1.0)
    rig = load_rig("single-axis").with_values(fast)
    figure = load_figure("arm")
    axes = {name: dataclasses.replace(axis, rig=rig) for name, axis in figure.axes.items()}
    with pytest.raises(InputError, match=r"valve\.spool\.frequency is 1e\+12 Hz"):
        simulate_figure(
            dataclasses.replace(figure, axes=axes), time=TIME, controller=SlidingMode(), demands={}
        )


def test_effects_beyond_the_baseline_are_refused(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text('[rig]\nkind = "single-axis"\n[effects."friction.pressure"]\nk_p = 1e-5\n')
    with pytest.raises(InputError, match=r"friction\.pressure"):
        simulate(str(path), time=TIME, command=0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SlidingMode(settling_time=0.0), "settling_time is 0; .* greater than 0"),
        (lambda: SlidingMode(boundary_layer=-1.0), "boundary_layer is -1; .* 0 or more"),
        (lambda: Proportional(gain=math.nan), "gain is nan"),
        (lambda: StateFeedback(velocity_gain=math.inf), "velocity_gain is inf; .* finite"),
        (lambda: card(velocity_breaks=(0.0, 1.0)), "break frequency is 0"),
    ],
)
def test_impossible_controllers_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_limit_cycle_of_known_signals():
    time = np.arange(0.0, 1.0, 1e-3)
    swing = np.sin(2.0 * np.pi * 37.0 * time) + 0.2
    cycle = limit_cycle(time, swing)
    # Linear interpolation of a sine at 27 samples a period.
    assert cycle.frequency == pytest.approx(37.0, rel=1e-4)
    assert (cycle.low, cycle.high) == pytest.approx((-0.8, 1.2), rel=0.01)
    assert limit_cycle(time, np.exp(-10.0 * time) * swing) is None
    assert limit_cycle(time, np.sin(2.0 * np.pi * 4.0 * time)) is None
    assert limit_cycle(time, np.ones_like(time)) is None
    # Ripple about zero at every crossing is not a period of its own.
    rippled = np.sin(2.0 * np.pi * 10.0 * time) + 0.02 * np.sin(2.0 * np.pi * 400.0 * time)
    assert limit_cycle(time, rippled).frequency == pytest.approx(10.0, rel=1e-2)


def test_step_response_of_a_known_answer():
    time = np.arange(0.0, 2.0, 1e-3)
    demand = np.where(time < 0.5, 0.0, 1.0)
    answer = np.where(time < 0.5, 0.0, 0.9 * (1.0 - np.exp(-(time - 0.5) / 0.1)))
    (step,) = step_responses(time, demand, answer)
    # On the samples' 1 ms; 2 % of the step about a final value of 0.9.
    assert step.rise_time == pytest.approx(0.1, abs=1.1e-3)
    assert step.settling_time == pytest.approx(0.1 * math.log(0.9 / 0.02), abs=1.1e-3)
    assert step.steady_state_error == pytest.approx(0.1, abs=1e-5)
    creeping = step_responses(time, demand, np.where(time < 0.5, 0.0, time - 0.5))
    assert math.isnan(creeping[0].settling_time)
    assert step_responses(time, np.zeros_like(time), answer) == []


def test_a_loop_that_does_nothing_or_breaks_down_does_not_settle():
    time = np.arange(0.0, 2.0, 1e-3)
    demand = np.where(time < 0.5, 0.0, 1.0)
    for answer in (np.zeros_like(time), np.full_like(time, np.nan), np.where(time < 1, 0, 0.015)):
        (step,) = step_responses(time, demand, answer)
        assert math.isnan(step.settling_time)
        assert math.isnan(step.overshoot)
    lazy = steps(Proportional(gain=0.0), hold=0.1)
    assert math.isnan(lazy.settling_time())


def test_metrics_need_a_demand():
    run = simulate(time=TIME, command=0.0)
    with pytest.raises(InputError, match="no channel 'demand'"):
        run.step_responses()
    with pytest.raises(InputError, match="never changes"):
        simulate(time=TIME, controller=SlidingMode(), demand=0.015).settling_time()


def test_plots_label_quantity_and_unit():
    run = steps(SlidingMode(), hold=0.1)
    ax = Figure().subplots()
    assert run.plot(ax) is ax
    assert ax.get_ylabel() == "displacement [mm]"
    assert [line.get_label() for line in ax.lines] == ["demand", "displacement"]
    np.testing.assert_allclose(ax.lines[1].get_ydata(), 1e3 * run["displacement"])
    with pytest.raises(InputError, match="different units"):
        run.plot(ax, "pressure_a", "velocity")
    with pytest.raises(InputError, match="no channel 'pressure'"):
        run.plot(ax, "pressure")
    labels = [panel.get_ylabel() for panel in run.figure().axes]
    assert labels == [
        "displacement [mm]",
        "velocity [m/s]",
        "absolute pressure [bar]",
        "voltage [V]",
    ]
    volume = simulate_dead_volume(time=TIME, command=1.0)
    assert [panel.get_ylabel() for panel in volume.figure().axes] == [
        "absolute pressure [bar]",
        "voltage [V]",
    ]
