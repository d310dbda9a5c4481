"""From what the loop has to do to weights, boundary layer and level, and what stands against it."""

import math
from dataclasses import dataclass, replace

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.errors import InputError
from pneuservo.linear import advanced_servo, servo_data, transfer_function, without_valve
from pneuservo.linear.servo_data import ServoData
from pneuservo.rigs import Rig
from pneuservo.sliding_mode.boundary_layer import WIDTHS, layer_cut_off, layer_width
from pneuservo.sliding_mode.disturbance import Reserve, reserve
from pneuservo.sliding_mode.range_space import (
    RangeSpace,
    linear_limits,
    physical_limits,
    representative_runs,
    trajectory_limits,
)
from pneuservo.sliding_mode.reachability import (
    Reachability,
    control_along_motion,
    fastest_settling_time,
    reachability,
    shortest_without_limit_cycle,
)
from pneuservo.sliding_mode.reaching import reaching_phase
from pneuservo.sliding_mode.sizing import required_supply_pressure
from pneuservo.sliding_mode.surface import Surface, surface_from_settling_time

# How the range space is found.
RANGE_SPACES = ("trajectories", "physical", "linear")
# Shares of the stroke at which the parameters are taken, besides the middle [-].
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
# Below this the loop inside the boundary layer rings or chatters with the valve [-].
_LEAST_GAIN_MARGIN = 1.2


@dataclass(frozen=True)
class Requirements:
    """What the loop has to do.

    Parameters
    ----------
    settling_time : float, optional
        4/(damping wn) of the sliding motion [s].
    damping : float, optional
        Of the sliding motion, above 0 up to 1 [-].
    step : float, optional
        Largest step of the demand; the stroke by default [m].
    level : float, optional
        Largest voltage; by default what opens the valve fully [V].
    boundary_layer : float, optional
        By default the narrowest whose corner frequency stays at the valve's [m/s2].
    range_space : str, optional
        One of `RANGE_SPACES`.
    """

    settling_time: float = 0.07
    damping: float = 1.0
    step: float | None = None
    level: float | None = None
    boundary_layer: float | None = None
    range_space: str = "trajectories"


@dataclass(frozen=True)
class SlidingModeDesign:
    """A design, and what stands against it.

    Attributes
    ----------
    surface : Surface
        With the weights c1, c2, c3.
    damping : float
        Of the sliding motion [-].
    boundary_layer, level : float
        [m/s2], [V].
    space : RangeSpace
        Over which the surface should be reachable.
    over_space : Reachability
        Whether it is, for every position and direction.
    fastest : float or None
        Settling time of the fastest surface that is [s].
    along_step : float
        Largest equivalent control of the nominal model on the way through the largest step [V].
    reaching_time : float
        Of the nominal model with its valve, in the largest step [s].
    without_limit_cycle : float
        Shortest settling time that itself causes no limit cycle [s].
    reserve : Reserve
        What is left in sliding against disturbances.
    required_opening : float
        Valve that the surface needs over the range space, over the valve there is [-].
    required_supply_pressure : float or None
        What it needs instead; None when no pressure up to four times the rig's will do [Pa].
    gain_margin : float
        Of the loop inside the boundary layer, with the valve, where it is smallest [-].
    warnings : tuple of str
        What an engineer has to know before building it.
    """

    surface: Surface
    damping: float
    boundary_layer: float
    level: float
    space: RangeSpace
    over_space: Reachability
    fastest: float | None
    along_step: float
    reaching_time: float
    without_limit_cycle: float
    reserve: Reserve
    required_opening: float
    required_supply_pressure: float | None
    gain_margin: float
    warnings: tuple[str, ...]


def design_sliding_mode(rig: Rig, requirements: Requirements | None = None) -> SlidingModeDesign:
    """Return the sliding-mode design for a rig.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    requirements : Requirements, optional
        What the loop has to do.

    Returns
    -------
    SlidingModeDesign
        The design with its warnings; it is made whether or not the surface is reachable.

    Raises
    ------
    InputError
        When a requirement is one that no design can meet.

    Notes
    -----
    Chapter 7 of the thesis. Nominal is the advanced linear model at mid-stroke, extending;
    parameter changes are those over five positions and both directions.
    """
    wanted = requirements or Requirements()
    data = servo_data(rig)
    level = _level(wanted, data)
    step = _step(wanted, data)
    surface = surface_from_settling_time(wanted.settling_time, wanted.damping)
    models = linear_models(data)
    nominal = advanced_servo(data, 0.5 * data.stroke, extending=True)
    still = [without_valve(servo) for servo in models]
    space = range_space(rig, wanted.range_space, level)
    width = _width(wanted, data, models, level)
    over_space = reachability(still, surface, space, level)
    found = SlidingModeDesign(
        surface=surface,
        damping=wanted.damping,
        boundary_layer=width,
        level=level,
        space=space,
        over_space=over_space,
        fastest=fastest_settling_time(still, space, level, wanted.damping),
        along_step=control_along_motion(without_valve(nominal), surface, level, -step),
        reaching_time=reaching_phase(nominal, surface, level, -step).time,
        without_limit_cycle=max(shortest_without_limit_cycle(servo) for servo in models),
        reserve=reserve(
            data, surface, level, 0.5 * (data.stroke - step), 0.5 * (data.stroke + step)
        ),
        required_opening=over_space.voltage / level,
        required_supply_pressure=required_supply_pressure(
            data, linear_models, surface, space, level
        ),
        gain_margin=min(_gain_margin(servo, surface, level, width) for servo in models),
        warnings=(),
    )
    return _with_warnings(found, layer_cut_off(nominal.b0, level, width), data.valve_frequency)


def linear_models(data: ServoData) -> list[LinearServo]:
    """Return the linear models over five positions and both directions.

    Parameters
    ----------
    data : ServoData
        The servo.
    """
    return [
        advanced_servo(data, share * data.stroke, extending)
        for share in _SHARES
        for extending in (True, False)
    ]


def range_space(rig: Rig, how: str, level: float) -> RangeSpace:
    """Return the range space of a rig.

    Parameters
    ----------
    rig : Rig
        A rig of kind ``single-axis``.
    how : str
        One of `RANGE_SPACES`.
    level : float
        Largest voltage [V].

    Raises
    ------
    InputError
        For a range space that is not known.

    Notes
    -----
    From representative trajectories, section 7.5.2 of the thesis; from choked flow and supply
    pressure, an outer bound; or from the frequency responses of the linear model, (7.12).
    """
    data = servo_data(rig)
    if how == "physical":
        return physical_limits(data)
    if how == "trajectories":
        return trajectory_limits(representative_runs(rig, voltage=level), data.stroke)
    if how == "linear":
        middle = advanced_servo(data, 0.5 * data.stroke, extending=True)
        return linear_limits(middle, level).range_space(data.stroke)
    raise InputError(f"range space {how!r} is not known; there are: {', '.join(RANGE_SPACES)}")


def _level(wanted: Requirements, data: ServoData) -> float:
    level = data.full_voltage if wanted.level is None else wanted.level
    if not 0.0 < level <= data.full_voltage:
        raise InputError(
            f"level is {level:g} V; it has to be greater than 0 and at most the "
            f"{data.full_voltage:g} V that open the valve fully"
        )
    return level


def _step(wanted: Requirements, data: ServoData) -> float:
    step = data.stroke if wanted.step is None else wanted.step
    if not 0.0 < step <= data.stroke:
        raise InputError(
            f"step is {step:g} m; it has to be greater than 0 and at most the stroke, "
            f"{data.stroke:g} m"
        )
    return step


def _width(wanted: Requirements, data: ServoData, models: list[LinearServo], level: float) -> float:
    width = wanted.boundary_layer
    if width is None:
        cut_off = 2 * math.pi * data.valve_frequency
        return max(layer_width(servo.b0, level, cut_off) for servo in models)
    lowest, highest = WIDTHS
    if not lowest <= width <= highest:
        raise InputError(
            f"boundary layer is {width:g} m/s2; it has to be from {lowest:g} to {highest:g} m/s2; "
            "left out, it is the narrowest that stays below the valve's frequency"
        )
    return width


def _gain_margin(servo: LinearServo, surface: Surface, level: float, width: float) -> float:
    import control

    c1, c2, c3 = surface.weights
    loop = level / width * control.tf([c3, c2, c1], [1.0]) * transfer_function(servo)
    margins, _, _, frequencies, *_ = control.stability_margins(loop, returnall=True)
    # The crossing beside the valve; one further down would only matter for a lower gain.
    return float(margins[np.argmax(frequencies)]) if len(margins) else math.inf


def _with_warnings(
    found: SlidingModeDesign, cut_off: float, valve_frequency: float
) -> SlidingModeDesign:
    over, surface, warnings = found.over_space, found.surface, []
    if not over.reachable:
        e, v, a = over.state
        faster = (
            "no surface of this damping is"
            if found.fastest is None
            else f"the fastest that is settles in {1e3 * found.fastest:.0f} ms"
        )
        warnings.append(
            f"the surface is not reachable over the whole range space: it needs {over.voltage:.2f} "
            f"V of {over.level:g} V at {1e3 * e:.1f} mm, {v:.3f} m/s, {a:.1f} m/s2; {faster}. For "
            f"the same motions a valve {found.required_opening:.2f} times as large would do"
        )
    if found.along_step > found.level:
        warnings.append(
            f"the largest step leaves the controllability space on its way: {found.along_step:.2f} "
            f"V of {found.level:g} V; sliding begins later than the surface is first met"
        )
    if surface.settling_time < found.without_limit_cycle:
        warnings.append(
            f"a settling time below {1e3 * found.without_limit_cycle:.1f} ms makes the loop "
            "oscillate even with an ideal valve"
        )
    if found.reserve.reserve <= 0.0:
        warnings.append("sliding takes the whole voltage: none is left against disturbances")
    if found.gain_margin < _LEAST_GAIN_MARGIN:
        warnings.append(
            f"inside the boundary layer the gain margin is {found.gain_margin:.2f}: the loop rings "
            f"or cycles with the valve ({cut_off / (2 * math.pi):.0f} Hz of {valve_frequency:g} "
            "Hz); give a wider boundary layer"
        )
    return replace(found, warnings=tuple(warnings))
