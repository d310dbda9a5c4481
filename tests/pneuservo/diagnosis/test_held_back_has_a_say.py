"""What explains little of the recordings that are used has to explain what was held back too."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from servo_recordings import noisy, recorded

from pneuservo.controllers import Proportional
from pneuservo.diagnosis import diagnose, document, held_back
from pneuservo.diagnosis import search as search_module
from pneuservo.diagnosis.diagnosis import _prepare
from pneuservo.diagnosis.fit import rms
from pneuservo.diagnosis.fitting import fit
from pneuservo.diagnosis.held_back import HeldBack
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.diagnosis.models import model_of
from pneuservo.diagnosis.search import Search
from pneuservo.rigs import load_rig
from pneuservo.simulation import simulate

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
    again.drop_refuted(HeldBack(model, kept_out[what], used))
    assert again.accepted == named
    assert [step.replaced for step in again.ledger] == ([] if named else [EFFECT])
    assert all("held back" in step.why for step in again.ledger)


def test_what_explains_much_is_not_refuted_by_what_was_held_back(cases, search, monkeypatch):
    monkeypatch.setattr(held_back, "BEYOND_DOUBT", 50.0)
    model, used, kept_out = cases
    before, after = search.fitted(Hypothesis()), search.chosen
    kept_out = HeldBack(model, kept_out["without"], used)
    assert kept_out.are_predicted_worse(before, after)
    assert not kept_out.refute(before, after)


def test_without_recordings_held_back_nothing_is_refuted(cases, search):
    model, used, _ = cases
    before, after = search.fitted(Hypothesis()), search.chosen
    assert not HeldBack(model, [], used).are_predicted_worse(before, after)


def test_where_a_stop_is_that_was_never_reached_says_nothing_against_a_name():
    given = load_rig("single-axis")
    # Two tolerances longer than it is said to be.
    stroke = given["piston.stroke"] + 2.0 * given.parameters["piston.stroke"].tolerance
    true = given.with_values({"piston.stroke": stroke})
    model, time = model_of("single-axis", frozenset()), np.arange(0.0, 4.0, 1e-3)

    def pressed(seed):
        run = simulate(true, time=time, command=np.where(time % 2.0 < 1.5, 3.0, -3.0))
        return _prepare(model, noisy(run, np.random.default_rng(seed)), given)

    def missed(kept_out, found):
        left = kept_out.predicted(found).residuals
        return max(rms([mine]) for mine in left)

    used = _prepare(model, recorded(true, Proportional(), 1), given)
    found, kept_out = fit(model, used, Hypothesis()), HeldBack(model, pressed(2), used)
    # At every arrival; then it is taken for a zero that wanders.
    assert missed(kept_out, found) > 4.0
    assert missed(kept_out.read_with(found), found) < 1.25
    # Recordings that have told it, too, have to be right.
    told = [*used, *pressed(3)]
    kept_out = HeldBack(model, pressed(2), told)
    assert model.told(kept_out.cases, told) == kept_out.cases
    assert missed(kept_out, fit(model, told, Hypothesis())) < 1.1


@pytest.mark.parametrize(
    ("channel", "before", "after", "missed"),
    [
        ("pressure_a", 4.8, 1.9, 1.9),
        ("pressure_a", 4.8, 1.4, 0.0),  # no more than one and a half times the noise
        ("pressure_a", 9.0, 1.9, 0.0),  # as another form of a law leaves
        ("displacement", 7.5, 7.5, 0.0),  # where a stop is, what was used need not have told
    ],
)
def test_how_many_times_its_noise_a_law_misses_what_was_held_back(channel, before, after, missed):
    case = SimpleNamespace(recorded=True, channel=channel)
    left = [[np.full(10, size)] for size in (before, after)]
    assert held_back.times_missed([case], *left) == pytest.approx(missed)


@pytest.mark.parametrize(
    ("together", "missed"),
    [
        ((1.0, 1.3), 0.0),  # a size that what was used has not told well
        ((1.0, 1.8), 1.9),
        ((1.8, 1.0), 1.9),  # at the cost of what was used
    ],
)
def test_a_law_that_holds_for_all_recordings_is_not_refuted_by_its_sizes(
    monkeypatch, together, missed
):
    def left(*sizes):
        return SimpleNamespace(residuals=[np.full(10, size) for size in sizes])

    case = SimpleNamespace(recorded=True, channel="pressure_a")
    monkeypatch.setattr(held_back, "refitted", lambda *given: left(*together))
    kept_out = HeldBack(None, [case], [case])
    fits = [left(size) for size in (4.0, 1.0, 4.8, 1.9)]
    assert held_back.times_missed_at_best(kept_out, *fits) == pytest.approx(missed)


def test_a_law_that_does_not_hold_elsewhere_stands_in_for_what_has_no_name():
    sound = load_rig("single-axis")
    used, kept_out = (
        recorded(
            dataclasses.replace(sound, effects={EFFECT: {"area": area}}),
            Proportional(),
            seed,
            interval=2e-3,
        )
        for area, seed in ((1e-8, 1), (0.0, 2))
    )
    answer = document(diagnose([used], [kept_out]))
    assert answer["verdict"] == "unexplained"
    first, second = answer["missing"]
    assert (first["effect"], first["block"]) == ("unexplained", "chamber.a")
    assert f"({EFFECT}) misses what was held back" in first["statement"]
    assert second["effect"] == EFFECT
    assert second["probability"] < 0.1
    assert [entry["block"] for entry in answer["located"]] == ["chamber.a"]
    # What stands in for it stays in the model.
    channel = answer["fit"]["channels"]["pressure_a"]
    assert channel["after"]["used"] < 0.8 * channel["before"]["used"]


@pytest.mark.parametrize(
    ("strained", "gains", "held_back_says_so", "named"),
    [
        (True, 600.0, True, ["load.gravity-angle"]),
        (True, 600.0, False, ["sensor.position-gain"]),
        (True, 230.0, True, ["sensor.position-gain"]),  # what was named explains 200
        (False, 600.0, True, ["sensor.position-gain"]),
    ],
    ids=["absorbed", "not confirmed", "hardly more", "nothing strained"],
)
def test_what_relieves_strained_parameters_is_named_where_what_was_held_back_says_so(
    monkeypatch, strained, gains, held_back_says_so, named
):
    def alone(gain):
        return SimpleNamespace(gain=gain, effective={}, information_criterion=lambda worth: -gain)

    found = Search(SimpleNamespace(steady=True), [], accepted=["sensor.position-gain"])
    found.fits = {
        Hypothesis(): alone(0.0),
        Hypothesis().adding("sensor.position-gain"): alone(200.0),
        Hypothesis().adding("load.gravity-angle"): alone(gains),
    }
    judge = SimpleNamespace(
        only_relieves=lambda name, fit: name == "load.gravity-angle", share=lambda fit: 1.0
    )
    monkeypatch.setattr(Search, "candidates", ["sensor.position-gain", "load.gravity-angle"])
    monkeypatch.setattr(Search, "_judge", lambda self, fit: judge)
    monkeypatch.setattr(Search, "ended", lambda self, hypothesis: self.fits[hypothesis])
    monkeypatch.setattr(search_module, "is_strained", lambda fit: strained)
    monkeypatch.setattr(search_module, "explained", lambda before, after: after.gain - before.gain)
    kept_out = SimpleNamespace(
        cases=[None], are_predicted_worse=lambda before, after, by: held_back_says_so
    )
    found.name_what_relieves(kept_out)
    assert found.accepted == named
