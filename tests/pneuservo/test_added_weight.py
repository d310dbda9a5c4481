"""What hangs on the rod, where weights are added to the load."""

import math
from dataclasses import replace

import numpy as np
import pytest

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig
from pneuservo.rigs.added_weight import with_added_weight
from pneuservo.simulation import simulate

LIGHT, HEAVY = 2.0, 7.0


def test_the_mass_between_rod_and_joint_stays():
    values = {"load.compliance:share": 0.6, "load.compliance:stiffness": 2e5}
    found = with_added_weight(values, HEAVY / LIGHT)
    assert (1.0 - found["load.compliance:share"]) * HEAVY == pytest.approx(0.4 * LIGHT)
    assert found["load.compliance:stiffness"] == 2e5


def test_more_than_hangs_behind_a_joint_cannot_be_taken_off():
    assert with_added_weight({"load.backlash:share": 0.3}, 0.5) == {"load.backlash:share": 0.0}


def test_a_frame_swings_as_its_mass_and_springs_say():
    frame, springs, losses = 30.0, 4e5, 300.0

    def swing(load):
        whole = frame + load
        return {
            "load.base-motion:share": load / whole,
            "load.base-motion:frequency": math.sqrt(springs / whole) / (2.0 * math.pi),
            "load.base-motion:damping": losses / (2.0 * math.sqrt(springs * whole)),
        }

    found = with_added_weight(swing(LIGHT), HEAVY / LIGHT)
    assert found == pytest.approx(swing(HEAVY))
    assert with_added_weight(found, LIGHT / HEAVY) == pytest.approx(swing(LIGHT))


@pytest.mark.parametrize("effect", ["load.compliance", "load.transverse-mode", "load.base-motion"])
def test_what_does_not_hang_there_is_not_added(effect):
    values = {f"{effect}:share": 0.0, "load.spring:stiffness": 100.0}
    assert with_added_weight(values, HEAVY / LIGHT) == values


def test_conditions_of_a_run_carry_what_hangs_on_the_rod():
    rig = load_rig("single-axis").with_values(
        {"load.mass": LIGHT, "load.compliance:share": 0.6, "load.compliance:stiffness": 2e5}
    )
    heavy = rig.with_conditions({"load_mass": HEAVY})
    assert heavy["load.mass"] == HEAVY
    assert (1.0 - heavy.effects["load.compliance"]["share"]) * HEAVY == pytest.approx(0.4 * LIGHT)
    assert rig.with_conditions({"load_mass": LIGHT}).effects == rig.effects


def test_a_joint_is_one_joint_under_two_loads():
    joint = {"share": 0.6, "stiffness": 1.2e5, "damping": 40.0}
    plain = load_rig("single-axis").with_values({"load.mass": LIGHT})
    rig = replace(plain, effects={"load.compliance": joint})
    noise = {"displacement": 5e-6, "pressure_a": 200.0, "pressure_b": 200.0}
    rng = np.random.default_rng(4)
    time = np.arange(0.0, 3.0, 1e-3)
    demand = np.repeat(rng.uniform(0.006, 0.024, 10), 300)
    model, cases = ServoModel(), []
    for conditions in ({}, {"load_mass": HEAVY}):
        loaded = rig.with_conditions(conditions)
        run = simulate(loaded, time=time, controller=Proportional(), demand=demand)
        channels = {name: run[name] + rng.normal(0.0, level, 3000) for name, level in noise.items()}
        recording = Recording("run", time, {**channels, "valve_voltage": run["valve_voltage"]})
        known = replace(recording, noise_rms=noise)
        cases += model.cases(known, plain.with_conditions(conditions))
    found = fit(model, cases, Hypothesis().adding("load.compliance"))
    assert max(np.std(left) for left in found.residuals) < 1.1
    assert found.shared["load.compliance:share"] == pytest.approx(0.6, rel=0.1)
    assert found.shared["load.compliance:stiffness"] == pytest.approx(1.2e5, rel=0.1)
