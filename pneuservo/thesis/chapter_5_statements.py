"""What chapter 5 of the thesis states of its linear models, figures 5.2 to 5.13."""

import math
from collections.abc import Iterator

import numpy as np

from pneuservo.linear import (
    ServoData,
    advanced_servo,
    conventional_servo,
    equal_areas,
    table_5_2,
    without_valve,
)
from pneuservo.linear.characteristics import (
    OverStroke,
    damping_ratio,
    natural_frequency,
    over_stroke,
    ultimate_gain,
    worst_linearisation,
)
from pneuservo.plant.gas import mass_flow_coefficient
from pneuservo.thesis.chapter_5_tables import servo_of, stated, tuned
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.statements import Finding, statement_row


def statement_rows() -> list[Row]:
    """Return the rows of the statements on linear models."""
    return [
        _flow_pressure(),
        *_conventional_over_stroke(),
        *_advanced(),
        _figure_5_10(),
        *_equal(),
        _figure_5_13(),
    ]


def _flow_pressure() -> Row:
    data = table_5_2()
    choked = data.gas.choked_coefficient
    ratio, step = 0.8, 1e-6
    value = mass_flow_coefficient(ratio, data.gas)
    slope = (mass_flow_coefficient(ratio + step, data.gas) - value) / step
    upstream, downstream = (value - ratio * slope) / choked, -slope / choked
    return statement_row(
        "5.2-flow-pressure",
        "flow-pressure coefficients at a pressure ratio of 0.8",
        "k2 of the discharge may be set to -k3 of the charge",
        Finding(
            abs(upstream / downstream - 1.0) < 0.1,
            f"k2 {upstream:.2f}, -k3 {downstream:.2f} of k1 over the pressure",
        ),
        "Fig 5.2",
        "of one size, but not equal; both are dropped in the end",
        in_kind=0.1 <= abs(upstream / downstream - 1.0) < 0.5,
    )


def _conventional_over_stroke() -> Iterator[Row]:
    data = table_5_2()
    positions = np.linspace(0.0, data.stroke, 61)
    servos = {
        way: [conventional_servo(data, float(x), way) for x in positions] for way in (True, False)
    }
    frequency = np.array([natural_frequency(servo) for servo in servos[True]]) / (2 * math.pi)
    damping = np.array([damping_ratio(servo) for servo in servos[True]])
    middle = len(positions) // 2
    yield statement_row(
        "5.5-conventional",
        "natural frequency and damping over the stroke, conventional model",
        "lowest frequency and highest damping at mid-stroke",
        Finding(
            frequency.argmin() == middle == damping.argmax(),
            f"{frequency[middle]:.1f} Hz and {damping[middle]:.3f} at mid-stroke, "
            f"{frequency[0]:.1f} Hz and {damping[0]:.3f} at the ends",
        ),
        "Fig 5.5",
    )
    gains = {
        way: np.array([ultimate_gain(without_valve(servo)) for servo in servos[way]])
        / stated()["sensitivity"]
        for way in servos
    }
    larger = np.maximum(gains[True], gains[False])
    either = all(gain.argmin() == middle for gain in gains.values())
    yield statement_row(
        "5.6-conventional-gain",
        "ultimate gain over the stroke, conventional model",
        "linear in position with its minimum at mid-stroke",
        Finding(
            either,
            f"extending {gains[True][0]:.2f} to {gains[True][-1]:.2f} V/V, retracting its mirror "
            f"image; the larger of the two is least, {larger[middle]:.2f} V/V, at mid-stroke",
        ),
        "Fig 5.6",
        "(5.23) is monotonic in either direction; a minimum needs both directions in one curve",
        in_kind=larger.argmin() == middle and not either,
    )
    apart = servos[True][12].b0 / servos[False][12].b0 - 1
    yield statement_row(
        "5.4-conventional-direction",
        "frequency response in both directions at position 1, conventional model",
        "no dependence on direction",
        Finding(abs(apart) < 0.01, f"numerator of (5.23) {100 * apart:.0f} % apart"),
        "Fig 5.4",
        "away from mid-stroke (5.23) charges the shorter chamber one way and the longer the other; "
        "only (5.27) is the same either way",
    )


def _advanced() -> Iterator[Row]:
    data = table_5_2()
    out, back = (advanced_servo(data, stated()["positions"][0], way) for way in (True, False))
    yield statement_row(
        "5.8-advanced-direction",
        "frequency response in both directions at position 1, advanced model",
        "depends on direction",
        Finding(
            out.b0 / back.b0 > 1.1, f"numerator {out.b0:.0f} extending, {back.b0:.0f} retracting"
        ),
        "Fig 5.8",
    )
    table = over_stroke(data)
    frequency = table.natural_frequency / (2 * math.pi)
    lowest = float(table.displacement[frequency.argmin()])
    yield statement_row(
        "5.9-advanced",
        "natural frequency and damping over the stroke, advanced model",
        "nearly symmetric, lowest frequency about mid-stroke; fully extended a little lower and "
        "more damped than fully retracted; no dependence on direction",
        Finding(
            abs(lowest - 0.5 * data.stroke) < 0.05 * data.stroke
            and frequency[-1] < frequency[0]
            and table.damping_ratio[-1] > table.damping_ratio[0],
            f"{frequency[0]:.1f}, {frequency.min():.1f}, {frequency[-1]:.1f} Hz at either end "
            f"and at {1e3 * lowest:.1f} mm",
        ),
        "Fig 5.9",
    )


def _figure_5_10() -> Row:
    found, curves = {}, {}
    for kind in (PRINTED, RECONCILED):
        table = over_stroke(servo_of(kind))
        worst = worst_linearisation(servo_of(kind))
        curves[kind] = (
            bool(np.all(table.gain_extending < table.gain_retracting))
            and _rises(table.gain_extending)
            and _rises(-table.gain_retracting)
        )
        found[kind] = Finding(
            curves[kind] and worst.displacement == table.displacement[-1],
            f"extending {_span(table, 'extending')}, retracting {_span(table, 'retracting')} V/V "
            f"from retracted to extended; lowest at {1e3 * worst.displacement:.0f} mm",
        )
    return statement_row(
        "5.10-gain",
        "ultimate gain over stroke and direction, advanced model",
        "extending clearly below retracting; extending rises outwards, retracting inwards; most "
        "likely unstable fully extended",
        found[PRINTED],
        "Fig 5.10, section 5.2.4",
        "the thesis contradicts itself on where it is lowest: its own curve rises outwards, and "
        "section 9.1 names full retraction. Retracting is flat at 6.5 bar",
        found[RECONCILED],
        in_kind=any(curves.values()) and not any(each.holds for each in found.values()),
    )


def _equal() -> Iterator[Row]:
    data = table_5_2()
    equal = equal_areas(data)
    out, back = (advanced_servo(equal, 0.5 * data.stroke, way) for way in (True, False))
    sensitivity, apart = stated()["sensitivity"], abs(out.b0 / back.b0 - 1)
    advanced = ultimate_gain(without_valve(out)) / sensitivity
    conventional = ultimate_gain(without_valve(conventional_servo(data))) / sensitivity
    yield statement_row(
        "5.11-equal-areas",
        "ultimate gain of equal areas, advanced against conventional model",
        "a little dependent on direction, and higher than the conventional one",
        Finding(
            advanced > conventional and apart > 0.01,
            f"{advanced:.2f} against {conventional:.2f} V/V at mid-stroke",
        ),
        "Fig 5.11",
        f"higher; at mid-stroke the directions are {100 * apart:.1f} % apart, "
        "since the quiescent pressure makes charge and discharge equal",
        in_kind=advanced > conventional and apart <= 0.01,
    )
    factors = (
        (
            "5.25-quiescent",
            "quiescent over supply pressure",
            0.8,
            equal.pressure_a / 6.5e5,
            "(5.25)",
        ),
        ("5.29-factor", "factor of the ultimate gain, 3.2/3.6", 0.89, 3.2 / 3.6, "(5.29)"),
        ("5.38-factor", "factor of (5.38) for air", 3.864, _factor_of_5_38(data), "(5.38)"),
    )
    for row, what, value, ours, source in factors:
        yield number_row(row, what, "", value, ours, None, source)


def _figure_5_13() -> Row:
    data, pole = table_5_2(), parameter_set(PRINTED, 5)["third_pole"]
    positions = np.linspace(0.0, data.stroke, 61)
    gains = {
        way: np.array(
            [
                (c.gain, c.velocity_gain)
                for x in positions
                for c in [tuned(data, float(x), way, pole)]
            ]
        )
        for way in (True, False)
    }
    at = [1e3 * positions[gain[:, 0].argmax()] for gain in gains.values()]
    return statement_row(
        "5.13-gains",
        "state-feedback gains over position and direction",
        "largest about mid-stroke, Kv negative, strongly dependent on direction",
        Finding(
            all(12.0 <= x <= 18.0 for x in at)
            and all(bool(np.all(gain[:, 1] < 0.0)) for gain in gains.values()),
            f"Kp {gains[True][:, 0].max():.3f} extending, {gains[False][:, 0].max():.3f} "
            f"retracting, largest at {at[0]:.1f} and {at[1]:.1f} mm; "
            f"Kv {gains[True][:, 1].max():.3f} at most",
        ),
        "Fig 5.13",
    )


def _factor_of_5_38(data: ServoData) -> float:
    g = data.gas.isentropic_exponent
    return math.sqrt(2 / (g - 1) * ((g + 1) / 2) ** ((g + 1) / (g - 1)))


def _rises(values: np.ndarray) -> bool:
    return bool(np.all(np.diff(values) > 0.0))


def _span(table: OverStroke, direction: str) -> str:
    gains = getattr(table, f"gain_{direction}") / stated()["sensitivity"]
    return f"{gains[0]:.2f} to {gains[-1]:.2f}"
