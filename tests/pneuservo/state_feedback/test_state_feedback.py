"""State feedback: pole placement and the step responses of the three models."""

import numpy as np
import pytest

from pneuservo.controllers import StateFeedback
from pneuservo.errors import InputError
from pneuservo.linear import TABLE_5_2, advanced_servo, table_5_2, without_valve
from pneuservo.linear.parameter_update import parameter_update_jerk
from pneuservo.rigs import load_rig
from pneuservo.state_feedback import (
    closed_loop,
    largest_real_part,
    linear_step,
    nonlinear_step,
    parameter_update_step,
    place_poles,
)

SENSITIVITY = 10.0 / 0.03


@pytest.fixture(scope="module")
def data():
    return table_5_2()


@pytest.mark.parametrize("extending", [True, False])
@pytest.mark.parametrize(
    ("settling_time", "damping", "third"), [(0.4, 0.4, 150.0), (0.2, 1.0, 60.0)]
)
def test_the_poles_are_where_they_were_asked_for(data, extending, settling_time, damping, third):
    servo = without_valve(advanced_servo(data, 0.006, extending))
    controller = place_poles(servo, SENSITIVITY, settling_time, damping, third)
    decay = 4 / settling_time
    # The characteristic polynomial, since a double pole is only found to the root of rounding.
    wanted = np.polymul([1.0, third], [1.0, 2 * decay, (decay / damping) ** 2])
    found = np.poly(closed_loop(servo, controller, SENSITIVITY).poles()).real
    assert found == pytest.approx(wanted, rel=1e-6)
    assert largest_real_part(servo, controller, SENSITIVITY) == pytest.approx(-decay, rel=1e-3)


def test_the_third_pole_of_table_5_5(data):
    servo = advanced_servo(data, 0.015, True)
    assert place_poles(servo, SENSITIVITY) == place_poles(servo, SENSITIVITY, third_pole=150.0)


def test_the_step_response_is_that_of_the_poles(data):
    servo = without_valve(advanced_servo(data, 0.015, True))
    controller = place_poles(servo, SENSITIVITY)
    time = np.linspace(0.0, 1.0, 1001)
    response = linear_step(servo, controller, SENSITIVITY, time)
    assert response[-1] == pytest.approx(1.0, abs=2e-4)
    # Overshoot of a pair with damping 0.4 is exp(-pi 0.4/sqrt(1 - 0.16)) = 25.4 %; the third
    # pole, 15 times further left, takes off less than a fifteenth of it.
    assert 0.254 * 14 / 15 < response.max() - 1.0 < 0.254


def test_the_update_model_with_fixed_parameters_is_the_linear_one(data):
    servo = without_valve(advanced_servo(data, 0.015, False))
    controller = place_poles(servo, SENSITIVITY)
    time = np.linspace(0.0, 0.3, 61)
    # Steps so small that the parameters are those of the position; one direction only matters
    # as long as the valve does not open the other way, so both have to agree at the start.
    run = parameter_update_step(data, controller, SENSITIVITY, time, 0.015, 0.015 - 1e-6)
    linear = linear_step(servo, controller, SENSITIVITY, time)
    early = time < 0.02
    progress = (0.015 - run.displacement) / 1e-6
    assert progress[early] == pytest.approx(linear[early], abs=2e-3)


def test_the_update_model_holds_its_parameters_beyond_the_stroke(data):
    inside = parameter_update_jerk(data, data.stroke, 0.1, 1.0, 2.0)
    assert parameter_update_jerk(data, data.stroke + 1e-3, 0.1, 1.0, 2.0) == inside


def test_damping_grows_from_linear_over_update_to_non_linear_model(data):
    # Figure 5.24 of the thesis, with the assumptions of the linear models in the non-linear one:
    # one coefficient for all paths, no Coulomb friction, the quiescent pressures at the start.
    rig = load_rig("single-axis")
    areas = {key: 0.81e-6 for key in rig.parameters if key.startswith("valve.flow.")}
    rig = rig.with_values({**TABLE_5_2, **areas, "piston.coulomb_friction": 0.0})
    controller = place_poles(advanced_servo(data, 0.015, False), SENSITIVITY)
    time = np.linspace(0.0, 1.0, 1001)
    origin, target = 0.006, 0.015
    out = without_valve(advanced_servo(data, target, True))
    linear = linear_step(out, controller, SENSITIVITY, time)
    update = parameter_update_step(data, controller, SENSITIVITY, time, origin, target)
    grid = 0.7 * np.ones((4, 51, 101))
    non_linear = nonlinear_step(rig, controller, time, origin, target, data.pressure_b, grid)
    late = time > 0.6
    swings = [
        (target - origin) * np.ptp(linear[late]),
        np.ptp(update.displacement[late]),
        np.ptp(non_linear.displacement[late]),
    ]
    # The changing stiffness takes off most, the changing pressures a little more.
    assert swings[0] > 10 * swings[1]
    assert swings[1] > swings[2]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"settling_time": 0.0}, "settling time"),
        ({"damping": 1.2}, "damping"),
        ({"third_pole": -5.0}, "third pole"),
    ],
)
def test_requirements_out_of_range_are_refused(data, wrong, message):
    with pytest.raises(InputError, match=message):
        place_poles(advanced_servo(data, 0.015, True), SENSITIVITY, **wrong)


def test_retraction_gains_of_table_5_5_make_extension_oscillate(data):
    # Recomputed with the printed parameters, nine of nine extension cases are unstable.
    for tuned in (0.006, 0.015, 0.024):
        controller = place_poles(advanced_servo(data, tuned, False), SENSITIVITY)
        for at in (0.006, 0.015, 0.024):
            servo = without_valve(advanced_servo(data, at, True))
            assert largest_real_part(servo, controller, SENSITIVITY) > 0.0
            assert isinstance(controller, StateFeedback)
