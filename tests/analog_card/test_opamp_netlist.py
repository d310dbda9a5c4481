"""The op-amp macromodel against the data-sheet figures it is made from."""

import numpy as np
import pytest

import netlists
from analog_card.design_file import load_design
from analog_card.ngspice import FrequencySweep, OperatingPoint, Transient, run

pytestmark = pytest.mark.ngspice

FIGURES = load_design().soldered.operational_amplifier
SUPPLIES = [
    f".include {netlists.ROOT / 'opamp' / 'ca3140.lib'}",
    "Vcc vcc 0 15",
    "Vee vee 0 -15",
]


@pytest.fixture
def bench(tmp_path):
    def write(*lines):
        file = tmp_path / "bench.cir"
        file.write_text("\n".join(["bench", *SUPPLIES, *lines, ".end"]) + "\n")
        return file

    return write


def test_open_loop_gain(bench):
    file = bench("Vin in 0 0 ac 1", "X1 in 0 vcc vee out ca3140")
    sweep = run(file, FrequencySweep(0.1, 1e5, 1))
    gain = np.abs(sweep["out"])
    # One pole at GBW/gain = 45 Hz: flat at 0.1 Hz, GBW/f at 100 kHz, each to (0.1/45)^2/2 and
    # (45/1e5)^2/2; the clamp diodes' leakage takes 1e-12 S of 8.5e-9 S.
    assert gain[0] == pytest.approx(FIGURES.open_loop_gain, rel=5e-4)
    assert gain[-1] * 1e5 == pytest.approx(FIGURES.gain_bandwidth, rel=5e-4)


@pytest.mark.parametrize(
    ("drive", "sign"), [("pulse(-5 5 0 1n 1n 1 2)", 1), ("pulse(5 -5 0 1n 1n 1 2)", -1)]
)
def test_slew_rate_of_a_follower(bench, drive, sign):
    file = bench(f"Vin in 0 {drive}", "X1 in out vcc vee out ca3140")
    result = run(file, Transient(2e-6, 1e-9))
    # Past the kick that the edge sends through the input capacitance.
    times = np.linspace(50e-9, 2e-6, 2001)
    out = sign * result.at(times, "out")
    ten, ninety = np.interp([-4, 4], out, times)
    # The input stage leaves saturation at differences of SR/(2 pi GBW) = 0.32 V: at the last
    # volt its current is tanh(1/0.32) = 0.996 of the limit.
    assert 8 / (ninety - ten) == pytest.approx(FIGURES.slew_rate, rel=4e-3)


@pytest.mark.parametrize(
    ("drive", "expected"), [(1, FIGURES.positive_swing), (-1, -FIGURES.negative_swing)]
)
def test_swing_into_2_kilohm(bench, drive, expected):
    file = bench(f"Vin in 0 {drive}", "X1 in 0 vcc vee out ca3140", "Rload out 0 2k")
    # The clamp diode's drop is set by formula; its temperature is that of SPICE, 27 C.
    assert run(file, OperatingPoint())["out"][0] == pytest.approx(expected, abs=5e-3)


@pytest.mark.parametrize(
    ("drive", "expected"), [(1, FIGURES.source_limit), (-1, -FIGURES.sink_limit)]
)
def test_short_circuit_current(bench, drive, expected):
    file = bench(f"Vin in 0 {drive}", "X1 in 0 vcc vee out ca3140", "Vshort out 0 0")
    # tanh(13.4 V/(60 ohm x 40 mA)) falls short of 1 by 3e-5.
    assert run(file, OperatingPoint())["vshort#branch"][0] == pytest.approx(expected, rel=1e-4)


def test_offset_and_bias_of_a_follower(bench):
    file = bench("R1 in 0 1g", "X1 in out vcc vee out ca3140 offset=5m")
    # The bias current flows into the input: 10 pA through 1 Gohm. Gain 1e5 takes 1e-5 of it all;
    # ngspice adds 1e-12 S from each node to ground.
    assert run(file, OperatingPoint())["out"][0] == pytest.approx(5e-3 - 10e-3, rel=5e-3)
