"""What explains little of the recordings that are used has to explain what was held back too."""

import dataclasses

import pytest
from servo_recordings import recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import held_back
from pneuservo.diagnosis.diagnosis import _prepare
from pneuservo.diagnosis.held_back import HeldBack
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.diagnosis.search import Search
from pneuservo.rigs import load_rig

EFFECT = "leakage.chamber-a"


@pytest.fixture(scope="module")
def cases():
    sound = load_rig("single-axis")
    leaking = dataclasses.replace(sound, effects={EFFECT: {"area": 2e-10}})
    model = model_of("single-axis", frozenset())

    def prepared(rig, seed):
        return _prepare(model, recorded(rig, Proportional(), seed), sound)

    return (
        model,
        prepared(leaking, 1),
        {"with": prepared(leaking, 2), "without": prepared(sound, 3)},
    )


@pytest.fixture(scope="module")
def search(cases):
    model, used, _ = cases
    search = Search(model, used)
    search.accepted.append(EFFECT)
    return search


@pytest.fixture
def nothing_is_beyond_doubt(monkeypatch):
    monkeypatch.setattr(held_back, "BEYOND_DOUBT", float("inf"))


@pytest.mark.parametrize(("what", "named"), [("with", [EFFECT]), ("without", [])])
def test_a_name_has_to_explain_what_was_held_back(
    cases, search, what, named, nothing_is_beyond_doubt
):
    model, used, kept_out = cases
    again = dataclasses.replace(search, accepted=list(search.accepted), ledger=[])
    again.drop_refuted(HeldBack(model, kept_out[what], used[0]))
    assert again.accepted == named
    assert [step.replaced for step in again.ledger] == ([] if named else [EFFECT])
    assert all("held back" in step.why for step in again.ledger)


def test_what_explains_much_is_not_refuted_by_what_was_held_back(cases, search, monkeypatch):
    monkeypatch.setattr(held_back, "BEYOND_DOUBT", 50.0)
    model, used, kept_out = cases
    before, after = search.fitted(Hypothesis()), search.chosen
    kept_out = HeldBack(model, kept_out["without"], used[0])
    assert kept_out.are_predicted_worse(before, after)
    assert not kept_out.refute(before, after)


def test_without_recordings_held_back_nothing_is_refuted(cases, search):
    model, used, _ = cases
    before, after = search.fitted(Hypothesis()), search.chosen
    assert not HeldBack(model, [], used[0]).are_predicted_worse(before, after)
