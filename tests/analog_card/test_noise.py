"""Noise of the card: behaviour against ngspice, and against hand calculation."""

import math
from dataclasses import replace

import numpy as np
import pytest

from analog_card.design_file import load_design
from analog_card.errors import InputError
from analog_card.noise import TAPS, card_noise, netlist_noise, opamp_noise, white_density
from analog_card.waveforms import noise_voltage


@pytest.fixture(scope="module")
def design():
    return load_design()


@pytest.mark.ngspice
@pytest.mark.parametrize("transducer", [0.0, 1e-6])
@pytest.mark.parametrize("tap", TAPS)
def test_the_behaviour_predicts_what_ngspice_finds(design, tap, transducer):
    frequency, density = netlist_noise(design, tap, transducer)
    predicted = card_noise(design, frequency, transducer)
    # What the project asks for: 10 %, in the whole band.
    assert predicted.voltage(tap) == pytest.approx(noise_voltage(frequency, density), rel=0.1)
    # At each frequency up to 100 kHz; above, where 1 % of the noise is, the op-amp's second pole,
    # which the behaviour does not have, lifts the netlist's.
    inside = frequency <= 100e3
    assert predicted.density(tap)[inside] == pytest.approx(density[inside], rel=0.1)


@pytest.mark.ngspice
def test_a_card_with_other_parts_is_followed(design):
    first = replace(design.soldered.velocity_differentiator, resistance=47e3)
    other = replace(design, soldered=replace(design.soldered, velocity_differentiator=first))
    frequency, density = netlist_noise(other, "acceleration")
    predicted = card_noise(other, frequency).voltage("acceleration")
    assert predicted == pytest.approx(noise_voltage(frequency, density), rel=0.1)
    assert predicted != pytest.approx(card_noise(design).voltage("acceleration"), rel=0.2)


def test_the_op_amp_has_the_noise_of_its_data_sheet(design):
    # A 1/f source cannot pass through 40 and 12 nV: 2.6 % low and 2.7 % high, as the netlist.
    low, high = opamp_noise(design, np.array([1e3, 10e3]))
    assert low == pytest.approx(40e-9, rel=0.027)
    assert high == pytest.approx(12e-9, rel=0.028)


def test_an_independent_study_found_the_same(design):
    noise = card_noise(design)
    # 0.28 and 23.9 mV, op-amps, 1 Hz to 1 MHz; its card had one op-amp fewer and its figures have
    # two digits: 5 %.
    assert noise.voltage("velocity") == pytest.approx(0.28e-3, rel=0.05)
    assert noise.voltage("acceleration") == pytest.approx(23.9e-3, rel=0.05)


def test_transducer_noise_is_differentiated(design):
    frequency = np.geomspace(1.0, 100.0, 101)
    density = white_density(10e-3, 100.0)
    noise = card_noise(design, frequency, density)
    # Far below the breaks the taps are (2 pi f RC) and its square times the input; the integrals
    # of their squares from 0 to 100 Hz are x^2/3 and x^4/5 of its power. The filter takes
    # 1 - 2 (100/2840)^2, less than 0.3 %.
    x = 2 * math.pi * 100.0 * 0.012
    velocity, acceleration = (noise.voltage(tap, "transducer") for tap in TAPS[:2])
    assert velocity == pytest.approx(10e-3 * x / math.sqrt(3), rel=5e-3)
    assert acceleration == pytest.approx(10e-3 * x * x / math.sqrt(5), rel=5e-3)


def test_origins_add_up_as_squares(design):
    noise = card_noise(design, transducer_density=1e-6)
    parts = [noise.voltage("surface", name) ** 2 for name in ("op-amps", "resistors", "transducer")]
    # Both sides integrate the same points; between them the interpolation differs: 0.1 %.
    assert noise.voltage("surface") ** 2 == pytest.approx(sum(parts), rel=1e-3)
    assert card_noise(design).voltage("surface", "transducer") == 0.0


def test_impossible_noise_is_refused():
    with pytest.raises(InputError, match="above 0 Hz"):
        white_density(1e-3, 0.0)
