"""A leak that no setting of the baseline can hide."""

import itertools

import numpy as np
import pytest
import truth_dead_volume as truth

from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.models import model_of
from pneuservo.rigs import load_rig

RIG = load_rig("dead-volume")
# Parameters of the baseline that move a tight volume, over three tolerances either way.
MOVED = (
    "dead-volume.volume",
    "supply.pressure",
    "dead-volume.polytropic_index",
    "ambient.pressure",
    "valve.flow.area_s_a",
)
STEPS = (-3.0, 0.0, 3.0)


def left_alone():
    return truth.recording(truth.pressure_history(truth.hole(2e-9)), 1)


def filled_and_shut():
    return truth.filled_and_shut(1, truth.hole(2e-8))


def residuals_without_a_leak(recording):
    """Root-mean-square residual of the tight volume by steps from the nominal values [Pa]."""
    found = {}
    model = model_of("dead-volume")
    for steps in itertools.product(STEPS, repeat=len(MOVED)):
        values = {
            key: RIG[key] + step * RIG.parameters[key].tolerance
            for key, step in zip(MOVED, steps, strict=True)
        }
        case = model.prepare(recording, RIG.with_values(values))
        start = {"initial_pressure": float(case.measured[0])}
        residual = case.measured - model.predict(case, values | start)
        # Left alone, a tight volume keeps its pressure, so that the best start is the mean.
        filled = "valve_voltage" in recording
        found[steps] = float(np.sqrt(np.mean(residual**2)) if filled else np.std(residual))
    return found


@pytest.mark.parametrize("make", [left_alone, filled_and_shut])
def test_no_corner_of_the_tolerances_hides_it(make):
    found = document(diagnose([make()]))
    (channel,) = found["fit"]["channels"].values()
    noise, before = channel["noise_rms"], channel["before"]["used"]
    tight = residuals_without_a_leak(make())
    assert min(tight.values()) > 10.0 * noise
    assert before > 10.0 * noise
    # A refit does no worse than the nominal values; the start is its own either way.
    assert before < 1.01 * tight[(0.0,) * len(MOVED)]
    assert channel["after"]["used"] < 2.0 * noise
