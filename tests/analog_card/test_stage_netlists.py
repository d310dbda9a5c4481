"""The stages and the card as netlists: hand calculations, faults, temperature and supplies."""

import re
import shutil
import subprocess

import numpy as np
import pytest

import netlists
from analog_card.design_file import load_design
from analog_card.figures import card_figures
from analog_card.ngspice import (
    FrequencySweep,
    Noise,
    OperatingPoint,
    Session,
    SourceSweep,
    Transient,
    noise_voltage,
    run,
)

pytestmark = pytest.mark.ngspice

BENCHES = netlists.shipped()
DESIGN = load_design()
VALUES = DESIGN.netlist_parameters()
NO_OFFSETS = {name: 0.0 for name in VALUES if name.endswith("_offset")}
# Circuits of the closed loop are tested with the plant.
OF_THE_CARD = sorted(name for name, path in BENCHES.items() if "plant" not in path.read_text())


@pytest.mark.skipif(shutil.which("ngspice") is None, reason="the ngspice program is not installed")
@pytest.mark.parametrize("name", OF_THE_CARD)
def test_batch_ngspice_runs_it_unchanged(name):
    path = BENCHES[name]
    done = subprocess.run(
        ["ngspice", "-b", path.name], cwd=path.parent, capture_output=True, text=True, timeout=60
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said[-2000:]
    assert re.search(r"No\. of Data Rows : [1-9]", said)
    assert not re.search(r"^(error|warning: can't|.*singular|.*abort)", said, re.I | re.M)


def test_a_follower_passes_the_transducer_on():
    sweep = run(BENCHES["buffer"], FrequencySweep(1, 1e5, 10))
    # 1/(1 + 1/A): at 100 kHz A is 45 at -91 degrees, which leaves 1/45^2/2 of the gain; 3 kohm
    # and 3.9 kohm carry only the current of an input capacitance with no voltage across it.
    gain = np.abs(sweep["out"])
    assert gain[0] == pytest.approx(1, abs=5e-5)
    assert gain[-1] == pytest.approx(1, abs=2e-3)


def test_the_difference_amplifier_subtracts():
    swept = run(
        BENCHES["difference-amplifier"], SourceSweep("vdisplacement", 0, 10, 2.5), NO_OFFSETS
    )
    # 2/A = 2e-5 of the output, and the common mode over the rejection twice: 5 V/31623 x 2.
    np.testing.assert_allclose(swept["out"], swept.sweep - 5, atol=1e-4 + 5e-4)
    common = run(BENCHES["difference-amplifier"], FrequencySweep(1, 10, 1))
    # Equal resistors: half the drive is common mode, and the noise gain is 2. The output carries
    # 1 V/20 kohm through 60 ohm, 3 mV over the open-loop gain, times 2.
    assert abs(common["rest"][0]) == pytest.approx(1 / 31623 + 2 * 3e-3 / 1e5, rel=1e-4)


def test_the_inverter_inverts():
    sweep = run(BENCHES["inverter"], FrequencySweep(1, 1e5, 1))
    # -1/(1 + 2/A)
    assert sweep["out"][0] == pytest.approx(-1, abs=3e-5)
    assert abs(sweep["out"][-1]) == pytest.approx(1 / np.hypot(1, 2 / 45), rel=2e-3)


def test_a_state_weight_is_that_of_a_loaded_potentiometer():
    point = run(BENCHES["state-weight"], OperatingPoint())
    track, resistor, end, wiper = 10e3, 100e3, 2.0, 3.0
    for name, fraction in (("set", 0.4819438539), ("top", 1.0)):
        lower, upper = fraction * track + end, (1 - fraction) * track + end
        share = lower / (lower + upper)
        expected = share / (resistor + wiper + lower * upper / (lower + upper))
        # Parts of the track are never less than 1 mohm.
        assert point[f"v{name}#branch"][0] == pytest.approx(expected, rel=1e-6)
    # At the bottom the end resistance is left: 2 ohm of 10 kohm.
    assert point["vbottom#branch"][0] * resistor == pytest.approx(2e-4, rel=1e-3)


def test_the_surface_amplifier_has_the_weights_of_the_design():
    sweep = run(BENCHES["surface-amplifier"], FrequencySweep(1, 10, 1))
    figures = card_figures(DESIGN)
    for name, weight in (
        ("deviation", figures.weight_displacement),
        ("velocity", figures.weight_velocity),
        ("acceleration", figures.weight_acceleration),
    ):
        # Not in the design's figures: ends and wiper of the potentiometers, 2 and 3 ohm of 10
        # kohm (2 x 2e-4 of travel), and the noise gain 4.7 over the open-loop gain.
        assert abs(sweep[name][0]) == pytest.approx(weight, rel=4e-4 + 5e-5)


def test_the_boundary_layer_is_that_of_the_design():
    swept = run(BENCHES["boundary-layer"], SourceSweep("vsurface", -0.6, 0.6, 5e-3), NO_OFFSETS)
    figures = card_figures(DESIGN)
    surface, control = swept.sweep, swept["control"]
    inside = np.abs(surface) < 0.1
    slope = np.polyfit(surface[inside], control[inside], 1)[0]
    # Ends and wiper of P3 and P4 (5 ohm in 19 kohm, 2 in 10 kohm), gain 31.6 over 1e5.
    assert slope == pytest.approx(figures.output_gain, rel=1.5e-3)
    # The clamp level is set by formula for the positive side. The negative side carries 1.3 mA
    # more: 26 mV ln(6.7/5.4) twice and 2 x 10 ohm x 1.3 mA, 40 mV of 6.9 V.
    assert control[-1] == pytest.approx(figures.level, rel=1e-3)
    assert control[0] == pytest.approx(-figures.level, rel=7e-3)


@pytest.mark.parametrize("setting", [0.25, 0.7246])
def test_the_relay_switches_between_levels_that_p4_sets(setting):
    result = run(BENCHES["relay"], Transient(12e-3, 5e-6), {"level_setting": setting})
    late = np.linspace(1e-3, 12e-3, 5001)
    control = result.at(late, "control")
    level = 6.9 * setting
    assert control.max() == pytest.approx(level, rel=2e-3, abs=10e-3)
    assert control.min() == pytest.approx(-level, rel=9e-3, abs=10e-3)
    # Finite gain-bandwidth: sqrt(2 dV/(2 pi GBW slope)) from zero surface to zero output with
    # dV = 13.4 V or 14.8 V of overdrive and 200 V/s, which is 69 us and 72 us; the offset of 5 mV
    # shifts the zero of the surface by 25 us.
    rising = late[np.argmax((control[:-1] < 0) & (control[1:] >= 0))]
    assert rising - 1.5e-3 == pytest.approx(72e-6 - 25e-6, abs=12e-6)


def test_taps_into_a_cable():
    loaded = run(BENCHES["taps"], FrequencySweep(10, 2e4, 10), NO_OFFSETS)
    bare = run(BENCHES["double-differentiator-ac"], FrequencySweep(10, 2e4, 10), NO_OFFSETS)
    for tap in ("velocity", "acceleration"):
        # 100 ohm with 1 Mohm take 1e-4; with 200 pF 2.5e-3 radian at 20 kHz, and the output
        # resistance of an op-amp with a loop gain of one there as much again.
        np.testing.assert_allclose(loaded[tap], bare[tap], rtol=6e-3)


def test_decoupling_keeps_the_rail_quiet():
    sweep = run(BENCHES["supply"], FrequencySweep(10, 1e7, 1))
    # Leads of 0.2 ohm at low frequency; 0.2 || 0.5 ohm without ceramics, 1/(2 pi 10 MHz 0.9 uF)
    # with them at high frequency.
    assert abs(sweep["vcc"][0]) == pytest.approx(0.2, rel=1e-3)
    assert abs(sweep["barecc"][-1]) == pytest.approx(0.2 * 0.5 / 0.7, rel=1e-3)
    assert abs(sweep["vcc"][-1]) == pytest.approx(1 / (2 * np.pi * 1e7 * 0.9e-6), rel=1e-2)


def test_differentiator_gain_and_roll_off():
    sweep = run(
        BENCHES["differentiator"], FrequencySweep(1, 1e5, 1), {"ca3140_gain_bandwidth": 4.5e9}
    )
    gain = np.abs(sweep["out"])
    # 2 pi f RC at 10 Hz: both breaks at 2.8 kHz take (10/2800)^2, 1.3e-5; gain 75 mV over 1e5.
    assert gain[1] == pytest.approx(2 * np.pi * 10 * 12e-3, rel=5e-5)
    # Far above both breaks 20 dB a decade: gain is 1/(2 pi f Rs Cf) but for (2.8/100)^2.
    assert gain[-1] == pytest.approx(1 / (2 * np.pi * 1e5 * 560 * 470e-12), rel=2e-3)


def test_the_channel_adds_up():
    sweep = run(netlists.CARD_AC, FrequencySweep(1, 100, 10))
    s = 2j * np.pi * sweep.frequency
    figures = card_figures(DESIGN)
    rc = figures.rc_velocity
    ideal = -(
        figures.weight_displacement
        + figures.weight_velocity * rc * s
        + figures.weight_acceleration * rc**2 * s**2
    )
    # Phase lags of the filters: 4 breaks of 2.83 kHz give 8 degrees at 100 Hz.
    assert np.abs(sweep["surface1"] / ideal - 1).max() < np.radians(8.1)
    # At 1 Hz the filter is 1e-3 of a radian, potentiometer contacts 4e-4.
    assert sweep["surface1"][0] == pytest.approx(ideal[0], rel=2e-3)
    # The channels share the supply only.
    assert np.abs(sweep["surface2"]).max() < 1e-6 * np.abs(sweep["surface1"]).max()


def test_channels_have_their_own_settings():
    point = run(
        netlists.CARD,
        OperatingPoint(),
        {"level_setting_two": 0.2, "demand_two": 9, "demand_one": 9},
    )
    assert point["control1"][0] == pytest.approx(5.0, rel=3e-3)
    assert point["control2"][0] == pytest.approx(0.2 * 6.9, rel=1e-2)


def test_noise_of_the_acceleration_tap():
    result = run(netlists.CARD_NOISE, Noise("acceleration", "vtransducer", 1, 1e6, 20))
    # An independent study with a floor of 7 nV found 23.9 mV without the series resistor of the
    # buffer; ours has no floor (2.7 % less at 10 kHz) and the resistor (8 nV in 1 Hz).
    total = noise_voltage(result.frequency, result.noise_density)
    assert total == pytest.approx(23.9e-3, rel=0.1)


# Element and its faulty value, the node it shows at, and its gain at 1 Hz over the healthy one.
FAULTS = {
    # Nothing comes out but what the feedback resistor and the load let through.
    "dead op-amp": (
        "xone.xtaps.xacceleration.xamplifier.xcore.rgain",
        1e-3,
        "acceleration1",
        0,
        0.05,
    ),
    # Of 0.470 - 1.371 (0.0754j) + 0.0754^2 j^2 the first term is gone: 0.1036/0.4757.
    "open wiper": (
        "xone.xsurface.xdisplacement.xpotentiometer.rwiper",
        1e12,
        "surface1",
        0.215,
        0.221,
    ),
    # R/Rs = 214 instead of 2 pi f RC = 0.0754, at 1 Hz.
    "shorted capacitor": ("xone.xtaps.xvelocity.cinput", 1.0, "velocity1", 2820, 2860),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_shows(fault):
    element, value, node, least, most = FAULTS[fault]
    with Session(netlists.CARD_AC, NO_OFFSETS) as session:
        healthy = session.run(FrequencySweep(1, 10, 1))
        session.change({element: value})
        broken = session.run(FrequencySweep(1, 10, 1))
    ratio = abs(broken[node][0] / healthy[node][0])
    assert least <= ratio <= most


@pytest.mark.parametrize("temperature", [-40, 0, 85])
def test_temperatures_converge(tmp_path, temperature):
    file = tmp_path / "card.cir"
    text = re.sub(r"\.include (\S+)", rf".include {netlists.ROOT}/\1", netlists.CARD.read_text())
    file.write_text(text.replace(".options", f".temp {temperature}\n.options"))
    point = run(file, OperatingPoint(), {"demand_one": 9, "card_temperature": temperature})
    cold = run(netlists.CARD, OperatingPoint(), {"demand_one": 9})
    assert point["control1"][0] == pytest.approx(5.0, rel=0.03)
    assert point["xone.clamped"][0] != cold["xone.clamped"][0]
    warm = {"card_temperature": temperature}
    result = run(file, Transient(15e-3, 50e-6), warm, save=["velocity1"])
    assert result.time[-1] == pytest.approx(15e-3)


@pytest.mark.parametrize("positive", [13.5, 16.5])
@pytest.mark.parametrize("negative", [13.5, 16.5])
def test_supply_corners_converge(positive, negative):
    supplies = {"positive_supply": positive, "negative_supply": negative, "demand_one": 9}
    result = run(
        netlists.CARD,
        Transient(15e-3, 50e-6),
        supplies,
        save=["control1", "xone.comparator", "velocity1"],
    )
    assert result.time[-1] == pytest.approx(15e-3)
    # The zeners keep the level: 1.5 mA more or less in 5.4 mA move them by 2 x 10 ohm x 1.5 mA
    # and 26 mV ln(6.9/5.4), 36 mV of 6.9 V, and the op-amps' offsets by 5 mV of 5 V. The swing
    # ahead of them follows the supply, less 2 x 9 x 4 mA in 0.2 ohm of leads and 1.5 mA more or
    # less in 60 ohm: 15 mV and 90 mV.
    assert result["control1"][0] == pytest.approx(5.0, rel=7e-3)
    assert result["xone.comparator"][0] == pytest.approx(13.0 + positive - 15, abs=0.14)


def test_offsets_are_told_apart():
    # Each op-amp's offset is a parameter: alone, it moves the surface by its own noise gain.
    base = run(netlists.CARD_AC, OperatingPoint(), NO_OFFSETS)["surface1"][0]
    moved = {
        name: run(netlists.CARD_AC, OperatingPoint(), NO_OFFSETS | {name: 1e-3})["surface1"][0]
        - base
        for name in ("transducer_buffer_offset", "demand_buffer_offset", "surface_offset")
    }
    weight = card_figures(DESIGN).weight_displacement
    # Ends of the potentiometers 4e-4; the output follows to 1e-6 V in the solver's tolerance.
    assert moved["transducer_buffer_offset"] == pytest.approx(-weight * 1e-3, rel=5e-3)
    assert moved["demand_buffer_offset"] == pytest.approx(weight * 1e-3, rel=5e-3)
    # 1 + Rf/(R1 + source of P1) + Rf/(R2 + source of P2) + Rf/R3
    f1, f2 = VALUES["displacement_weight"], VALUES["velocity_weight"]
    gain = 2 + 100 / (100 + f1 * (1 - f1) * 10) + 100 / (51 + f2 * (1 - f2) * 10)
    assert moved["surface_offset"] == pytest.approx(gain * 1e-3, rel=5e-3)
