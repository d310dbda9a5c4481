"""The two-link manipulator under its controllers: appendix A1 of the thesis."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pneuservo.errors import InputError
from pneuservo.manipulator.adaptive import VariableStructureAdaptive
from pneuservo.manipulator.controllers import (
    ComputedTorque,
    Motion,
    ProportionalDerivative,
    StateFeedback,
    decoupling_gain,
    demanded_motion,
    joint_models,
)
from pneuservo.manipulator.manipulator import bounds, nominal, printed_state_feedback
from pneuservo.manipulator.simulation import TARGETS, joint_acceleration, simulate_manipulator

# The last digit that the reference values are stated to [rad].
LAST_DIGIT = 0.005


def test_tables_of_the_appendix():
    varied = nominal().varied(0.3)
    assert varied.parameters == pytest.approx([13.0, 13.0, 0.65, 0.65, 52.5, 7.0])
    assert (varied.length, *varied.centres) == pytest.approx((1.3, 0.65, 0.65))
    assert nominal().varied(0.3, lengths=False).length == 1.0
    low, high = bounds()
    for share in (-0.3, 0.3):
        inside = nominal().varied(share).parameters
        assert ((low < inside) & (inside < high)).all()


def test_models_and_gains_are_the_printed_ones():
    a, b = joint_models(nominal())
    # (A1.7) is printed to four digits.
    assert a == pytest.approx([3.077, 8.205], abs=5e-4)
    assert b == pytest.approx([5.769, 4.103], abs=5e-4)
    proportional, derivative = ProportionalDerivative().gains
    assert proportional == pytest.approx([5.2, 1.95], abs=5e-4)
    # Table A1.2 prints 0.7228 and 0.4758, 0.3 % beside its own formula (A1.9).
    assert derivative == pytest.approx([0.7228, 0.4758], rel=4e-3)
    # (A1.12) is printed to one digit; 1.325 is printed as 1.3.
    assert printed_state_feedback() == pytest.approx(decoupling_gain(nominal()), abs=0.025001)


def test_the_reference_is_its_own_derivative():
    step = 1e-5
    for time in (0.1, 0.5, 2.0):
        before, now, after = (
            demanded_motion(time + shift, np.array(TARGETS)) for shift in (-step, 0.0, step)
        )
        # Central differences: step^2 times a third derivative of at most 4^3.
        assert (after.angles - before.angles) / (2 * step) == pytest.approx(now.rates, abs=1e-7)
        assert (after.rates - before.rates) / (2 * step) == pytest.approx(
            now.accelerations, abs=1e-6
        )


@pytest.mark.parametrize(
    ("controller", "share", "highest", "final"),
    [
        (ProportionalDerivative(), 0.0, (1.02, 0.58), (1.000, 0.500)),
        (ProportionalDerivative(), 0.3, None, (1.58, 0.98)),
        (StateFeedback(), 0.0, (1.00, 0.60), (1.000, 0.500)),
        (StateFeedback(), 0.3, None, (1.49, 0.62)),
        (ComputedTorque(), 0.0, (1.000, 0.500), (1.000, 0.500)),
    ],
    ids=["pd", "pd varied", "state feedback", "state feedback varied", "computed torque"],
)
def test_figures_of_the_appendix(controller, share, highest, final):
    run = simulate_manipulator(controller, nominal().varied(share), duration=12.0)
    assert run.final == pytest.approx(final, abs=LAST_DIGIT)
    if highest is not None:
        assert run.highest == pytest.approx(highest, abs=LAST_DIGIT)
    assert run.swing().max() < LAST_DIGIT


def test_computed_torque_oscillates_at_thirty_percent_and_not_at_twenty():
    run = simulate_manipulator(ComputedTorque(), nominal().varied(0.3), duration=20.0)
    # Sustained: as large over the last two seconds as over the two before the middle.
    middle = run.angles[8000:10000, 1]
    assert run.swing()[1] == pytest.approx(np.ptp(middle), rel=0.05)
    assert run.swing()[1] > 1.0
    settled = simulate_manipulator(ComputedTorque(), nominal().varied(0.2), duration=20.0)
    assert settled.swing().max() < 1e-3


@pytest.mark.parametrize(("boundary_layer", "left"), [(0.02, 0.010), (0.1, 0.050)])
def test_switched_parameters_hold_what_computed_torque_does_not(boundary_layer, left):
    controller = VariableStructureAdaptive(boundary_layer=boundary_layer)
    plant = nominal().varied(0.3, lengths=False)
    run = simulate_manipulator(controller, plant)
    # Inside the layer the error is at most its width over the slope, plus what fades of E1.
    assert abs(run.final - TARGETS).max() == pytest.approx(left, abs=1e-3)
    assert (run.highest <= np.array(TARGETS) + left + 1e-3).all()
    low, high = bounds()
    assert (run.estimates >= low - 1e-9).all()
    assert (run.estimates <= high + 1e-9).all()
    # No drift: masses and inertias switch about the same values, to 1 % of their bounds, one second
    # and the next. Friction has no part in a rest.
    earlier, later = (part.mean(axis=0)[:4] for part in np.split(run.estimates[-2000:], 2))
    assert ((later - earlier) / (high - low)[:4]) == pytest.approx(np.zeros(4), abs=0.01)


def test_sampled_control_comes_to_continuous_control():
    """Another solver, torques not held: what is left is half a sample's delay."""
    plant, controller = nominal().varied(0.3), ProportionalDerivative()
    links, friction = plant.linkage, np.array(plant.frictions)

    def rate(time, state):
        measured = Motion(state[:2], state[2:], np.zeros(2))
        torque = controller.torque(measured, demanded_motion(time, np.array(TARGETS)))
        return [*state[2:], *joint_acceleration(state[:2], state[2:], torque, friction, links)]

    smooth = solve_ivp(rate, (0.0, 2.0), np.zeros(4), rtol=1e-8, atol=1e-10).y[:2, -1]
    errors = [
        abs(
            simulate_manipulator(
                controller, plant, duration=2.0, sampling_time=sampling_time
            ).angles[-1]
            - smooth
        ).max()
        for sampling_time in (2e-3, 1e-3)
    ]
    # The held torque is late by half a millisecond, at up to 4 rad/s.
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_bad_values_are_refused():
    with pytest.raises(InputError, match="boundary_layer is -1 rad/s"):
        VariableStructureAdaptive(boundary_layer=-1.0)
    with pytest.raises(InputError, match="slope is 9 1/s"):
        VariableStructureAdaptive(slope=9.0)
    with pytest.raises(InputError, match="masses is -13"):
        nominal().varied(-2.3)
    with pytest.raises(InputError, match="sampling_time is 0 s"):
        simulate_manipulator(ComputedTorque(), sampling_time=0.0)
