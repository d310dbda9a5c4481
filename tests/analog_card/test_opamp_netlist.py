"""The op-amp macromodel against the data-sheet figures it is made from."""

from dataclasses import replace

import numpy as np
import pytest

import netlists
from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.ngspice import FrequencySweep, Noise, Transient, noise_voltage, run
from analog_card.noise import opamp_noise
from analog_card.opamp_bench import LIMIT, measure_opamp

pytestmark = pytest.mark.ngspice

FIGURES = load_design().soldered.operational_amplifier
BENCHES = netlists.shipped()
# What follows from the other figures and cannot be met with them.
NOT_MET = {
    "settling to 10 mV, 10 V step",
    "settling to 1 mV, 10 V step",
    "rise time, small step",
}


@pytest.fixture(scope="module")
def figures():
    return {figure.name: figure for figure in measure_opamp()}


def test_every_figure_is_within_5_per_cent_or_says_why_not(figures):
    assert LIMIT == 5.0
    assert {name for name, figure in figures.items() if not figure.within} == NOT_MET
    assert {name for name, figure in figures.items() if figure.why} == NOT_MET
    assert len(figures) == 25
    for figure in figures.values():
        assert figure.bench in {path.name for path in BENCHES.values()}


@pytest.mark.parametrize(
    ("name", "data_sheet", "tolerance"),
    [
        # The clamp diodes' leakage takes 1e-12 S of 8.5e-9 S; one pole at 45 Hz is seen at 0.1 Hz
        # as (0.1/45)^2/2.
        ("open-loop gain", 1e5, 5e-4),
        # 0.07 % of the compensation is the second pole's capacitor, whose pole takes (1/90)^2/2.
        ("gain-bandwidth", 4.5e6, 1e-3),
        ("common-mode rejection", 10 ** (90 / 20), 1e-4),
        ("positive supply rejection", 1e4, 1e-4),
        ("negative supply rejection", 1e4, 1e-4),
        # The open-loop gain takes 1e-5 of the offset, the common mode 3e-5.
        ("input offset voltage", 5e-3, 1e-4),
        ("offset drift", 8e-6, 1e-4),
        ("input bias current", 10e-12, 1e-6),
        ("input offset current", 0.5e-12, 1e-6),
        ("input resistance", 1.5e12, 1e-3),
        ("input capacitance", 4e-12, 1e-6),
        # The clamp diode's drop is set by formula for 27 C, the temperature of SPICE.
        ("positive swing into 2 kohm", 13.0, 4e-4),
        ("negative swing into 2 kohm", -14.4, 4e-4),
        # tanh(13.4 V/(60 ohm x 40 mA)) falls short of 1 by 3e-5.
        ("source current limit", 40e-3, 1e-4),
        ("sink current limit", 18e-3, 1e-4),
        ("output resistance", 60.0, 1e-4),
        ("supply current", 4e-3, 1e-4),
    ],
)
def test_the_figures_that_are_parameters_are_met(figures, name, data_sheet, tolerance):
    assert figures[name].data_sheet == pytest.approx(data_sheet, rel=1e-6)
    assert figures[name].measured == pytest.approx(data_sheet, rel=tolerance)


def test_other_figures_reach_the_model_and_the_table():
    other = replace(
        FIGURES,
        gain_bandwidth=2e6,
        slew_rate=4e6,
        positive_swing=11.0,
        sink_limit=10e-3,
        output_resistance=100.0,
        common_mode_rejection=1e3,
        offset_current=-2e-12,
        noise_1_kilohertz=100e-9,
        noise_10_kilohertz=30e-9,
    )
    found = {figure.name: figure for figure in measure_opamp(other)}
    for name in (
        "gain-bandwidth",
        "slew rate, 10 V step",
        "positive swing into 2 kohm",
        "sink current limit",
        "output resistance",
        "common-mode rejection",
        "input offset current",
        "noise in 1 Hz at 1 kHz",
    ):
        assert found[name].within, found[name]
    # The sheet's full-power bandwidth follows from 9 V/us; at 4 V/us it is missed, with no excuse.
    assert not found["full-power bandwidth, +-10 V"].passed


def test_an_op_amp_that_is_slower_is_given_the_time_that_it_takes():
    slow = replace(FIGURES, slew_rate=0.5e6, gain_bandwidth=60e3, positive_swing=3.0)
    found = {figure.name: figure for figure in measure_opamp(slow)}
    # From -5 to 3 V at 0.5 V/us.
    assert found["settling to 1 mV, 10 V step"].measured > 8 / 0.5e6
    # From 10 to 90 % by one pole at 60 kHz; the slewing ahead of it adds 2 %.
    rise = np.log(9) / (2 * np.pi * 60e3)
    assert found["rise time, small step"].measured == pytest.approx(rise, rel=0.03)
    # An output that ends at 3 V never reaches the 4 V that the slew rate is measured to.
    assert np.isnan(found["slew rate, 10 V step"].measured)
    assert not found["slew rate, 10 V step"].passed


def test_an_excuse_goes_no_further_than_its_reason(figures):
    for name in NOT_MET:
        known = figures[name]
        assert known.passed
        # Nor do three hundredths of the data sheet more pass, or any that is slower than it.
        for further in (known.measured - 0.03 * known.data_sheet, 1.1 * known.data_sheet):
            assert not replace(known, measured=further).passed


def test_second_pole_turns_the_phase_on():
    # atan(1 MHz/9 MHz) = 6.3 degrees beyond the 90 of the first pole, at 1 MHz; the first pole at
    # 45 Hz and the input capacitance leave less than 0.01.
    sweep = run(BENCHES["opamp-open-loop"], FrequencySweep(1e6, 1e7, 1))
    phase = np.angle(sweep["differential"][0], deg=True)
    assert phase == pytest.approx(-90 - np.degrees(np.arctan(1 / 9)), abs=0.05)


def test_noise_is_flicker_between_the_two_points():
    result = run(BENCHES["opamp-noise"], Noise("out", "vdrive", 10, 1e5, 10))
    density = result.noise_density
    # 1/f: 20 dB in two decades of frequency; the diodes' shot noise, 0.7 nV, is 1.7 % at 100 kHz.
    assert density[0] / density[20] == pytest.approx(10, rel=1e-3)
    voltage = noise_voltage(result.frequency, density, 10, 1e4)
    # Integral of k/f with k = (40 nV)(12 nV) sqrt(1 kHz 10 kHz)
    k = 40e-9 * 12e-9 * np.sqrt(1e7)
    assert voltage == pytest.approx(np.sqrt(k * np.log(1e3)), rel=1e-3)


@pytest.mark.parametrize("points", [(18e-9, 18e-9), (20e-9, 12e-9), (40e-9, 12e-9)])
def test_noise_is_white_and_flicker_through_both_points(points):
    low, high = points
    quiet = replace(FIGURES, noise_1_kilohertz=low, noise_10_kilohertz=high)
    found = {figure.name: figure for figure in measure_opamp(quiet)}
    # Within a thousandth where not steeper than 1/f, as the CA3140's are; 0.7 nV of the diodes.
    within = 30e-3 if low > np.sqrt(10) * high else 3e-3
    for name, stated in (("1 kHz", low), ("10 kHz", high)):
        assert found[f"noise in 1 Hz at {name}"].measured == pytest.approx(stated, rel=within)
    design = load_design()
    design = replace(design, soldered=replace(design.soldered, operational_amplifier=quiet))
    computed = opamp_noise(design, np.array([1e3, 10e3]))
    assert computed == pytest.approx(points, rel=within)


@pytest.mark.parametrize("points", [(10e-9, 12e-9), (100e-9, 12e-9)])
def test_noise_that_rises_or_falls_too_fast_is_refused(points):
    low, high = points
    with pytest.raises(InputError, match="white and 1/f noise has from 1 to 5 times as much"):
        replace(FIGURES, noise_1_kilohertz=low, noise_10_kilohertz=high)


def test_the_variant_without_noise_has_none_of_it(tmp_path):
    quiet = netlists.ROOT / "opamp" / "ca3140.lib"
    file = tmp_path / "bench.cir"
    text = BENCHES["opamp-noise"].read_text()
    file.write_text(text.replace("../opamp/ca3140-noisy.lib", str(quiet)))
    result = run(file, Noise("out", "vdrive", 100, 1e4, 5))
    # Left are the resistors of the model, below 1 nV in 1 Hz.
    assert result.noise_density.max() < 1e-9


def test_recovery_from_saturation_is_that_of_the_slew_rate(tmp_path):
    file = tmp_path / "recovery.cir"
    model = netlists.ROOT / "opamp" / "ca3140.lib"
    file.write_text(
        f"recovery\n.include {model}\nVcc vcc 0 15\nVee vee 0 -15\n"
        "Vin in 0 pulse(-1 1 1u 1n 1n 5u 10u)\nR1 in minus 1k\nR2 minus out 20k\n"
        "X1 0 minus vcc vee out ca3140\nRl out 0 2k\n.end\n"
    )
    result = run(file, Transient(4e-6, 5e-9))
    times = np.linspace(1e-6, 4e-6, 3001)
    out = result.at(times, "out")
    # Overdriven, then 1 V the other way: from 13 V to 0 at 9 V/us are 1.4 us. No wind-up adds to
    # it; discharging the input capacitance through 1 kohm and leaving the clamp add 0.1 us each.
    assert out[0] == pytest.approx(13.0, abs=0.1)
    crossing = times[np.argmax(out < 0)] - 1e-6
    assert 13.0 / 9e6 < crossing < 13.0 / 9e6 + 0.2e-6
