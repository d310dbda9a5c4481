"""What a card reaches, how finely it turns, and the way back from its settings."""

import json
import math
from dataclasses import replace

import pytest
from click.testing import CliRunner

from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.reach import sensitivities
from analog_card.tuning import read_settings, tune, with_transducer_gain


def limit(tuning, quantity, reason=""):
    return next(
        item for item in tuning.limits if item.quantity == quantity and reason in item.reason
    )


def run(*arguments):
    return CliRunner().invoke(main, ["tune", *arguments])


def test_settings_read_back_as_they_were_tuned():
    tuning = tune(0.1, damping=0.7, boundary_layer=8.0, level=4.0)
    found = read_settings(tuning.design)
    # Closed formulas both ways: rounding alone.
    assert found.settling_time == pytest.approx(0.1, rel=1e-12)
    assert found.damping == pytest.approx(0.7, rel=1e-12)
    assert found.achieved == pytest.approx(
        {
            "c1": tuning.weights.displacement,
            "c2": tuning.weights.velocity,
            "boundary_layer": 8.0,
            "level": 4.0,
        },
        rel=1e-12,
    )


def test_a_card_turned_to_nothing_has_no_settling_time():
    design = load_design()
    turned = replace(design.turned, displacement_weight=0.0, velocity_weight=0.0)
    found = read_settings(replace(design, turned=turned)).to_dict()
    assert found["settling_time"] is None
    assert found["damping"] is None
    json.dumps(found, allow_nan=False)


def test_a_card_without_damping_reaches_no_settling_time():
    design = load_design()
    turned = replace(design.turned, velocity_weight=0.0)
    found = read_settings(replace(design, turned=turned))
    assert (found.settling_time, found.damping) == (math.inf, 0.0)
    assert limit(found, "settling time").lowest == math.inf
    json.dumps(found.to_dict(), allow_nan=False)


def test_the_transducer_scale_moves_what_depends_on_it():
    # Surface volts for each m/s2 grow with the scale, so that the same layer takes half the gain;
    # the weights are ratios of states and stay.
    usual, doubled = tune(0.07), tune(0.07, transducer_gain=2 * 10 / 0.03)
    assert doubled.achieved == pytest.approx(usual.achieved)
    assert doubled.design.turned.displacement_weight == pytest.approx(
        usual.design.turned.displacement_weight
    )
    gains = [1 + (3.9e3 + item.design.turned.boundary_layer * 100e3) / 620 for item in
             (usual, doubled)]  # fmt: skip
    assert gains[0] == pytest.approx(2 * gains[1])
    assert limit(doubled, "velocity").highest == pytest.approx(limit(usual, "velocity").highest / 2)
    with pytest.raises(InputError, match="transducer gain"):
        with_transducer_gain(load_design(), -1.0)


def test_limits_by_hand():
    tuning = tune(0.07)
    # Full travel is not loaded: Rf/R1 / (RC)^2 and Rf/R2 / (RC).
    assert limit(tuning, "c1").highest == pytest.approx(1 / 0.012**2)
    assert limit(tuning, "c2").highest == pytest.approx(100 / 51 / 0.012)
    # 8/c2, longer than 4/sqrt(c1) = 0.048 s.
    assert limit(tuning, "settling time").lowest == pytest.approx(8 * 0.012 * 51 / 100)
    # 13 V over 333.3 V/m, RC and RC squared.
    assert limit(tuning, "velocity").highest == pytest.approx(13 / (333.333333 * 0.012))
    assert limit(tuning, "acceleration").highest == pytest.approx(13 / (333.333333 * 0.012**2))
    # An independent study: 1..22 m/s2.
    layer = limit(tuning, "boundary layer", "P3")
    assert (layer.lowest, layer.highest) == pytest.approx((0.95, 22.0), rel=0.02)
    assert all(item.holds for item in tuning.limits)


def test_what_saturates_and_what_is_noise_is_said_so():
    # RC = 26 ms: 82 m/s2 would be 18.5 V.
    design = load_design()
    slow = {
        name: replace(getattr(design.soldered, name), resistance=260e3)
        for name in ("velocity_differentiator", "acceleration_differentiator")
    }
    saturating = replace(design, soldered=replace(design.soldered, **slow))
    assert not limit(read_settings(saturating), "acceleration").holds
    # Three times 23.5 mV of noise over 48 mV for each m/s2 is 1.5 m/s2.
    narrow = limit(tune(0.07, boundary_layer=1.0), "boundary layer", "noise")
    assert narrow.lowest == pytest.approx(1.47, rel=0.02)
    assert not narrow.holds


def test_sensitivities_by_hand():
    p1, p2, p3, p4 = sensitivities(load_design(), turns=20)
    # w = Rf f/(R + f (1 - f) T): d ln w/d ln f = 1 - f (1 - 2 f) T/(R + f (1 - f) T).
    for found, f, resistance, value in (
        (p1, 0.4819438539, 100e3, 3265.3),
        (p2, 0.7266681013, 51e3, 114.2857),
    ):
        expected = 1 - f * (1 - 2 * f) * 10e3 / (resistance + f * (1 - f) * 10e3)
        assert found.relative == pytest.approx(expected, rel=1e-5)
        assert found.per_turn == pytest.approx(value * expected / f / 20, rel=1e-4)
    # phi goes as 1/(Rg + Rf + f T): -f T/(0.62 + 3.9 + f T) in kohm.
    assert p3.relative == pytest.approx(-15.0875 / (4.52 + 15.0875), rel=1e-4)
    assert p4.per_turn == pytest.approx(6.9 / 20)


def test_a_potentiometer_at_its_end_still_has_a_sensitivity():
    design = load_design()
    turned = replace(design.turned, level=1.0, boundary_layer=0.0)
    _, _, p3, p4 = sensitivities(replace(design, turned=turned))
    assert p4.per_turn == pytest.approx(0.69)
    assert math.isfinite(p3.per_turn)


def test_json_has_settings_achieved_and_limits():
    found = json.loads(run("--settling-time", "0.07", "--json").stdout)
    assert found["settings"]["P1"] == pytest.approx(
        {"fraction": 0.48194385, "ohm": 4819.4385}, rel=1e-6
    )
    assert set(found["settings"]) == {"P1", "P2", "P3", "P4"}
    assert found["achieved"]["c1"] == pytest.approx(3265.306, rel=1e-6)
    assert set(found["achieved"]) == {"c1", "c2", "boundary_layer", "level"}
    assert all({"quantity", "highest", "reason", "holds"} <= set(item) for item in found["limits"])


def test_the_way_back_from_a_file(tmp_path):
    file = tmp_path / "card.toml"
    assert run("--settling-time", "90ms", "--damping", "0.8", "--out", str(file)).exit_code == 0
    found = json.loads(run("--from", str(file), "--json").stdout)
    # A design file holds its settings to all digits.
    assert found["settling_time"] == pytest.approx(0.09, rel=1e-9)
    assert found["damping"] == pytest.approx(0.8, rel=1e-9)
    shown = run("--from", str(file))
    assert shown.exit_code == 0
    assert "settling time 0.09 s, damping 0.8" in shown.stdout


def test_both_ways_at_once_are_refused(tmp_path):
    file = tmp_path / "card.toml"
    file.write_text("")
    refused = run("--from", str(file), "--settling-time", "0.07")
    assert refused.exit_code == 2
    assert "--settling-time is not used with --from" in refused.stderr
