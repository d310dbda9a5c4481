"""What chapter 8 of the thesis states in words of its digital loops, recomputed."""

from collections.abc import Iterator, Mapping

import numpy as np

from pneuservo.limit_cycle import Loop, Signals, simulate_linear
from pneuservo.limit_cycle.comparison import by_linear_simulation
from pneuservo.limit_cycle.linear_simulation import START_ERROR
from pneuservo.limit_cycle.locking import locking
from pneuservo.thesis.chapter_8_loops import Plants
from pneuservo.thesis.chapter_8_statements import (
    FOLLOWED,
    SETTLED,
    largest_difference,
    row_of_sets,
)
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.slow_oscillation import slow_range
from pneuservo.thesis.statements import Finding

_MEASURED_1KHZ = Signals(sampling_time=1e-3)
_DIFFERENCES_1KHZ = Signals("backward", 1e-3)


def sampled_rows(sets: Mapping[str, Plants]) -> Iterator[Row]:
    """Yield the rows of the statements on digital loops.

    Parameters
    ----------
    sets : mapping of str to Plants
        The printed and the reconciled parameters.
    """
    yield row_of_sets(
        "8.20-steady-error",
        "1 kHz, linear model: steady-state error",
        "there is one without valve; with valve it is smaller",
        "Figures 8.20 and 8.22",
        sets,
        _error_with_and_without_valve,
    )
    yield row_of_sets(
        "8.29-steady-error",
        "1 kHz, no valve, linear model: steady-state error with differences",
        "larger than with measured states",
        "Figures 8.20 and 8.29",
        sets,
        _error_with_differences,
        reason="the error depends on the start; over 25 starts it is about as large with either",
    )
    yield row_of_sets(
        "8.21-slow-oscillation",
        "1 kHz, no valve: displacement of the linear and of the non-linear model",
        "the non-linear model shows a low-frequency oscillation, the linear one does not",
        "Figures 8.20 to 8.23",
        sets,
        _slow_oscillation,
    )
    yield row_of_sets(
        "8.25-10kHz",
        "10 kHz against analogue, non-linear model with valve",
        "approaches the continuous system",
        "Figures 8.24 and 8.25",
        sets,
        _near_the_analogue,
    )
    chatter = {kind: _chatter(plant) for kind, plant in sets.items()}
    yield number_row(
        "8.31-displacement-chatter",
        "1 kHz, backward differences, valve: chattering of the displacement, linear model",
        "Hz",
        80.0,
        chatter[PRINTED],
        chatter[RECONCILED],
        "Figure 8.31",
        "stated as about 80 Hz; table 8.10 has 86.2 Hz for the same run. An ideal relay "
        "locks to 83.3 or 100 Hz",
        in_kind=True,
    )
    yield row_of_sets(
        "8.2.3-conclusion",
        "chattering of the displacement with differences and valve, non-linear model",
        "1 kHz is not acceptable, 10 kHz is",
        "section 8.2.3",
        sets,
        _acceptable,
    )


def _chatter(plant: Plants) -> float | None:
    cycle = by_linear_simulation(plant.loop_with(True, _DIFFERENCES_1KHZ)).cycle
    return None if cycle is None else cycle.frequency


def _mean_size_of_error(loop: Loop) -> float:
    return float(np.mean(np.abs(locking(loop).mean_error)))


def _error_with_and_without_valve(plant: Plants) -> Finding:
    bare, valve = (
        _mean_size_of_error(plant.loop_with(with_valve, _MEASURED_1KHZ))
        for with_valve in (False, True)
    )
    words = f"{1e3 * bare:.2f} mm without, {1e3 * valve:.2f} mm with valve, mean over 25 starts"
    return Finding(0.0 < valve < bare, words)


def _error_with_differences(plant: Plants) -> Finding:
    plain, differences = (
        _mean_size_of_error(plant.loop_with(False, signals))
        for signals in (_MEASURED_1KHZ, _DIFFERENCES_1KHZ)
    )
    words = f"{1e3 * plain:.2f} mm measured, {1e3 * differences:.2f} mm with differences"
    # 3 %: no more than the mean over 25 starts can tell.
    return Finding(differences > 1.03 * plain, words)


def _slow_oscillation(plant: Plants) -> Finding:
    loop = plant.loop_with(False, _MEASURED_1KHZ)
    sizes = [
        slow_range(course.time, course.error, SETTLED)
        for course in (simulate_linear(loop, duration=FOLLOWED), plant.simulate(loop, FOLLOWED))
    ]
    words = f"{1e6 * sizes[0]:.1f} µm linear, {1e6 * sizes[1]:.0f} µm non-linear, below 60 Hz"
    return Finding(sizes[1] > 10.0 * sizes[0], words)


def _near_the_analogue(plant: Plants) -> Finding:
    analogue, fast, slow = (
        plant.simulate(plant.loop_with(True, signals), SETTLED)
        for signals in (Signals(), Signals(sampling_time=1e-4), _MEASURED_1KHZ)
    )
    near, far = (largest_difference(course, analogue) for course in (fast, slow))
    words = f"{1e3 * near:.2f} mm apart at 10 kHz, {1e3 * far:.2f} mm at 1 kHz"
    return Finding(near < 0.02 * START_ERROR and near < far, words)


def _acceptable(plant: Plants) -> Finding:
    ranges = []
    for period in (1e-3, 1e-4):
        course = plant.simulate(plant.loop_with(True, Signals("backward", period)), FOLLOWED)
        settled = course.time > 0.5 * FOLLOWED
        ranges.append(float(np.ptp(course.error[settled])))
    words = f"{1e3 * ranges[0]:.2f} mm peak to peak at 1 kHz, {1e3 * ranges[1]:.3f} mm at 10 kHz"
    # What is seen in a plot of the stroke: a three-hundredth of it.
    return Finding(ranges[0] > 0.1e-3 > ranges[1], words)
