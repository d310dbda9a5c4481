"""The leak laws against their closed forms."""

import numpy as np
import pytest

from pneuservo.plant.leak_laws import laminar_leak, orifice_leak, power_leak

AMBIENT, TEMPERATURE, R, GAMMA = 1.013e5, 293.0, 287.0, 1.4
AREA, CONDUCTANCE, AT_ONE_BAR, EXPONENT = 2e-9, 3e-18, 4e-7, 1.3
# Rounding of a handful of multiplications and one power each.
ROUNDING = 1e-12


def orifice(pressure, ambient=AMBIENT):
    return orifice_leak(pressure, ambient, TEMPERATURE, R, GAMMA, AREA)


LAWS = {
    "orifice": orifice,
    "laminar": lambda pressure: laminar_leak(pressure, AMBIENT, TEMPERATURE, CONDUCTANCE),
    "power": lambda pressure: power_leak(pressure, AMBIENT, AT_ONE_BAR, EXPONENT),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_nothing_flows_at_ambient_pressure(law):
    assert law(AMBIENT) == 0.0


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_air_flows_towards_the_lower_pressure(law):
    assert law(AMBIENT + 1e4) > 0.0 > law(AMBIENT - 1e4)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_more_pressure_gives_more_flow(law):
    flows = [law(pressure) for pressure in np.linspace(0.3e5, 9e5, 60)]
    assert np.all(np.diff(flows) >= 0.0)
    assert flows[-1] > flows[40]


def test_the_choked_orifice_passes_flow_in_proportion_to_pressure():
    critical = (2.0 / (GAMMA + 1.0)) ** (GAMMA / (GAMMA - 1.0))
    # Saint-Venant and Wantzel: sonic speed and density in the throat.
    throat_temperature = TEMPERATURE * 2.0 / (GAMMA + 1.0)
    per_pressure = (
        AREA * critical / (R * throat_temperature) * np.sqrt(GAMMA * R * throat_temperature)
    )
    for pressure in (1.001 * AMBIENT / critical, 4e5, 9e5):
        assert orifice(pressure) / pressure == pytest.approx(per_pressure, rel=ROUNDING)
    assert orifice(0.9 * AMBIENT / critical) < 0.9 * AMBIENT / critical * per_pressure


def test_the_orifice_is_the_same_both_ways():
    assert orifice(0.7e5) == -orifice(AMBIENT, ambient=0.7e5)


def test_the_laminar_gap_follows_the_difference_of_squares():
    for pressure in (0.5e5, 1.5e5, 8e5):
        difference = (pressure - AMBIENT) * (pressure + AMBIENT)
        assert LAWS["laminar"](pressure) == pytest.approx(CONDUCTANCE * difference, rel=ROUNDING)
    # Half as dense at twice the temperature.
    warm = laminar_leak(8e5, AMBIENT, 586.0, CONDUCTANCE)
    assert warm == pytest.approx(LAWS["laminar"](8e5) / 2.0, rel=ROUNDING)


def test_the_power_law_is_a_straight_line_in_logarithms():
    gauge = np.array([0.1e5, 1e5, 7e5])
    flow = np.array([LAWS["power"](AMBIENT + g) for g in gauge])
    assert flow[1] == pytest.approx(AT_ONE_BAR, rel=1e-9)  # gauge pressure is a difference
    slopes = np.diff(np.log(flow)) / np.diff(np.log(gauge))
    assert slopes == pytest.approx([EXPONENT, EXPONENT], rel=1e-9)
    assert LAWS["power"](AMBIENT - 0.1e5) == pytest.approx(-flow[0], rel=1e-9)
