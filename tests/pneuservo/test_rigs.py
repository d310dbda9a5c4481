"""Rigs as data: built-in ones, files that change them, and files that are refused."""

from dataclasses import replace

import pytest
import tomli_w

from analog_card.files import write_files
from analog_card.quantities import to_si
from pneuservo.errors import InputError
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.rigs import BUILT_IN_RIGS, VARIANTS, load_rig, load_valve_tables
from pneuservo.rigs.rig_file import files_beside, rig_document


@pytest.mark.parametrize("name", BUILT_IN_RIGS)
def test_every_built_in_rig_states_its_sources(name):
    rig = load_rig(name)
    assert rig.kind == name
    for key, parameter in rig.parameters.items():
        assert parameter.source, key
        assert parameter.tolerance >= 0.0, key
        to_si(f"1 {parameter.unit}" if parameter.unit else "1", parameter.unit, key)


def test_baseline_values_of_the_single_axis():
    rig = load_rig("single-axis")
    expected = {
        "piston.area_a": 490.87e-6,
        "piston.area_b": 412.33e-6,
        "piston.stroke": 0.030,
        "chamber.a.dead_volume": 1.7e-6,
        "load.mass": 1.825,
        "piston.viscous_friction": 102.53,
        "piston.coulomb_friction": 1.013,
        "valve.flow.area_a_e": 0.795e-6,
        "supply.pressure": 6.5e5,
        "ambient.pressure": 1.013e5,
        "temperature": 293.0,
    }
    assert {key: rig[key] for key in expected} == pytest.approx(expected, rel=1e-12)


def test_valve_tables_are_complete_and_ordered():
    tables = load_valve_tables("ddv-27a1")
    assert set(tables) == set(FLOW_PATHS)
    for table in tables.values():
        assert table.pressure_ratio.shape == table.discharge_coefficient.shape == (10, 5)
        assert (table.command[1:] > table.command[:-1]).all()
        assert (table.pressure_ratio[:, 0] == 0.0).all()
        assert (table.pressure_ratio[:, -1] == 1.0).all()


def test_values_of_parameters_and_effects_are_put_in_alike():
    rig = load_rig("single-axis")
    changed = rig.with_values({"load.mass": 2.0, "leakage.chamber-a:area": 3e-9})
    assert changed["load.mass"] == 2.0
    assert changed.effect_values == {"leakage.chamber-a:area": 3e-9}
    again = changed.with_values({"leakage.chamber-a:area": 1e-9, "friction.lag:time": 0.01})
    assert again.effect_values == {"leakage.chamber-a:area": 1e-9, "friction.lag:time": 0.01}
    assert rig.effects == {}
    assert changed.effect_values == {"leakage.chamber-a:area": 3e-9}


def write(tmp_path, text):
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_states_only_what_differs(tmp_path):
    path = write(
        tmp_path,
        '[rig]\nkind = "single-axis"\ntitle = "heavy"\n'
        '[parameters]\n"load.mass" = "6.82 kg"\n'
        '"piston.stroke" = { value = "50 mm", tolerance = "0.1 mm" }\n',
    )
    rig = load_rig(path)
    assert (rig.title, rig["load.mass"], rig["piston.stroke"]) == ("heavy", 6.82, 0.05)
    assert rig.parameters["piston.stroke"].tolerance == pytest.approx(1e-4)
    assert rig["supply.pressure"] == load_rig("single-axis")["supply.pressure"]
    # Another mass is known as well, in share of it, as the built-in one.
    assert rig.parameters["load.mass"].tolerance == pytest.approx(0.03 * 6.82)


def test_a_value_of_zero_is_not_known_exactly(tmp_path):
    text = '[rig]\nkind = "single-axis"\n[parameters]\n"piston.coulomb_friction" = 0\n'
    known = load_rig("single-axis").parameters["piston.coulomb_friction"].tolerance
    found = load_rig(write(tmp_path, text)).parameters["piston.coulomb_friction"]
    assert (found.value, found.tolerance) == (0.0, known)


def test_a_tolerance_of_a_temperature_is_a_difference(tmp_path):
    text = '[rig]\nkind = "single-axis"\n[parameters]\ntemperature = {{ tolerance = "2 {}" }}\n'
    assert load_rig(write(tmp_path, text.format("K"))).parameters["temperature"].tolerance == 2.0
    with pytest.raises(InputError, match="no difference of temperatures; write it in K"):
        load_rig(write(tmp_path, text.format("degC")))


def test_a_valve_that_is_a_link_to_elsewhere_is_refused(tmp_path):
    (tmp_path / "secret").write_text("machine x")
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "valve.toml").symlink_to(tmp_path / "secret")
    path = tmp_path / "lab" / "rig.toml"
    path.write_text('[rig]\nkind = "seal-tester"\nvalve = "valve.toml"\n')
    with pytest.raises(InputError, match=r"'valve\.toml' leads to .*secret"):
        load_rig(path)


def test_a_file_may_hold_effects(tmp_path):
    path = write(
        tmp_path,
        '[rig]\nkind = "seal-tester"\n'
        '[effects."friction.pressure"]\nslope = { value = 1e-6, unit = "m**2" }\n',
    )
    assert load_rig(path).effect_values == {"friction.pressure:slope": 1e-6}


def test_effects_take_units_as_parameters_do(tmp_path):
    path = write(
        tmp_path,
        '[rig]\nkind = "single-axis"\n[effects]\n'
        '"sensor.quantisation" = { displacement = "7.3 um", pressure = "0.5 kPa" }\n'
        '"valve.upstream-temperature" = { difference = "-8 K" }\n',
    )
    assert load_rig(path).effect_values == pytest.approx(
        {
            "sensor.quantisation:displacement": 7.3e-6,
            "sensor.quantisation:pressure": 500.0,
            "valve.upstream-temperature:difference": -8.0,
        }
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[rig]\nkind = "single-axs"', "Did you mean 'single-axis'"),
        ('[rig]\nkind = "single-axis"\n[parameters]\n"load.mas" = 1', "Did you mean 'load.mass'"),
        ('[rig]\nkind = "single-axis"\n[parameters]\n"load.mass" = "6 bar"', "a mass is needed"),
        ('[rig]\nkind = "single-axis"\n[parametres]\n', "Did you mean 'parameters'"),
        ('[rig]\nkind = "single-axis"\n[parameters]\n"load.mass" = {wert = 1}', "'wert'"),
        (
            '[rig]\nkind = "circuit"\n[effects]\n"circuit.cubic-stiffness" = 3',
            "table of parameter values",
        ),
        (
            '[rig]\nkind = "seal-tester"\n[effects."friction.pressure"]\n'
            'slope = { value = 1, unit = "kg" }',
            "the unit is 'kg'",
        ),
        (
            '[rig]\nkind = "single-axis"\n[effects."leakage.rod-seal"]\narea = { value = -1e-8 }',
            "cannot be negative",
        ),
        (
            '[rig]\nkind = "single-axis"\n[effects."sensor.quantisation"]\npressure = "5 mm"',
            "a pressure is needed",
        ),
        (
            '[rig]\nkind = "single-axis"\n'
            '[effects."valve.upstream-temperature"]\ndifference = "5 degC"',
            "write it in K",
        ),
        ("[rig\n", "not valid TOML"),
        ("a = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_refusals_name_what_is_wrong(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as refusal:
        load_rig(write(tmp_path, text))
    assert "rig.toml" in str(refusal.value)


def test_unknown_names_are_answered_with_the_known_ones(tmp_path):
    with pytest.raises(InputError, match="Did you mean 'single-axis'"):
        load_rig("singleaxis")
    with pytest.raises(InputError, match="a rig file is needed"):
        load_rig(tmp_path / "none.toml")
    with pytest.raises(InputError, match="ddv-27a1"):
        load_valve_tables("ddv")


def test_a_condition_that_repeats_the_nominal_value_keeps_what_was_fitted(tmp_path):
    path = write(
        tmp_path,
        '[rig]\nkind = "seal-tester"\n[parameters."piston.diameter"]\n'
        "value = 0.02508\nnominal = 0.025\n",
    )
    rig = load_rig(path)
    assert rig.with_conditions({"piston_diameter": 0.025})["piston.diameter"] == 0.02508
    assert rig.with_conditions({"piston_diameter": 0.032})["piston.diameter"] == 0.032


@pytest.mark.parametrize("name", [*BUILT_IN_RIGS, *VARIANTS])
def test_a_rig_is_the_same_when_written_and_read(name, tmp_path):
    rig = load_rig(name)
    assert replace(read_again(rig, tmp_path), name=name) == rig


def test_all_that_a_rig_file_can_say_is_written_and_read(tmp_path):
    path = write(
        tmp_path,
        """
        [rig]
        kind = "single-axis"
        title = "mine"
        valve = "valve.toml"
        [parameters]
        "load.mass" = {value = "40 kg", tolerance = "10 %", source = "weighed"}
        "piston.area_a" = {value = 1.256e-3, unit = "m^2"}
        "piston.coulomb_friction" = {value = 3.0, free = true}
        [effects]
        "valve.overlap" = {lap = 0.02}
        [transducers.pressure]
        noise = "500 Pa"
        """,
    )
    (path.parent / "valve.toml").write_text("beside it")
    rig = load_rig(path)
    again = read_again(rig, tmp_path / "elsewhere")
    assert (tmp_path / "elsewhere" / "valve.toml").read_text() == "beside it"
    assert replace(again, name=rig.name, valve=rig.valve) == rig


def read_again(rig, folder):
    write_files(folder, {"again.toml": tomli_w.dumps(rig_document(rig)), **files_beside(rig)})
    return load_rig(folder / "again.toml")
