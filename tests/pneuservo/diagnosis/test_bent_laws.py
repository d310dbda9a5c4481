"""What acts elsewhere is told from what another form of the same law would explain."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pneuservo.diagnosis.bent_laws import bendable, explained_beyond
from pneuservo.diagnosis.fit import Fit
from pneuservo.diagnosis.hypothesis import Hypothesis
from pneuservo.effects import effect_by_id

SAMPLES = 4000
TIME = np.arange(SAMPLES) * 1e-3
DISPLACEMENT = 0.1 * np.sin(2.0 * np.pi * 0.7 * TIME)
SPRING = effect_by_id("load.spring", "seal-tester")
SIZE = SPRING.key(SPRING.parameters[0].name)
MODEL = SimpleNamespace(
    effects=[SPRING], regressors=lambda case: {"displacement": DISPLACEMENT, "time": TIME}
)
CASES = [SimpleNamespace(recorded=True, usable=np.ones(SAMPLES, dtype=bool))]
NOISE = np.random.default_rng(1).standard_normal(SAMPLES)


def spring_fitted(left):
    """Return the fit of a spring that leaves this."""
    column = (DISPLACEMENT / 0.1)[:, np.newaxis]
    return Fit(
        hypothesis=Hypothesis().adding(SPRING.id),
        shared={SIZE: 1.0},
        intervals={},
        own=({},),
        channels=("displacement",),
        residuals=(left,),
        rms=float(np.sqrt(np.mean(left**2))),
        samples=SAMPLES,
        effective={"displacement": SAMPLES},
        finest={"displacement": 1e-6},
        known=frozenset(),
        unknowns=1,
        penalty=0.0,
        scale={"displacement": 1.0},
        keys=(SIZE,),
        units=np.ones(1),
        bounds=(np.full(1, -np.inf), np.full(1, np.inf)),
        vector=np.ones(1),
        owners=(0,),
        tolerated=(),
        distance=np.zeros(0),
        sensitivity=column,
        covariance=np.eye(1),
    )


def beyond(missing):
    """Return what is explained, and what of it no bent spring would, by what was missing."""
    found = spring_fitted(NOISE + missing)
    closer = replace(found, residuals=(NOISE,))
    explains = float(np.sum(found.left**2) - np.sum(closer.left**2))
    return explains, explained_beyond(bendable(MODEL, CASES, found), closer)


@pytest.mark.parametrize(
    "missing",
    [
        0.5 * (DISPLACEMENT / 0.1) ** 3,
        0.5 * np.clip(DISPLACEMENT / 0.1, 0.0, None),
        0.5 * DISPLACEMENT / 0.1 * TIME / TIME[-1],
        0.5 * np.cos(2.0 * np.pi * 0.7 * TIME),
    ],
    ids=["stiffer far out", "one way", "growing", "later"],
)
def test_what_another_form_of_the_law_would_explain_is_not_elsewhere(missing):
    explains, elsewhere = beyond(missing)
    assert explains > 100.0
    assert elsewhere < 0.05 * explains


def test_what_acts_elsewhere_is_all_that_it_explains():
    explains, elsewhere = beyond(0.5 * np.sin(2.0 * np.pi * 40.0 * TIME))
    assert explains > 100.0
    assert elsewhere > 0.95 * explains


def test_a_law_that_was_not_found_cannot_be_bent():
    found = replace(spring_fitted(NOISE), hypothesis=Hypothesis())
    assert bendable(MODEL, CASES, found).sensitivity.shape == found.sensitivity.shape


def test_what_was_not_recorded_is_not_bent():
    found = spring_fitted(NOISE)
    cases = [SimpleNamespace(recorded=False, usable=CASES[0].usable)]
    assert bendable(MODEL, cases, found).sensitivity.shape == found.sensitivity.shape
