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


def test_the_slowest_controller_that_is_allowed_is_judged():
    result = run("--sampling-time", "0.1", "--json")
    assert result.exit_code == 0, result.output
    methods = json.loads(result.stdout)["methods"]
    for method in ("linear_simulation", "nonlinear_simulation"):
        # Switching at every sample is the fastest that there is, 5 Hz.
        assert 3.0 < methods[method]["frequency"] < 5.01


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--differentiation", "backward"], "sampling time"),
        (["--position", "31mm"], "outside the stroke"),
        (["--plot", "cycle.gif"], ".svg"),
        (["--rig", "dead-volume"], "single-axis is needed"),
        (["--filter-frequency", "100"], "--filter-frequency is not used by --filter none"),
        (["--break-frequency", "1e4"], "--break-frequency is not used by --differentiation"),
        (["--sampling-time", "1"], "sampling time is 1 s; it has to be 0"),
        (["--level", "1e300"], "level is 1e+300 V; it has to be from 0.001 to 1000 V"),
        (["--boundary-layer", "1e-300"], "boundary layer is 1e-300 m/s2; it has to be 0"),
        (["--filter", "all", "--filter-frequency", "1e300"], "filter frequency is 1e+300 Hz"),
        (["--differentiation", "analogue", "--break-frequency", "1e7"], "frequency is 1e+07 Hz"),
        (["--differentiation", "analogue", "--break-frequency", "1e-300"], "frequency is 1e-300"),
    ],
)
def test_what_cannot_be_is_refused(arguments, words):
    result = run(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr
