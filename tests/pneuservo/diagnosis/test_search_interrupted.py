"""A search that the user stops answers with what it has."""

import dataclasses

import pytest

from pneuservo.diagnosis import diagnose, document
from pneuservo.diagnosis.search import Search
from pneuservo.examples.leaking_volume import leaking_volume


def stop_at(word):
    def progress(step):
        if word in step:
            raise KeyboardInterrupt

    return progress


def test_interrupted_after_the_first_effect_it_answers_with_that():
    whole = diagnose([leaking_volume()])
    second = whole.search.ledger[1]
    first = whole.search.ledger[0].candidate
    assert second.base == (first,)
    found = diagnose([leaking_volume()], progress=stop_at(f"{first} + "))
    answer = document(found)
    assert answer["partial"] is True
    assert answer["verdict"] == "missing-physics"
    assert [entry["effect"] for entry in answer["missing"]] == [first]
    assert "partial" not in document(whole)


def test_interrupted_among_the_first_candidates_it_knows_the_baseline():
    found = diagnose([leaking_volume()], progress=stop_at("fitting leakage.laminar"))
    answer = document(found)
    assert answer["partial"] is True
    assert answer["missing"] == [] or answer["verdict"] == "unexplained"


def test_interrupted_before_the_baseline_there_is_no_answer():
    with pytest.raises(KeyboardInterrupt):
        diagnose([leaking_volume()], progress=stop_at("the baseline"))


@pytest.mark.parametrize("moment", ["how far the sizes", "predicting what was held back"])
def test_interrupted_after_the_search_it_answers_with_all_that_was_found(moment):
    found = diagnose([leaking_volume(1)], [leaking_volume(2)], progress=stop_at(moment))
    answer = document(found)
    assert answer["partial"] is True
    assert answer["verdict"] == "missing-physics"
    left = answer["fit"]["channels"]["dead_volume_pressure"]["after"]
    assert left["held_back"] is None or "sizes" in moment


def test_names_that_were_only_fitted_together_are_answered_with():
    # As where recordings are followed anew with what was found in them before.
    whole = diagnose([leaking_volume()])
    search = whole.search
    assert len(search.accepted) > 1
    both = search.chosen
    again = Search(search.model, search.cases, stop_at("fitting"))
    again.fits |= {found.hypothesis: found for found in (search.baseline, both)}
    again.go_on_with(search)
    assert again.interrupted
    again.progress = lambda step: None
    answer = document(dataclasses.replace(whole, search=again))
    assert {entry["effect"] for entry in answer["missing"]} == set(search.accepted)
    assert answer["partial"] is True
