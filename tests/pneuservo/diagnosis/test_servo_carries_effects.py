"""The observer knows what the plant does: with the true values of an effect nothing is left."""

import numpy as np
import pytest
from servo_recordings import NOISE, noisy

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

TIME = np.arange(0.0, 4.0, 1e-3)
WITHIN_THE_STROKE = np.repeat([0.010, 0.022, 0.008, 0.018, 0.024, 0.006, 0.015, 0.021], 500)
FROM_STOP_TO_STOP = np.where(TIME < 0.2, 0.015, np.where(TIME % 2.0 < 1.0, -0.009, 0.039))


@pytest.fixture(scope="module")
def rig():
    return load_rig("single-axis")


def recorded(rig, demand, quiet):
    rng = np.random.default_rng(1)
    run = simulate(rig, time=TIME, controller=Proportional(), demand=demand)
    return noisy(run, rng, {name: quiet * size for name, size in NOISE.items()})


def misfit(recording, rig, values):
    """Return the sum of squares beyond what noise alone leaves, as the baseline leaves it."""
    cases = ServoModel().cases(recording, rig)
    left = [(c.measured - ServoModel().predict(c, values))[c.usable] for c in cases]
    return sum(float(np.sum(part**2)) - len(part) for part in left)


@pytest.mark.parametrize(
    ("demand", "values"),
    [
        (
            WITHIN_THE_STROKE,
            {
                "load.compliance:share": 0.5,
                "load.compliance:stiffness": 1e5,
                "load.compliance:damping": 30.0,
            },
        ),
        (WITHIN_THE_STROKE, {"load.backlash:play": 2e-4, "load.backlash:share": 0.5}),
        (WITHIN_THE_STROKE, {"sensor.position-wiper:half_width": 3e-5}),
        (FROM_STOP_TO_STOP, {"sensor.position-wiper:half_width": 3e-5}),
        (WITHIN_THE_STROKE, {"sensor.position-lag:time": 3e-4}),
        (WITHIN_THE_STROKE, {"sensor.pressure-static:share": 0.8}),
        (FROM_STOP_TO_STOP, {"endstop.cushion:length": 6e-3, "endstop.cushion:area": 1e-7}),
    ],
    ids=["compliance", "backlash", "wiper", "wiper at the stops", "lag", "static tap", "cushion"],
)
def test_what_hangs_on_the_piston_is_expected(rig, demand, values):
    baseline = misfit(recorded(rig, demand, 0.5), rig, {})
    recording = recorded(rig.with_values(values), demand, 0.5)
    missed, found = misfit(recording, rig, {}), misfit(recording, rig, values)
    assert missed - baseline > 1000.0
    assert found - baseline < 0.35 * (missed - baseline)


def test_a_stiff_joint_is_none(rig):
    recording = recorded(rig, WITHIN_THE_STROKE, 0.5)
    stiff = {"load.compliance:share": 0.5, "load.compliance:stiffness": 3e6}
    change = misfit(recording, rig, stiff) - misfit(recording, rig, {})
    assert abs(change) < 300.0


@pytest.mark.parametrize(
    ("demand", "values"),
    [
        (
            FROM_STOP_TO_STOP,
            {"load.transverse-mode:share": 0.2, "load.transverse-mode:frequency": 15.0},
        ),
        (WITHIN_THE_STROKE, {"sensor.position-nonlinearity:second": 1e-4}),
        (FROM_STOP_TO_STOP, {"sensor.position-offset:offset": 1e-3}),
        (FROM_STOP_TO_STOP, {"sensor.position-gain:gain": -0.02}),
    ],
    ids=[
        "a load that a stop throws on",
        "a reading whose slope changes along the way",
        "a stop that reads a millimetre off",
        "a stop that reads two per cent short",
    ],
)
def test_what_it_knows_exactly_leaves_nothing(rig, demand, values):
    baseline = misfit(recorded(rig, demand, 0.5), rig, {})
    recording = recorded(rig.with_values(values), demand, 0.5)
    missed, found = misfit(recording, rig, {}), misfit(recording, rig, values)
    assert found - baseline < 0.01 * (missed - baseline)
