"""The main job, as `make run` starts it."""

import json

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.examples.leaking_volume import write_example
from pneuservo.rigs import load_rig

pytestmark = pytest.mark.ngspice


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    result = CliRunner().invoke(main, ["demo", "--out", str(folder)])
    assert result.exit_code == 0, result.output
    return folder


def test_the_four_parts_give_their_figures(folder):
    summary = json.loads((folder / "summary.json").read_text())
    fractions = [pot["fraction"] for pot in summary["potentiometers"].values()]
    # Card notes section 2: settings for 0.07 s, damping 1, 5 m/s2, 5 V.
    assert fractions == pytest.approx([0.482, 0.727, 0.151, 0.725], abs=6e-4)
    assert summary["netlist"]["passed"]
    targets = [(step["from"], step["to"]) for step in summary["steps"]]
    for found, asked in zip(targets, [(0.015, 0.024), (0.024, 0.006), (0.006, 0.015)], strict=True):
        assert found == pytest.approx(asked, abs=1e-5)
    # A double pole at 57 rad/s settles to 2 % in 0.102 s; the boundary layer makes it slower.
    assert all(0.1 < step["settling_time"] < 0.2 for step in summary["steps"])
    # 12-bit resolution of the displacement is 7 um: a settled loop without offsets is far below.
    assert all(abs(step["steady_state_error"]) < 2e-6 for step in summary["steps"])
    assert summary["verdict"] == "missing-physics"


def test_the_example_is_diagnosed_as_what_it_is(folder):
    answer = json.loads((folder / "diagnosis.json").read_text())
    leak = next(entry for entry in answer["missing"] if entry["effect"].startswith("leakage."))
    assert leak["block"] == "dead-volume"
    start = leak["parameters"]["start"]
    # The example lets go of the volume at 4 s; its samples are 0.1 s apart.
    assert start["value"] == pytest.approx(4.0, abs=0.1)
    fit = answer["fit"]["channels"]["dead_volume_pressure"]
    # Noise of 250 Pa and steps of 100 Pa: 252 Pa.
    assert fit["after"]["used"] < 1.1 * 252.0


def test_the_page_needs_nothing_else(folder):
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count("<svg") >= 5
    for reference in ("src=", "<link", "@import", "<script"):
        assert reference not in page
    assert load_rig(folder / "model.toml").effects


def test_a_recording_of_the_users_own(tmp_path):
    own = write_example(tmp_path / "mine", seed=3)
    before = own.read_bytes()
    result = CliRunner().invoke(
        main, ["demo", "--out", str(tmp_path / "out"), "--recording", str(own)]
    )
    assert result.exit_code == 0, result.output
    assert own.read_bytes() == before
    assert not (tmp_path / "out/example").exists()
    assert "leaking-volume.csv" in (tmp_path / "out/report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("content", "message"),
    [(None, "no such file"), ("a;b\n1;2\n", "leaking.csv")],
    ids=["missing", "not a recording"],
)
def test_a_recording_that_cannot_be_used_costs_nothing(tmp_path, content, message):
    path = tmp_path / "leaking.csv"
    if content is not None:
        path.write_text(content)
    result = CliRunner().invoke(
        main, ["demo", "--out", str(tmp_path / "out"), "--recording", str(path)]
    )
    assert result.exit_code == 2
    assert message in result.output.replace("\n", " ")
    assert not (tmp_path / "out").exists()
