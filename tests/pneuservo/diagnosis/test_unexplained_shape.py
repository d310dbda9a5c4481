"""The table for what has no name: its shape in words, and the smoothing behind it."""

import numpy as np
import pytest

from pneuservo.diagnosis.models.model import Table
from pneuservo.diagnosis.unexplained import Unexplained, smoothed

KNOTS = np.linspace(0.0, 8.0, 9)
TABLE = Table(
    effect="unexplained.force",
    block="piston",
    what="force on the piston",
    unit="N",
    quantity="displacement",
    unit_of_quantity="m",
    values={
        "unexplained.force:over": 0.0,
        "unexplained.force:low": 0.0,
        "unexplained.force:high": 8.0,
    },
    low="unexplained.force:low",
    high="unexplained.force:high",
    knots=tuple(f"unexplained.force:v{k}" for k in range(9)),
    step=1.0,
    least=0.0,
    largest=1e4,
    least_gain=0.0,
)


def shaped(values, spread=0.01):
    return Unexplained(TABLE, KNOTS, np.asarray(values), np.full(9, spread), 200.0, 100.0, None)


@pytest.mark.parametrize(
    ("values", "form"),
    [
        (2.0 * KNOTS, "growing"),
        (-(KNOTS**2), "falling"),
        (np.exp(-((KNOTS - 4.0) ** 2)), "a hump at 4 m"),
        (-np.exp(-((KNOTS - 4.0) ** 2)), "a dip at 4 m"),
        (np.cos(np.pi * KNOTS / 2.0), "up and down, 3 turns"),
    ],
)
def test_the_shape_is_said_in_words(values, form):
    assert shaped(values).form == form
    assert shaped(values).shape == f"force on the piston that depends on displacement ({form})"


def test_smoothing_takes_noise_out_and_leaves_the_shape():
    rng = np.random.default_rng(3)
    truth = np.sin(KNOTS / 3.0)
    errors = []
    for _ in range(20):
        noisy = truth + rng.normal(0.0, 0.2, 9)
        smooth = smoothed(KNOTS, noisy, np.full(9, 0.2))
        errors.append([np.mean((noisy - truth) ** 2), np.mean((smooth - truth) ** 2)])
    before, after = np.mean(errors, axis=0)
    assert after < 0.7 * before


def test_its_share_and_parameters_are_those_of_the_table():
    found = shaped(2.0 * KNOTS)
    assert found.share == pytest.approx(2.0 / 3.0)
    assert found.parameters["v3"] == {
        "value": 6.0,
        "unit": "N",
        "low": pytest.approx(6.0 - 1.96 * 0.01),
        "high": pytest.approx(6.0 + 1.96 * 0.01),
    }
    assert found.parameters["high"]["value"] == 8.0
