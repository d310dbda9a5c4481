"""The linear models against the compiled non-linear plant."""

from dataclasses import replace

import numpy as np
import pytest

from pneuservo.linear import TABLE_5_2, advanced_servo, at_quiescent_pressures, servo_data
from pneuservo.linear.numerical import OperatingPoint, linearised_plant, steady_motion
from pneuservo.rigs import load_rig

CONSTANT = 0.7 * np.ones((4, 51, 101))


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis").with_values(TABLE_5_2)


@pytest.mark.parametrize("extending", [True, False])
@pytest.mark.parametrize("position", [0.0, 6e-3, 15e-3, 28.5e-3])
def test_near_null_the_kernels_have_the_advanced_model(rig, position, extending):
    data = servo_data(rig, opening=0.02)
    # 1 mV beside null, where the flow's own feedback on the pressures is below 1e-3.
    voltage = 1e-3 if extending else -1e-3
    point = OperatingPoint(position, 1e-9, data.pressure_a, data.pressure_b, voltage)
    plant = linearised_plant(rig, point)
    servo = advanced_servo(data, position, extending)
    s = 2j * np.pi * np.array([5.0, 20.0, 80.0])
    numerical = np.array([plant(value)[0, 0] for value in s])
    analytic = servo.b0 / (s * (s * s + servo.a2 * s + servo.a1))
    assert numerical == pytest.approx(analytic, rel=3e-3)


def test_quiescent_pressures_are_those_of_slow_motion(rig):
    # Without friction, since (5.35) to (5.41) leave it out.
    frictionless = rig.with_values({"piston.viscous_friction": 0.0, "piston.coulomb_friction": 0.0})
    frictionless = frictionless.with_values(
        {f"valve.flow.area_{path}": 0.81e-6 for path in ("s_a", "b_e", "s_b", "a_e")}
    )
    data = servo_data(frictionless, flow_area=0.7 * 0.81e-6)
    for extending, voltage in ((True, 0.5), (False, -0.5)):
        found = steady_motion(frictionless, 0.015, voltage, CONSTANT)
        expected = at_quiescent_pressures(data, extending)
        assert found.pressure_a == pytest.approx(expected.pressure_a, rel=1e-6)
        assert found.pressure_b == pytest.approx(expected.pressure_b, rel=1e-6)
        # (5.35) and (5.39): the choked discharge alone sets the velocity.
        gas, area = data.gas, data.area_b if extending else data.area_a
        choked = gas.choked_coefficient * gas.gas_constant * np.sqrt(gas.temperature)
        velocity = 0.7 * 0.81e-6 * voltage / 5.0 * choked / area
        assert found.velocity == pytest.approx(velocity, rel=1e-6)


def test_a_level_rod_moves_steadily_too(rig):
    level = rig.with_values({"load.gravity": 0.0})
    hanging, lying = (steady_motion(each, 0.015, 2.5) for each in (rig, level))

    # The weight of 1.825 kg helps a rod that hangs down; pressures carry it, friction hardly moves.
    def force(point):
        area_a, area_b = rig["piston.area_a"], rig["piston.area_b"]
        return point.pressure_a * area_a - point.pressure_b * area_b

    weight = 9.81 * rig["load.mass"]
    friction = rig["piston.viscous_friction"] * (lying.velocity - hanging.velocity)
    assert force(lying) - force(hanging) == pytest.approx(weight + friction, rel=1e-6)


def test_at_an_opening_the_flow_adds_damping(rig):
    # What (5.20) drops: the loss of flow as pressures change damps and stiffens.
    point = steady_motion(rig, 0.015, 2.5)
    poles = np.linalg.eigvals(linearised_plant(rig, point).A)
    pair = poles[np.abs(poles.imag) > 1.0]
    data = replace(servo_data(rig), pressure_a=point.pressure_a, pressure_b=point.pressure_b)
    servo = advanced_servo(data, 0.015, True)
    assert len(pair) == 2
    assert -2 * pair[0].real > 1.2 * servo.a2
