"""A parameter out of its tolerance is named, though it costs little to explain recordings with."""

from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional, SlidingMode
from pneuservo.diagnosis import diagnose, document, search
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.strained import out_of_tolerance
from pneuservo.rigs import load_rig


def diagnosed(key, tolerances):
    """Return the answer where one parameter is so many tolerances off, and what it is."""
    rig = load_rig("single-axis")
    parameter = rig.parameters[key]
    off = rig.with_values({key: parameter.value + tolerances * parameter.tolerance})
    used = [recorded(off, Proportional(), 5, 2.0), recorded(off, SlidingMode(), 6, 2.0)]
    return document(diagnose(used)), off[key]


def test_a_parameter_three_tolerances_off_is_named_with_its_value():
    answer, true = diagnosed("valve.flow.area_s_a", -3.0)
    assert answer["verdict"] == "parameter", answer["missing"]
    assert list(answer["corrected_parameters"]) == ["valve.flow.area_s_a"]
    found = answer["corrected_parameters"]["valve.flow.area_s_a"]
    assert found["value"] == pytest.approx(true, rel=0.03)
    assert [entry["block"] for entry in answer["located"]] == ["valve.flow"]


def test_a_parameter_within_two_tolerances_is_left_alone():
    answer, _ = diagnosed("valve.flow.area_s_a", -1.5)
    assert answer["verdict"] == "consistent"
    assert answer["corrected_parameters"] == {}


@pytest.mark.parametrize(
    ("distance", "known", "out"),
    [(2.2, 0.05, ["mass"]), (-2.2, 0.05, ["mass"]), (2.2, 0.3, []), (1.9, 0.01, [])],
)
def test_all_of_its_interval_has_to_be_out_of_it(distance, known, out):
    found = SimpleNamespace(
        tolerated=("zero_force", "mass"),
        shared={"mass": 2.0},
        distance=np.array([9.0, distance]),
        leverage=lambda name: known**2,
    )
    assert out_of_tolerance(found) == out


@pytest.mark.parametrize(
    ("wrong", "leaving_noise", "named"),
    [
        (["a"], {"a", ""}, ["param.a"]),
        (["a", "b"], {"a", "b", ""}, ["param.a", "param.b"]),
        (["a", "b", "c"], {"a", "b", "c", ""}, []),  # so many are hardly wrong at once
        (["a", "b"], {"a", ""}, []),  # ... nor is one that cannot be let go
    ],
)
def test_parameters_that_make_up_for_something_else_are_not_named(
    monkeypatch, wrong, leaving_noise, named
):
    monkeypatch.setattr(search, "out_of_tolerance", lambda found: wrong[len(found.members) :])

    class Named(search.Search):
        @property
        def chosen(self):
            return fitted(self.accepted)

        @property
        def baseline(self):
            return fitted([])

        def ended(self, hypothesis):
            return fitted(hypothesis.members)

        def leaves_noise(self, found):
            return found.last in leaving_noise

        def are_judged(self, found):
            return True

        def one_cause_instead(self, base, several):
            return None

    def fitted(members):
        last = members[-1].removeprefix("param.") if members else ""
        return SimpleNamespace(
            members=tuple(members),
            last=last,
            hypothesis=Hypothesis(
                frozenset(), frozenset(m.removeprefix("param.") for m in members)
            ),
            effective={},
            information_criterion=lambda effective: 0.0,
        )

    found = Named(SimpleNamespace(steady=True), [])
    found.name_wrong_parameters()
    assert found.accepted == named


def test_one_zero_that_is_off_is_no_two_wrong_dead_volumes():
    """Away from both stops it makes one chamber larger and the other smaller."""
    rig = load_rig("single-axis")
    off = rig.with_values({"sensor.position-offset:offset": 1.8e-3})
    found = diagnose([recorded(off, Proportional(), seed, duration=2.0) for seed in (1, 2)])
    answer = document(found)
    assert [entry["effect"] for entry in answer["missing"]] == ["sensor.position-offset"]
    assert answer["corrected_parameters"] == {}
