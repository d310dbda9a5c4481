"""Controllers that sample: converters, timing, and the laws against other ways to run them."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.linalg import expm

from analog_card.linear_servo import LinearServo, converter_step
from pneuservo.controllers import (
    CONTROLLERS,
    DT2812A,
    AnalogueCard,
    Board,
    DigitalSlidingMode,
    DigitalStateFeedback,
    DiscreteSlidingMode,
    HybridSlidingMode,
    Reading,
    SampledController,
    StateFeedback,
    controller_settings,
)
from pneuservo.controllers.sampled import INPUTS
from pneuservo.errors import InputError
from pneuservo.limit_cycle import Loop, Signals, simulate_nonlinear
from pneuservo.linear.models import state_matrices
from pneuservo.rigs import Transducer, load_rig
from pneuservo.simulation import (
    InitialState,
    simulate,
    simulate_batch,
    simulate_gradient,
    step_demand,
)

RIG = load_rig("single-axis")
STROKE = RIG["piston.stroke"]
SAMPLED = [kind for kind in CONTROLLERS.values() if issubclass(kind, SampledController)]
SLIDING = [kind for kind in SAMPLED if kind is not DigitalStateFeedback]


def step_of(controller, rate=1e3, hold=0.1, **how):
    time, demand = step_demand([0.015, 0.024], hold=hold, rate=rate)
    return simulate(RIG, time=time, demand=demand, controller=controller, **how)


def test_a_converter_is_half_a_bit_off_at_most_and_stays_in_its_range():
    values = np.linspace(-0.1 * STROKE, 1.1 * STROKE, 10_001)
    read = np.array([DT2812A.read(value, 0.0, STROKE) for value in values])
    inside = (values >= 0.0) & (values < STROKE - 2 * converter_step(STROKE))
    assert np.max(np.abs(read - values)[inside]) == pytest.approx(converter_step(STROKE), rel=0.05)
    assert read.min() == 0.0
    assert len(np.unique(read)) == 2**12
    assert DT2812A.write(7.0) == pytest.approx(5.0 - 10.0 / 2**12)
    assert DT2812A.write(-7.0) == -5.0


def test_noise_of_a_converter_is_a_share_of_its_range():
    board = Board(bits=24, input_noise=1e-3)
    assert board.read(0.5, -1.0, 1.0, noise=2.0) == pytest.approx(0.5 + 2.0 * 2e-3, abs=1e-6)


def test_every_controller_can_be_asked_for_its_settings():
    for kind in SAMPLED:
        assert controller_settings(kind())["sampling_time"] == 1e-3
        assert set(kind().inputs) <= set(INPUTS)


@dataclass(frozen=True)
class Recorder(SampledController):
    """Gives one volt and keeps what it reads."""

    readings: list
    sampling_time: float = 2e-3
    board: Board | None = None
    inputs: tuple[str, ...] = ("displacement", "pressure_a")

    def start(self, rig):
        def voltage(reading):
            self.readings.append(reading)
            return 1.0

        return voltage


def test_samples_come_at_their_times_with_what_acts_then():
    readings = []
    time, demand = step_demand([0.015, 0.016], hold=0.01, rate=1e3)
    run = simulate(RIG, time=time, demand=demand, controller=Recorder(readings))
    assert [reading.time for reading in readings] == pytest.approx(np.arange(10) * 2e-3)
    # The demand changes at 10 ms, and the sample of 10 ms has the new one.
    assert [reading.demand for reading in readings] == [0.015] * 5 + [0.016] * 5
    assert [reading.displacement for reading in readings] == pytest.approx(
        run["displacement"][::2], abs=1e-12
    )
    assert [reading.pressure_a for reading in readings] == pytest.approx(run["pressure_a"][::2])
    assert all(math.isnan(reading.acceleration) for reading in readings)


def test_the_output_follows_after_the_delay_of_the_board():
    board = Board(bits=16, input_noise=0.0, conversion_time=0.3e-3, output_settling_time=0.9e-3)
    time = np.arange(0.0, 6e-3, 0.5e-3)
    run = simulate(RIG, time=time, demand=0.015, controller=Recorder([], board=board))
    # Two inputs: 1.5 ms, at which time the row already has the new voltage.
    expected = np.where(time < 1.5e-3 - 1e-9, 0.0, 1.0)
    assert run["valve_voltage"] == pytest.approx(expected, abs=10.0 / 2**16)


def test_a_held_voltage_moves_the_plant_as_a_replayed_command_does():
    time = np.arange(0.0, 0.05, 1e-3)
    held = simulate(RIG, time=time, demand=0.015, controller=Recorder([]))
    commanded = simulate(RIG, time=time, command=1.0)
    # Two integrators of fourth order at steps of 20 us.
    for channel, tolerance in (("displacement", 1e-9), ("pressure_a", 1.0)):
        assert held[channel] == pytest.approx(commanded[channel], abs=tolerance)


def test_differences_agree_with_the_loop_that_acts_in_ticks():
    law = DigitalSlidingMode(boundary_layer=0.0, board=None)
    loop = Loop(LinearServo(), law.weights, 5.0, signals=Signals("backward", 1e-3))
    course = simulate_nonlinear(RIG, loop, 0.015, start_error=0.009, duration=0.1)
    run = simulate(RIG, time=course.time, demand=0.015, controller=law, initial=InitialState(0.006))
    # The same decisions at the same times: what is left is rounding, which a relay amplifies.
    assert run["valve_voltage"] == pytest.approx(course.voltage)
    assert 0.015 - run["displacement"] == pytest.approx(course.error, abs=1e-9)


def apart(controller, target):
    return np.max(np.abs(step_of(controller)["displacement"] - target["displacement"]))


def test_the_noise_before_differentiators_does_not_depend_on_the_step():
    law = HybridSlidingMode(boundary_layer=1e4, board=None)
    time = np.arange(0.0, 0.1, 1e-4)
    usual, fine = (
        simulate(time=time, controller=law, demand=0.015, largest_step=step, seed=2)
        for step in (20e-6, 5e-6)
    )
    # It would be half as much. A thousand readings, hardly correlated: 3 % each.
    for tap in ("card_velocity", "card_acceleration"):
        assert np.std(fine[tap]) == pytest.approx(np.std(usual[tap]), rel=0.12)


def test_fast_hybrid_control_without_noise_becomes_the_analogue_card():
    hybrid = HybridSlidingMode(boundary_layer=20.0, board=None, transducer_noise=0.0)
    figures = hybrid.differentiators
    scale = figures.weight_acceleration * figures.rc_velocity * figures.rc_acceleration
    card = AnalogueCard(
        replace(
            figures,
            weight_displacement=hybrid.weights[0] * scale,
            weight_velocity=hybrid.weights[1] * scale / figures.rc_velocity,
            output_gain=0.25 / figures.surface_scale,
            surface_limit=1e9,
            level=5.0,
        )
    )
    target = step_of(card)
    slow, fast = (apart(replace(hybrid, sampling_time=T), target) for T in (1e-4, 5e-5))
    # A hold is a delay of half the sampling time: what is left falls with it, to 4 um, the
    # 25 us of delay at the 0.2 m/s of this step.
    assert fast == pytest.approx(0.5 * slow, rel=0.2)
    assert fast < 5e-6


def test_fast_digital_state_feedback_becomes_the_continuous_one():
    target = step_of(StateFeedback())
    slow, fast = (
        apart(DigitalStateFeedback(sampling_time=T, accelerometer=True, board=None), target)
        for T in (1e-4, 5e-5)
    )
    # Hold and difference delay by half the sampling time each.
    assert fast == pytest.approx(0.5 * slow, rel=0.2)
    assert fast < 20e-6


def test_discrete_law_takes_the_stated_share_of_sigma_off_its_model():
    servo = LinearServo(valve_frequency=math.inf)
    law = DiscreteSlidingMode(
        sampling_time=2e-3, reaching_share=0.3, switching_share=0.0, servo=servo, level=1e6
    )
    a, b = state_matrices(servo)
    augmented = np.zeros((4, 4))
    augmented[:3, :3], augmented[:3, 3:] = a, b
    step = expm(augmented * law.sampling_time)
    state = np.array([-1e-3, 0.02, 0.5])
    feedback, reaching = law._gains(servo)
    sigma = law.switching_function(tuple(state))
    voltage = reaching * sigma - np.dot(feedback, state)
    after = (step @ [*state, voltage])[:3]
    assert law.switching_function(tuple(after)) == pytest.approx(0.7 * sigma, rel=1e-9)


def test_discrete_law_outlasts_the_continuous_one_at_slow_sampling():
    chatter = {}
    for kind in (DiscreteSlidingMode, DigitalSlidingMode):
        law = kind(sampling_time=2e-3, accelerometer=True, board=None)
        chatter[kind] = np.ptp(step_of(law, hold=0.4)["displacement"][-100:])
    # Section 6.13.2 of the thesis: significantly better at low sampling rates.
    assert chatter[DiscreteSlidingMode] < 0.5 * chatter[DigitalSlidingMode]


@pytest.mark.parametrize("kind", SLIDING)
def test_a_relay_switches_and_a_boundary_layer_does_not_always(kind):
    relay = step_of(kind(boundary_layer=0.0, board=None))["valve_voltage"]
    layer = step_of(kind(boundary_layer=20.0, board=None))["valve_voltage"]
    if kind is not DiscreteSlidingMode:
        assert set(np.abs(relay[1:])) <= {0.0, 5.0}
    assert np.ptp(layer[-20:]) < np.ptp(relay[-20:])


def test_noise_is_drawn_from_the_seed():
    law = DigitalSlidingMode()
    first, again, other = (step_of(law, seed=seed)["displacement"] for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_when_the_result_is_written_changes_nothing():
    law = HybridSlidingMode(boundary_layer=20.0, board=None, transducer_noise=0.0)
    coarse, fine = step_of(law), step_of(law, rate=4e3)
    # Steps of integration fall elsewhere, and with them the kinks of the valve's tables.
    assert fine["displacement"][::4] == pytest.approx(coarse["displacement"], abs=1e-7)


def test_transducers_of_the_rig_are_read_and_recorded():
    rig = replace(RIG, transducers={"displacement": Transducer(noise=1e-4, low=0.0, high=0.0149)})
    readings = []
    time = np.arange(0.0, 0.4, 1e-3)
    law = Recorder(readings, inputs=("displacement",), sampling_time=1e-3)
    run = simulate(rig, time=time, demand=0.0145, controller=replace(law), seed=3)
    read = np.array([reading.displacement for reading in readings])
    assert read.max() == 0.0149
    assert run["displacement"].max() == 0.0149
    assert np.std(read[:5]) > 0.0


class Silent(SampledController):
    """Breaks after 3 ms."""

    kind = "silent"

    def start(self, rig):
        return lambda reading: math.nan if reading.time > 2.5e-3 else 0.0


class Curious(SampledController):
    """Reads what there is not."""

    inputs = ("displacement", "smell")

    def start(self, rig):
        return lambda reading: 0.0


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (Silent(), "silent gives nan V at 0.003 s"),
        (Curious(), "reads 'smell'; it can read: displacement"),
        (DigitalSlidingMode(sampling_time=15e-6), "its board takes 1.8e-05 s for 1 inputs"),
        (Recorder([], sampling_time=0.0), "sampling time is 0 s"),
        (Recorder([], inputs=("card_velocity",)), "has no differentiators"),
    ],
)
def test_what_cannot_be_run_is_refused_by_name(controller, message):
    with pytest.raises(InputError, match=message):
        step_of(controller, hold=0.01)


def test_settings_that_make_no_controller_are_refused():
    for wrong in ({"sampling_time": 0.0}, {"boundary_layer": -1.0}, {"settling_time": math.nan}):
        with pytest.raises(InputError, match=next(iter(wrong))):
            DigitalSlidingMode(**wrong)
    with pytest.raises(InputError, match="transducer_noise"):
        HybridSlidingMode(transducer_noise=-1.0)
    with pytest.raises(InputError, match="reaching_share"):
        DiscreteSlidingMode(reaching_share=2.0)
    with pytest.raises(InputError, match="output_high"):
        Board(output_high=-5.0)


def test_what_cannot_take_a_sampled_controller_says_so():
    law = DigitalSlidingMode()
    affected = replace(RIG, effects={"friction.stribeck": {"excess": 5.0}})
    with pytest.raises(InputError, match="digital-sliding-mode samples"):
        simulate(affected, time=[0.0, 1e-3], demand=0.015, controller=law)
    with pytest.raises(InputError, match="needs a demand"):
        simulate(RIG, time=[0.0, 1e-3], controller=law)
    with pytest.raises(InputError, match="samples"):
        simulate_gradient(RIG, ["load.mass"], time=[0.0, 1e-3], demand=0.015, controller=law)


def test_a_batch_runs_them_one_by_one():
    law = DigitalSlidingMode(board=None)
    time, demand = step_demand([0.015, 0.024], hold=0.05, rate=1e3)
    runs = simulate_batch(
        RIG, {"load.mass": [1.825, 2.0]}, time=time, demand=demand, controller=law, jobs=1
    )
    alone = simulate(RIG, time=time, demand=demand, controller=law)
    assert np.array_equal(runs["displacement"][0], alone["displacement"])
    assert not np.array_equal(runs["displacement"][1], alone["displacement"])


def test_a_reading_has_nothing_that_was_not_converted():
    assert math.isnan(Reading(0.0, 0.015, displacement=0.01).card_velocity)
