import pytest

from analog_card.design_file import design_to_toml, load_design
from analog_card.errors import InputError


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
    assert len(values) == len(design.sources) == 61


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
        ("title = 3\n", "title is 3, a text is needed"),
        ("title = \n", "not TOML"),
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
    with pytest.raises(InputError, match=r"no\.toml: No such file"):
        load_design(tmp_path / "no.toml")
    binary = tmp_path / "card.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not UTF-8"):
        load_design(binary)
