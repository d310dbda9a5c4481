"""What a surface leaves against disturbances, and the range spaces of the non-linear plant."""

import numpy as np
import pytest
from scipy.linalg import expm

from pneuservo.linear import advanced_servo, servo_data, state_matrices, table_5_2, without_valve
from pneuservo.rigs import load_rig
from pneuservo.sliding_mode.disturbance import reserve
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.range_space import (
    physical_limits,
    representative_runs,
    trajectory_limits,
)
from pneuservo.sliding_mode.surface import surface_from_settling_time

SURFACE = surface_from_settling_time(0.07)


def test_near_the_goal_the_whole_voltage_is_left():
    data = table_5_2()
    found = reserve(data, SURFACE, 5.0, 0.015, 0.015 + 1e-6)
    assert found.reserve == pytest.approx(5.0, abs=1e-3)
    servos = [advanced_servo(data, 0.015, way) for way in (True, False)]
    weaker = min(servo.b0 for servo in servos)
    assert found.acceleration == pytest.approx(weaker * 5.0 / SURFACE.weights[1], rel=0.3)


@pytest.mark.parametrize(("share", "slides"), [(0.9, True), (1.1, False)])
def test_the_largest_disturbance_is_what_a_relay_still_holds(share, slides):
    # From rest on the surface: (7.16) leaves c3 b0 U/c2 of acceleration.
    servo = without_valve(advanced_servo(table_5_2(), 0.015, True))
    weights = np.array(SURFACE.weights)
    disturbance = share * servo.b0 * 5.0 / weights[1]
    a, b = state_matrices(servo)
    step = 2e-6
    matrix = np.zeros((5, 5))
    matrix[:3, :3], matrix[:3, 3] = a, b[:, 0]
    matrix[1, 4] = 1.0  # the disturbance acceleration
    transition = expm(matrix * step)
    state = np.array([0.0, 0.0, 0.0, 0.0, disturbance])
    largest = 0.0
    gains = servo_gains(servo, SURFACE)
    for _ in range(100):
        sigma = float(-weights @ state[:3])
        state[3] = 5.0 * np.sign(sigma)
        state = transition @ state
        largest = max(largest, abs(sigma))
    # Held, sigma swings by one step of its largest rate; otherwise it runs away at what is left,
    # a tenth of it, over 100 steps.
    one_step = 2 * servo.b0 * 5.0 * step
    assert (largest < 2 * one_step) == slides
    # So short that the equivalent control of the motion itself stays out of it.
    assert abs(gains @ state[:3]) < 0.05 * 5.0


def test_physical_limits_hold_the_choked_velocities():
    data = servo_data(load_rig("single-axis"))
    space = physical_limits(data)
    # (7.13): -0.25 and 0.356 m/s; with the valve's tables within 4 %.
    assert space.velocity == pytest.approx((-0.25, 0.356), rel=0.042)


def test_representative_motions_end_at_the_stop():
    rig = load_rig("single-axis")
    runs = representative_runs(rig)
    assert len(runs) == 4
    stroke = rig["piston.stroke"]
    for run in runs:
        assert np.all((run["displacement"] >= 0.0) & (run["displacement"] <= stroke))
        # The blow against the stop is not a motion of the servo.
        assert run["acceleration"][-1] != 0.0
    space = trajectory_limits(runs, stroke)
    assert space.displacement == (-stroke, stroke)
    assert space.velocity[0] < 0.0 < space.velocity[1]
    # Extending is the stronger direction.
    assert space.velocity[1] > -space.velocity[0]
    gentle = trajectory_limits(representative_runs(rig, voltage=2.0), stroke)
    assert gentle.velocity[1] < space.velocity[1]
