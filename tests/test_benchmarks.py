"""A short round of the benchmark: every row is there, and what it times is right."""

import json

import numpy as np
import pytest

from benchmarks import single_runs, startup
from benchmarks.batches import gradient_rows, monte_carlo_rows, scaling_rows
from benchmarks.compiled_plant import CompiledPlant
from benchmarks.diagnosis import diagnosis_rows
from benchmarks.numpy_plant import NumpyPlant
from benchmarks.problem import ALLOWED_ERROR, CARDS, displacement, reference
from benchmarks.results import Row, table_of, write_results

SHORT = 0.03  # s


@pytest.mark.parametrize("case", CARDS)
def test_yardstick_has_the_same_equations(case):
    yardstick, compiled = NumpyPlant(CARDS[case]), CompiledPlant(CARDS[case])
    random = np.random.default_rng(2)
    held = np.array([0.015, 0.0])
    for _ in range(100):
        state = np.array([0.015, 0.1, 4e5, 4e5, 0.0, 10.0, 5.0, 30.0, 0.4, 40.0])
        state *= random.uniform(0.5, 1.5, 10)
        state[4] = random.uniform(-1.0, 1.0)
        modes = np.array([random.integers(-2, 3), random.integers(-1, 2), random.choice([-1, 1])])
        rates = [plant.rate(state, modes, held) for plant in (yardstick, compiled)]
        # The polynomial in place of powers: 1e-12 of a flow, in a difference of two terms.
        np.testing.assert_allclose(*rates, rtol=1e-8, atol=1e-8)
        margins = [min(plant.margin(state, modes, held), 1.0) for plant in (yardstick, compiled)]
        assert margins[0] == pytest.approx(margins[1], abs=1e-9)


def test_rows_of_single_runs_are_checked_against_the_reference():
    rows = list(single_runs.single_rows(SHORT, 1))
    assert len(rows) == 6
    assert all(row.error_um < ALLOWED_ERROR * 1e6 for row in rows)
    assert all(row.committed is not None and row.value > 0.0 for row in rows)
    # Whatever the machine does: a run is faster than scipy by more than a factor of two.
    assert all(row.value > 2.0 for row in rows if "faster" in row.name)


def test_a_setting_that_is_not_good_enough_is_not_timed():
    exact = reference(CARDS["relay"], SHORT)
    wrong = exact + 1e-3
    with pytest.raises(SystemExit, match="no setting comes within"):
        single_runs.loosest("own", (1e-4, 1e-5), lambda step: wrong, exact)
    found = single_runs.loosest("own", (1.0, 1e-4, 1e-5), lambda s: exact + s * (s > 0.5), exact)
    assert found.setting == 1e-4


def test_rows_of_many_runs():
    rows = [
        *monte_carlo_rows(9, SHORT, 1),
        *gradient_rows(SHORT, 1),
        *scaling_rows(SHORT, 1),
    ]
    names = [row.name for row in rows]
    assert len(set(names)) == len(names) == 8 + 2 + 12
    assert all(np.isfinite(row.value) and row.value > 0.0 for row in rows)


def test_startup_row():
    rows = {row.name: row for row in startup.startup_rows(1)}
    # The third of a second that is asked for is the benchmark's, of an idle machine; nothing that
    # simulates, or compiles, is to be loaded.
    assert 0.0 < rows["pneuservo --help"].value < 3.0


def test_rows_of_a_diagnosis_add_up():
    whole, wall, observer, ratio, *parts = diagnosis_rows(0.5, 1)
    assert wall.value > 0.0
    assert "leakage.chamber-a" in whole.note
    # Every part was recognised in what the diagnosis says it is doing, and took some time.
    assert len(parts) == 7
    assert all(part.value > 0.0 for part in parts)
    assert sum(part.value for part in parts) == pytest.approx(whole.value, rel=1e-9)
    assert ratio.value == pytest.approx(1e3 * whole.value / observer.value, rel=1e-9)


def test_results_are_written(tmp_path):
    rows = [
        Row("a", np.float64(2.0), "x", 1.0, 3.0, error_um=0.01),
        Row("b", 2.0, "s", 1.0, higher_is_better=False, spread=(1.0, 3.0)),
        Row("c", 1.0, "ms/s"),
    ]
    assert [row.kept for row in rows] == [True, False, None]
    write_results(rows, tmp_path / "results.json")
    document = json.loads((tmp_path / "results.json").read_text())
    assert [row["kept"] for row in document["rows"]] == [True, False, None]
    assert document["machine"]["processors"] > 0
    assert table_of(rows).row_count == 3
    assert displacement(CARDS["relay"], SHORT, 1e-4)[0] == 0.0145
