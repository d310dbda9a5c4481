"""Numbers with units as people type them, and what is no such number."""

import numpy as np
import pytest

from analog_card.errors import InputError
from analog_card.quantities import to_si, to_si_all, unit_factor
from analog_card.toml_file import read_toml


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("70 ms", "s", 0.07),
        ("70ms", "s", 0.07),
        ("5000 mm/s2", "m/s2", 5.0),
        ("1.5e-3m", "m", 1.5e-3),
        ("+.5 V", "V", 0.5),
        ("5.", "", 5.0),
        ("3 %", "", 0.03),
        ("-200 ppm/K", "1/K", -2e-4),
        ("2 1/s**2", "1/s**2", 2.0),
        ("2 /s", "1/s", 2.0),
        ("20 °C", "K", 293.15),
        ("15.1 kΩ", "ohm", 15100.0),
        ("10 m*s**-1", "m/s", 10.0),
        ("3 g/(s*kPa**2)", "kg/(s*Pa**2)", 3e-9),
        ("2 N s/m", "N*s/m", 2.0),
        (np.int64(3), "V", 3.0),
        (np.float32(0.5), "V", 0.5),
    ],
)
def test_one_number_with_a_unit_is_read(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("50 ppm/degC", "1/K", 50e-6),
        ("1e-4/degC", "1/K", 1e-4),
        ("8 uV/°C", "V/K", 8e-6),
        ("-2 mV/degF", "V/K", -3.6e-3),
        ("2 J/(kg degC)", "J/kg/K", 2.0),
    ],
)
def test_per_degree_is_of_a_difference_of_temperatures(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "right"),
    [
        ("628 rad/s", "99.9493 Hz"),
        ("3000 rpm", "50 Hz"),
        ("2 cycle/s", "2 Hz"),
        ("90 deg/s", "0.25"),
    ],
)
def test_an_angular_frequency_is_no_frequency(text, right):
    with pytest.raises(InputError, match=f"is an angular frequency; write {right}"):
        to_si(text, "Hz")
    assert to_si("2 kHz", "Hz") == to_si("2000 1/s", "Hz") == 2000.0


@pytest.mark.parametrize("text", ["1,5", "4,5 V", "0,07 V", "1,825 V"])
def test_a_decimal_comma_is_no_other_number(text):
    with pytest.raises(InputError, match="a decimal point is needed in place of the comma"):
        to_si(text, "V")


@pytest.mark.parametrize(
    "text",
    ["1 000 V", "3 4 mV", "15;24 V", "5 V - 3 V", "5 V + 3 V", "2**3", "1/3", "[1]", "(1) V", "pi"],
)
def test_what_would_have_to_be_worked_out_is_refused(text):
    with pytest.raises(InputError, match="cannot be read as a number with a unit"):
        to_si(text, "V")


def test_a_list_with_decimal_commas_is_refused():
    with pytest.raises(InputError, match="decimal point"):
        to_si_all(["6,5", "7,7 bar"], "Pa")


@pytest.mark.parametrize(("unit", "what"), [("0 m", "a unit alone"), ("10 mm", "a unit alone")])
def test_a_unit_has_no_number(unit, what):
    with pytest.raises(InputError, match=what):
        unit_factor(unit, "m")


def test_not_a_number_is_no_unit():
    with pytest.raises(InputError, match="nan' cannot be read as a number with a unit"):
        unit_factor("nan", "")
    # So small that nothing is left of it: 1e-540.
    with pytest.raises(InputError, match="is not a unit"):
        unit_factor("qm**9*qm**9", "m**18")


@pytest.mark.parametrize("digits", [17, 5000])
def test_an_integer_too_long_for_toml_is_refused(tmp_path, digits):
    file = tmp_path / "long.toml"
    file.write_text(f"[a]\nb = [1, {{ c = 0x1{digits * 'f'} }}]\n")
    with pytest.raises(InputError, match="64 bits"):
        read_toml(file, "a file")
