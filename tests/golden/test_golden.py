"""Every golden trajectory, replayed (see README.md beside this file)."""

import math
from pathlib import Path

import numpy as np
import pandas
import pytest

from pneuservo.controllers import SlidingMode
from pneuservo.recordings import Recording
from pneuservo.simulation import limit_cycle, replay, simulate, step_demand

FOLDER = Path(__file__).parent
OPEN_LOOP = ("open-loop", "open-loop-stops")
CLOSED_LOOP = {"closed-loop-phi5": 5.0, "closed-loop": 5000.0}
DEAD_VOLUME = sorted(
    path.name.removesuffix(".csv.xz") for path in FOLDER.glob("dead-volume-*.csv.xz")
)
# Asked for is 1e-4 of a channel's range. Steps of 20 us pass over the kinks of the valve tables
# and of |spool|, which costs up to 2.6e-6 (spool and voltage of closed-loop-phi5); the rest is
# headroom for other processors' libraries of powers.
TOLERANCE = 1e-5
C1, C2 = 3265.3, 114.286


def table(name):
    return pandas.read_csv(FOLDER / f"{name}.csv.xz")


def recording(name, rig):
    golden = table(name)
    channels = {key: golden[key].to_numpy() for key in golden if key != "time"}
    return Recording(name, golden["time"].to_numpy(), channels, rig=rig)


def sliding_mode(boundary_layer):
    # The golden files use rounded weights; these two give exactly them.
    damping = C2 / (2.0 * math.sqrt(C1))
    return SlidingMode(8.0 / C2, damping, boundary_layer)


def differences(result, golden):
    """Largest difference of every channel that moves, as a share of its range."""
    return {
        name: float(np.max(np.abs(result[name] - golden[name])) / np.ptp(golden[name]))
        for name in golden.channels
        if np.ptp(golden[name]) > 0.0
    }


def assert_close(result, golden, tolerance):
    shares = differences(result, golden)
    assert shares, "no channel was compared"
    assert max(shares.values()) < tolerance, shares


def test_all_files_are_here():
    assert len(DEAD_VOLUME) == 8
    names = {path.name.removesuffix(".csv.xz") for path in FOLDER.glob("*.csv.xz")}
    assert names == {*OPEN_LOOP, *CLOSED_LOOP, *DEAD_VOLUME, "relay"}


@pytest.mark.parametrize("name", DEAD_VOLUME)
def test_dead_volume(name):
    golden = recording(name, "dead-volume")
    # One smooth state: only the root at equal pressures keeps it from rounding, 1e-9 measured.
    assert_close(replay(golden), golden, 1e-8)


@pytest.mark.parametrize("name", OPEN_LOOP)
def test_open_loop(name):
    golden = recording(name, "single-axis")
    assert_close(replay(golden), golden, TOLERANCE)


def test_shorter_steps_come_closer():
    golden = recording("open-loop-stops", "single-axis")
    result = simulate(time=golden.time, command=golden["valve_voltage"], largest_step=5e-6)
    # 8e-8 measured, against 6e-7 at 20 us; the golden file itself is good to 1e-8.
    assert_close(result, golden, 2e-7)


@pytest.mark.parametrize("name", CLOSED_LOOP)
def test_closed_loop(name):
    golden = recording(name, "single-axis")
    result = simulate(
        time=golden.time,
        controller=sliding_mode(CLOSED_LOOP[name]),
        demand=golden["demand"],
    )
    assert_close(result, golden, TOLERANCE)
    assert result.limit_cycle() is None


def test_relay():
    golden = recording("relay", "single-axis")
    result = simulate(time=golden.time, controller=sliding_mode(0.0), demand=golden["demand"])
    shares = differences(result, golden)
    # Every switching time carries on in all later ones, so that states are compared more loosely
    # (4e-5 measured), and not what jumps: acceleration and voltage.
    for name in ("displacement", "velocity", "pressure_a", "pressure_b"):
        assert shares[name] < 2e-4, shares
    sigma = -(
        C1 * (golden["displacement"] - golden["demand"])
        + C2 * golden["velocity"]
        + golden["acceleration"]
    )
    last = golden.time >= 1.65
    expected = limit_cycle(golden.time[last], sigma[last])
    found = result.limit_cycle(1.65)
    assert found.periods == expected.periods
    assert found.frequency == pytest.approx(expected.frequency, rel=1e-4)


@pytest.mark.parametrize(
    ("set_point", "frequency", "sigma", "acceleration", "mean_error"),
    [
        (6e-3, 210.8631, (-5.2773, 4.0712), (-4.6441, 4.7199), 0.17307e-3),
        (12e-3, 218.1306, (-3.9291, 3.0369), (-3.4428, 3.5338), 0.12270e-3),
        (15e-3, 219.4250, (-3.7782, 2.9141), (-3.3028, 3.3993), 0.11751e-3),
        (18e-3, 218.6572, (-3.8867, 2.9896), (-3.3931, 3.4934), 0.12204e-3),
        (24e-3, 212.2586, (-5.1240, 3.8931), (-4.4589, 4.5732), 0.17093e-3),
    ],
)
def test_limit_cycle_of_the_relay(set_point, frequency, sigma, acceleration, mean_error):
    time, demand = step_demand([set_point], hold=2.0, rate=20e3)
    result = simulate(time=time, controller=sliding_mode(0.0), demand=demand)
    cycle = result.limit_cycle(1.0)
    second = time >= 1.0
    # Crossings are interpolated between samples 50 us apart: below 5e-5 over a second.
    assert cycle.frequency == pytest.approx(frequency, rel=5e-5)
    # Samples miss an extreme by up to half a sample, 0.15 % measured.
    assert (cycle.low, cycle.high) == pytest.approx(sigma, rel=5e-3)
    found = result["acceleration"][second]
    assert (found.min(), found.max()) == pytest.approx(acceleration, rel=5e-3)
    # The mean over a window that is not of whole periods, 1e-5 measured.
    assert -result.steady_state_error(0.5) == pytest.approx(mean_error, rel=1e-3)
