"""``pneuservo design``: the design of a sliding-mode controller from a shell."""

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from pneuservo.command_line import main
from pneuservo.errors import InputError
from pneuservo.linear import advanced_servo, servo_data
from pneuservo.rigs import load_rig
from pneuservo.sliding_mode.design import Requirements, design_sliding_mode


@pytest.fixture(scope="module")
def runner():
    return CliRunner()


@pytest.fixture(scope="module")
def found():
    return design_sliding_mode(load_rig("single-axis"))


def test_the_default_design(found):
    # (7.15) of the thesis.
    assert found.surface.weights == pytest.approx((3265.306, 114.2857, 1.0), rel=1e-6)
    assert found.level == 5.0
    # The thesis: not reachable over the range space with this valve, and yet good.
    assert not found.over_space.reachable
    assert found.required_opening > 1.0
    assert any("not reachable" in warning for warning in found.warnings)
    assert found.reserve.reserve > 0.0
    # The narrowest layer that ends at the valve's frequency everywhere, with some margin left.
    assert found.gain_margin > 1.2
    assert 5.0 < found.boundary_layer < 20.0


def test_a_larger_valve_makes_it_reachable(found):
    rig = load_rig("single-axis")
    factor = 1.1 * found.required_opening
    areas = {key: factor * rig[key] for key in rig.parameters if key.startswith("valve.flow.area")}
    # The range space of the rig as it is: what the piston has to do stays the same.
    larger = design_sliding_mode(rig.with_values(areas), Requirements(range_space="physical"))
    same = design_sliding_mode(rig, Requirements(range_space="physical"))
    assert larger.over_space.voltage < same.over_space.voltage * factor
    assert larger.along_step < found.along_step * factor


def test_a_large_cylinder_takes_its_time_and_is_designed_for():
    areas = {"piston.area_a": 7854e-6, "piston.area_b": 7363e-6}
    rig = load_rig("single-axis").with_values({**areas, "piston.stroke": 0.5})
    large = design_sliding_mode(rig)
    nominal = advanced_servo(servo_data(rig), 0.25, extending=True)
    at_full_speed = 0.5 * nominal.a1 / (nominal.b0 * large.level)
    assert at_full_speed > 20.0
    assert large.reaching_time == pytest.approx(at_full_speed, rel=0.01)


def test_a_narrow_layer_is_warned_of(found):
    narrow = design_sliding_mode(load_rig("single-axis"), Requirements(boundary_layer=2.0))
    assert narrow.gain_margin < 1.0
    assert any("gain margin" in warning for warning in narrow.warnings)
    # The margin is inverse to the gain, and the gain to the width of the layer.
    assert narrow.gain_margin == pytest.approx(found.gain_margin * 2.0 / found.boundary_layer)


def test_a_surface_too_fast_is_warned_of():
    fast = design_sliding_mode(load_rig("single-axis"), Requirements(settling_time=0.01))
    assert any("oscillate" in warning for warning in fast.warnings)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"level": 6.0}, "level is 6 V"),
        ({"step": 0.05}, "step is 0.05 m"),
        ({"boundary_layer": 0.0}, "boundary layer"),
        ({"boundary_layer": 1e-300}, r"boundary layer is 1e-300 m/s2; it has to be from 0\.001"),
        ({"boundary_layer": math.inf}, "boundary layer is inf"),
        ({"range_space": "sphere"}, "range space 'sphere'"),
    ],
)
def test_requirements_that_cannot_be_met_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        design_sliding_mode(load_rig("single-axis"), Requirements(**wrong))


def test_the_command_prints_one_json_document(runner):
    result = runner.invoke(
        main, ["design", "--overshoot", "0.0432", "--range-space", "linear", "--json"]
    )
    assert result.exit_code == 0
    report = json.loads(result.stdout)
    c1, c2 = report["weights"]["c1"], report["weights"]["c2"]
    assert c2 / (2 * math.sqrt(c1)) == pytest.approx(0.707, abs=1e-3)
    assert report["reachable"] is False
    assert report["warnings"]


def test_the_command_prints_a_table_and_draws(runner, tmp_path):
    picture = tmp_path / "design.svg"
    result = runner.invoke(main, ["design", "--range-space", "physical", "--plot", str(picture)])
    assert result.exit_code == 0
    assert "3265.3 1/s2" in result.stdout
    assert "Warning: the surface is not reachable" in " ".join(result.stdout.split())
    assert Path(picture).read_text(encoding="utf-8").startswith("<?xml")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--damping", "1", "--overshoot", "0.1"], "either --damping or --overshoot"),
        (["--plot", "design.txt"], "a picture ends in"),
        (["--rig", "dead-volume"], "single-axis is needed"),
        (["--settling-time", "0"], "not greater than 0"),
    ],
)
def test_wrong_use_is_refused_with_status_2(runner, arguments, message):
    result = runner.invoke(main, ["design", *arguments])
    assert result.exit_code == 2
    assert message in result.output


def test_a_repaired_rig_is_designed_for_without_its_effects(runner, tmp_path):
    repaired = tmp_path / "model.toml"
    effect = '[effects."friction.pressure"]\nsum = 1e-5\n'
    repaired.write_text(f'[rig]\nkind = "single-axis"\n{effect}')
    same = [
        runner.invoke(main, ["design", "--rig", str(rig), "--json"])
        for rig in ("single-axis", repaired)
    ]
    assert [result.exit_code for result in same] == [0, 0]
    assert "friction.pressure is left out here" in same[1].stderr
    weights = [json.loads(result.stdout)["weights"] for result in same]
    assert weights[0] == weights[1]
