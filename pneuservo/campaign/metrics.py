"""What a campaign reads off each run."""

import math
from collections.abc import Sequence

import numpy as np

from analog_card.plain_json import plain_json
from pneuservo.simulation import Simulation
from pneuservo.simulation.metrics import (
    StepResponse,
    control_effort,
    final_swings,
    limit_cycles,
)

METRICS = {
    "rise_time": "s",
    "settling_time": "s",
    "overshoot": "",
    "steady_state_error": "m",
    "limit_cycle_frequency": "Hz",
    "limit_cycle_stroke": "m",
    "largest_error": "m",
    "rms_error": "m",
    "chatter": "V",
    "control_effort": "V",
}
"""SI unit of each metric."""

_OF_STEPS = ("rise_time", "settling_time", "overshoot", "steady_state_error")
_OF_CYCLE = ("limit_cycle_frequency", "limit_cycle_stroke")
OF_SET_POINTS = (*_OF_STEPS, *_OF_CYCLE)
"""What is measured of a demand that steps, unless said: its largest error is the step itself."""
OF_RECORDED = ("largest_error", "rms_error", *_OF_CYCLE)
"""What is measured of a demand that moves, unless said: it may never hold still."""


def metrics_of(run: Simulation, names: Sequence[str]) -> dict[str, float | None]:
    """Return metrics of a closed loop.

    Parameters
    ----------
    run : Simulation
        With a demand.
    names : sequence of str
        Some of `METRICS`.

    Returns
    -------
    dict of str to float or None
        In SI; None where there is no number, such as the settling time of a loop that does not
        settle, or the frequency of a loop that does not oscillate.

    Notes
    -----
    Rise time, settling time and overshoot are the largest over all steps, the steady-state error
    the one largest in magnitude. Of the limit cycles in the second halves of the holds it is the
    one with the largest stroke, which is how far the displacement swings. Errors are demand less
    displacement, over the whole run. Chatter is the largest swing of the valve voltage at the end
    of a hold, peak to peak without its creep; control effort its root mean square over the whole
    run.

    Examples
    --------
    >>> from pneuservo.controllers import SlidingMode
    >>> from pneuservo.simulation import simulate, step_demand
    >>> time, demand = step_demand([0.015, 0.024], 0.5, 1000.0)
    >>> run = simulate(time=time, demand=demand, controller=SlidingMode())
    >>> 0.1 < metrics_of(run, ["settling_time"])["settling_time"] < 0.2
    True
    """
    found: dict[str, float] = {}
    if set(names) & set(_OF_STEPS):
        steps = run.step_responses()
        found = {name: _worst(steps, name) for name in _OF_STEPS}
    if set(names) & set(_OF_CYCLE):
        found |= dict(zip(_OF_CYCLE, _largest_cycle(run), strict=True))
    error = run["demand"] - run["displacement"]
    found["largest_error"] = float(np.max(np.abs(error)))
    found["rms_error"] = float(np.sqrt(np.mean(error**2)))
    if "chatter" in names:
        swings = final_swings(run.time, run["demand"], run["valve_voltage"])
        found["chatter"] = max(swing.size for swing in swings)
    found["control_effort"] = control_effort(run.time, run["valve_voltage"])
    return {name: plain_json(found.get(name, math.nan)) for name in names}


def _worst(steps: Sequence[StepResponse], name: str) -> float:
    """Return what is largest in magnitude over the steps; not a number if it is not for one."""
    values = [float(getattr(step, name)) for step in steps]
    if not values or any(math.isnan(value) for value in values):
        return math.nan
    return max(values, key=abs)


def _largest_cycle(run: Simulation) -> tuple[float, float]:
    """Return frequency [Hz] and stroke [m] of the limit cycle with the largest stroke."""
    signal = run["valve_voltage"] if run.surface is None else run.surface
    frequency, largest = math.nan, math.nan
    for cycle in limit_cycles(run.time, run["demand"], signal):
        inside = (run.time >= cycle.start) & (run.time <= cycle.end)
        stroke = float(np.ptp(run["displacement"][inside]))
        if not stroke <= largest:
            frequency, largest = cycle.frequency, stroke
    return frequency, largest
