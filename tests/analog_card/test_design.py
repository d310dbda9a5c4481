import pytest

from analog_card.behaviour_elements import nominal_elements
from analog_card.design_file import design_to_toml, load_design
from analog_card.errors import InputError
from analog_card.tolerance import quantities


def test_recommended_card_has_the_soldered_values():
    parts = load_design().soldered
    for stage in (parts.velocity_differentiator, parts.acceleration_differentiator):
        assert stage.capacitance == pytest.approx(100e-9)
        assert stage.resistance == 120e3
        assert stage.series_resistance == 560
        assert stage.feedback_capacitance == pytest.approx(470e-12)
    assert parts.boundary_layer_amplifier.ground_resistance == 620
    assert parts.output_limiter.clamp_level == 6.9
    assert parts.operational_amplifier.slew_rate == pytest.approx(9e6)


def test_every_value_of_the_recommended_card_has_a_source():
    design = load_design()
    text = design_to_toml(design)
    values = [line for line in text.splitlines() if " = " in line and not line.startswith("title")]
    assert len(values) == len(design.sources) == 84


def test_tolerances_are_part_of_the_design(tmp_path):
    shipped = load_design().tolerances
    assert shipped.capacitor.tolerance == pytest.approx(0.05)
    assert shipped.capacitor.temperature_coefficient == pytest.approx(-200e-6)
    assert shipped.zener.forward_drift == pytest.approx(-2e-3)
    assert shipped.operational_amplifier.gain_bandwidth == pytest.approx(0.25)
    assert shipped.temperature.lowest == pytest.approx(288.15)
    file = tmp_path / "card.toml"
    file.write_text('[tolerances.capacitor]\ntolerance = "1 %"\n')
    tight = load_design(file)
    assert tight.tolerances.capacitor.tolerance == pytest.approx(0.01)
    # The netlists take the coefficients; how far parts are from their values is not theirs.
    parameters = tight.netlist_parameters(273.15)
    assert parameters["card_temperature"] == 0
    assert parameters["capacitor_temperature_coefficient"] == pytest.approx(-200e-6)
    assert parameters == load_design().netlist_parameters(273.15)


def test_a_part_may_have_a_tolerance_of_its_own(tmp_path):
    file = tmp_path / "card.toml"
    file.write_text(
        "[soldered.velocity_differentiator]\n"
        'capacitance = { value = "100 nF", tolerance = "1 %", source = "selected" }\n'
        "[soldered.output_limiter]\n"
        'potentiometer = { value = "10 kohm", temperature_coefficient = "20 ppm/K" }\n'
    )
    design = load_design(file)
    own = design.part_tolerance("velocity_differentiator", "capacitance")
    assert own.tolerance == pytest.approx(0.01)
    assert own.temperature_coefficient == design.tolerances.capacitor.temperature_coefficient
    other = design.part_tolerance("acceleration_differentiator", "capacitance")
    assert other == design.tolerances.capacitor
    spreads = {item.name: item.spread for item in quantities(design)}
    assert spreads["xtaps.xvelocity.cinput"] == pytest.approx(0.01)
    assert spreads["xtaps.xacceleration.cinput"] == pytest.approx(0.05)
    track = design.part_tolerance("output_limiter", "potentiometer")
    assert track.temperature_coefficient == pytest.approx(20e-6)
    # The netlist changes every track by 100 ppm/K; what it is given makes up for the difference.
    parameters = design.netlist_parameters(298.15 + 40)
    in_netlist = parameters["limiter_potentiometer"] * (1 + 100e-6 * 40)
    assert in_netlist == pytest.approx(10e3 * (1 + 20e-6 * 40), rel=1e-12)
    behaviour = nominal_elements(design, temperature=298.15 + 40)
    lower = "xlimiter.xpotentiometer.rlower"
    assert behaviour[lower] == pytest.approx(in_netlist * design.turned.level, rel=1e-12)
    again = tmp_path / "again.toml"
    again.write_text(design_to_toml(design), encoding="utf-8")
    assert load_design(again) == design
    assert load_design(again).sources == design.sources


def test_a_file_needs_only_what_differs(tmp_path):
    file = tmp_path / "card.toml"
    file.write_text('[soldered.surface_amplifier]\nacceleration_resistance = "1 Mohm"\n')
    design = load_design(file)
    assert design.soldered.surface_amplifier.acceleration_resistance == 1e6
    assert design.soldered.surface_amplifier.displacement_resistance == 100e3
    assert design.turned == load_design().turned


def test_what_is_written_reads_back(tmp_path):
    file = tmp_path / "card.toml"
    file.write_text(
        'title = "two \\"quotes\\" and ohm Ω"\n[soldered.velocity_differentiator]\n'
        'capacitance = { value = "82.5 nF", source = "measured\\non the bench" }\n'
    )
    design = load_design(file)
    file.write_text(design_to_toml(design), encoding="utf-8")
    again = load_design(file)
    assert again == design
    assert again.sources == design.sources


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[soldered.velocity_diferentiator]\n", "nearest is 'velocity_differentiator'"),
        (
            '[soldered.velocity_differentiator]\ncapacitanse = "1 nF"\n',
            "'soldered.velocity_differentiator.capacitanse'; nearest is 'capacitance'",
        ),
        ("turnd = 3\n", "nearest is 'turned'"),
        ("turned = 3\n", "turned is 3, a table of values is needed"),
        ("[turned]\nlevel = { valeu = 0.5 }\n", "nearest is 'value'"),
        ('[turned]\nlevel = { source = "guess" }\n', "turned.level has no value"),
        ("[turned]\nlevel = 1.5\n", "turned.level is 1.5, a fraction of travel, 0 to 1,"),
        ('[transducer]\nfull_scale_voltage = "10 mm"\n', "has the unit of a length"),
        ('[transducer]\nfull_scale_voltage = "-10 V"\n', "a positive value is needed"),
        ("[transducer]\nfull_scale_voltage = nan\n", "not a finite number"),
        ("[transducer]\nfull_scale_voltage = true\n", "is not a quantity"),
        ('[tolerances.resistor]\ntolerance = "100 %"\n', "from 0 to less than 1"),
        ("[tolerances.operational_amplifier]\nbias_current = 0.5\n", "a factor of 1 or more"),
        ('[tolerances.temperature]\nlowest = "50 degC"\n', "the lowest comes first"),
        ('[tolerances.resistor]\ntemperature_coefficient = "5 V"\n', "has the unit of a voltage"),
        (
            '[soldered.supply]\nlead_resistance = { value = "1 ohm", tolerance = "1 %" }\n',
            "unknown name 'soldered.supply.lead_resistance.tolerance'",
        ),
        (
            '[soldered.inverter]\nresistance = { value = "22 kohm", tolerance = -0.1 }\n',
            "soldered.inverter.resistance.tolerance is -0.1",
        ),
        (
            "[soldered.inverter]\nresistance = { value = 1, source = { a = 1 } }\n",
            "soldered.inverter.resistance.source is {'a': 1}, a text is needed",
        ),
        ("title = 3\n", "title is 3, a text is needed"),
        ("title = \n", "not valid TOML"),
    ],
)
def test_refusals_name_file_and_remedy(tmp_path, text, expected):
    file = tmp_path / "card.toml"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_design(file)
    assert str(file) in str(caught.value)
    assert expected in str(caught.value)


def test_a_file_that_is_not_there_or_not_text(tmp_path):
    with pytest.raises(InputError, match=r"no\.toml: cannot be read: No such file"):
        load_design(tmp_path / "no.toml")
    binary = tmp_path / "card.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        load_design(binary)
