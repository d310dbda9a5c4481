import json
import shlex

import pytest
from click.testing import CliRunner

from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.tuning import weights_from_settings

COMMANDS = ["doctor", "opamp", "schematic", "simulate", "tolerance", "tune", "verify"]
BAD_DESIGN = "[soldered.surface_amplifier]\nvelocity_resistanze = 3\n"


@pytest.fixture
def analog_card(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.toml").write_text(BAD_DESIGN)

    def call(*arguments):
        return CliRunner().invoke(main, arguments)

    return call


def examples(command):
    text = CliRunner().invoke(main, [command, "--help"]).output
    after = text.split("Examples:")[1].strip().splitlines()
    return [shlex.split(line)[1:] for line in after]


@pytest.mark.ngspice
@pytest.mark.parametrize("command", COMMANDS)
def test_help_ends_with_two_examples_that_run(analog_card, command):
    found = examples(command)
    assert len(found) == 2
    for example in found:
        assert example[0] == command
        result = analog_card(*example)
        assert result.exit_code == 0, result.output


def test_tune_prints_settings_and_a_design_file(analog_card, tmp_path):
    result = analog_card("tune", "--settling-time", "70ms")
    assert result.exit_code == 0
    for text in ("P1", "48.2 %", "4.82 kΩ", "P2", "72.7 %", "P3", "15.1 kΩ", "P4", "72.5 %"):
        assert text in result.output
    file = tmp_path / "printed.toml"
    file.write_text(result.output[result.output.index("title = ") :], encoding="utf-8")
    assert weights_from_settings(load_design(file)).displacement == pytest.approx(16e4 / 49)


def test_tune_writes_a_design_file(analog_card, tmp_path):
    result = analog_card(
        *shlex.split("tune --settling-time 0.1 --boundary-layer '4000 mm/s2' --out deep/card.toml")
    )
    assert result.exit_code == 0
    assert "title = " not in result.output
    weights = weights_from_settings(load_design(tmp_path / "deep" / "card.toml"))
    assert weights.boundary_layer == pytest.approx(4.0)
    assert weights.velocity == pytest.approx(80.0)
    again = analog_card(*shlex.split("tune --settling-time 0.2 --design deep/card.toml --json"))
    assert json.loads(again.output)["weights"]["velocity"] == pytest.approx(40.0)


def test_tune_prints_json_only(analog_card):
    found = json.loads(analog_card("tune", "--settling-time", "0.07", "--json").output)
    assert found["potentiometers"]["P1"]["fraction"] == pytest.approx(0.482, abs=5e-4)
    assert found["figures"]["rc_velocity"] == pytest.approx(0.012)
    assert found["natural_frequency"] == pytest.approx(4 / 0.07)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("tune", "Missing option '--settling-time'"),
        ("tune --settling-time 0.07kg", "a time is needed"),
        ("tune --settling-time 0", "not greater than 0"),
        ("tune --settling-time abc", "cannot be read as a number"),
        ("tune --settling-time 0.01", "P1 (displacement weight) cannot reach"),
        ("tune --settling-time 0.07 --boundary-layer 5000", "write '5000 mm/s2'"),
        ("tune --settling-time 0.07 --level 9", "P4 (level) cannot reach"),
        ("tune --settling-time 0.07 --damping 2", "above 1"),
        ("tune --settling-time 0.07 --design bad.toml", "nearest is 'velocity_resistance'"),
        ("tune --settling-time 0.07 --design no.toml", "no.toml: cannot be read: No such file"),
        ("tune --settling-time 0.07 --out bad.toml/card.toml", "bad.toml"),
        ("verify --design bad.toml", "bad.toml"),
        ("tolerance --jobs two", "'two' is not a whole number; allowed: 1 and more"),
        ("tolerance --trials 1", "1 is out of range; allowed: 2 and more"),
        ("verify --design no.toml", "no.toml"),
        ("doctor --nonsense", "No such option"),
        ("tun", "No such command"),
    ],
)
def test_bad_input_exits_with_status_2(analog_card, arguments, expected):
    result = analog_card(*shlex.split(arguments))
    assert result.exit_code == 2, result.output
    assert expected in result.output
    assert "Traceback" not in result.output


@pytest.mark.parametrize(
    ("arguments", "design"),
    [
        ("schematic --out", "card.svg"),
        ("trade-off --plot", "card.svg"),
        ("verify --out .", "verification.json"),
        ("verify --out .", "verification.png"),
        ("tolerance --out .", "tolerance.json"),
    ],
)
def test_the_design_is_not_written_over(analog_card, tmp_path, arguments, design):
    (tmp_path / design).write_text('title = "mine"\n')
    words = arguments.split() + [design] * (not arguments.endswith("."))
    result = analog_card(*words, "--design", design)
    assert result.exit_code == 2, result.output
    assert f"{design}: is read, and nothing that is read is written over" in result.output
    assert [path.name for path in tmp_path.iterdir() if path.name != "bad.toml"] == [design]
    assert (tmp_path / design).read_text() == 'title = "mine"\n'


@pytest.mark.ngspice
def test_verify_writes_picture_and_numbers(analog_card, tmp_path):
    result = analog_card("verify", "--out", "out")
    assert result.exit_code == 0
    # Gain and phase of 12 stages, 5 transients of 8 nodes.
    assert result.output.count("pass") == 2 * 12 + 5 * 8
    assert "FAIL" not in result.output
    assert json.loads((tmp_path / "out" / "verification.json").read_text())["passed"] is True
    assert (tmp_path / "out" / "verification.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.ngspice
def test_verify_fails_with_status_1(analog_card):
    result = analog_card("verify", "--without", "saturation")
    assert result.exit_code == 1
    assert "FAIL" in result.output
    failed = analog_card("verify", "--without", "saturation", "--json")
    assert failed.exit_code == 1
    assert json.loads(failed.output)["passed"] is False


@pytest.mark.ngspice
def test_doctor(analog_card):
    found = json.loads(analog_card("doctor", "--json").output)
    assert found["works"] is True
    assert found["gain"] == pytest.approx(0.5**0.5)
    assert int(found["ngspice"]) >= 36
    assert analog_card("doctor").output.endswith("ok\n")
