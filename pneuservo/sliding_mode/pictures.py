"""Pictures of a sliding-mode design: range space, reachability, reserve and response."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from analog_card.linear_servo import LinearServo
from pneuservo.linear import ServoData, advanced_servo, without_valve
from pneuservo.sliding_mode.design import SlidingModeDesign, linear_models
from pneuservo.sliding_mode.disturbance import reserve
from pneuservo.sliding_mode.equivalent_control import servo_gains
from pneuservo.sliding_mode.loop import LoopRun
from pneuservo.sliding_mode.range_space import RangeSpace
from pneuservo.sliding_mode.reachability import fastest_settling_time, opened
from pneuservo.sliding_mode.surface import Surface, surface_from_settling_time
from pneuservo.thinning import thinned

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POINTS = 60
_OPENINGS = np.linspace(0.6, 3.0, 17)


def draw_range_space(
    ax: "Axes", servo: LinearServo, surface: Surface, space: RangeSpace, level: float
) -> "Axes":
    """Draw the range space in velocity and acceleration, and where it cannot be controlled.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    servo : LinearServo
        The servo, without the dynamics of its valve.
    surface : Surface
        Of order 2.
    space : RangeSpace
        The box.
    level : float
        Largest voltage [V].

    Returns
    -------
    matplotlib.axes.Axes
        The same axes: light grey outside the controllability space, dark grey where the surface
        itself lies there, so that the state is repelled from one of its sides.
    """
    c1, c2, c3 = surface.weights
    v = np.linspace(*space.velocity, _POINTS)
    # Along each velocity both spaces are intervals of the acceleration.
    _, per_velocity, per_acceleration = servo_gains(servo, surface)
    ends = [(side * level - per_velocity * v) / per_acceleration for side in (-1.0, 1.0)]
    low, high = np.minimum(*ends), np.maximum(*ends)
    least, most = (-(c1 * end + c2 * v) / c3 for end in reversed(space.displacement))
    for strip, colour in ((space.acceleration, "0.82"), ((least, most), "0.5")):
        bottom, top = (np.broadcast_to(np.asarray(end), v.shape) for end in strip)
        above, below = np.maximum(high, bottom), np.minimum(low, top)
        ax.fill_between(v, above, top, where=above < top, color=colour, lw=0.0)
        ax.fill_between(v, bottom, below, where=bottom < below, color=colour, lw=0.0)
    for line in (least, most):
        ax.plot(v, line, color="C0", lw=1.0)
    ax.set_xlim(*space.velocity)
    ax.set_ylim(*space.acceleration)
    ax.set_xlabel("velocity [m/s]")
    ax.set_ylabel("acceleration [m/s²]")
    ax.set_title(f"sliding domain, settling time {1e3 * surface.settling_time:.0f} ms")
    ax.plot([], [], color="C0", lw=1.0, label="surface at either end of the errors")
    ax.fill_between([], [], color="0.82", label="sign of dσ/dt not free")
    ax.fill_between([], [], color="0.5", label="surface repels on one side")
    ax.legend(loc="best", fontsize="x-small")
    return ax


def draw_fastest(
    ax: "Axes",
    models: Mapping[str, Sequence[LinearServo]],
    space: RangeSpace,
    level: float,
    damping: float = 1.0,
) -> "Axes":
    """Draw the settling time of the fastest reachable surface over the size of the valve.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    models : mapping of str to sequence of LinearServo
        Label to the models that have to reach the surface.
    space, level, damping
        As in `pneuservo.sliding_mode.reachability.fastest_settling_time`.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes; a curve begins where any surface is reachable at all.
    """
    for label, servos in models.items():
        fastest = [
            fastest_settling_time([opened(servo, o) for servo in servos], space, level, damping)
            for o in _OPENINGS
        ]
        times = [np.nan if found is None else 1e3 * found for found in fastest]
        ax.plot(_OPENINGS, times, marker=".", label=label)
    ax.set_xlim(_OPENINGS[0], _OPENINGS[-1])
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel("largest flow over that of the valve [-]")
    ax.set_ylabel("settling time [ms]")
    ax.set_title("fastest reachable surface")
    ax.legend(fontsize="x-small")
    ax.grid(alpha=0.3)
    return ax


def draw_reserve(
    ax: "Axes", data: ServoData, level: float, step: float, damping: float = 1.0
) -> "Axes":
    """Draw the largest equivalent control of a step in the middle over the settling time.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    data : ServoData
        The servo.
    level : float
        Largest voltage [V].
    step : float
        Of the demand, about mid-stroke [m].
    damping : float, optional
        Of the surfaces [-].

    Returns
    -------
    matplotlib.axes.Axes
        The same axes, with the acceleration that may disturb on a second axis.
    """
    times = np.linspace(0.02, 0.25, 24)
    origin, target = 0.5 * (data.stroke - step), 0.5 * (data.stroke + step)
    found = [
        reserve(data, surface_from_settling_time(float(t), damping), level, origin, target)
        for t in times
    ]
    ax.plot(1e3 * times, [each.control for each in found], color="k", label="equivalent control")
    ax.axhline(level, color="0.5", ls="--", label="level")
    ax.set_ylim(0.0, 1.6 * level)
    ax.set_xlabel("settling time [ms]")
    ax.set_ylabel("voltage [V]")
    right = ax.twinx()
    right.plot(1e3 * times, [each.acceleration for each in found], color="C3")
    right.set_ylabel("largest disturbance [m/s²]", color="C3")
    right.set_ylim(bottom=0.0)
    ax.set_title(f"reserve in sliding, step of {1e3 * step:.0f} mm")
    ax.legend(loc="upper center", fontsize="x-small")
    ax.grid(alpha=0.3)
    return ax


def draw_motion(ax: "Axes", runs: Mapping[str, LoopRun]) -> "Axes":
    """Draw displacement over time for some laws.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    runs : mapping of str to LoopRun
        Label to run.

    Returns
    -------
    matplotlib.axes.Axes
        The same axes.
    """
    for label, run in runs.items():
        ax.plot(*thinned(run.time, 1e3 * run.displacement, 600), lw=1.0, label=label)
    ax.axhline(1e3 * run.demand, color="0.5", lw=0.8)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("displacement [mm]")
    ax.legend(fontsize="x-small")
    ax.grid(alpha=0.3)
    return ax


def design_figure(found: SlidingModeDesign, data: ServoData) -> "Figure":
    """Return the figure of a design: sliding domain, fastest surfaces, reserve.

    Parameters
    ----------
    found : SlidingModeDesign
        The design.
    data : ServoData
        Of the rig it is for.

    Returns
    -------
    matplotlib.figure.Figure
        Not tied to any window.
    """
    from matplotlib.figure import Figure

    nominal = without_valve(advanced_servo(data, 0.5 * data.stroke, extending=True))
    models = {
        "nominal": [nominal],
        "every position and direction": [without_valve(servo) for servo in linear_models(data)],
    }
    figure = Figure(figsize=(12.0, 4.0), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    damping = found.damping
    draw_range_space(left, nominal, found.surface, found.space, found.level)
    draw_fastest(middle, models, found.space, found.level, damping)
    draw_reserve(right, data, found.level, data.stroke / 3, damping)
    return figure
