from dataclasses import replace
from itertools import product

import pytest

from analog_card.design_file import design_to_toml, load_design
from analog_card.errors import InputError
from analog_card.figures import card_figures
from analog_card.tuning import read_settings, retune, tune, weights_from_settings

FAST_RANGE = """
[soldered.surface_amplifier]
acceleration_resistance = "1 Mohm"
displacement_resistance = "39 kohm"
velocity_resistance = "100 kohm"
"""


@pytest.fixture
def fast_range(tmp_path):
    file = tmp_path / "fast.toml"
    file.write_text(FAST_RANGE)
    return load_design(file)


def test_weights_follow_the_thesis():
    # (7.15): settling time 0.07 s and damping 1 give 3265.3 1/s2 and 114.3 1/s as printed.
    weights = tune(0.07).weights
    assert weights.displacement == pytest.approx(3265.3, abs=0.05)
    assert weights.velocity == pytest.approx(114.3, abs=0.05)
    # (7.3), (7.4): wn = 4/(zeta Tsett) = 80 rad/s.
    slower = tune(0.1, damping=0.5)
    assert slower.natural_frequency == pytest.approx(80)
    assert slower.weights.velocity == pytest.approx(80)


def test_settings_of_the_recommended_card():
    # Figures of an independent study of this circuit; tolerances are half its last digit.
    p1, p2, p3, p4 = tune(0.07).potentiometers
    assert p1.fraction == pytest.approx(0.482, abs=5e-4)
    assert p2.fraction == pytest.approx(0.727, abs=5e-4)
    assert p3.resistance == pytest.approx(15.1e3, abs=50)
    assert p4.fraction == pytest.approx(0.725, abs=5e-4)
    assert [item.name for item in (p1, p2, p3, p4)] == ["P1", "P2", "P3", "P4"]


def test_full_scales_of_the_recommended_card():
    design = load_design()
    full = replace(
        design, turned=replace(design.turned, displacement_weight=1.0, velocity_weight=1.0)
    )
    weights = weights_from_settings(full)
    assert weights.displacement == pytest.approx(6940, abs=5)
    assert weights.velocity == pytest.approx(163, abs=0.5)


def test_full_scales_of_the_fast_range(fast_range):
    full = replace(
        fast_range, turned=replace(fast_range.turned, displacement_weight=1.0, velocity_weight=1.0)
    )
    weights = weights_from_settings(full)
    assert weights.displacement == pytest.approx(178e3, abs=500)
    assert weights.velocity == pytest.approx(833, abs=0.5)


def test_the_shipped_settings_are_those_of_the_thesis():
    # The file gives ten digits.
    shipped, tuned = load_design().turned, tune(0.07).design.turned
    assert vars(shipped) == pytest.approx(vars(tuned), rel=1e-9)


@pytest.mark.parametrize(
    ("settling_time", "boundary_layer", "level"),
    list(product((0.05, 0.07, 0.25), (1.0, 5.0, 20.0), (0.5, 5.0, 6.9))),
)
def test_settings_and_weights_are_inverse(settling_time, boundary_layer, level):
    tuning = tune(settling_time, 1.0, boundary_layer, level)
    # Both directions are closed formulas: only rounding is left.
    assert vars(weights_from_settings(tuning.design)) == pytest.approx(
        vars(tuning.weights), rel=1e-12
    )


def test_inverse_in_the_fast_range_too(fast_range):
    tuning = tune(0.012, 0.9, 30.0, 5.0, fast_range)
    assert vars(weights_from_settings(tuning.design)) == pytest.approx(
        vars(tuning.weights), rel=1e-12
    )


def test_stages_may_differ():
    # 82 ms and 4.7 ms need 3265.3 x 82e-3 x 4.7e-3 = 1.2585 and 114.3 x 4.7e-3 = 0.5372; one
    # unit of the last digit is allowed because the state weights are rounded too.
    design = load_design()
    parts = design.soldered
    velocity = replace(parts.velocity_differentiator, capacitance=1e-6, resistance=82e3)
    acceleration = replace(parts.acceleration_differentiator, capacitance=47e-9, resistance=100e3)
    surface = replace(parts.surface_amplifier, displacement_resistance=50e3)
    design = replace(
        design,
        soldered=replace(
            parts,
            velocity_differentiator=velocity,
            acceleration_differentiator=acceleration,
            surface_amplifier=surface,
        ),
    )
    figures = tune(0.07, design=design).figures
    assert figures.rc_velocity == pytest.approx(0.082)
    assert figures.rc_acceleration == pytest.approx(4.7e-3)
    assert figures.weight_displacement == pytest.approx(1.2585, abs=1e-4)
    assert figures.weight_velocity == pytest.approx(0.5372, abs=1e-4)
    assert figures.weight_acceleration == 1.0


def test_figures_of_the_recommended_card():
    figures = card_figures(load_design())
    assert figures.velocity_breaks == pytest.approx((2842, 2822), abs=0.5)
    assert figures.rc_velocity == pytest.approx(12.0e-3)
    assert figures.surface_scale == pytest.approx(48.0e-3)
    assert figures.surface_limit == 13.0
    # The output reaches its level where sigma is the boundary layer of 5 m/s2.
    assert figures.output_gain * figures.surface_scale * 5.0 == pytest.approx(figures.level)


def test_settings_survive_the_design_file(tmp_path):
    tuning = tune(0.08, 0.8, 3.0, 4.0)
    file = tmp_path / "card.toml"
    file.write_text(design_to_toml(tuning.design), encoding="utf-8")
    assert load_design(file).turned == tuning.design.turned


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"settling_time": 0.01}, ["P1", "0 to 6944 1/s2", "displacement_resistance of at most"]),
        ({"settling_time": 0.0485}, ["P2", "0 to 163.4 1/s", "fast range"]),
        ({"settling_time": 0.07, "boundary_layer": 0.1}, ["P3", "0.938 to 21.7", "relay"]),
        ({"settling_time": 0.07, "boundary_layer": 100}, ["P3", "feedback_resistance of at most"]),
        ({"settling_time": 0.07, "boundary_layer": 5000}, ["P3", "write '5000 mm/s2'"]),
        ({"settling_time": 0.07, "level": 7.0}, ["P4", "0 to 6.9 V", "zeners"]),
        ({"settling_time": 0.07, "damping": 1.2}, ["damping", "above 1"]),
        ({"settling_time": -1.0}, ["settling time", "not greater than 0"]),
        ({"settling_time": float("nan")}, ["settling time", "not greater than 0"]),
    ],
)
def test_out_of_reach_names_potentiometer_range_and_remedy(arguments, expected):
    with pytest.raises(InputError) as caught:
        tune(**arguments)
    for words in expected:
        assert words in str(caught.value)


def test_the_resistor_advised_is_enough(tmp_path):
    file = tmp_path / "card.toml"
    # Advice for 0.0485 s: "solder velocity_resistance of at most 50.5 kOhm".
    with pytest.raises(InputError, match=r"velocity_resistance of at most 50\.5 kΩ"):
        tune(0.0485)
    file.write_text('[soldered.surface_amplifier]\nvelocity_resistance = "50.5 kohm"\n')
    assert 0.99 < tune(0.0485, design=load_design(file)).design.turned.velocity_weight <= 1


def test_a_surface_faster_than_any_servo_is_refused():
    with pytest.raises(InputError, match="no surface is so fast"):
        tune(settling_time=1e-300)


def test_a_card_that_is_damped_by_more_than_one_takes_another_settling_time():
    design = load_design()
    turned = replace(design.turned, velocity_weight=1.1 * design.turned.velocity_weight)
    found = read_settings(retune(replace(design, turned=turned), settling_time=0.06))
    assert (found.settling_time, found.damping) == pytest.approx((0.06, 1.0), rel=1e-6)
