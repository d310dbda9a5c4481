"""Tables found again from pressure alone."""

from pathlib import Path

import numpy as np
import pandas
import pytest

from pneuservo.calibration import Calibration, calibrate, fit_row, simulate_transient, transient_of
from pneuservo.calibration.experiment import COMMANDS, CONDITIONS
from pneuservo.calibration.table import cannot_tell_apart
from pneuservo.calibration.validation import experiment_rig
from pneuservo.errors import InputError
from pneuservo.identification.whiteness import whiteness
from pneuservo.plant.flow_paths import FLOW_PATHS
from pneuservo.recordings import Recording
from pneuservo.rigs import load_valve_tables

TABLES = load_valve_tables("ddv-27a1")
GOLDEN = Path(__file__).parents[2] / "golden"


def true_row(path, command):
    table = TABLES[path]
    k = int(np.argmin(np.abs(table.command - command)))
    return table.pressure_ratio[k], table.discharge_coefficient[k]


@pytest.fixture(scope="module")
def rows():
    """Every third row of all four tables, at the break points of the thesis."""
    return {
        (path, command): fit_row(
            transient_of(simulate_transient(path, command, seed=[number, k])),
            true_row(path, command)[0],
        )
        for number, path in enumerate(FLOW_PATHS)
        for k, command in enumerate(COMMANDS[::3])
    }


def test_every_coefficient_in_reach_is_found(rows):
    for (path, command), row in rows.items():
        error = row.coefficient - true_row(path, command)[1]
        # Four standard deviations: of 63 values one is further off once in 250 times. The
        # tables themselves bend below the first break point by up to 0.11, which the plateau of
        # the model does not: 0.002 of that reaches the value there.
        allowed = 4.0 / 1.96 * row.half_width[row.visible] + 0.002
        assert np.all(np.abs(error[row.visible]) <= allowed), (path, command, error)


def test_the_intervals_hold_the_truth_as_often_as_they_say(rows):
    inside = []
    for (path, command), row in rows.items():
        error = np.abs(row.coefficient - true_row(path, command)[1])
        inside += (error <= row.half_width)[row.visible].tolist()
    # 95 % of 63; fewer than 86 % has a chance below 1 %.
    assert np.mean(inside) > 0.86


def test_what_is_left_is_the_noise(rows):
    white = [whiteness(row.residual).white for row in rows.values()]
    # One in a hundred is called coloured by chance; two of 16 has a chance of 1 %.
    assert sum(white) >= 15
    for row in rows.values():
        # 300 Pa, estimated from 3000 samples: 1.3 %.
        assert np.std(row.residual) == pytest.approx(300.0, rel=0.06)


def test_flow_that_stops_before_the_pressures_are_equal_is_seen(rows):
    # Table 4.3 at 0.1 V: no flow from a pressure ratio of 0.25 on.
    row = rows["b_e", 0.1]
    assert row.coefficient[3] == pytest.approx(0.0, abs=0.002)
    assert not row.visible[4]
    assert "not decided" in " ".join(cannot_tell_apart([row]))


def test_areas_are_found_given_the_coefficient_at_full_opening(rows):
    reference = {path: float(TABLES[path].discharge_coefficient[-1, 1]) for path in FLOW_PATHS}
    areas = Calibration(tuple(rows.values())).areas(reference)
    # Table 4.1 of the thesis.
    for path, stated in {"s_a": 0.870, "b_e": 0.810, "s_b": 0.870, "a_e": 0.795}.items():
        area = areas[path]
        # Twice the 95 % interval, of four.
        assert abs(1e6 * area.value - stated) <= 1e6 * (area.high - area.low), path
        assert 1e6 * area.value == pytest.approx(stated, rel=5e-3)


@pytest.mark.parametrize(("path", "command"), [("s_a", 0.1), ("a_e", 3.0), ("b_e", 0.6)])
def test_break_points_are_found_too(path, command):
    row = fit_row(transient_of(simulate_transient(path, command, seed=5)))
    points, values = true_row(path, command)
    seen = np.linspace(row.curve.pressure_ratio.min(), row.curve.pressure_ratio.max(), 100)
    # A break point is a multiple of 0.01: half of that along the steepest part, 4 per unit.
    assert np.max(np.abs(row.at(seen) - np.interp(seen, points, values))) < 0.02


def test_twice_the_noise_doubles_the_intervals():
    quiet, noisy = (
        fit_row(
            transient_of(simulate_transient("s_b", 2.0, noise_rms=noise)),
            true_row("s_b", 2.0)[0],
        )
        for noise in (200.0, 400.0)
    )
    seen = quiet.visible
    # The worth of the samples is estimated from their correlation, to some 20 % each.
    assert noisy.half_width[seen] / quiet.half_width[seen] == pytest.approx(2.0, rel=0.4)


@pytest.mark.parametrize("name", ["charge-s-a-0.5V", "discharge-b-e-5V", "discharge-a-e-0.5V"])
def test_another_program_s_transients_give_the_tables(name):
    """The golden transients are of an independent implementation: 50 cm^3, 6.5 bar."""
    golden = pandas.read_csv(GOLDEN / f"dead-volume-{name}.csv.xz")
    channels = {key: golden[key].to_numpy() for key in ("valve_voltage", "dead_volume_pressure")}
    recording = Recording(
        name,
        golden["time"].to_numpy(),
        channels,
        rig="dead-volume",
        noise_rms={"dead_volume_pressure": 1.0},
    )
    transient = transient_of(recording)
    points, values = true_row(transient.path, 0.5 if transient.command < 1.0 else 5.0)
    if transient.command == 0.5:
        # Between the rows of 0.4 and 0.6 V every break point of either bends the coefficient.
        pairs = [true_row(transient.path, command) for command in (0.4, 0.6)]
        points = np.unique(np.concatenate([p for p, _ in pairs]))
        values = np.mean([np.interp(points, p, v) for p, v in pairs], axis=0)
    row = fit_row(transient, points)
    seen = row.curve.pressure_ratio
    seen = np.linspace(seen.min(), min(seen.max(), 0.98), 100)
    # Half a thousandth: what steps of the fit four to a sample leave.
    assert row.at(seen) == pytest.approx(np.interp(seen, points, values), abs=5e-4)


def test_a_hole_of_known_area_is_found_as_a_leak():
    rig = experiment_rig().with_values({"dead-volume.polytropic_index": 1.0})
    recording = simulate_transient("a_e", 5.0, rig=rig)
    channels = {"dead_volume_pressure": recording["dead_volume_pressure"]}
    conditions = dict(CONDITIONS)
    leak = Recording("leak", recording.time, channels, "dead-volume", conditions)
    row = fit_row(transient_of(leak))
    # Table 4.5 times table 4.1.
    assert row.at(0.33) == pytest.approx(0.68 * 0.795e-6, rel=0.01)
    assert row.at(0.74) == pytest.approx(0.50 * 0.795e-6, rel=0.03)
    assert "from the volume it empties" in cannot_tell_apart([row])[0]


def test_a_tight_volume_says_nothing():
    time = np.arange(0.0, 60.0, 0.1)
    noise = 100.0 * np.random.default_rng(1).standard_normal(len(time))
    tight = Recording("tight", time, {"dead_volume_pressure": 7e5 + noise}, "dead-volume")
    with pytest.raises(InputError, match="too little to decide"):
        fit_row(transient_of(tight))


def test_break_points_have_to_run_from_0_to_1():
    transient = transient_of(simulate_transient("s_a", 5.0))
    with pytest.raises(InputError, match="increase from 0 to 1"):
        fit_row(transient, [0.2, 0.1, 1.0])


def test_processes_change_nothing():
    transients = [
        transient_of(simulate_transient(path, 5.0, samples=300)) for path in FLOW_PATHS[:2]
    ]
    alone, together = (calibrate(transients, jobs=jobs).rows for jobs in (1, 2))
    for one, other in zip(alone, together, strict=True):
        assert np.array_equal(one.pressure_ratio, other.pressure_ratio)
        assert np.array_equal(one.coefficient, other.coefficient)


def test_one_command_twice_makes_no_table(rows):
    twice = Calibration((rows["s_a", 5.0], rows["s_a", 5.0]))
    with pytest.raises(InputError, match="more than once at 5 V"):
        twice.tables(experiment_rig())
