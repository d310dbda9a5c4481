"""The behavioural card against hand calculation: ideal limits, and each imperfection alone."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from analog_card.behaviour import CardBehaviour, Imperfections, card_stages
from analog_card.behaviour_elements import nominal_elements, offset_name
from analog_card.behaviour_model import rest_voltages, run_behaviour, stage_responses
from analog_card.design_file import load_design
from analog_card.differentiator import differentiator_pair
from analog_card.errors import InputError
from analog_card.figures import card_figures

TIME = np.arange(0, 30e-3, 2e-6)
REST = np.full(len(TIME), 5.0)


@pytest.fixture(scope="module")
def design():
    return load_design()


def only(design, *names, **changes):
    return CardBehaviour(design, imperfections=Imperfections.only(*names), **changes)


def sine(amplitude, frequency):
    """A sine that starts softly, and the part of it that has settled."""
    wave = np.sin(2 * np.pi * frequency * TIME) * np.minimum(TIME / 10e-3, 1) ** 3
    return REST + amplitude * wave, TIME >= 15e-3


def test_the_ideal_card_has_the_figures_of_the_design(design):
    stages = card_stages(CardBehaviour(design, imperfections=Imperfections.none()))
    figures = card_figures(design)
    # The op-amps left have a gain of 1e10.
    expected = [
        -figures.weight_displacement,
        -figures.weight_velocity,
        -figures.weight_acceleration,
    ]
    np.testing.assert_allclose(stages.surface, [*expected, 0], rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(stages.difference, [1, -1, 0], rtol=1e-8, atol=1e-15)
    gain = stages.comparator_gain * stages.limiter.division * stages.limiter.fraction
    # The jumper in the feedback has 1 mohm of 19.6 kohm.
    assert gain == pytest.approx(figures.output_gain, rel=1e-6)
    assert stages.limiter.fraction * stages.limiter.clamped[-1] == pytest.approx(figures.level)


def test_the_ideal_card_in_time_is_the_linear_system(design):
    transducer, _ = sine(5e-3, 150.0)
    run = run_behaviour(only(design), TIME, transducer, REST)
    taps = differentiator_pair(design, finite_bandwidth=False).transient(TIME, transducer)
    offset = design.soldered.operational_amplifier.input_offset_voltage
    # Parabolas between samples instead of straight lines: (2 pi 150 2e-6)^2/12 of 0.4 V.
    np.testing.assert_allclose(run["first"], taps.velocity - offset, atol=1e-6)
    np.testing.assert_allclose(run["second"], taps.acceleration - offset, atol=2e-5)


def test_the_whole_card_in_time_settles_at_its_frequency_response(design):
    frequency = 200.0
    transducer, late = sine(2e-3, frequency)
    card = CardBehaviour(design, imperfections=Imperfections().without("offset_voltage"))
    run = run_behaviour(card, TIME, transducer, REST)
    gains = {name: g[0] for name, g in stage_responses(card, np.array([frequency])).items()}
    tap = gains["buffer"] * gains["first"]
    deviation = gains["buffer"] * gains["difference from displacement"]
    surface = (
        gains["surface from deviation"] * deviation
        + gains["surface from rate"] * tap * gains["inverter"]
        + gains["surface from acceleration"] * tap * gains["second"]
    )
    phase = np.exp(2j * np.pi * frequency * TIME)
    for node, gain in (("first", tap), ("second", tap * gains["second"]), ("surface", surface)):
        expected = 2e-3 * np.imag(gain * phase)
        measured = run[node] - run[node][0]
        # What the start leaves after 15 ms, and 1e-5 of the parabolas.
        np.testing.assert_allclose(measured[late], expected[late], atol=1e-4 * 2e-3 * abs(gain))


def test_relay_has_the_describing_function_of_a_relay(design):
    # 4 M/(pi A): the ideal relay's fundamental, whatever drives it. The edges of the ideal card's
    # 2 us steps are up to 2 us late, 2 pi 100 2e-6 of a radian; the level is P4's share of 6.9 V.
    frequency, amplitude = 100.0, 5e-3
    transducer, late = sine(amplitude, frequency)
    run = run_behaviour(only(design, relay=True), TIME, transducer, REST)
    whole = late & (TIME < 25e-3)
    phase = np.exp(-2j * np.pi * frequency * TIME[whole])
    control, surface = (2 * np.mean(run[node][whole] * phase) for node in ("control", "surface"))
    level = card_figures(design).level
    assert abs(control) == pytest.approx(4 * level / np.pi, rel=2e-3)
    function = abs(control) / abs(surface)
    assert function == pytest.approx(4 * level / (np.pi * abs(surface)), rel=2e-3)
    assert abs(np.angle(control / surface)) < 2 * np.pi * frequency * 4e-6


def test_relay_delay_is_that_of_an_integrator(design):
    # From zero to the knee of the clamp's other side: dV = 13.0 + 6.9 (1.1) V at 2 pi GBW s t^2/2.
    frequency, amplitude = 100.0, 5e-3
    transducer, late = sine(amplitude, frequency)
    card = only(design, "gain_bandwidth", relay=True)
    run = run_behaviour(card, TIME, transducer, REST)
    surface, comparator = run["surface"], run["comparator"]
    cross = int(np.flatnonzero(late[1:] & (surface[:-1] < 0) & (surface[1:] >= 0))[0])
    slope = (surface[cross + 1] - surface[cross]) / (TIME[1] - TIME[0])
    start = comparator[cross]
    reached = cross + int(np.argmax(comparator[cross:] > 0))
    speed = 2 * np.pi * design.soldered.operational_amplifier.gain_bandwidth
    expected = math.sqrt(-2 * start / (speed * slope))
    # The slope changes a little on the way, and samples are 2 us apart.
    assert TIME[reached] - TIME[cross] == pytest.approx(expected, abs=4e-6)


def test_the_elements_of_a_whole_card_do_not_close_the_link_of_a_relay(design):
    whole = nominal_elements(design)
    relay, other = (
        card_stages(CardBehaviour(design, elements=elements, relay=True))
        for elements in ({}, whole)
    )
    assert other.comparator_gain == relay.comparator_gain
    # 10 Mohm over 620 ohm, of an open-loop gain of 1e5.
    assert relay.comparator_gain > 1e4


def test_offsets_have_the_noise_gains_of_their_stages(design):
    off = dict.fromkeys((n for n in nominal_elements(design) if n.endswith("voffset")), 0.0)

    def surface(**offsets):
        elements = off | {offset_name(name): value for name, value in offsets.items()}
        card = CardBehaviour(design, elements, Imperfections.only("offset_voltage"))
        return rest_voltages(card_stages(card), 5.0, 5.0)["surface"]

    figures, parts = card_figures(design), design.soldered.surface_amplifier
    wipers = [f * (1 - f) * 10e3 for f in vars(design.turned).values()][:2]
    noise_gain = 1 + parts.feedback_resistance * (
        1 / (parts.displacement_resistance + wipers[0])
        + 1 / (parts.velocity_resistance + wipers[1])
        + 1 / parts.acceleration_resistance
    )
    assert surface(surface=5e-3) == pytest.approx(noise_gain * 5e-3, rel=1e-6)
    assert surface(difference=5e-3) == pytest.approx(-2 * figures.weight_displacement * 5e-3)
    assert surface(inverter=5e-3) == pytest.approx(-2 * figures.weight_velocity * 5e-3)
    assert surface(acceleration=5e-3) == pytest.approx(-figures.weight_acceleration * 5e-3)
    assert surface(velocity=5e-3) == pytest.approx(figures.weight_velocity * 5e-3)
    assert surface(transducer_buffer=5e-3) == pytest.approx(-figures.weight_displacement * 5e-3)
    assert surface(demand_buffer=5e-3) == pytest.approx(figures.weight_displacement * 5e-3)


def test_bias_currents_drop_across_the_feedback(design):
    amplifier = replace(
        design.soldered.operational_amplifier, bias_current=1e-6, offset_current=0.0
    )
    design = replace(design, soldered=replace(design.soldered, operational_amplifier=amplifier))
    first = rest_voltages(card_stages(only(design, "bias_current")), 5.0, 5.0)["first"]
    # The bias resistor balances it: 120 kohm at both inputs.
    assert first == pytest.approx(0.0, abs=1e-6)
    rate = rest_voltages(card_stages(only(design, "bias_current")), 5.0, 5.0)["rate"]
    assert rate == pytest.approx(22e3 * 1e-6, rel=1e-3)


def test_saturation_stops_the_taps_at_the_asymmetric_swing(design):
    ramp = REST + np.clip((TIME - 1e-3) / 1e-3, 0, 1) * 3
    for imperfections in (Imperfections(), Imperfections.only("saturation")):
        run = run_behaviour(CardBehaviour(design, imperfections=imperfections), TIME, ramp, REST)
        for tap in ("first", "second"):
            # 13 and 14.4 V into 2 kohm; with hardly a load up to 0.5 V more.
            assert -15.0 < run[tap].min() < -14.35
        assert 12.9 < run["second"].max() < 13.5
        assert abs(run["first"][-1]) < 0.02  # recovered
    free = run_behaviour(only(design), TIME, ramp, REST)
    assert free["first"].min() < -30  # 3 V/ms times 12 ms


def test_slew_rate_limits_the_differentiators(design):
    slow = replace(design.soldered.operational_amplifier, slew_rate=5e3)
    design = replace(design, soldered=replace(design.soldered, operational_amplifier=slow))
    ramp = REST + np.clip((TIME - 1e-3) / 20e-6, 0, 1) * 3e-3
    limited = run_behaviour(only(design, "slew_rate", "gain_bandwidth"), TIME, ramp, REST)
    free = run_behaviour(only(design, "gain_bandwidth"), TIME, ramp, REST)
    rates = [np.abs(np.diff(run["second"])).max() / 2e-6 for run in (limited, free)]
    assert rates[1] > 5 * 5e3
    # Output resistance passes the current of the stage on unlimited: a few per cent.
    assert rates[0] == pytest.approx(5e3, rel=0.05)


@pytest.mark.parametrize(
    ("name", "node"),
    [
        ("offset_voltage", "surface"),
        ("bias_current", "first"),
        ("common_mode", "deviation"),
        ("potentiometer_contacts", "surface"),
        ("zener_knee", "clamped"),
        ("saturation", "comparator"),
        ("gain_bandwidth", "comparator"),
        ("output_resistance", "second"),
    ],
)
def test_each_imperfection_alone_moves_what_it_should(design, name, node):
    transducer, late = sine(10e-3, 150.0)
    with_, without = (
        run_behaviour(card, TIME, transducer, REST) for card in (only(design, name), only(design))
    )
    moved = {n: np.abs(with_[n] - without[n])[late].max() for n in without.voltages}
    assert moved[node] > 1e-12
    if name in ("zener_knee", "saturation"):
        assert max(moved[n] for n in ("first", "second", "deviation", "surface")) < 1e-9
    if name in ("common_mode", "potentiometer_contacts"):
        assert max(moved[n] for n in ("first", "second")) < 1e-3


def test_every_imperfection_has_a_name_that_turns_it_off():
    names = [item.name for item in fields(Imperfections)]
    for name in names:
        left = Imperfections().without(name)
        assert [n for n in names if not getattr(left, n)] == [name]
    assert not Imperfections.none().any


def test_uneven_times_are_refused(design):
    with pytest.raises(InputError, match="equally spaced"):
        run_behaviour(CardBehaviour(design), np.array([0, 1e-3, 3e-3]), np.zeros(3), np.zeros(3))
