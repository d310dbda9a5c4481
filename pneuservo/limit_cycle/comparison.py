"""One loop's limit cycle by every method, side by side."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from pneuservo.arrays import Array
from pneuservo.limit_cycle.cycle import Cycle, dominant
from pneuservo.limit_cycle.describing_function import describing_function_cycles
from pneuservo.limit_cycle.exact import exact_cycles
from pneuservo.limit_cycle.linear_simulation import START_ERROR, StepCourse, simulate_linear
from pneuservo.limit_cycle.loop import BILINEAR, Loop
from pneuservo.limit_cycle.nonlinear_simulation import simulate_nonlinear
from pneuservo.rigs import Rig
from pneuservo.simulation.metrics import limit_cycle, sustained

DESCRIBING_FUNCTION, EXACT = "describing_function", "exact"
LINEAR, NONLINEAR = "linear_simulation", "nonlinear_simulation"
# How long a loop is followed at least and at most; the second half is looked at [s].
_SHORTEST, _LONGEST = 0.8, 20.0
# After so many settling times of the surface the mean error has come to rest [-].
_SETTLING_TIMES = 2.5
# How many periods of the predicted cycle a loop is followed at least, of which half are looked at.
_PERIODS = 20
# The thesis' step, 9 mm, as a share of the stroke [-].
_STEP_OF_STROKE = 0.3
# An analogue cycle with fewer samples than this is that of the integration: the loop slides.
_SAMPLES_PER_CYCLE = 20


@dataclass(frozen=True)
class Finding:
    """What one method finds.

    Attributes
    ----------
    cycle : Cycle or None
        The limit cycle that the loop is expected to show, or shows.
    mean_error : float or None
        Demand less displacement, mean; also where a simulation shows no cycle [m].
    others : tuple of Cycle
        Further cycles of the same loop, unstable ones among them.
    note : str
        Why there is no cycle, or what to know about it.
    course : StepCourse or None
        What was simulated.
    """

    cycle: Cycle | None
    mean_error: float | None = None
    others: tuple[Cycle, ...] = ()
    note: str = ""
    course: StepCourse | None = None

    def to_dict(self) -> dict[str, object]:
        """Return the finding as plain values in SI, for JSON."""
        cycle = self.cycle
        return {
            "frequency": None if cycle is None else cycle.frequency,
            "amplitude": None if cycle is None else cycle.amplitude,
            "stable": None if cycle is None else cycle.stable,
            "mean_error": self.mean_error,
            "high": None if cycle is None else cycle.high,
            "low": None if cycle is None else cycle.low,
            "asymmetry": None if cycle is None else cycle.asymmetry,
            "others": [
                {"frequency": c.frequency, "amplitude": c.amplitude, "stable": c.stable}
                for c in self.others
            ],
            "note": self.note,
        }


def compare(
    loop: Loop,
    rig: Rig | None = None,
    displacement: float = 0.015,
    grid: Array | None = None,
    step: Callable[[str], None] = lambda _: None,
) -> Mapping[str, Finding]:
    """Return the limit cycle of a loop by every method.

    Parameters
    ----------
    loop : Loop
        The loop.
    rig : Rig, optional
        For the non-linear simulation, which is left out without one.
    displacement : float, optional
        Where the non-linear plant is controlled to [m].
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].
    step : callable, optional
        Told what is computed next.

    Returns
    -------
    mapping of str to Finding
        ``describing_function``, ``exact``, ``linear_simulation`` and ``nonlinear_simulation``.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> loop = Loop(LinearServo(1045.0, 17046.0, 54.945, 202.0, 0.7), (3265.3, 57.14, 1.0))
    >>> found = compare(loop)
    >>> [round(finding.cycle.frequency) for finding in found.values()]
    [202, 199, 199]
    """
    step("describing function")
    found = {DESCRIBING_FUNCTION: by_describing_function(loop)}
    step("exact method")
    found[EXACT] = by_exact_method(loop, found[DESCRIBING_FUNCTION].cycle)
    step("linear simulation")
    start_error = START_ERROR if rig is None else step_inside(rig, displacement)
    found[LINEAR] = by_linear_simulation(loop, start_error)
    if rig is not None:
        step("non-linear simulation")
        found[NONLINEAR] = by_nonlinear_simulation(loop, rig, displacement, start_error, grid)
    return found


def by_describing_function(loop: Loop) -> Finding:
    """Return what the describing function predicts for a loop.

    Parameters
    ----------
    loop : Loop
        The loop.
    """
    cycles = describing_function_cycles(loop)
    note = ""
    if not cycles:
        note = "the open loop does not reach -180 degrees with enough gain: no limit cycle"
    elif loop.boundary_layer > 0.0 and loop.asymmetry != 0.0:
        note = "asymmetry of a layered output by that of a relay"
    return _chosen(cycles, dominant(cycles) or next(iter(cycles), None), note)


def by_exact_method(loop: Loop, near: Cycle | None = None) -> Finding:
    """Return what the exact method finds for a loop, near a cycle of the describing function.

    Parameters
    ----------
    loop : Loop
        The loop.
    near : Cycle, optional
        Of several stable cycles the one nearest to this is chosen.
    """
    if loop.boundary_layer > 0.0:
        return Finding(None, note="the exact method is that of a relay, without boundary layer")
    cycles = exact_cycles(loop)
    note = "" if cycles else "no limit cycle with one switching each way"
    if loop.signals.sampled:
        if cycles:
            note = "locks to whole samples: to which of these frequencies, the start decides"
        if loop.asymmetry != 0.0:
            note = f"{note}; asymmetry left out".removeprefix("; ")
    chosen = dominant(cycles, None if near is None else near.frequency)
    chosen = chosen or next(iter(cycles), None)
    finding = _chosen(cycles, chosen, note)
    # The mean error of a sampled loop depends on the start.
    return replace(finding, mean_error=None) if loop.signals.sampled else finding


def by_linear_simulation(loop: Loop, start_error: float = START_ERROR) -> Finding:
    """Return what the linear servo shows after a step.

    Parameters
    ----------
    loop : Loop
        The loop.
    start_error : float, optional
        Demand less displacement at the start [m].
    """
    course = simulate_linear(loop, start_error, followed(loop, start_error))
    note = ""
    if loop.signals.differentiation == BILINEAR:
        note = "bilinear differences ring at half the sampling frequency"
    return measured(course, note)


def by_nonlinear_simulation(
    loop: Loop,
    rig: Rig,
    displacement: float = 0.015,
    start_error: float = START_ERROR,
    grid: Array | None = None,
) -> Finding:
    """Return what the non-linear plant shows after a step.

    Parameters
    ----------
    loop : Loop
        The loop.
    rig : Rig
        Of kind ``single-axis``.
    displacement : float, optional
        The demand [m].
    start_error : float, optional
        Demand less displacement at the start [m].
    grid : (4, 51, 101) array, optional
        Discharge coefficients; by default those of the rig's valve [-].
    """
    duration = followed(loop, start_error)
    return measured(simulate_nonlinear(rig, loop, displacement, start_error, duration, grid))


def followed(loop: Loop, start_error: float) -> float:
    """Return how long to follow a loop, so that it cycles in all of the second half [s].

    Parameters
    ----------
    loop : Loop
        The loop.
    start_error : float
        Demand less displacement at the start [m].

    Notes
    -----
    The first half is enough for the way to the surface at the servo's full speed, b0 U/a1, and for
    two and a half settling times along it. At most 20 s.

    Examples
    --------
    >>> from analog_card.linear_servo import LinearServo
    >>> followed(Loop(LinearServo(), (3265.3, 114.3, 1.0)), 9e-3)
    0.8
    """
    servo = loop.servo
    reaching = abs(start_error) * servo.a1 / (servo.b0 * min(loop.levels))
    decay = [-pole.real for pole in np.roots(loop.weights[::-1]) if pole.real < 0.0]
    settling = 4.0 / min(decay) if decay else 0.0
    predicted = dominant(describing_function_cycles(loop))
    periods = 0.0 if predicted is None else _PERIODS / predicted.frequency
    needed = max(2.0 * (reaching + _SETTLING_TIMES * settling), periods)
    return float(min(max(needed, _SHORTEST), _LONGEST))


def measured(course: StepCourse, note: str = "") -> Finding:
    """Return the limit cycle in the second half of what was simulated.

    Parameters
    ----------
    course : StepCourse
        The step response.
    note : str, optional
        What to say of it.
    """
    half = len(course.time) // 2
    found = limit_cycle(course.time[half:], course.surface[half:])
    interval = float(course.time[1] - course.time[0])
    if found is None:
        note = note or _without_cycle(course, half)
    elif not course.sampled and found.frequency * interval * _SAMPLES_PER_CYCLE > 1.0:
        found, note = None, "slides: switches with every step"
    if found is None:
        return Finding(None, float(np.mean(course.error[half:])), note=note, course=course)
    whole = (course.time >= found.start) & (course.time <= found.end)
    error = float(np.mean(course.error[whole]))
    cycle = Cycle(found.frequency, found.high, found.low, True, error)
    return Finding(cycle, error, note=note, course=course)


def step_inside(rig: Rig, displacement: float) -> float:
    """Return an error to start from: the piston comes from the side with more room [m].

    Parameters
    ----------
    rig : Rig
        Of kind ``single-axis``.
    displacement : float
        The demand [m].
    """
    size = _STEP_OF_STROKE * rig["piston.stroke"]
    return size if displacement >= size else -size


def _without_cycle(course: StepCourse, half: int) -> str:
    """Return why no cycle is seen in what follows the first half."""
    end = float(course.time[-1])
    if np.all(course.voltage[: half + 1] == course.voltage[0]):
        return (
            f"not seen: still on the way to the surface after {0.5 * end:.3g} of the {end:.3g} s "
            "that were followed; a higher level would get there sooner"
        )
    if sustained(course.surface[half:]):
        return f"not seen: swings on, but too few whole periods end within {end:.3g} s"
    return "settles without a limit cycle"


def _chosen(cycles: list[Cycle], chosen: Cycle | None, note: str) -> Finding:
    others = tuple(cycle for cycle in cycles if cycle is not chosen)
    return Finding(chosen, None if chosen is None else chosen.mean_error, others, note)
