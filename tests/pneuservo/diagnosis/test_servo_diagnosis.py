"""The servo's diagnosis: nothing where there is nothing, the right name where there is something.

The truth of the planted effects is that of `pneuservo.challenge`: other equations, other forms of
the laws, another integrator.
"""

import pytest
from servo_recordings import recorded

from pneuservo.challenge.cases import make_case
from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis import diagnose, document, repaired_model
from pneuservo.recordings import read_recording
from pneuservo.rigs import load_rig


@pytest.mark.parametrize(("controller", "seed"), [(Proportional(), 1), (SlidingMode(), 2)])
def test_no_effect_raises_no_alarm(controller, seed):
    found = diagnose([recorded(load_rig("single-axis"), controller, seed)])
    assert found.verdict == "consistent", found.search.accepted
    assert document(found)["located"] == []


def test_a_wrong_mass_is_a_parameter_and_no_physics():
    rig = load_rig("single-axis")
    heavy = rig.with_values({"load.mass": 1.2 * rig["load.mass"]})
    found = diagnose([recorded(heavy, Proportional(), 3)])
    answer = document(found)
    assert answer["verdict"] == "parameter", found.search.accepted
    mass = answer["corrected_parameters"]["load.mass"]
    assert mass["value"] == pytest.approx(heavy["load.mass"], rel=0.02)
    assert [entry["block"] for entry in answer["located"]] == ["load"]
    # Two fits at a time give the same answer to the last digit.
    both = diagnose([recorded(heavy, Proportional(), 3)], jobs=2)
    assert document(both) == answer


@pytest.mark.parametrize(
    ("effect", "blocks"),
    [
        ("leakage.chamber-a", {"chamber.a"}),
        ("spool.hysteresis", {"valve.spool"}),
    ],
)
def test_a_planted_effect_is_named_and_put_in_its_block(effect, blocks, tmp_path):
    make_case(11, effect, "visible", tmp_path)
    used = [read_recording(str(path)) for path in sorted(tmp_path.glob("used-*.csv"))]
    held_back = [read_recording(str(path)) for path in sorted(tmp_path.glob("held-back-*.csv"))]
    found = diagnose(used, held_back)
    answer = document(found)
    assert answer["verdict"] == "missing-physics"
    first = answer["missing"][0]
    assert effect in first["class"], (first["effect"], first["class"])
    assert answer["located"][0]["block"] in blocks
    # What was held back is predicted better too.
    before, after = (
        sum(
            entry[when]["held_back"] / entry["noise_rms"]
            for entry in answer["fit"]["channels"].values()
        )
        for when in ("before", "after")
    )
    assert after < before
    assert first["effect"] in repaired_model(found)["effects"]
