"""Break frequency against noise and switching frequency, and the linear servo behind it."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from analog_card.command_line import main
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.linear_servo import (
    LinearServo,
    converter_step,
    detectable_frequency,
    limit_cycle,
)
from analog_card.trade_off import surface_response, trade_off, with_break_frequency

BAND = np.geomspace(20.0, 1000.0, 4000)


def test_the_limit_cycle_of_an_integrator_chain_by_hand():
    # 1/(s (s + 1)^2): phase -180 degrees at 1 rad/s, where its magnitude is 1/2; 4 M/(pi A) = 2.
    frequency = np.geomspace(0.01, 1.0, 4000)
    s = 2j * math.pi * frequency
    at, amplitude = limit_cycle(frequency, 1 / (s * (s + 1) ** 2), level=5.0)
    assert 2 * math.pi * at == pytest.approx(1.0, rel=1e-5)
    assert amplitude == pytest.approx(4 * 5.0 / math.pi / 2, rel=1e-4)


@pytest.mark.parametrize(
    ("break_frequency", "expected"),
    # An independent study of this servo: describing function, its last digit 0.1 Hz.
    [
        (None, 193.3),
        (1061.0, 130.9),
        (1950.0, 152.7),
        (2842.0, 163.0),
        (4823.0, 173.9),
        (10526.0, 183.8),
    ],
)
def test_the_filters_lower_the_limit_cycle(break_frequency, expected):
    lag = 1.0 if break_frequency is None else 1 / (1 + 1j * BAND / break_frequency) ** 2
    s = 2j * math.pi * BAND
    loop = (3265.3 + 114.286 * s * lag + (s * lag) ** 2) * LinearServo().response(BAND)
    # The two breaks of a stage are 0.7 % apart there and equal here.
    assert limit_cycle(BAND, loop, 5.0)[0] == pytest.approx(expected, rel=1e-3)


def test_the_cards_own_surface_closes_the_same_loop():
    # Scales of transducer and surface have no part in the frequency; op-amps move it by 0.1 Hz.
    loop = surface_response(load_design(), BAND) * LinearServo().response(BAND)
    assert limit_cycle(BAND, loop, 5.0)[0] == pytest.approx(163.0, abs=0.2)


def test_a_delay_lowers_the_limit_cycle():
    s = 2j * math.pi * BAND
    loop = (3265.3 + 114.286 * s + s * s) * LinearServo().response(BAND)
    assert limit_cycle(BAND, loop, 5.0, 1e-6)[0] < limit_cycle(BAND, loop, 5.0)[0]


def test_no_limit_cycle_is_said_so():
    s = 2j * math.pi * BAND
    with pytest.raises(InputError, match="does not reach -180"):
        limit_cycle(BAND, 1 / (s + 1), 5.0)


def test_the_converter_step_of_the_thesis():
    # (9.1): 3.662 um; (9.2): 0.0394 m/s2.
    assert converter_step(30e-3) == pytest.approx(3.662e-6, abs=0.5e-9)
    assert converter_step(322.57) == pytest.approx(0.0394, abs=5e-5)


def test_what_a_converter_sees_by_hand():
    # Far above its resonance the servo is b0/w^3: 5 V b0/w^3 = threshold.
    servo = LinearServo(b0=1000.0, a1=1.0, a2=1.0, valve_frequency=math.inf)
    w = (5.0 * 1000.0 / 1e-6) ** (1 / 3)
    # (a2/w)^2 and a1/w^2 are below 1e-6.
    found = detectable_frequency(servo, 5.0, 1e-6)
    assert 2 * math.pi * found == pytest.approx(w, rel=1e-5)
    with pytest.raises(InputError, match="lower threshold"):
        detectable_frequency(servo, 1e-30, 1.0)


def test_noise_grows_faster_than_the_switching_frequency():
    found = trade_off(load_design(), (1000.0, 2000.0, 5000.0, 10000.0))
    noise = [point.own_noise for point in found.points]
    switching = [point.circuit_switching_frequency for point in found.points]
    assert noise == sorted(noise)
    assert switching == sorted(switching)
    # An independent study: 0.24 m/s2 at 1.95 kHz and 1.42 at 4.82 kHz, growing about as f^2.
    assert noise[1] == pytest.approx(0.24, rel=0.1)
    assert noise[2] == pytest.approx(1.42 * (5000 / 4823) ** 2, rel=0.1)
    for point in found.points:
        assert point.circuit_switching_frequency < point.switching_frequency
        assert point.total_noise > point.own_noise


def test_the_converter_has_the_range_of_the_transducer():
    design = load_design()
    longer = replace(design, transducer=replace(design.transducer, full_scale_displacement=120e-3))
    found = [trade_off(each, (3000.0,)).detectable_frequency for each in (design, longer)]
    # The movement falls with the fifth power of the frequency at most: load, and valve squared.
    assert found[1] < found[0] / 4 ** (1 / 5)


def test_only_the_breaks_change():
    design = load_design()
    changed = with_break_frequency(design, 1000.0).soldered.velocity_differentiator
    assert changed.series_resistance * changed.capacitance == pytest.approx(1 / (2000 * math.pi))
    assert changed.capacitance == design.soldered.velocity_differentiator.capacitance
    with pytest.raises(InputError, match="above 0 Hz"):
        trade_off(design, (0.0,))


def test_the_command_draws_and_prints(tmp_path):
    picture = tmp_path / "trade-off.svg"
    result = CliRunner().invoke(main, ["trade-off", "--plot", str(picture), "--json"])
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    assert len(found["points"]) == 11
    # 163 Hz ideal, 4 % less as a circuit.
    assert found["nominal"]["switching_frequency"] == pytest.approx(163.0, abs=0.5)
    assert picture.read_text(encoding="utf-8").startswith("<?xml")
    refused = CliRunner().invoke(main, ["trade-off", "--plot", str(tmp_path / "x.gif")])
    assert refused.exit_code == 2
