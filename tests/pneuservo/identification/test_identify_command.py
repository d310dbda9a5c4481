"""``pneuservo identify`` as a user runs it."""

import json
from dataclasses import replace

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.identification import simulate_excitation
from pneuservo.recordings import write_recording
from pneuservo.rigs import load_rig


def run(*arguments):
    return CliRunner().invoke(main, ["identify", *map(str, arguments)])


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("identification") / "sweep.csv"
    made = simulate_excitation(duration=3.0, amplitude=0.004, seed=4, held=True)
    write_recording(made, path)
    return path


def document(recording, folder, *options):
    done = run(recording, *options, "--out", folder, "--json")
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def test_output_error_gives_values_intervals_correlations_and_whiteness(recording, tmp_path):
    answer = document(recording, tmp_path)
    assert answer["method"] == "output-error"
    mass = answer["values"]["load.mass"]
    assert mass["low"] < mass["value"] < mass["high"]
    # Some ten times the half width of the interval.
    assert mass["value"] == pytest.approx(1.825, rel=5e-3)
    assert mass["unit"] == "kg"
    assert len(answer["correlations"]) == 3
    assert all(residual["white"] for residual in answer["residuals"].values())
    assert answer["cannot_tell_apart"]
    assert json.loads((tmp_path / "identification.json").read_text()) == answer
    assert (tmp_path / "fit.svg").read_text().startswith("<svg")


def test_the_rig_it_writes_holds_the_values(recording, tmp_path):
    answer = document(recording, tmp_path)
    rig = load_rig(tmp_path / "rig.toml")
    for name, entry in answer["values"].items():
        assert rig[name] == pytest.approx(entry["value"])


def test_a_condition_that_the_fit_began_at_leaves_the_value_found_alone(tmp_path):
    heavy = load_rig("single-axis").with_values({"load.mass": 2.4})
    made = simulate_excitation(heavy, duration=1.0, amplitude=0.004, seed=4, held=True)
    stated = {"load_mass": 2.0}
    write_recording(replace(made, rig="single-axis", conditions=stated), tmp_path / "heavy.csv")
    answer = document(tmp_path / "heavy.csv", tmp_path, "--method", "least-squares")
    found = answer["values"]["load.mass"]["value"]
    assert found == pytest.approx(2.4, rel=0.1)
    rig = load_rig(tmp_path / "rig.toml")
    assert rig.with_conditions(stated)["load.mass"] == found
    assert rig.with_conditions({"load_mass": 3.0})["load.mass"] == 3.0
    # Again from there: what was taken to be before the first fit stays.
    document(tmp_path / "heavy.csv", tmp_path / "again", "--rig", tmp_path / "rig.toml")
    assert load_rig(tmp_path / "again" / "rig.toml").parameters["load.mass"].nominal == 2.0


def test_the_rig_it_writes_is_otherwise_the_one_it_was_given(recording, tmp_path):
    given = tmp_path / "given.toml"
    given.write_text(
        '[rig]\nkind = "single-axis"\ntitle = "mine"\n[parameters]\n"supply.pressure" = "6.6 bar"\n'
        '[transducers.pressure]\nnoise = "500 Pa"\n'
    )
    options = ("--rig", given, "--method", "least-squares")
    answer = document(recording, tmp_path / "found", *options)
    rig = load_rig(tmp_path / "found" / "rig.toml")
    assert rig["load.mass"] == pytest.approx(answer["values"]["load.mass"]["value"])
    assert (rig.title, rig["supply.pressure"]) == ("mine", 6.6e5)
    assert rig.transducers["pressure"].noise == 500.0


def test_parameters_that_act_alike_are_named(recording, tmp_path):
    answer = document(
        recording, tmp_path,
        "--parameter", "valve.flow.area_s_a", "--parameter", "supply.pressure",
        "--parameter", "valve.flow.area_s_b",
    )  # fmt: skip
    assert "cannot be told apart" in " ".join(answer["cannot_tell_apart"])


def test_least_squares_also_gives_each_direction(recording, tmp_path):
    answer = document(recording, tmp_path, "--method", "least-squares")
    assert [entry["direction"] for entry in answer["each"]] == ["extending", "retracting"]
    one = document(recording, tmp_path, "--method", "least-squares", "--direction", "extending")
    assert one["values"] == answer["each"][0]["values"]


def test_people_get_a_table(recording, tmp_path):
    done = run(recording, "--method", "least-squares", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert "load.mass" in done.stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--parameter", "load.mas"), "load.mass"),
        (("--method", "least-squares", "--parameter", "load.mass"), "output-error"),
        (("--window", "9:10"), "no sample lies"),
        (("--rig", "dead-volume"), "single-axis is needed"),
        (("--cutoff", "20 Hz"), "--cutoff is not used by --method output-error"),
        (("--method", "evolution", "--direction", "extending"), "--direction is not used by"),
        (("--method", "least-squares", "--segment", "1 s"), "--segment is not used by"),
        (("--method", "least-squares", "--command", "continuous"), "--command is not used by"),
        (("--method", "least-squares", "--cutoff", "1e9"), "cut-off of 1e+09 Hz"),
        (("--method", "least-squares", "--cutoff", "1e-9"), "above 1.33 Hz, for the filter"),
        (("--segment", "1e-9"), "has to be 8 samples or more"),
    ],
)
def test_what_cannot_be_used_is_said_without_a_traceback(recording, tmp_path, options, message):
    done = run(recording, *options, "--out", tmp_path)
    assert done.exit_code == 2, done.output
    assert message in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.output
