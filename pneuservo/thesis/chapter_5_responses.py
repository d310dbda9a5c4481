"""What chapter 5 of the thesis states of state-feedback step responses, figures 5.14 to 5.24."""

from collections.abc import Iterator
from functools import cache
from itertools import product

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.arrays import Array
from pneuservo.controllers import StateFeedback
from pneuservo.linear import (
    ServoData,
    advanced_servo,
    conventional_servo,
    equal_areas,
    table_5_2,
    without_valve,
)
from pneuservo.rigs import Rig
from pneuservo.state_feedback import (
    closed_loop,
    largest_real_part,
    linear_step,
    nonlinear_step,
    parameter_update_step,
    place_poles,
)
from pneuservo.thesis.chapter_5_tables import DIRECTIONS, servo_of, stated, tuned
from pneuservo.thesis.one_coefficient import rig_with_one_coefficient
from pneuservo.thesis.parameter_sets import PRINTED, RECONCILED, parameter_set
from pneuservo.thesis.rows import Row
from pneuservo.thesis.statements import Finding, statement_row

TIME = np.linspace(0.0, 1.0, 1001)
# Of table 5.2 [-], [m^2].
_COEFFICIENT, _FLOW_AREA = 0.70, 0.81e-6
# After this a response as tuned has settled to 2 % [s].
_LATE = 0.6
# So many of nine cases are "almost whatever the position".
_MOST = 7


def response_rows(rig: Rig) -> list[Row]:
    """Return the rows of the statements on step responses.

    Parameters
    ----------
    rig : Rig
        For the non-linear simulations.
    """
    return [_equal(), *_unequal(), _conventional(), *_nonlinear(rig)]


@cache
def three_models(origin: float, target: float) -> dict[str, Array]:
    """Return a step with the gains of table 5.5, retraction, position 2, by each model.

    Parameters
    ----------
    origin, target : float
        Demand before and after [m].

    Returns
    -------
    dict of str to (n,) array
        ``linear``, ``parameter update`` and ``non-linear``: share of the step, at `TIME`. The
        gains are worked out from table 5.2.
    """
    data, sensitivity = table_5_2(), stated()["sensitivity"]
    controller = tuned(
        data, stated()["positions"][1], False, parameter_set(PRINTED, 5)["third_pole"]
    )
    servo = without_valve(advanced_servo(data, target, target > origin))
    update = parameter_update_step(data, controller, sensitivity, TIME, origin, target)
    rig, grid = rig_with_one_coefficient(_COEFFICIENT, _FLOW_AREA)
    motion = nonlinear_step(rig, controller, TIME, origin, target, data.pressure_b, grid)
    return {
        "linear": linear_step(servo, controller, sensitivity, TIME),
        "parameter update": (update.displacement - origin) / (target - origin),
        "non-linear": (motion.displacement - origin) / (target - origin),
    }


def printed_controller(direction: str, position: int) -> StateFeedback:
    """Return the state feedback with the gains that table 5.5 prints.

    Parameters
    ----------
    direction : str
        ``retraction`` or ``extension``.
    position : int
        0 to 2.
    """
    gains = stated()["table-5-5"][direction]
    return StateFeedback(*(gains[name][position] for name in ("Kp", "Kv", "Ka")))


def _equal() -> Row:
    pole = parameter_set(PRINTED, 5)["third_pole_equal_areas"]
    equal = equal_areas(table_5_2())
    positions = stated()["positions"]
    dampings = [
        _least_damping(advanced_servo(equal, at, way), tuned(equal, x, True, pole))
        for x, at, way in product(positions, positions, (True, False))
    ]
    conventional = [
        _least_damping(advanced_servo(equal, at, way), _tuned_conventionally(equal, x, pole))
        for x, at, way in product(positions, positions, (True, False))
    ]
    return statement_row(
        "5.14-equal-areas",
        "linear step responses of equal areas, three gain sets at three positions",
        "in no case more oscillatory than tuned; conventional gains give similar responses",
        Finding(
            min(dampings) > 0.95 * stated()["damping"],
            f"damping {min(dampings):.2f} to {max(dampings):.2f}, tuned for 0.40; with "
            f"conventional gains {min(conventional):.2f} to {max(conventional):.2f}",
        ),
        "Figs 5.14 to 5.16",
        "the gains of positions 1 and 3 make position 2 a little more oscillatory than tuned",
        in_kind=min(dampings) <= 0.95 * stated()["damping"],
    )


def _unequal() -> Iterator[Row]:
    positions = stated()["positions"]
    found = {
        kind: int(np.sum(_growth(kind, "retraction", True) > 0.0)) for kind in (PRINTED, RECONCILED)
    }
    yield statement_row(
        "5.17-retraction-gains",
        "retraction gains on the linear model of extension, three sets at three positions",
        "unstable or highly oscillatory, almost whatever the position",
        Finding(found[PRINTED] >= _MOST, f"{found[PRINTED]} of 9 unstable"),
        "Figs 5.17 and 5.19",
        reconciled=Finding(found[RECONCILED] >= _MOST, f"{found[RECONCILED]} of 9 unstable"),
    )
    extension = {
        kind: np.concatenate([_growth(kind, "extension", way) for way in (True, False)])
        for kind in (PRINTED, RECONCILED)
    }
    findings = [
        Finding(
            bool(np.all(found < 0)),
            f"{int(np.sum(found < 0))} of 18 stable, at most {found.max():.1f} 1/s",
        )
        for found in extension.values()
    ]
    yield statement_row(
        "5.18-extension-gains",
        "extension gains on the linear models of both directions",
        "stable at every position and in both directions",
        findings[0],
        "Figs 5.18 and 5.20",
        reconciled=findings[1],
    )
    damped = [
        _least_damping(advanced_servo(data, at, way), tuned(data, x, True, third))
        for data, third in [(table_5_2(), parameter_set(PRINTED, 5)["third_pole"])]
        for x, at, way in product(positions, positions, (True, False))
    ]
    more = sum(value > 0.99 * stated()["damping"] for value in damped)
    yield statement_row(
        "5.18-damping",
        "damping of the linear responses with extension gains",
        "generally more damped than tuned",
        Finding(more > len(damped) / 2, f"{more} of {len(damped)}; {min(damped):.2f} at the least"),
        "Figs 5.18 and 5.20",
    )


def _conventional() -> Row:
    data, sensitivity = table_5_2(), stated()["sensitivity"]
    pole = parameter_set(PRINTED, 5)["third_pole"]
    controller = _tuned_conventionally(data, 0.5 * data.stroke, pole)
    found = [
        largest_real_part(without_valve(advanced_servo(data, at, True)), controller, sensitivity)
        for at in stated()["positions"]
    ]
    gains = stated()["table-5-4"]
    printed = StateFeedback(*(gains[name][0] for name in ("Kp", "Kv", "Ka")))
    reconciled = servo_of(RECONCILED)
    others = [
        largest_real_part(without_valve(advanced_servo(reconciled, at, True)), printed, sensitivity)
        for at in stated()["positions"]
    ]
    return statement_row(
        "5.3.1-conventional-gains",
        "gains of the conventional model on the linear model of extension",
        "unstable",
        Finding(max(found) > 0.0, f"rightmost pole {min(found):.1f} to {max(found):.1f} 1/s"),
        "Section 5.3.1",
        "not with the conventional model's gains; those printed in table 5.4 are unstable on the "
        "reconciled model",
        Finding(
            max(others) > 0.0,
            f"gains of table 5.4, position 1: {min(others):.1f} to {max(others):.1f} 1/s",
        ),
        in_kind=max(found) <= 0.0 < max(others),
    )


def _nonlinear(rig: Rig) -> Iterator[Row]:
    sensitivity = stated()["sensitivity"]
    low, middle = stated()["positions"][:2]
    controller = printed_controller("retraction", 0)
    out = _share(nonlinear_step(rig, controller, TIME, low, middle).displacement, low, middle)
    back = _share(nonlinear_step(rig, controller, TIME, middle, low).displacement, middle, low)
    linear = linear_step(
        without_valve(advanced_servo(table_5_2(), middle, True)), controller, sensitivity, TIME
    )
    late = TIME > _LATE
    found = Finding(
        bool(np.ptp(out[late]) < 0.1 * np.ptp(linear[late]))
        and out.max() > 1.5
        and back.max() < 1.35,
        f"overshoot {100 * (out.max() - 1):.0f} % outwards (up to the end stop at "
        f"{1e3 * rig['piston.stroke']:.0f} mm), {100 * (back.max() - 1):.0f} % inwards; after "
        f"0.6 s it swings by {np.ptp(out[late]):.2f} of the step, the linear model by "
        f"{np.ptp(linear[late]):.0f}",
    )
    yield statement_row(
        "5.21-non-linear",
        "non-linear step responses with the retraction gains of position 1",
        "far less oscillatory than the linear ones; overshoot outwards clearly larger than the "
        "25 % tuned for, inwards satisfactory",
        found,
        "Figs 5.21 and 5.22",
        # A rig of the user's need not behave as the calibrated one does.
        "" if found.holds else "with another rig: an end stop, for one, cuts the overshoot off",
    )
    models = three_models(low, middle)
    swings = {name: float(np.ptp(response[late])) for name, response in models.items()}
    linear_swing, update, non_linear = swings.values()
    yield statement_row(
        "5.24-three-models",
        "damping of linear, parameter-update and non-linear model",
        "the update model is more damped than the linear one, the non-linear one a little more "
        "again; the changing stiffness does most of it",
        Finding(
            linear_swing > update > non_linear and linear_swing - update > update - non_linear,
            f"swing after 0.6 s {linear_swing:.1f}, {update:.2f} and {non_linear:.2f} of the step",
        ),
        "Fig 5.24",
    )


def _tuned_conventionally(data: ServoData, position: float, third_pole: float) -> StateFeedback:
    values = stated()
    return place_poles(
        conventional_servo(data, position),
        values["sensitivity"],
        values["settling_time"],
        values["damping"],
        third_pole,
    )


def _growth(kind: str, direction: str, extending: bool) -> Array:
    """Return the rightmost poles of three gain sets at three positions [1/s].

    As printed the gains are worked out from table 5.2; reconciled they are those of table 5.5.
    """
    data, sensitivity = servo_of(kind), stated()["sensitivity"]
    pole, positions = parameter_set(kind, 5)["third_pole"], stated()["positions"]
    controllers = [
        tuned(data, x, DIRECTIONS[direction], pole)
        if kind == PRINTED
        else printed_controller(direction, k)
        for k, x in enumerate(positions)
    ]
    return np.array(
        [
            largest_real_part(without_valve(advanced_servo(data, at, extending)), each, sensitivity)
            for each in controllers
            for at in positions
        ]
    )


def _least_damping(servo: LinearServo, controller: StateFeedback) -> float:
    poles = closed_loop(without_valve(servo), controller, stated()["sensitivity"]).poles()
    return float(np.min(-poles.real / np.abs(poles)))


def _share(displacement: Array, origin: float, target: float) -> Array:
    return (displacement - origin) / (target - origin)
