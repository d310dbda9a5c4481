"""Tables 5.3 to 5.5 of the thesis: quiescent pressures and state-feedback gains."""

import math
import tomllib
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib.resources import files
from typing import Any

from pneuservo.controllers import StateFeedback
from pneuservo.linear import (
    FlowAreas,
    ServoData,
    advanced_servo,
    equal_areas,
    quiescent_pressures,
    table_5_2,
)
from pneuservo.state_feedback import place_poles
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set
from pneuservo.thesis.rows import Row, number_row

DIRECTIONS = {"retraction": False, "extension": True}
# The attribute of a controller, and unit, of each printed gain.
_GAINS = {
    "Kp": ("gain", "V/V"),
    "Kv": ("velocity_gain", "s"),
    "Ka": ("acceleration_gain", "s²"),
}
_SEA_LEVEL = 1.013e5
_TRUNCATED = "printed with one digit, cut off and not rounded; ours is cut off likewise"
# Corrections of the scan, by row.
_CORRECTED = {
    "5.5-retraction-Kv-1": "the scan reads -0.0314, with which Kp and Kv of this column disagree"
}
_B0 = "table 5.5 needs a b0 5.5 to 20.8 % above that of table 5.2"
_EQUAL = "no set fits tables 5.4 and 5.5: this needs a b0 14 % below the model at a supply of 7 bar"


@cache
def stated() -> dict[str, Any]:
    """Return what chapter 5 prints, as its data file has it."""
    text = (files("pneuservo.thesis") / "chapter_5.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def servo_of(kind: str) -> ServoData:
    """Return the servo of a parameter set of chapter 5.

    Parameters
    ----------
    kind : str
        ``printed`` or ``reconciled``.
    """
    data = table_5_2()
    if kind == PRINTED:
        return data
    values = parameter_set(RECONCILED, 5)
    factor = values["b0_factor"]
    areas = FlowAreas(*(factor * area for area in vars(data.flow_areas).values()))
    return replace(data, supply_pressure=values["supply_pressure"], flow_areas=areas)


def tuned(data: ServoData, position: float, extending: bool, third_pole: float) -> StateFeedback:
    """Return the controller for a position and direction, to the requirements of chapter 5.

    Parameters
    ----------
    data : ServoData
        The servo.
    position : float
        [m].
    extending : bool
        The direction.
    third_pole : float
        [rad/s].
    """
    servo = advanced_servo(data, position, extending)
    values = stated()
    return place_poles(
        servo, values["sensitivity"], values["settling_time"], values["damping"], third_pole
    )


def table_rows() -> list[Row]:
    """Return the rows of tables 5.3, 5.4 and 5.5."""
    return [*_pressure_rows(), *_equal_area_rows(), *_unequal_area_rows()]


def _pressure_rows() -> Iterator[Row]:
    data = replace(table_5_2(), exhaust_pressure=_SEA_LEVEL)
    for direction, extending in DIRECTIONS.items():
        found = quiescent_pressures(data, extending)
        printed = stated()["table-5-3"][direction]
        for chamber, value, ours in zip("ab", printed, found, strict=True):
            yield number_row(
                f"5.3-{direction}-{chamber}",
                f"quiescent pressure in chamber {chamber}, {direction}",
                "Pa",
                value,
                ours,
                None,
                "Table 5.3",
                "the scan reads 5.85 and 5.49 bar in chamber a, which (5.37) and the load exclude"
                if chamber == "a"
                else "",
            )
    yield number_row(
        "5.2-equal-areas",
        "quiescent pressure of equal areas without load",
        "Pa",
        stated()["table-5-3"]["equal-areas"],
        equal_areas(data).pressure_a,
        None,
        "Table 5.2",
    )


def _equal_area_rows() -> Iterator[Row]:
    controllers = {}
    for kind in (PRINTED, RECONCILED):
        data = equal_areas(servo_of(kind))
        pole = parameter_set(kind, 5)["third_pole_equal_areas"]
        controllers[kind] = [tuned(data, x, True, pole) for x in stated()["positions"]]
    yield from _gain_rows("5.4", "equal areas", stated()["table-5-4"], controllers, _EQUAL)


def _unequal_area_rows() -> Iterator[Row]:
    for direction, extending in DIRECTIONS.items():
        controllers = {}
        for kind in (PRINTED, RECONCILED):
            data, pole = servo_of(kind), parameter_set(kind, 5)["third_pole"]
            controllers[kind] = [tuned(data, x, extending, pole) for x in stated()["positions"]]
        values = stated()["table-5-5"][direction]
        yield from _gain_rows(f"5.5-{direction}", direction, values, controllers, _B0)


def _gain_rows(
    label: str,
    what: str,
    values: dict[str, list[float]],
    controllers: dict[str, list[StateFeedback]],
    reason: str,
) -> Iterator[Row]:
    for name, (attribute, unit) in _GAINS.items():
        for k, value in enumerate(values[name]):
            printed, reconciled = (
                float(getattr(controllers[kind][k], attribute)) for kind in (PRINTED, RECONCILED)
            )
            if name == "Ka":
                printed, reconciled = _cut_off(printed), _cut_off(reconciled)
            row = f"{label}-{name}-{k + 1}"
            why = f"{reason}; {_TRUNCATED}" if name == "Ka" else reason
            yield number_row(
                row,
                f"{name}, {what}, position {k + 1}",
                unit,
                value,
                printed,
                reconciled,
                f"Table {label[:3]}",
                _CORRECTED.get(row, why),
                in_kind=True,
            )


def _cut_off(value: float) -> float:
    """Return a value cut off after four decimals, as the printed acceleration gains are."""
    return math.floor(value * 1e4) / 1e4
