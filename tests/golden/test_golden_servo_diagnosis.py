"""The golden servo, held against the simulation like any recording, lacks nothing."""

from pathlib import Path

import numpy as np
import pandas
import pytest

from pneuservo.diagnosis import diagnose
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig

FOLDER = Path(__file__).parent
RECORDED = ("valve_voltage", "demand", "displacement", "pressure_a", "pressure_b")


def recorded(name, position=0.0, pressure=0.0):
    """Return a golden trajectory as transducers with white noise would have recorded it."""
    table = pandas.read_csv(FOLDER / f"{name}.csv.xz")
    rng = np.random.default_rng(7)
    sizes = {"displacement": position, "pressure_a": pressure, "pressure_b": pressure}
    channels = {}
    for channel in RECORDED:
        if channel in table:
            noise = sizes.get(channel, 0.0) * rng.standard_normal(len(table))
            channels[channel] = table[channel].to_numpy() + noise
    return Recording(name, table["time"].to_numpy(), channels)


@pytest.mark.parametrize(("position", "pressure"), [(0.0, 0.0), (5e-6, 100.0), (2e-5, 300.0)])
def test_a_continuous_controller_sampled_at_a_kilohertz_is_consistent(position, pressure):
    found = diagnose([recorded("closed-loop-phi5", position, pressure)], [])
    assert found.verdict == "consistent"
    assert max(found.search.baseline.rms_of(c) for c in ("pressure_a", "pressure_b")) < 1.1


@pytest.mark.parametrize("name", ["closed-loop", "closed-loop-phi5", "open-loop"])
def test_without_any_noise_innovations_are_smaller_than_any_transducer_resolves(name):
    rig, model = load_rig("single-axis"), ServoModel()
    running, held, *_ = model.readings(model.cases(recorded(name), rig))
    # Open-loop voltages are held; the golden controller is continuous.
    for case in held if name == "open-loop" else running:
        if case.recorded:
            left = (case.measured - model.predict(case, {}))[case.usable]
            assert np.sqrt(np.mean(left**2)) < 1.0, case.channel
