"""Reachability in chapter 7 of the thesis: figures 7.2 to 7.11."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.linear import advanced_servo, conventional_servo, table_5_2, without_valve
from pneuservo.sliding_mode.equivalent_control import is_attracted, servo_gains
from pneuservo.sliding_mode.range_space import RangeSpace, linear_limits
from pneuservo.sliding_mode.reachability import (
    fastest_along_motions,
    fastest_settling_time,
    opened,
)
from pneuservo.sliding_mode.reaching import reaching_phase
from pneuservo.sliding_mode.sizing import least_opening
from pneuservo.sliding_mode.surface import Surface, surface_from_settling_time
from pneuservo.thesis.chapter_7_surface import level, printed_space, servo_of, stated
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED
from pneuservo.thesis.rows import Row, number_row
from pneuservo.thesis.statements import Finding, statement_row

_KINDS = (PRINTED, RECONCILED)
# Points of a surface along either axis of the range space.
_POINTS = 400
_TEN_BAR = 10e5
_OPENINGS = (2.0, 2.25, 2.5, 2.75, 3.0)


def reachability_rows() -> list[Row]:
    """Return the rows of figures 7.2 to 7.11."""
    return [*_domains(), *_fastest(), *_changes_and_motions(), *_crossing()]


@cache
def changed_servos(kind: str) -> tuple[LinearServo, ...]:
    """Return the nominal servo with the parameter changes of position and direction.

    Parameters
    ----------
    kind : str
        ``printed`` or ``reconciled``.

    Notes
    -----
    The changes are those to the advanced model at positions 1 to 3 of table 5.1 in both directions.
    """
    data, nominal = table_5_2(), servo_of(kind)
    middle = conventional_servo(data)
    servos = [
        advanced_servo(data, share * data.stroke, way)
        for share in (0.2, 0.5, 0.8)
        for way in (True, False)
    ]
    return tuple(
        replace(
            nominal,
            b0=nominal.b0 * servo.b0 / middle.b0,
            a1=nominal.a1 * servo.a1 / middle.a1,
        )
        for servo in servos
    )


def at_supply_pressure(pressure: float, stiffer: bool = True) -> LinearServo:
    """Return the printed nominal servo at another supply pressure.

    Parameters
    ----------
    pressure : float
        Absolute [Pa].
    stiffer : bool, optional
        Whether the stiffness grows with it, as (5.27) has it.
    """
    servo = without_valve(conventional_servo(replace(table_5_2(), supply_pressure=pressure)))
    return servo if stiffer else replace(servo, a1=servo_of(PRINTED).a1)


def _repelled_shares(surface: Surface, space: RangeSpace) -> tuple[float, float]:
    """Return the shares of a surface in a range space that are repelled below and above it."""
    c1, c2, c3 = surface.weights
    v, a = np.meshgrid(
        np.linspace(*space.velocity, _POINTS), np.linspace(*space.acceleration, _POINTS)
    )
    error = -(c2 * v + c3 * a) / c1
    inside = (error >= space.displacement[0]) & (error <= space.displacement[1])
    gains = servo_gains(servo_of(PRINTED), surface)
    # A hair to either side of the surface.
    sides = [
        np.logical_not(is_attracted(gains, surface, (error + side * 1e-9, v, a), level())) & inside
        for side in (-1.0, 1.0)
    ]
    total = np.sum(inside)
    return float(np.sum(sides[0]) / total), float(np.sum(sides[1]) / total)


def _domains() -> Iterator[Row]:
    slow = surface_from_settling_time(0.25)
    physical = _repelled_shares(slow, printed_space())
    linear = _repelled_shares(
        slow, linear_limits(servo_of(PRINTED), level()).range_space(printed_space().displacement[1])
    )
    yield statement_row(
        "7.2-one-side",
        "surface of 0.25 s over the range space (7.13)",
        "the sliding domain ends inside the range space on one side only",
        Finding(
            (physical[0] > 0.0) != (physical[1] > 0.0),
            f"{100 * physical[0]:.1f} % repelled on one side, {100 * physical[1]:.1f} % the other",
        ),
        "Fig 7.2",
    )
    yield statement_row(
        "7.3-linear-limits",
        "the same over the linear limits (7.12)",
        "large regions where the surface repels",
        Finding(
            sum(linear) > 3 * sum(physical),
            f"{100 * sum(linear):.0f} % of the surface, against {100 * sum(physical):.0f} %",
        ),
        "Fig 7.3",
    )
    times = (0.09, 0.07, 0.05)
    extents = [_largest_sliding_error(surface_from_settling_time(t)) for t in times]
    yield statement_row(
        "7.4-domain",
        "errors covered by the sliding domain, surfaces of 0.09, 0.07 and 0.05 s",
        "the domain, and the errors that it covers, shrink with the settling time",
        Finding(
            extents[0] > extents[1] > extents[2],
            ", ".join(f"{1e3 * extent:.1f} mm" for extent in extents),
        ),
        "Figs 7.4 to 7.6, 7.9",
    )


def _largest_sliding_error(surface: Surface) -> float:
    """Return the largest error at which a surface is in its sliding domain, in range (7.13) [m]."""
    space = printed_space()
    c1, c2, c3 = surface.weights
    gains = servo_gains(servo_of(PRINTED), surface)
    v, a = np.meshgrid(
        np.linspace(*space.velocity, _POINTS), np.linspace(*space.acceleration, _POINTS)
    )
    sliding = np.abs(gains[1] * v + gains[2] * a) <= level()
    return float(np.max(np.abs(c2 * v + c3 * a)[sliding]) / c1)


def _fastest() -> Iterator[Row]:
    values, space = stated()["reachability"], printed_space()
    printed, reconciled = (least_opening(servo_of(kind), space, level())[0] for kind in _KINDS)
    yield number_row(
        "7.7-least-opening",
        "smallest valve opening with which any surface is reachable, 6.5 bar",
        "",
        values["least_opening"],
        printed,
        reconciled,
        "Fig 7.7",
        "the curve begins a little earlier here; read off a curve",
        in_kind=True,
    )
    printed, reconciled = (fastest([servo_of(kind)], 2.0, space) for kind in _KINDS)
    yield number_row(
        "7.7-opening-2",
        "fastest reachable surface at opening 2, 6.5 bar",
        "s",
        values["settling_time_at_opening_2"],
        printed,
        reconciled,
        "Fig 7.7",
        "0.05 s needs a slightly larger opening here; read off a curve",
        in_kind=True,
    )
    softer = fastest([at_supply_pressure(_TEN_BAR, stiffer=False)], 1.0, space)
    yield number_row(
        "7.7-10-bar",
        "fastest reachable surface at opening 1, 10 bar",
        "s",
        values["settling_time_at_10_bar"],
        fastest_settling_time([at_supply_pressure(_TEN_BAR)], space, level()),
        None,
        "Fig 7.7",
        f"by (5.27) the stiffness grows with the pressure, and nothing is reachable; with that of "
        f"6.5 bar {softer:.3f} s",
    )


def _changes_and_motions() -> Iterator[Row]:
    values = stated()["reachability"]
    printed, reconciled = (_penalty(kind) for kind in _KINDS)
    yield number_row(
        "7.7-parameter-changes",
        "longer settling time of the fastest surface with parameter changes, openings 2 to 3",
        "s",
        values["parameter_changes"],
        printed,
        reconciled,
        "Fig 7.7",
        "mean over the openings; advanced model at positions 1 to 3 in both directions",
        in_kind=True,
    )
    error = stated()["motion"]["initial_error"]
    along = [fastest_along_motions([servo_of(kind)], level(), [-error]) for kind in _KINDS]
    yield number_row(
        "7.7-along-motion",
        "fastest surface reachable along the open-loop motion from 30 mm, opening 1",
        "s",
        values["settling_time_along_motion"],
        along[0],
        along[1],
        "Fig 7.7, section 7.5.2",
        "up to where the motion meets the surface; the thesis gives its motions no numbers",
        in_kind=True,
    )


def _penalty(kind: str) -> float:
    space = printed_space()
    longer = [
        fastest(changed_servos(kind), opening, space) - fastest([servo_of(kind)], opening, space)
        for opening in _OPENINGS
    ]
    return float(np.mean(longer))


def fastest(servos: Sequence[LinearServo], opening: float, space: RangeSpace) -> float:
    """Return the fastest reachable surface at an opening; NaN when there is none [s].

    Parameters
    ----------
    servos : sequence of LinearServo
        At opening 1.
    opening : float
        [-].
    space : RangeSpace
        The range space.
    """
    found = fastest_settling_time([opened(servo, opening) for servo in servos], space, level())
    return float("nan") if found is None else found


def _crossing() -> Iterator[Row]:
    error = stated()["motion"]["initial_error"]
    repelled = {}
    for settling_time in (0.05, 0.02):
        surface = surface_from_settling_time(settling_time)
        states = reaching_phase(servo_of(PRINTED), surface, level(), -error).states[:-1]
        gains = servo_gains(servo_of(PRINTED), surface)
        repelled[settling_time] = int(
            np.sum(np.logical_not(is_attracted(gains, surface, tuple(states.T), level())))
        )
    yield statement_row(
        "7.10-slower-violates",
        "open-loop motion from 30 mm against the surfaces of 0.05 and 0.02 s",
        "the slower surface violates reachability, the faster one does not",
        Finding(
            repelled[0.05] > 0 and repelled[0.02] == 0,
            f"repelled at {repelled[0.05]} points of the motion with 0.05 s, at {repelled[0.02]} "
            "with 0.02 s",
        ),
        "Figs 7.10 and 7.11",
    )
