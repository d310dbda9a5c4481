"""Equation (4.34) against flows worked out by hand."""

import numpy as np
import pytest

from pneuservo.calibration import LEAK, flow_curve, simulate_transient, transient_of
from pneuservo.calibration.flow_curve import discharge_coefficient_from_rate
from pneuservo.calibration.transient import in_flow
from pneuservo.errors import InputError
from pneuservo.recordings import Recording

# sqrt(g/R (2/(g+1))^((g+1)/(g-1))) for air, equation (4.18) of the thesis.
CHOKED = 0.0404184
VOLUME, SUPPLY, AREA, GAS, TEMPERATURE = 120e-6, 7.7e5, 0.870e-6, 287.0, 293.0


def choked_charge(coefficient, index=1.4, samples=200):
    """A charge while the flow is choked: the pressure rises along a straight line."""
    flow = coefficient * CHOKED * AREA * SUPPLY / np.sqrt(TEMPERATURE)
    rate = index * GAS * TEMPERATURE * flow / VOLUME
    time = np.linspace(0.0, 0.2 * SUPPLY / rate, samples)
    return Recording(
        "charge",
        time,
        {"valve_voltage": np.full(samples, 5.0), "dead_volume_pressure": 1.1e5 + rate * time},
        rig="dead-volume",
        conditions={"supply_pressure": SUPPLY, "dead_volume_volume": VOLUME},
        noise_rms={"dead_volume_pressure": 1.0},
    )


@pytest.mark.parametrize("coefficient", [0.4, 0.8])
def test_a_straight_charge_gives_the_coefficient_that_made_it(coefficient):
    curve = flow_curve(transient_of(choked_charge(coefficient)))
    # CHOKED has six digits.
    assert curve.coefficient == pytest.approx(coefficient, rel=1e-5)


def test_assuming_isothermal_gas_scales_by_the_index():
    curve = flow_curve(transient_of(choked_charge(0.8)), polytropic_index=1.0)
    assert curve.coefficient == pytest.approx(0.8 * 1.4, rel=1e-5)


def test_the_interval_holds_the_truth_as_often_as_it_says():
    transient = transient_of(simulate_transient("a_e", 5.0, seed=7))
    curve = flow_curve(transient)
    true = np.interp(
        curve.pressure_ratio, [0.0, 0.16, 0.33, 0.74, 1.0], [0.82, 0.82, 0.68, 0.50, 0.33]
    )
    # Near equal pressures the rate changes too fast for a parabola.
    kept = curve.pressure_ratio < 0.9
    inside = np.abs(curve.coefficient - true)[kept] <= curve.half_width[kept]
    # 95 % of some 35 points; fewer than 85 % has a chance of 2 %.
    assert np.mean(inside) > 0.85


def test_a_rate_has_no_sign():
    transient = transient_of(choked_charge(0.8))
    pressure = np.array([2e5])
    forwards, backwards = (
        discharge_coefficient_from_rate(np.array([rate]), pressure, transient, 1.4)
        for rate in (1e5, -1e5)
    )
    assert forwards == backwards


@pytest.mark.parametrize(
    ("path", "sign"), [("s_a", 1.0), ("b_e", 1.0), ("s_b", -1.0), ("a_e", -1.0)]
)
def test_the_path_follows_from_command_and_pressure(path, sign):
    recording = simulate_transient(path, 3.0)
    assert np.all(recording["valve_voltage"] == sign * 3.0)
    transient = transient_of(recording)
    assert (transient.path, transient.command) == (path, 3.0)
    assert transient.opening == pytest.approx(sign * 0.6)


def test_samples_after_the_pressures_are_equal_do_not_flow():
    transient = transient_of(simulate_transient("s_a", 5.0))
    flowing = np.flatnonzero(in_flow(transient))
    assert flowing[0] == 0
    assert np.all(np.diff(flowing) == 1)
    # 0.1 % of the supply pressure and four times the noise of 300 Pa.
    assert transient.pressure[flowing[-1] + 1 :].min() > SUPPLY - 0.01 * SUPPLY


def changed(**changes):
    recording = simulate_transient("s_a", 5.0)
    channels = {**recording.channels, **changes}
    channels = {name: values for name, values in channels.items() if values is not None}
    return Recording(
        "bad", recording.time, channels, rig="dead-volume", conditions=recording.conditions
    )


def test_a_command_that_moves_is_refused():
    moving = np.linspace(0.0, 5.0, len(simulate_transient("s_a", 5.0)))
    with pytest.raises(InputError, match="one held command"):
        transient_of(changed(valve_voltage=moving))


def test_a_recording_without_pressure_is_refused():
    with pytest.raises(InputError, match="no channel dead_volume_pressure"):
        transient_of(changed(dead_volume_pressure=None))


def test_a_gauge_pressure_taken_for_absolute_is_refused():
    with pytest.raises(InputError, match="gauge = true"):
        transient_of(changed(dead_volume_pressure=simulated_gauge()))


def simulated_gauge():
    return simulate_transient("s_a", 5.0)["dead_volume_pressure"] - 1.013e5 - 1e3


def test_another_rig_is_refused():
    recording = simulate_transient("s_a", 5.0)
    with pytest.raises(InputError, match="dead-volume"):
        transient_of(recording, "single-axis")


def test_without_a_command_it_is_a_leak():
    assert transient_of(changed(valve_voltage=None)).path == LEAK
