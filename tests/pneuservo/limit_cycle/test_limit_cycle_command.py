"""The command ``pneuservo limit-cycle``."""

import json

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main


def run(*arguments):
    return CliRunner().invoke(main, ["limit-cycle", *arguments])


def test_json_has_every_method():
    result = run("--json", "--sampling-time", "1ms")
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)
    methods = report["methods"]
    assert set(methods) == {
        "describing_function",
        "exact",
        "linear_simulation",
        "nonlinear_simulation",
    }
    for values in methods.values():
        assert {"frequency", "amplitude", "stable", "mean_error"} <= set(values)
    # 1 kHz, all states measured: the thesis has 145 Hz.
    assert methods["describing_function"]["frequency"] == pytest.approx(145, rel=0.1)
    assert report["detectable_frequency"] > 100.0


def test_table_and_picture(tmp_path):
    picture = tmp_path / "cycle.svg"
    result = run("--boundary-layer", "5", "--plot", str(picture))
    assert result.exit_code == 0, result.output
    assert "none" in result.stdout
    assert "<svg" in picture.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--differentiation", "backward"], "sampling time"),
        (["--position", "31mm"], "outside the stroke"),
        (["--plot", "cycle.gif"], ".svg"),
        (["--rig", "dead-volume"], "single-axis is needed"),
    ],
)
def test_what_cannot_be_is_refused(arguments, words):
    result = run(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr
