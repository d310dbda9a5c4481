"""The mirror image of a servo leaves the mirror image of what the servo leaves."""

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis.models.servo import run_observer
from pneuservo.diagnosis.models.servo.servo import ServoModel
from pneuservo.recordings import Recording
from pneuservo.rigs import load_rig, plant_numbers

MODEL = ServoModel()
SWAPPED = {
    "chamber.a.dead_volume": "chamber.b.dead_volume",
    "piston.area_a": "piston.area_b",
    "valve.flow.area_s_a": "valve.flow.area_s_b",
    "valve.flow.area_a_e": "valve.flow.area_b_e",
}
OPPOSITE = {"pressure_a": "pressure_b", "pressure_b": "pressure_a"}


@pytest.fixture(scope="module")
def both():
    """Return what is followed of a recording, and of its mirror image on the mirrored rig."""
    grid = plant_numbers.valve_grid
    with pytest.MonkeyPatch.context() as patch:
        # One table of discharge coefficients for all four edges.
        for module in (plant_numbers, run_observer):
            patch.setattr(module, "valve_grid", lambda valve: np.repeat(grid(valve)[:1], 4, axis=0))
        rig = load_rig("single-axis")
        pairs = [*SWAPPED.items(), *((b, a) for a, b in SWAPPED.items())]
        mirrored = {here: rig[there] for here, there in pairs}
        other_rig = rig.with_values(mirrored | {"load.gravity": -rig["load.gravity"]})
        run = recorded(rig, Proportional(), 5, duration=2.0)
        seen = {OPPOSITE.get(name, name): values for name, values in run.channels.items()}
        seen["displacement"] = rig["piston.stroke"] - run["displacement"]
        seen["valve_voltage"] = -run["valve_voltage"]
        image = Recording("image", run.time, seen)
        yield MODEL.cases(run, rig), MODEL.cases(image, other_rig)


def left(cases, values):
    return {
        case.channel: (case.measured - MODEL.predict(case, values))[case.usable] for case in cases
    }


def change(cases, values):
    with_it, without = left(cases, values), left(cases, {})
    return {name: np.linalg.norm(with_it[name] - without[name]) for name in without}


def test_what_is_left_is_mirrored(both):
    here, there = (left(cases, {}) for cases in both)
    assert set(here) == set(there) > {"displacement", "pressure_a", "pressure_b"}
    for name, values in here.items():
        sign = 1.0 if name.startswith("pressure") else -1.0
        # In units of the noise; steps are divided where the spool crosses its null.
        assert there[OPPOSITE.get(name, name)] == pytest.approx(sign * values, abs=0.1), name


@pytest.mark.parametrize(
    ("values", "mirrored"),
    [
        ({"valve.overlap:lap": 0.01}, {}),
        ({"spool.hysteresis:half_width": 0.005}, {}),
        ({"leakage.cross-piston:conductance": 1e-16}, {}),
        ({"chamber.heat-transfer:conductance": 0.1}, {}),
        ({"friction.stribeck:excess": 2.0}, {}),
        ({"sensor.pressure-gain-a:gain": 0.01}, {"sensor.pressure-gain-b:gain": 0.01}),
        ({"sensor.pressure-offset-a:offset": 5e3}, {"sensor.pressure-offset-b:offset": 5e3}),
        ({"spool.null-bias:bias": 0.005}, {"spool.null-bias:bias": -0.005}),
        ({"load.gravity-angle:angle": 0.5}, {}),
    ],
    ids=lambda values: " ".join(values) or "itself",
)
def test_what_an_effect_changes_is_mirrored(both, values, mirrored):
    here, there = (
        change(cases, v) for cases, v in zip(both, (values, mirrored or values), strict=True)
    )
    assert max(here.values()) > 10.0
    for name, size in here.items():
        assert there[OPPOSITE.get(name, name)] == pytest.approx(size, rel=0.03, abs=0.1), name
