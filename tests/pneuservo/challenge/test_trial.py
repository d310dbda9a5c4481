"""The trial: sealed keys, the score of made-up answers, and taking up what was stopped."""

import json

import pytest
from click.testing import CliRunner

from analog_card.files import alone_in
from pneuservo.challenge import trial as trial_module
from pneuservo.challenge.answers import Answer
from pneuservo.challenge.classes import classmates
from pneuservo.challenge.judge import judge, names
from pneuservo.challenge.key import Key
from pneuservo.challenge.mix import counts, draw_mix
from pneuservo.challenge.page import trial_page
from pneuservo.challenge.score import confusion, measures, wilson, wrong
from pneuservo.challenge.seal import seal, unseal
from pneuservo.challenge.sizes import FEWEST_CONTROLS, QUICK
from pneuservo.challenge.trial import (
    diagnose_cases,
    judge_cases,
    make_cases,
    open_trial,
    summary,
)
from pneuservo.command_line import main
from pneuservo.errors import InputError

CONSISTENT = {"verdict": "consistent", "missing": [], "located": []}


def key(effect="friction.pressure", **changes):
    found = {
        "effects": (effect,), "kinds": ("physics",), "blocks": (("piston",),), "forms": ("f",),
        "sizes": (1e-6,), "units": ("N/Pa",), "shared": False, "distances": (50.0,),
        "follow_up": (0.0,), "visibility": "visible", "stratum": "single", "retuned": False,
        "missing": (), "experiments": {}, "noise": {"displacement": 1e-5, "pressure_a": 500.0},
    }  # fmt: skip
    return Key(**{**found, **changes}).document()


def answer(effect="friction.pressure", block="piston", probability=0.9, **more):
    entry = {"effect": effect, "probability": probability, "class": [effect], **more}
    return {
        "verdict": "missing-physics",
        "located": [{"block": block, "share": 0.9}],
        "missing": [entry],
    }


def of(judged, name):
    return next(line for line in measures(judged) if line.name == name and line.count)


# ---- keys ------------------------------------------------------------------------------------


def test_a_key_is_opened_only_as_it_was_sealed(tmp_path):
    file = tmp_path / "key.json"
    published = seal(key(), file)
    assert unseal(file, published)["effects"] == ["friction.pressure"]
    changed = json.loads(file.read_text())
    changed["key"]["effects"] = ["none"]
    file.write_text(json.dumps(changed))
    with pytest.raises(InputError, match="published before"):
        unseal(file, published)


def test_the_same_key_never_gives_the_same_commitment(tmp_path):
    # Otherwise a commitment could be looked up: there are few effects.
    assert seal(key(), tmp_path / "a.json") != seal(key(), tmp_path / "b.json")


@pytest.mark.parametrize("text", ["", "[]", '{"salt": "x"}'])
def test_a_broken_key_is_refused(tmp_path, text):
    (tmp_path / "key.json").write_text(text)
    with pytest.raises(InputError, match=r"key\.json"):
        unseal(tmp_path / "key.json", "0")


# ---- the mix ---------------------------------------------------------------------------------


@pytest.mark.parametrize("cases", [QUICK, 200, 320])
def test_mix_is_complete(cases):
    assert sum(counts(cases).values()) == cases
    assert cases < 200 or counts(cases)["none"] >= FEWEST_CONTROLS
    import numpy as np

    wishes = draw_mix(cases, np.random.default_rng(1))
    assert len(wishes) == cases
    assert {wish.stratum for wish in wishes} == set(counts(cases))
    assert wishes != draw_mix(cases, np.random.default_rng(2))


# ---- the score -------------------------------------------------------------------------------


def test_wilson_interval():
    # Newcombe 1998, Stat. Med. 17, 857, table I: 81 of 263 and 0 of 20.
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


@pytest.mark.parametrize(
    ("said", "met"),
    [
        (answer(), {"detected", "block first", "name first", "name in the first two", "class"}),
        (
            answer("param.piston.coulomb_friction"),
            {"detected", "block first", "class"},
        ),
        (
            answer(
                "load.spring", alternatives=[{"effect": "friction.pressure", "probability": 0.2}]
            ),
            {"detected", "block first", "name in the first two"},
        ),
        (answer("leakage.rod-seal", "chamber.b"), {"detected"}),
        (CONSISTENT, set()),
        (None, set()),
    ],
)
def test_a_single_effect(said, met):
    found = judge("c", key(), said)
    assert {name for name, right in found.right.items() if right} == met | {"nothing else named"}


def test_a_second_name_that_is_wrong():
    said = answer()
    said["missing"].append({"effect": "sensor.clock"})
    assert not judge("c", key(), said).right["nothing else named"]
    assert judge("c", key(), said).right["name first"]


def test_no_answer_is_a_wrong_answer():
    found = judge("c", key("none", stratum="none", distances=(0.0,)), None)
    assert not found.right["no false alarm"]
    assert wrong([found]) == [found]


def test_a_control():
    nothing = key("none", stratum="none", kinds=("none",), visibility="hidden")
    assert judge("c", nothing, CONSISTENT).right["no false alarm"]
    parameter = {"verdict": "parameter", "corrected_parameters": {"load.mass": {}}}
    found = judge("c", nothing, parameter)
    assert not found.right["no false alarm"]
    assert found.right["no false physics"]


def test_a_wrong_parameter_and_its_error():
    wrong_mass = key(
        "param.load.mass", stratum="wrong-parameter", kinds=("parameter",),
        parameters={"load.mass": 2.0},
    )  # fmt: skip
    corrected = {"load.mass": {"value": 2.1, "unit": "kg", "low": 1.9, "high": 2.2}}
    found = judge("c", wrong_mass, {"verdict": "parameter", "corrected_parameters": corrected})
    assert all(found.right.values())
    assert found.figures["parameter error"] == pytest.approx(0.05)
    assert found.figures["inside the interval"] == 1.0
    assert not judge("c", wrong_mass, answer()).right["not called physics"]


def test_outside_the_catalogue():
    icing = key("outside.icing", stratum="outside", blocks=(("valve.flow", "lines"),))
    unexplained = {"verdict": "unexplained", "located": [{"block": "lines"}], "missing": []}
    assert all(judge("c", icing, unexplained).right.values())
    assert not judge("c", icing, answer()).right["no confident wrong name"]
    assert judge("c", icing, answer(probability=0.4)).right["no confident wrong name"]


def test_a_pair():
    both = key(
        effects=("valve.overlap", "leakage.rod-seal"), kinds=("physics",) * 2,
        blocks=(("valve.flow",), ("chamber.b",)), distances=(20.0, 30.0), stratum="pair",
    )  # fmt: skip
    said = answer("valve.overlap")
    found = judge("c", both, said)
    assert found.right["at least one name"]
    assert not found.right["both names"]
    assert found.right["no wrong name"]
    said["missing"].append({"effect": "load.spring"})
    assert not judge("c", both, said).right["no wrong name"]


def test_a_hidden_effect_and_the_experiment_after_it():
    hidden = key(visibility="hidden", distances=(2.0,), follow_up=(25.0,))
    said = {**CONSISTENT, "not_visible": [{"effect": "friction.pressure"}]}
    found = judge("c", hidden, said, further=answer())
    assert found.right == {
        "consistent": True, "said not visible": True, "named after the experiment": True,
    }  # fmt: skip


def test_a_claim_finer_than_the_channels():
    few = key("spool.null-bias", stratum="missing-channels", blocks=(("valve.spool",),))
    assert judge("c", few, answer("leakage.cross-piston")).right["not too fine"]
    assert not judge("c", few, answer("load.spring")).right["not too fine"]
    assert "leakage.cross-piston" in classmates("spool.null-bias")


def test_residuals_are_measured_against_the_true_noise():
    said = answer()
    said["fit"] = {
        "channels": {
            "displacement": {"after": {"used": 2e-5, "held_back": 1e-5}},
            "pressure_a": {"after": {"used": 500.0, "held_back": None}},
        }
    }
    figures = judge("c", key(), said).figures
    assert figures["after held_back"] == pytest.approx(1.0)
    assert figures["after used"] == pytest.approx(((2.0**2 + 1.0**2) / 2.0) ** 0.5)


def test_the_tables_of_some_made_up_answers():
    cases = [
        judge("a", key(), answer()),
        judge("b", key(), answer("leakage.rod-seal", "chamber.b")),
        judge("c", key("none", stratum="none", visibility="hidden"), CONSISTENT),
    ]
    line = of(cases, "name first")
    assert (line.value, line.count, line.met) == (0.5, 2, False)
    assert (line.low, line.high) == wilson(1, 2)
    assert of(cases, "no false alarm").met
    assert confusion(cases) == {"friction": {"friction": 1, "leakage": 1}, "none": {"none": 1}}
    assert [case.case for case in wrong(cases)] == ["b"]


def test_names_of_an_answer():
    assert names(CONSISTENT) == ()
    mixed = {**answer(), "corrected_parameters": {"load.mass": {}}}
    # Parameters that were re-fitted beside physics are not what is asserted.
    assert names(mixed) == ("friction.pressure",)


# ---- stopping and taking up ------------------------------------------------------------------


@pytest.fixture
def small(tmp_path, monkeypatch):
    """A trial of three cases that takes no time to make."""

    def make(trial, name, number, wish):
        folder = trial.case_folder(name)
        folder.mkdir(parents=True)
        for part in ("used-1", "used-2", "held-back-1"):
            (folder / f"{part}.csv").write_text("")
        seal(key("none", stratum="none", visibility="hidden"), trial.key_file(name))

    class Here:
        def __init__(self, *arguments, **options):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *problem):
            return None

        def submit(self, function, *arguments):
            from concurrent.futures import Future

            future = Future()
            future.set_result(function(*arguments))
            return future

    monkeypatch.setattr(trial_module, "_make", make)
    monkeypatch.setattr(trial_module, "processes", Here)
    return open_trial(tmp_path / "trial", 3, 5)


def test_a_stopped_trial_asks_only_for_what_is_missing(small, monkeypatch):
    asked = []

    def ask(used, held_back, folder, without):
        asked.append(used[0].parent.name)
        if len(asked) == 2:
            raise KeyboardInterrupt
        return Answer(CONSISTENT, 1.0, 0, "")

    monkeypatch.setattr(trial_module, "ask", ask)
    make_cases(small, 1)
    with pytest.raises(KeyboardInterrupt):
        diagnose_cases(small, 1)
    done = len(list((small.folder / "answers").glob("*.json")))
    before = len(asked)
    again = open_trial(small.folder, None, None)
    assert (again.seed, again.cases) == (5, 3)
    make_cases(again, 1)
    diagnose_cases(again, 1)
    assert len(asked) - before == 3 - done
    judged = judge_cases(again)
    assert [case.right["no false alarm"] for case in judged] == [True] * 3
    assert "3 of 3 cases" in trial_page([(again, judged)])
    # Strict JSON: no NaN for what was not counted.
    json.dumps(summary(again, judged), allow_nan=False)


@pytest.mark.parametrize(
    ("said", "status"), [({**CONSISTENT, "partial": True}, 0), (None, -2), (None, -15)]
)
def test_an_answer_that_was_interrupted_is_asked_for_again(small, monkeypatch, said, status):
    monkeypatch.setattr(trial_module, "ask", lambda *words: Answer(said, 1.0, status, ""))
    make_cases(small, 1)
    diagnose_cases(small, 1)
    assert judge_cases(small) == []
    # A crash and a refusal are wrong answers, and stay.
    monkeypatch.setattr(trial_module, "ask", lambda *words: Answer(None, 1.0, -11, ""))
    diagnose_cases(small, 1)
    assert len(judge_cases(small)) == 3


@pytest.mark.parametrize("text", ["", "[1", "{}", "[]"])
def test_damaged_commitments_are_refused(small, text):
    make_cases(small, 1)
    (small.folder / "commitments.json").write_text(text)
    with pytest.raises(InputError, match=r"commitments\.json"):
        judge_cases(small)


def test_an_unknown_part_is_refused_before_anything_runs(tmp_path):
    words = ["challenge", "--quick", "--without", "stickmask", "--out", str(tmp_path / "new")]
    outcome = CliRunner().invoke(main, words)
    assert outcome.exit_code == 2
    assert "stick-mask" in outcome.output
    assert not (tmp_path / "new").exists()


def test_a_part_left_out_is_kept_apart(small, monkeypatch):
    said = {"": CONSISTENT, "mask": answer()}
    monkeypatch.setattr(
        trial_module,
        "ask",
        lambda used, held_back, folder, without: Answer(said[without], 1.0, 0, ""),
    )
    make_cases(small, 1)
    diagnose_cases(small, 1)
    diagnose_cases(small, 1, without="mask")
    assert all(case.right["no false alarm"] for case in judge_cases(small))
    assert not any(case.right["no false alarm"] for case in judge_cases(small, "mask"))
    assert "| no effect | no false alarm | 1 | 0 |" in trial_page([(small, judge_cases(small))])


def test_diagnoses_see_no_key(small, monkeypatch):
    seen = []
    monkeypatch.setattr(
        trial_module,
        "ask",
        lambda used, held_back, folder, without: (
            seen.extend([*used, *held_back, folder]) or Answer(CONSISTENT, 1.0, 0, "")
        ),
    )
    make_cases(small, 1)
    diagnose_cases(small, 1)
    keys = small.key_file("case-001").parent
    assert seen
    assert not any(keys in path.parents or path in keys.parents for path in seen)


def test_a_folder_with_another_trial_is_refused(small):
    with pytest.raises(InputError, match="3 cases with seed 5"):
        open_trial(small.folder, 4, None)
    outcome = CliRunner().invoke(main, ["challenge", "--quick", "--out", str(small.folder)])
    assert outcome.exit_code == 2
    assert "3 cases with seed 5" in outcome.output
    assert "Traceback" not in outcome.output


def test_two_runs_do_not_share_a_folder(tmp_path):
    # Both made the same cases, and the keys of the one were not those that the other had promised.
    with alone_in(tmp_path):
        run = CliRunner().invoke(main, ["challenge", "--quick", "--out", str(tmp_path)])
    assert run.exit_code == 2
    assert "another run is at work in it" in run.stderr
    assert not list(tmp_path.iterdir())
    with alone_in(tmp_path):
        pass


def test_changed_keys_are_noticed(small):
    make_cases(small, 1)
    seal(key(), small.key_file("case-001"))
    with pytest.raises(InputError, match="differs from the keys"):
        make_cases(small, 1)
