"""The answer of a diagnosis in words."""

import pytest

from pneuservo.report.words import headline


def answer(held_back, used=2.3e-5, noise=2.1e-5):
    channel = {
        "noise_rms": noise,
        "unit": "m",
        "before": {"used": 4.1e-4, "held_back": held_back},
        "after": {"used": used, "held_back": held_back},
    }
    return {"verdict": "consistent", "fit": {"channels": {"displacement": channel}}}


def test_what_is_predicted_far_worse_is_said():
    words = headline(answer(1.15e-4))
    assert "What was held back is not predicted as well" in words
    assert "0.115 mm of the displacement are left there, 5 times as much" in words


@pytest.mark.parametrize("held_back", [None, 2.0e-5, 3.4e-5])
def test_what_is_predicted_as_well_is_not_mentioned(held_back):
    assert "held back" not in headline(answer(held_back))


def test_less_than_the_noise_is_no_scale():
    # Of a recording that was fitted closely the noise is what others are held against.
    assert "held back" not in headline(answer(2.5e-5, used=1e-6))


@pytest.mark.parametrize(("after", "said"), [(2.4e-5, False), (2.9e-5, True)])
def test_what_the_baseline_predicts_better_is_said(after, said):
    document = answer(2.2e-5)
    document["fit"]["channels"]["displacement"]["after"]["held_back"] = after
    assert ("the baseline leaves less: 0.022 mm, not 0.029 mm" in headline(document)) is said


def test_a_misfit_that_reads_the_same_before_and_after_does_not_fall():
    document = answer(None, used=4.1e-4) | {"verdict": "parameter", "corrected_parameters": {}}
    assert "the misfit of the displacement stays at 0.41 mm" in headline(document)


@pytest.mark.parametrize(("used", "said"), [(2.9e-5, False), (6.3e-5, True)])
def test_far_more_than_noise_that_is_left_is_said(used, said):
    words = headline(answer(None, used=used))
    assert ("Not all is explained: 0.063 mm of the displacement are left, 3 times" in words) is said


def test_an_answer_that_was_interrupted_does_not_say_that_all_was_tried():
    whole, partial = answer(None), answer(None) | {"partial": True}
    assert "no effect in the catalogue does better" in headline(whole)
    assert "no effect" not in headline(partial)
    assert "not all of what the catalogue would explain had been asked" in headline(partial)
