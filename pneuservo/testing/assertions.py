"""What is asserted of one closed loop; every figure is that of `pneuservo.simulation.metrics`."""

import math
from collections.abc import Callable

import numpy as np

from analog_card.quantities import as_text, to_si
from pneuservo.errors import InputError
from pneuservo.recordings import CHANNELS
from pneuservo.simulation import Simulation, step_responses
from pneuservo.simulation.metrics import (
    LimitCycle,
    StepResponse,
    control_effort,
    final_swings,
    limit_cycles,
)
from pneuservo.testing.words import Run, fail, samples

Limit = str | float


def assert_settles_within(run: Run, limit: Limit, band: Limit = 0.02) -> None:
    """Assert that every step of the demand settles in time.

    Parameters
    ----------
    run : Simulation or Recording
        With a demand that steps.
    limit : str or float
        Longest settling time allowed, such as ``"150 ms"`` [s].
    band : str or float, optional
        Half width of the band about the final value, as a share of the step [-].

    Raises
    ------
    AssertionError
        When a step settles later or not at all.
    InputError
        When nothing can be said of the run.

    Examples
    --------
    >>> from pneuservo.testing import close_loop
    >>> run = close_loop("sliding-mode", demand="15,24 mm")
    >>> assert_settles_within(run, "150 ms")
    >>> assert_settles_within(run, "100 ms")
    Traceback (most recent call last):
    ...
    AssertionError: step from 15 to 24 mm at t = 0.5 s: settles after 132 ms, 100 ms is allowed, ...
    """
    __tracebackhide__ = True
    allowed, share = _limit(limit, "s"), to_si(band, "", "band")
    if not 0.0 < share < 1.0:
        raise InputError(
            f"band is {share:g}; it has to be between 0 and 1, a share of the step, such as "
            'band="2 %"'
        )

    def says(step: StepResponse) -> str | None:
        if step.settling_time <= allowed:
            return None
        if math.isnan(step.settling_time):
            words = f"has not settled when it ends at t = {step.end:.4g} s"
        else:
            words = f"settles after {_shown(step.settling_time, 's')}"
        about = f"{_shown(allowed, 's')} is allowed, to {100 * share:.3g} % of the step"
        return f"{words}, {about}"

    _each_step(run, says, share)


def assert_overshoot_below(run: Run, limit: Limit) -> None:
    """Assert that no step of the demand overshoots by more.

    Parameters
    ----------
    run : Simulation or Recording
        With a demand that steps.
    limit : str or float
        Largest overshoot allowed, as a share of the way, such as ``"2 %"`` [-].

    Raises
    ------
    AssertionError
        When a step overshoots by more.
    InputError
        When nothing can be said of the run.
    """
    __tracebackhide__ = True
    allowed = _limit(limit, "")

    def says(step: StepResponse) -> str | None:
        if step.overshoot <= allowed:
            return None
        if math.isnan(step.overshoot):
            return f"the displacement does not answer, {100 * allowed:.3g} % overshoot is allowed"
        return f"overshoots by {100 * step.overshoot:.3g} %, {100 * allowed:.3g} % is allowed"

    _each_step(run, says)


def assert_steady_state_error_below(run: Run, limit: Limit) -> None:
    """Assert that no step of the demand leaves a larger error.

    Parameters
    ----------
    run : Simulation or Recording
        With a demand that steps.
    limit : str or float
        Largest error allowed, either way, such as ``"0.1 mm"`` [m].

    Raises
    ------
    AssertionError
        When more is left, on average over the last fifth of a hold.
    InputError
        When nothing can be said of the run.
    """
    __tracebackhide__ = True
    allowed = _limit(limit, "m")

    def says(step: StepResponse) -> str | None:
        if abs(step.steady_state_error) <= allowed:
            return None
        left = (
            f"{_shown(step.steady_state_error, 'm')} is left when it ends at t = {step.end:.4g} s"
        )
        return f"{left}, {_shown(allowed, 'm')} is allowed"

    _each_step(run, says)


def assert_chatter_below(run: Run, limit: Limit, channel: str = "valve_voltage") -> None:
    """Assert that a signal swings no more once the loop has come to rest.

    Parameters
    ----------
    run : Simulation or Recording
        With a demand.
    limit : str or float
        Largest swing allowed, peak to peak, such as ``"0.2 V"`` [unit of the channel].
    channel : str, optional
        What must not swing: the valve voltage, or for example the displacement.

    Raises
    ------
    AssertionError
        When it swings more over the last fifth of a hold, creep taken off.
    InputError
        When nothing can be said of the run.
    """
    __tracebackhide__ = True
    signal = samples(run, channel)
    unit = CHANNELS[channel].unit
    allowed = _limit(limit, unit)
    found = [
        f"{channel} swings by {_shown(swing.size, unit)} from t = {swing.start:.4g} to "
        f"{swing.end:.4g} s, {_shown(allowed, unit)} is allowed"
        for swing in final_swings(run.time, samples(run, "demand"), signal)
        if not swing.size <= allowed
    ]
    if found:
        fail(run, found)


def assert_control_effort_below(run: Run, limit: Limit) -> None:
    """Assert that the valve is driven no harder.

    Parameters
    ----------
    run : Simulation or Recording
        With a valve voltage.
    limit : str or float
        Largest root mean square of the valve voltage over the run, such as ``"1.5 V"`` [V].

    Raises
    ------
    AssertionError
        When it is larger.
    InputError
        When nothing can be said of the run.
    """
    __tracebackhide__ = True
    allowed = _limit(limit, "V")
    voltage = samples(run, "valve_voltage")
    effort = control_effort(run.time, voltage)
    if not effort <= allowed:
        fail(
            run,
            [
                f"the valve voltage is {_shown(effort, 'V')} rms from t = {run.time[0]:.4g} to "
                f"{run.time[-1]:.4g} s, {_shown(allowed, 'V')} is allowed"
            ],
        )


def assert_no_sustained_oscillation(run: Run, stroke: Limit = 0.0) -> None:
    """Assert that no hold ends in an oscillation that goes on.

    Parameters
    ----------
    run : Simulation or Recording
        With a demand.
    stroke : str or float, optional
        Oscillations that move the piston by less, peak to peak, are let pass [m].

    Raises
    ------
    AssertionError
        When five whole periods or more are found in the second half of a hold, dying out no
        faster than to half.
    InputError
        When nothing can be said of the run.

    Notes
    -----
    Looked for in the switching function, or in the valve voltage without one.
    """
    __tracebackhide__ = True
    least = _limit(stroke, "m")
    displacement = samples(run, "displacement")

    def moved(cycle: LimitCycle) -> float:
        inside = (run.time >= cycle.start) & (run.time <= cycle.end)
        return float(np.ptp(displacement[inside]))

    found = [
        f"oscillates at {cycle.frequency:.4g} Hz, {cycle.periods} periods from t = "
        f"{cycle.start:.4g} to {cycle.end:.4g} s, and moves the piston by "
        f"{_shown(moved(cycle), 'm')}"
        for cycle in limit_cycles(run.time, samples(run, "demand"), _switching(run))
        if moved(cycle) >= least
    ]
    if found:
        fail(run, found)


def _each_step(run: Run, says: Callable[[StepResponse], str | None], band: float = 0.02) -> None:
    __tracebackhide__ = True
    demand, displacement = samples(run, "demand"), samples(run, "displacement")
    steps = step_responses(run.time, demand, displacement, band)
    if not steps:
        raise InputError(
            "the demand never changes, so that there is no step to judge; "
            "give it two set points and more"
        )
    found = []
    for step in steps:
        words = says(step)
        if words is not None:
            way = f"{1e3 * step.origin:.4g} to {1e3 * step.target:.4g} mm"
            found.append(f"step from {way} at t = {step.start:.4g} s: {words}")
    if found:
        fail(run, found)


def _switching(run: Run) -> np.ndarray:
    if isinstance(run, Simulation) and run.surface is not None:
        return run.surface
    return samples(run, "card_surface" if "card_surface" in run else "valve_voltage")


def _limit(limit: Limit, unit: str) -> float:
    value = to_si(limit, unit, "limit")
    if value < 0.0:
        raise InputError(f"limit is {value:g} {unit}; it cannot be below 0".replace("  ", " "))
    return value


def _shown(value: float, unit: str) -> str:
    return as_text(value, unit, 3)
